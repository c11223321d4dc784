//! Indices of refraction near 1, far from 1, inside out, matched, nested, and with next to nothing between
//! them.
//!
//! The oracle is a body of concentric balls under a lamp: light stays in a plane through the axis, and n r
//! sin θ is the same all along a ray (Bouguer; Born and Wolf, *Principles of Optics*, 7th edition, 3.2.2
//! (7)).

mod coincident;
mod extent;
mod nested;
mod shells;
