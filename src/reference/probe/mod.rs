//! Every specular path from lights without size to one receiver point, by root finding.
//!
//! Light of a delta emitter is a two-dimensional family of rays; each chain of specular surfaces maps it to the
//! receiver. At a point, the irradiance is a sum over the preimages x of the point under all these maps,
//!
//! ```text
//! E = Σ w(x) / |det J(x)|
//! ```
//!
//! with w the flux per unit of light-space measure (intensity per solid angle, or irradiance across parallel light) times
//! Fresnel's shares and tints, and det J the receiver area per unit of that measure (Mitchell and Hanrahan, *Illumination from
//! curved reflectors*, SIGGRAPH 1992). Nothing is sampled at random and nothing averaged: this is the *pointwise* irradiance,
//! infinite on a fold, where every other method measures averages over texels. It shares with those the
//! intersections and Fresnel's formulas, but neither cells, nor densities, nor deposits: an independent check.
//!
//! # How preimages are found
//!
//! The cells of [light space](crate::transport::domain) are looked at on 3 x 3 nodes: `search` traces the full Fresnel tree
//! with [derivatives](crate::transport::differentials) at each, and divides a patch until each chain in it
//! is either away from the point, by a margin from its second differences, or so nearly linear that it meets the point once at
//! most. There `newton` finds the root; `path` traces it through the scene as it is.
//!
//! # What it does not promise
//!
//! A feature that none of the nodes' rays meets is not known: nodes stand about 1/100 of the specular geometry's width apart at first
//! ([`ProbeSettings::first_level`] halves that at each step, and outlines seen from the emitter are divided four times in any case). So small
//! facets and far occluders' outlines can be missed: tests hold it to a diamond's polygons of light down to 1/30 of its width; one of 1/150 was missed. Margins come from samples; they are no interval proof. Patches that
//! stay unclear to the last level, as they must where the point lies *on* a fold or a focus, are counted in
//! [`Probed::unresolved`]. On a focus each level may have twice the patches of the one before: there
//! [`ProbeSettings::max_rays`] ends the search, and [`Probed::end`] says so.

mod direct;
mod map;
mod newton;
mod path;
mod search;
mod target;

use glam::{DVec2, DVec3};

pub use search::MAX_LEVEL;

use crate::geometry::{SurfacePoint, TraversalCounters};
use crate::radiometry::Rgb;
use crate::scene::{Scene, Sensor};
use crate::transport::chain_limits;
use crate::transport::domain::{LightSpace, LightSpaceError};
use crate::transport::receiver::{Receiver, ReceiverError};
use crate::transport::scatter::{ShadingNormals, Way};
use crate::transport::signature::{MAX_EVENTS, Signature};

/// How far paths are followed and how closely light is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ProbeSettings {
    /// Specular events after which light is cut off, at most [`MAX_EVENTS`].
    pub max_depth: u32,
    /// What interpolated normals do to flux.
    pub shading_normals: ShadingNormals,
    /// How often every cell of light space is divided before anything is decided.
    pub first_level: u32,
    /// Rays after which no more patches are divided.
    pub max_rays: u64,
}

impl Default for ProbeSettings {
    /// 16 events, cells as they are, 2²⁵ rays (some seconds): more than a search away from foci takes in
    /// most scenes, as 2²⁴·³ in the shipped `glass-ball` where three sheets of light meet.
    fn default() -> Self {
        Self {
            max_depth: 16,
            shading_normals: ShadingNormals::Flux,
            first_level: 0,
            max_rays: 1 << 25,
        }
    }
}

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

impl Probed {
    /// Pointwise irradiance \[W/m²\] by all paths together.
    pub fn irradiance(&self) -> Rgb {
        self.paths.iter().map(|path| path.irradiance).sum()
    }
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

/// Why a point cannot be probed.
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
        /// Counted from 1, in the scene's order.
        emitter: usize,
    },
    /// Deeper than a signature can tell.
    #[error("max_depth = {0}: allowed are 0 to {MAX_EVENTS}")]
    Depth(u32),
}

/// Finds every specular path from the scene's emitters to the point at `uv` of the shape that `sensor` measures,
/// and direct light.
///
/// # Errors
///
/// As [`probe_until`].
pub fn probe(
    scene: &Scene,
    sensor: &Sensor,
    uv: DVec2,
    settings: &ProbeSettings,
) -> Result<Probed, ProbeError> {
    probe_until(scene, sensor, uv, settings, &|| false)
}

/// As [`probe`], until `stop` says so: then what was found by that time.
///
/// The crop of the sensor's film does not matter. Results that nothing stopped are the same bits on any number of threads.
///
/// # Errors
///
/// Where the sensor is no irradiance meter on a shape with (u, v), `uv` is outside of it, or an emitter has a surface.
pub fn probe_until(
    scene: &Scene,
    sensor: &Sensor,
    uv: DVec2,
    settings: &ProbeSettings,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Probed, ProbeError> {
    if settings.max_depth as usize > MAX_EVENTS {
        return Err(ProbeError::Depth(settings.max_depth));
    }
    let receiver = Receiver::new(scene, sensor)?;
    let target =
        target::ProbeTarget::new(scene, &receiver, uv).ok_or(ProbeError::OffReceiver(uv))?;
    chain_limits::check(scene).map_err(LightSpaceError::from)?;
    let area = scene
        .emitters()
        .iter()
        .position(|emitter| !emitter.is_delta());
    if let Some(index) = area {
        return Err(ProbeError::AreaEmitter { emitter: index + 1 });
    }
    let light = LightSpace::new(scene)?;
    let map = map::LightMap::new(scene, &light, &target, settings);
    let found = search::search(&map, stop);
    let mut counters = found.counters;
    let mut paths = direct::direct_paths(&map, &mut counters);
    paths.extend(path::specular_paths(&map, found.roots, &mut counters));
    paths.sort_by(|a, b| {
        let brighter = b.irradiance.mean().total_cmp(&a.irradiance.mean());
        a.signature.cmp(&b.signature).then(brighter)
    });
    Ok(Probed {
        point: target.point(),
        paths,
        unresolved: found.unresolved,
        end: found.end,
        level: found.level,
        patches: found.patches,
        counters,
    })
}
