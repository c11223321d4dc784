//! Reasons why a point cannot be probed.

use glam::DVec2;

use crate::transport::domain::LightSpaceError;
use crate::transport::receiver::ReceiverError;
use crate::transport::signature::MAX_EVENTS;

/// The reason why a point cannot be probed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProbeError {
    /// The sensor measures no surface with parameters.
    #[error(transparent)]
    Receiver(#[from] ReceiverError),
    /// The light cannot be charted.
    #[error(transparent)]
    Light(#[from] LightSpaceError),
    /// The point is not on the receiver.
    #[error("the point (u, v) = ({}, {}) is not on the receiver: both must be in 0..=1", .0.x, .0.y)]
    OffReceiver(DVec2),
    /// Light from a surface reaches a point on infinitely many paths.
    #[error(
        "emitter {emitter} shines from a surface (area): its paths to a point cannot be counted; \
         emitters of plugin point, spot and directional are allowed"
    )]
    AreaEmitter {
        /// The emitter, counted from 1 in the scene's order.
        emitter: usize,
    },
    /// Light has a path for each wavelength.
    #[error(
        "\"{0}\" has dispersion: light of each wavelength has a path of its own to a point; leave --dispersion out"
    )]
    Dispersion(String),
    /// The depth is larger than a signature can hold.
    #[error("max_depth = {0}: allowed are 0 to {MAX_EVENTS}")]
    Depth(u32),
}
