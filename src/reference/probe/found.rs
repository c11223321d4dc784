//! The light that a probe finds.

use glam::DVec3;

use crate::geometry::{SurfacePoint, TraversalCounters};
use crate::radiometry::Rgb;
use crate::transport::scatter::Way;
use crate::transport::signature::Signature;

/// All light that reaches a point.
#[derive(Clone, Debug)]
pub struct Probed {
    /// The point.
    pub point: SurfacePoint,
    /// The paths, by signature, then the brightest first.
    pub paths: Vec<SpecularPath>,
    /// Patches of light space that may hold one more path, because they stayed unclear to the last level or
    /// to the last ray.
    pub unresolved: u64,
    /// The reason why the search ended.
    pub end: SearchEnd,
    /// Number of times that cells were divided until then, at most [`MAX_LEVEL`](super::MAX_LEVEL).
    pub level: u32,
    /// Number of patches of light space that were traced.
    pub patches: u64,
    /// Work done.
    pub counters: TraversalCounters,
}

impl Probed {
    /// Pointwise irradiance \[W/m²\] by all paths together.
    pub fn irradiance(&self) -> Rgb {
        self.paths.iter().map(|path| path.irradiance).sum()
    }
}

/// The reason why a search for paths ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SearchEnd {
    /// Nothing was left to search.
    #[default]
    Complete,
    /// It reached [`ProbeSettings::max_rays`](super::ProbeSettings::max_rays).
    OutOfRays,
    /// It was told to stop.
    Stopped,
}

/// One path of light from an emitter to the point.
#[derive(Clone, Debug)]
pub struct SpecularPath {
    /// The specular events on the way.
    pub signature: Signature,
    /// The emitter, as an index into the scene's.
    pub emitter: usize,
    /// The start of the ray: the emitter, or for parallel light a point before the scene.
    pub origin: DVec3,
    /// The unit direction in which the ray starts.
    pub direction: DVec3,
    /// The surfaces that the ray meets, without the receiver.
    pub vertices: Vec<Vertex>,
    /// The share (0..=1) of the emitted flux that arrives.
    pub throughput: Rgb,
    /// |det J|: receiver area for a unit of light-space measure, \[m²/sr\] for points and spots, \[m²/m²\]
    /// for parallel light.
    pub jacobian: f64,
    /// True if the sheet of light is turned over, compared with light that met flat mirrors instead. Then it
    /// has passed an odd number of caustics on its way.
    pub folded: bool,
    /// Pointwise irradiance \[W/m²\].
    pub irradiance: Rgb,
    /// Distance \[m\] on the receiver to the nearest fold of this path's sheet, to first order; `None` if
    /// that order shows no fold.
    ///
    /// It is |det J| / (2 |∇ det J|), with the gradient taken on the receiver. Near a fold det J grows as the
    /// square root of the distance, and the value is the distance exactly. Far from any fold it is an order
    /// of magnitude. The gradient is a central difference of the exact det J. On meshes det J jumps from face
    /// to face, and the gradient may be that of a jump.
    pub fold_distance: Option<f64>,
    /// Distance \[m\] on the receiver between the point and the arrival of the ray, traced through the scene.
    pub residual: f64,
}

/// A surface on a path.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    /// The shape, as an index into the scene's objects.
    pub shape: u32,
    /// The triangle; 0 on shapes that are not meshes.
    pub face: u32,
    /// The way on which light leaves the surface.
    pub way: Way,
    /// World space position.
    pub position: DVec3,
    /// The unit normal that bends light.
    pub normal: DVec3,
}
