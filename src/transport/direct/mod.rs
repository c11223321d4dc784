//! `LD`: light that comes straight from an emitter to the receiver, by quadrature.
//!
//! A delta emitter's light is integrated over a texel with 2 x 2 Gauss points. Shadows have sharp
//! edges, which may run through a texel and yet miss its four points; so a texel is looked at closely
//! where its points *or its neighbours'* differ in what they see of the emitter: it is cut along the edge
//! (`edge.rs`). What its bend leaves uncertain is booked as error. Texels on several faces are
//! cut into a quadtree instead, at least `EDGE_LEVELS` deep and down to `SHADOW_LEVELS` where any of a leaf's
//! guards, which stand a little outside of it, sees otherwise than the rest; what is
//! still mixed there is booked as error. Area lights are integrated over texel and emitter
//! together by randomised quasi-Monte Carlo, with `AREA_SAMPLES` a texel; where more are asked for, texels about shadows' edges,
//! and those whose scatter is large, are sampled anew with so many.
//!
//! Averages are by surface area. Where a mesh covers a texel in part, or faces that stretch or lean
//! differently meet in it, the parts where they do are cut into smaller ones, too (`EDGE_LEVELS`
//! deep), and what remains uncertain is booked as error.
//!
//! A shadow (or a gap in one) narrower than about half a texel can be missed, and in a texel with an
//! edge one narrower than 1/8 of it.

mod area;
mod delta;
mod edge;
mod look;

pub use area::REPLICATES as AREA_REPLICATES;

/// Samples of a texel and an area light where no more are asked for.
pub const AREA_SAMPLES: u32 = AREA_REPLICATES * area::SAMPLES;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::domain::surface::LightSurface;
use super::receiver::{Patch, Receiver};
use super::visibility::transmittance;
use crate::geometry::{SurfacePoint, TraversalCounters};
use crate::numeric::{Stream, StreamKind};
use crate::radiometry::Rgb;
use crate::scene::{Emitter, Scene};

/// Half the distance of two Gauss points on an interval of length 1: 1 / (2 √3).
const GAUSS: f64 = 0.288_675_134_594_812_9;

/// A texel's direct irradiance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DirectTexel {
    /// Average irradiance [W/m²].
    pub irradiance: Rgb,
    /// For delta emitters a bound, for area lights the standard error [W/m²].
    pub error: Rgb,
}

impl DirectTexel {
    /// Nothing is known of it.
    const UNKNOWN: Self = Self {
        irradiance: Rgb::grey(f64::NAN),
        error: Rgb::grey(f64::NAN),
    };
}

/// Direct irradiance of every texel, and the work it took.
#[derive(Clone, Debug)]
pub struct Direct {
    /// Row by row, as the receiver's texels.
    pub texels: Vec<DirectTexel>,
    /// Shadow rays and their cost.
    pub counters: TraversalCounters,
}

