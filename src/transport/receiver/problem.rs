//! Why a mesh's (u, v) cannot carry texels.

/// What is wrong with a mesh's uv map; reads on after "which".
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum UvProblem {
    /// There are none.
    #[error(
        "has no texture coordinates: receivers can be rectangle, disk, sphere, cylinder, and \
         meshes with (u, v)"
    )]
    Missing,
    /// A vertex that would fall off the film.
    #[error(
        "has (u, v) = ({u}, {v}) at a corner of face {face} (counted from 0): allowed on a \
         receiver are 0 to 1, without repetition"
    )]
    Outside {
        /// Counted from 0.
        face: usize,
        /// The offending coordinates.
        u: f64,
        /// The offending coordinates.
        v: f64,
    },
    /// One (u, v) is in two places.
    #[error(
        "has faces {first} and {second} (counted from 0) on the same (u, v): on a receiver each \
         (u, v) may lie on one face only"
    )]
    Overlap {
        /// Counted from 0.
        first: u32,
        /// Counted from 0.
        second: u32,
    },
    /// Surface without (u, v) of its own.
    #[error(
        "has faces whose (u, v) are a line or a point; they make up {share:.1e} of the surface in \
         texel ({column}, {row}), and on a receiver at most 1e-6 is allowed"
    )]
    Collapsed {
        /// Of the texel's surface, 0..=1.
        share: f64,
        /// Of the full film.
        column: usize,
        /// Of the full film.
        row: usize,
    },
}
