//! Reasons why a sensor cannot be used as a camera.

use crate::transport::bsdf::UnknownColor;

/// Reason why a sensor cannot be used as a camera.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// The sensor measures a shape.
    #[error("sensor \"{id}\" is an irradiancemeter: it measures a surface and is no camera")]
    NoCamera {
        /// The sensor.
        id: String,
    },
    /// The sensor measures a shape, or has a lens of some size.
    #[error(
        "sensor \"{id}\" is a {plugin}: a camera that light can be connected to must be perspective \
         or orthographic"
    )]
    Kind {
        /// The sensor.
        id: String,
        /// Mitsuba's name of its kind.
        plugin: &'static str,
    },
    /// Pixels would overlap.
    #[error(
        "sensor \"{id}\" has a film with a {filter} filter: pixels here are plain averages; add \
         <rfilter type=\"box\"/> to the film, or render with --filter box"
    )]
    Filter {
        /// The sensor.
        id: String,
        /// Mitsuba's name of the filter.
        filter: &'static str,
    },
    /// A surface's colour is not known.
    #[error(transparent)]
    Color(#[from] UnknownColor),
    /// A surface's brightness varies.
    #[error(
        "sensor \"{id}\" may see shape \"{shape}\", whose diffuse reflectance (or opacity) is a texture: light \
         that is connected to pixels as a whole needs an rgb or a float"
    )]
    Reflectance {
        /// The sensor.
        id: String,
        /// The shape.
        shape: String,
    },
    /// A medium is around it.
    #[error(
        "sensor \"{id}\" is in a medium that absorbs light: light that is connected to a camera comes through \
         the clear; paths and photon maps see through media"
    )]
    InMedium {
        /// The sensor.
        id: String,
    },
    /// Media meet at its film.
    #[error(
        "sensor \"{id}\" is partly in a medium that absorbs light: give it a <medium>, or move it off the border"
    )]
    AcrossMedia {
        /// The sensor.
        id: String,
    },
    /// Its numbers overflow.
    #[error(
        "sensor \"{id}\": its to_world, field of view and film size give pixels of size {size:e}; \
         allowed are sizes from 1e-70 to 1e70"
    )]
    Size {
        /// The sensor.
        id: String,
        /// The side of a pixel, in camera space or on the plane z = 1.
        size: f64,
    },
}
