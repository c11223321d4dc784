//! Integrals of functions of one variable.
