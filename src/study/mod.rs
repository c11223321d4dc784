//! Questions that take several methods to answer.
//!
//! | file | question |
//! |---|---|
//! | [`attribution`] | which stage of an approximation makes its error? |

pub mod attribution;
