//! Reasons why a sensor, or the (u, v) of a mesh, cannot carry texels.

/// Reason why a sensor cannot be used as a receiver.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReceiverError {
    /// The sensor is a camera.
    #[error(
        "sensor \"{id}\" is a {plugin}: this method measures irradiance; \
         sensors of plugin irradiancemeter are allowed"
    )]
    NotAMeter {
        /// The sensor.
        id: String,
        /// Mitsuba's name of its kind.
        plugin: &'static str,
    },
    /// The shape is a mesh whose (u, v) cannot carry texels.
    #[error("sensor \"{id}\" measures shape \"{shape}\" ({plugin}), which {problem}")]
    Mesh {
        /// The sensor.
        id: String,
        /// The shape.
        shape: String,
        /// Mitsuba's name of the shape.
        plugin: &'static str,
        /// The fault of the mesh.
        problem: UvProblem,
    },
}

/// Fault of a mesh's uv map; its text reads on after "which".
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum UvProblem {
    /// There are no texture coordinates.
    #[error(
        "has no texture coordinates: receivers can be rectangle, disk, sphere, cylinder, and \
         meshes with (u, v)"
    )]
    Missing,
    /// A vertex falls off the film.
    #[error(
        "has (u, v) = ({u}, {v}) at a corner of face {face} (counted from 0): allowed on a \
         receiver are 0 to 1, without repetition"
    )]
    Outside {
        /// Face, counted from 0.
        face: usize,
        /// The offending coordinates.
        u: f64,
        /// The offending coordinates.
        v: f64,
    },
    /// One (u, v) lies on two faces.
    #[error(
        "has faces {first} and {second} (counted from 0) on the same (u, v): on a receiver each \
         (u, v) may lie on one face only"
    )]
    Overlap {
        /// Face, counted from 0.
        first: u32,
        /// Face, counted from 0.
        second: u32,
    },
    /// A part of the surface has no (u, v) of its own.
    #[error(
        "has faces whose (u, v) are a line or a point; they make up {share:.1e} of the surface in \
         texel ({column}, {row}), and on a receiver at most 1e-6 is allowed"
    )]
    Collapsed {
        /// Share of the texel's surface, 0..=1.
        share: f64,
        /// Column of the full film.
        column: usize,
        /// Row of the full film.
        row: usize,
    },
}