/// Measures `LD` on every texel of the receiver, with so many samples of a texel and an area light where light is hard to
/// measure; `None` where `stop` said so before the end.
pub fn direct(
    scene: &Scene,
    receiver: &Receiver,
    seed: u64,
    samples: u32,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Direct> {
    let stream = Stream::new(StreamKind::Sobol, seed).split(0x4c44);
    // A light whose surface is not modelled has been refused when light space was built.
    let surfaces: Vec<Option<LightSurface>> = scene
        .emitters()
        .iter()
        .map(|emitter| match emitter {
            Emitter::Area { shape, .. } => {
                LightSurface::new(&scene.world().shapes()[shape.0 as usize])
            }
            _ => None,
        })
        .collect();
    let mut result = Direct {
        texels: vec![DirectTexel::default(); receiver.texels()],
        counters: TraversalCounters::default(),
    };
    for (index, (emitter, surface)) in scene.emitters().iter().zip(&surfaces).enumerate() {
        let measured = if let Some(surface) = surface {
            let stream = stream.split(index as u64);
            let area = |at: &mut DirectLight, texel: usize, stream: &Stream, each: u32| {
                at.area(texel, emitter, surface, &stream.split(texel as u64), each)
            };
            let first = result.by_row(scene, receiver, stop, |at, texel| {
                area(at, texel, &stream, area::SAMPLES)
            })?;
            let each = samples / AREA_REPLICATES;
            // Points of their own: that texels were chosen by the first ones does not bias what the second ones find.
            let again = stream.split(AGAIN);
            result.by_row(scene, receiver, stop, |at, texel| {
                let value = first[texel].value;
                let is_hard = delta::is_near_edge(&first, texel, receiver) || is_rough(&value);
                if each > area::SAMPLES && is_hard {
                    area(at, texel, &again, each).value
                } else {
                    value
                }
            })?
        } else {
            let first =
                result.by_row(scene, receiver, stop, |at, texel| at.glance(texel, emitter))?;
            result.by_row(scene, receiver, stop, |at, texel| {
                if delta::is_near_edge(&first, texel, receiver) {
                    at.edge(texel, emitter)
                } else {
                    first[texel].value
                }
            })?
        };
        for (sum, part) in result.texels.iter_mut().zip(measured) {
            sum.irradiance += part.irradiance;
            sum.error += part.error;
        }
    }
    Some(result)
}

/// The stream of second samples; texels' are counted from 0.
const AGAIN: u64 = u64::MAX;

/// Whether the scatter of a texel's samples is large.
fn is_rough(texel: &DirectTexel) -> bool {
    texel.error.max_channel() > area::SMOOTH_ERROR * texel.irradiance.max_channel()
}

impl Direct {
    /// What is known before anything was measured: nothing, which is NaN.
    pub fn unknown(texels: usize) -> Self {
        Self {
            texels: vec![DirectTexel::UNKNOWN; texels],
            counters: TraversalCounters::default(),
        }
    }

    /// `measure` of every texel, on all cores; counts the work.
    fn by_row<T: Send>(
        &mut self,
        scene: &Scene,
        receiver: &Receiver,
        stop: &(dyn Fn() -> bool + Sync),
        measure: impl Fn(&mut DirectLight, usize) -> T + Sync,
    ) -> Option<Vec<T>> {
        let rows: Option<Vec<(Vec<T>, TraversalCounters)>> = (0..receiver.height())
            .into_par_iter()
            .map(|row| {
                let mut at = DirectLight {
                    scene,
                    receiver,
                    stop,
                    counters: TraversalCounters::default(),
                };
                let mut texels = Vec::with_capacity(receiver.width());
                for column in 0..receiver.width() {
                    texels.push(measure(&mut at, row * receiver.width() + column));
                    // What was given up in its middle is no measurement.
                    if stop() {
                        return None;
                    }
                }
                Some((texels, at.counters))
            })
            .collect();
        let mut all = Vec::with_capacity(receiver.texels());
        for (texels, counters) in rows? {
            all.extend(texels);
            self.counters += counters;
        }
        Some(all)
    }
}

/// Looks from the receiver at emitters.
struct DirectLight<'a> {
    scene: &'a Scene,
    receiver: &'a Receiver,
    /// Whether to give up: what is measured from then on is thrown away.
    stop: &'a (dyn Fn() -> bool + Sync),
    counters: TraversalCounters,
}

impl DirectLight<'_> {
    /// The receiver at fractions `at` across a texel; `None` where it has no surface there.
    fn patch(&self, texel: usize, at: DVec2) -> Option<Patch> {
        self.receiver.patch(self.scene, texel, at)
    }

    /// The share of light that reaches `point` along `-towards` past null surfaces and masks.
    fn transmittance(&mut self, point: &SurfacePoint, towards: DVec3, distance: f64) -> f64 {
        transmittance(self.scene, point, towards, distance, &mut self.counters)
    }
}
