//! The flux of a technique's frame, from the light to the image.

use serde::Serialize;

use crate::radiometry::Rgb;

/// One change of a technique's flux \[W\], with the stage that makes it and its reason.
///
/// The first entry is the flux that set out, the others are what stages drop (negative) or add. All together
/// are the flux on the sensor, Σ E A over its texels; of a camera, whose values are no flux, that on the map
/// or on the surfaces.
///
/// # Example: the largest loss of a frame
///
/// ```
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let map = nephroid::Method::new("caustic-map", &Default::default())?;
/// # let map = map.with("photons", "16")?.with("map", "16")?;
/// # let rendering = map.run(&scene, sensor, &Default::default(), &Default::default())?;
/// let by_flux = |a: &&nephroid::FluxEntry, b: &&nephroid::FluxEntry| {
///     a.flux.mean().total_cmp(&b.flux.mean())
/// };
/// let loss = rendering.flux.iter().min_by(by_flux).unwrap();
/// println!("{}: {}: {:.3} W", loss.stage, loss.reason, loss.flux.mean());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FluxEntry {
    /// The stage.
    pub stage: &'static str,
    /// What it does to the flux, and why.
    pub reason: &'static str,
    /// The change \[W\]: positive where flux is added.
    pub flux: Rgb,
    /// Photons, or corners of beams, that came to nothing for this reason, or set out; 0 where each may have
    /// lost a part.
    pub photons: u64,
}
