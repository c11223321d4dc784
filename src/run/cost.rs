//! The cost of a run, before anything is traced.

use serde::Serialize;

use super::Counter;

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
