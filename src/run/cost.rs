//! The cost of a run, before anything is traced.

use serde::Serialize;

use super::Counter;
use crate::film::exr;
use crate::scene::Sensor;

/// The cost of a run, before anything is traced: a bound on its memory, and the work that is known.
///
/// # Example: refuse runs above a gigabyte
///
/// ```
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// let method = nephroid::Method::new("beams", &Default::default())?;
/// let cost = method.cost(&scene, sensor);
/// assert!(cost.bytes < 1_000_000_000);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Cost {
    /// Memory \[bytes\] that the run takes at most, beside the scene and the program.
    pub bytes: u64,
    /// Work that its settings fix; empty if time or an error ends the run.
    pub work: Vec<Counter>,
}

/// Three `f64`.
pub(crate) const TRIPLE: u64 = 24;

/// Bytes of a texel of a picture while it is written: the values as `f32` and `f64`, and those from which a
/// range is found, or the pixels and the bytes of their file.
pub(crate) const PICTURE: u64 = 4 + 8 + 8;

/// Texels or pixels of a sensor's film.
pub(crate) fn texels(sensor: &Sensor) -> u64 {
    let [width, height] = sensor.size();
    width as u64 * height as u64
}

/// Memory \[bytes\] of an image of so many bytes a texel and of so many channels, while its files are written
/// one after the other.
pub(crate) fn written(sensor: &Sensor, each: u64, channels: u64) -> u64 {
    let size = sensor.size().map(|side| side as u64);
    let picture = texels(sensor).saturating_mul(PICTURE);
    let files = picture.max(exr::encoding_bytes(size, channels));
    texels(sensor).saturating_mul(each).saturating_add(files)
}

/// Memory \[bytes\] of a technique's frame: that of its stages or, if it is more, that of the image while it
/// is written, and what is kept beside.
pub(crate) fn of_frame(sensor: &Sensor, stages: u64, kept: u64) -> u64 {
    // The one layer and the total, each with a standard error that is not known; counts.
    const EACH: u64 = 4 * TRIPLE + 8;
    const CHANNELS: u64 = 4 * 3 + 1;
    stages.max(written(sensor, EACH, CHANNELS).saturating_add(kept))
}
