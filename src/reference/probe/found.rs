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
    /// Patches of light space that may hold a path more, because they stayed unclear to the last level or to the last ray.
    pub unresolved: u64,
    /// Why the search ended.
    pub end: SearchEnd,
    /// How often cells were divided when it did, at most [`MAX_LEVEL`].
    pub level: u32,
    /// Patches of light space looked at.
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

/// Why a search for paths ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SearchEnd {
    /// Nothing was left to look at.
    #[default]
    Complete,
    /// At [`ProbeSettings::max_rays`].
    OutOfRays,
    /// It was told to stop.
    Stopped,
}

/// One path of light from an emitter to the point.
#[derive(Clone, Debug)]
pub struct SpecularPath {
    /// What happened on the way.
    pub signature: Signature,
    /// The emitter, as an index into the scene's.
    pub emitter: usize,
    /// Where the ray starts: the emitter, or for parallel light a point before the scene.
    pub origin: DVec3,
    /// The unit direction in which it starts.
    pub direction: DVec3,
    /// The surfaces it meets, without the receiver.
    pub vertices: Vec<Vertex>,
    /// The share (0..=1) of the emitted flux that arrives.
    pub throughput: Rgb,
    /// |det J|: receiver area per light-space measure, \[m²/sr\] for points and spots, \[m²/m²\] for parallel light.
    pub jacobian: f64,
    /// Whether the sheet of light is turned over, compared with light that met flat mirrors instead: it has passed an odd
    /// number of caustics on its way.
    pub folded: bool,
    /// Pointwise irradiance \[W/m²\].
    pub irradiance: Rgb,
    /// The distance (m) on the receiver to the nearest fold of this path's sheet, to first order; `None` where that knows of none.
    ///
    /// |det J| / (2 |∇ det J|), the gradient taken on the receiver: near a fold det J grows as the square root of the distance,
    /// and this is the distance exactly. Far from any fold it is an order of magnitude. The gradient is a central
    /// difference of the exact det J; on meshes, whose det J jumps from face to face, it may be that of a jump.
    pub fold_distance: Option<f64>,
    /// The distance (m) on the receiver between the point and where the ray, traced through the scene, arrives.
    pub residual: f64,
}

/// A surface on a path.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    /// The shape, as an index into the scene's objects.
    pub shape: u32,
    /// The triangle; 0 on shapes that are not meshes.
    pub face: u32,
    /// How light goes on.
    pub way: Way,
    /// World space.
    pub position: DVec3,
    /// The unit normal that bends light.
    pub normal: DVec3,
}
