//! What cannot be run, and why.

use crate::setting::SettingError;
use crate::transport::camera::CameraError;
use crate::transport::receiver::ReceiverError;

/// Why a technique cannot fill a sensor.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ApproximationError {
    /// A setting.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The sensor cannot receive.
    #[error(transparent)]
    Receiver(#[from] ReceiverError),
    /// The camera cannot be looked through.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// An emitter that has no view.
    #[error(
        "an emitter is of plugin {plugin}: caustic maps are rendered from one point or direction; emitters of \
         plugin point, spot and directional are allowed"
    )]
    Emitter {
        /// Mitsuba's name of it.
        plugin: &'static str,
    },
    /// Nothing shines.
    #[error(
        "no emitter shines: a caustic map is rendered from one of plugin point, spot or directional"
    )]
    NoEmitter,
    /// Nothing refracts, or mirrors.
    #[error("no shape {does}: mode={mode} needs one of plugin {plugins}")]
    NoSpecular {
        /// The mode.
        mode: &'static str,
        /// What is missing.
        does: &'static str,
        /// What would do.
        plugins: &'static str,
    },
    /// The light view sees refractors from inside only.
    #[error(
        "the emitter at ({}, {}, {}) is inside shape \"{shape}\": a caustic map's light crosses two interfaces, from outside in and out again",
        position[0], position[1], position[2]
    )]
    LightInside {
        /// The emitter's place.
        position: [f64; 3],
        /// The shape's id.
        shape: String,
    },
    /// A sum does not fit.
    #[error(
        "the light on one texel or pixel is beyond what can be summed: allowed are emitters of 1e-250 to 1e250 W, and \
         cameras no nearer to what they see than 1/64 of the typical distance"
    )]
    Overflow,
}
