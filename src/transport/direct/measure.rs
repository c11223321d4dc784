//! Direct irradiance of all texels, row by row on all cores.

use rayon::prelude::*;

use super::area::SMOOTH_ERROR;
use super::environment::is_open;
use super::glance::{Glance, is_near_edge};
use super::light::DirectLight;
use super::sampled::{REPLICATES, SAMPLES, unseen_part};
use super::shaft::are_to_be_cut;
use super::shafts::{Shafts, TexelView};
use super::texel::DirectTexel;
use super::window::Window;
use crate::geometry::TraversalCounters;
use crate::numeric::{Stream, StreamKind};
use crate::radiometry::Rgb;
use crate::scene::{Emitter, Scene};
use crate::transport::domain::normal_light::NormalLight;
use crate::transport::domain::surface::LightSurface;
use crate::transport::domain::textured::TexturedSurface;
use crate::transport::lights::Environment;
use crate::transport::receiver::Receiver;

/// Samples of a texel and an area light, an environment or an image if no more are asked for.
pub const AREA_SAMPLES: u32 = REPLICATES * SAMPLES;

/// A scene, a receiver, and the wish to stop.
type MeasuredScene<'a> = (&'a Scene, &'a Receiver, &'a (dyn Fn() -> bool + Sync));

/// Direct irradiance of every texel, and the work it took.
#[derive(Clone, Debug)]
pub struct Direct {
    /// Texels row by row, as the receiver's.
    pub texels: Vec<DirectTexel>,
    /// Shadow rays and their cost.
    pub counters: TraversalCounters,
}

/// Measures `LD` on every texel of the receiver; `None` if `stop` asked for an end before.
///
/// Texels in which an area light, an environment or an image is hard to measure get `samples` samples of it.
pub fn direct(
    scene: &Scene,
    receiver: &Receiver,
    seed: u64,
    samples: u32,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Direct> {
    let stream = Stream::new(StreamKind::Sobol, seed).split(0x4c44);
    let mut result = Direct {
        texels: vec![DirectTexel::default(); receiver.texels()],
        counters: TraversalCounters::default(),
    };
    for (index, emitter) in scene.emitters().iter().enumerate() {
        let stream = stream.split(index as u64);
        let run = (scene, receiver, stop);
        match emitter {
            Emitter::Area { shape, texture, .. } => {
                let surface = LightSurface::new(&scene.world().shapes()[shape.0 as usize]);
                // Light space refuses lights whose surface is not modelled.
                let Some(surface) = surface else { continue };
                let mut textured = None;
                let mut radiance = emitter.strength();
                if let Some(id) = texture {
                    let Some(light) = TexturedSurface::new(scene, *shape, *id, &surface) else {
                        continue;
                    };
                    match light.even() {
                        Some(value) => radiance = radiance * value,
                        None => textured = Some(light),
                    }
                }
                let unseen = |each: u32| {
                    let light = textured.as_ref();
                    light.map_or(Rgb::BLACK, |it| it.unseen(unseen_part(each)))
                };
                let (first, again) = (unseen(SAMPLES), unseen(samples / REPLICATES));
                let area = |at: &mut DirectLight, texel: usize, stream: &Stream, each: u32| {
                    match &textured {
                        Some(light) => {
                            let unseen = if each == SAMPLES { first } else { again };
                            at.textured_area(texel, radiance, (light, unseen), stream, each)
                        }
                        None => at.area(texel, radiance, &surface, stream, each),
                    }
                };
                let measured = result.by_samples(run, None, &stream, samples, false, area)?;
                result.add(measured);
            }
            Emitter::DirectionalArea { .. } => {
                let parts = NormalLight::parts(scene, emitter).unwrap_or_default();
                for (number, part) in parts.iter().enumerate() {
                    let emitter = part.without_size();
                    let measured = if part.has_pattern() {
                        let stream = stream.split(number as u64);
                        // It ends in an edge, which may cut off less of a texel than samples find.
                        let patterned =
                            |at: &mut DirectLight, texel: usize, stream: &Stream, each: u32| {
                                let window = at.window(texel, part);
                                if window.as_ref().is_some_and(Window::is_outside) {
                                    return Glance::DARK;
                                }
                                let one = (&emitter, part, window.as_ref());
                                at.patterned(texel, one, stream, each)
                            };
                        result.by_samples(run, Some(part), &stream, samples, false, patterned)?
                    } else {
                        result.by_windows(run, &emitter, part)?
                    };
                    result.add(measured);
                }
            }
            _ => {
                let measured = if let Some(light) = Environment::of(emitter) {
                    let is_open = is_open(scene, receiver);
                    let all_round =
                        |at: &mut DirectLight, texel: usize, stream: &Stream, each: u32| {
                            at.environment(texel, &light, stream, each, is_open)
                        };
                    result.by_samples(run, None, &stream, samples, !is_open, all_round)?
                } else if emitter.slide().is_some() {
                    let thrown =
                        |at: &mut DirectLight, texel: usize, stream: &Stream, each: u32| {
                            at.image(texel, emitter, stream, each)
                        };
                    result.by_samples(run, None, &stream, samples, false, thrown)?
                } else {
                    result.by_views(run, emitter)?
                };
                result.add(measured);
            }
        }
    }
    Some(result)
}

/// The stream of second samples; streams of texels are counted from 0.
const AGAIN: u64 = u64::MAX;

/// True if the scatter of a texel's samples is large.
fn is_rough(texel: &DirectTexel) -> bool {
    texel.error.max_channel() > SMOOTH_ERROR * texel.irradiance.max_channel()
}

impl Direct {
    /// The state before any measurement: every texel is NaN.
    pub fn unknown(texels: usize) -> Self {
        Self {
            texels: vec![DirectTexel::UNKNOWN; texels],
            counters: TraversalCounters::default(),
        }
    }

    fn add(&mut self, measured: Vec<DirectTexel>) {
        for (sum, part) in self.texels.iter_mut().zip(measured) {
            sum.irradiance += part.irradiance;
            sum.error += part.error;
        }
    }

    /// An emitter that sends one ray to each point.
    fn by_views(
        &mut self,
        (scene, receiver, stop): MeasuredScene,
        emitter: &Emitter,
    ) -> Option<Vec<DirectTexel>> {
        let shafts = Shafts::new(scene, receiver, emitter);
        let known = shafts
            .as_ref()
            .map(|shafts| (shafts, shafts.views(stop, &mut self.counters)));
        let view = |texel: usize| {
            let (shafts, views) = known.as_ref()?;
            Some((*shafts, views.of(texel)))
        };
        let run = (scene, receiver, stop);
        let first = self.by_row(run, None, |at, texel| match view(texel) {
            Some((_, TexelView::Same(share))) => at.glance(texel, emitter, Some(share)),
            Some((shafts, TexelView::Divided(by))) if are_to_be_cut(by) => {
                at.divided(texel, emitter, shafts, by)
            }
            _ => at.glance(texel, emitter, None),
        })?;
        self.by_row(run, None, |at, texel| {
            let value = first[texel].value;
            match view(texel) {
                Some((_, TexelView::Same(_))) => value,
                Some((_, TexelView::Divided(by))) if are_to_be_cut(by) => value,
                _ if !is_near_edge(&first, texel, receiver) => value,
                Some((shafts, TexelView::Divided(by))) => {
                    at.divided(texel, emitter, shafts, by).value
                }
                Some((_, TexelView::Unknown)) | None => at.edge(texel, emitter),
            }
        })
    }

    /// The rays of an emitter that sends one ray to each point, if they meet a part.
    ///
    /// There are no shafts: what is between a part and the receiver is not what is between it and infinity.
    fn by_windows(
        &mut self,
        run: MeasuredScene,
        emitter: &Emitter,
        part: &NormalLight,
    ) -> Option<Vec<DirectTexel>> {
        let first = self.by_row(run, Some(part), |at, texel| {
            let window = at.window(texel, part);
            let glance = match &window {
                Some(window) if window.is_outside() => Glance::DARK,
                Some(window) if window.is_exact && window.is_divided() => {
                    at.through(texel, (emitter, part), window)
                }
                _ => at.glance(texel, emitter, None),
            };
            (glance, window)
        })?;
        let (first, windows): (Vec<_>, Vec<_>) = first.into_iter().unzip();
        let (_, receiver, _) = run;
        self.by_row(run, Some(part), |at, texel| {
            let value = first[texel].value;
            let is_near_edge = is_near_edge(&first, texel, receiver);
            match &windows[texel] {
                Some(window) if window.is_outside() => value,
                Some(window) if window.is_exact => {
                    if !is_near_edge {
                        return value;
                    }
                    let found = at.edge(texel, emitter);
                    if window.is_divided() && !window.is_found_by(&first[texel], &found) {
                        return value;
                    }
                    found
                }
                window => {
                    let is_divided = window.as_ref().is_some_and(Window::is_divided);
                    if !is_near_edge && !is_divided && !at.is_divided_by_end(texel, part) {
                        return value;
                    }
                    let mut found = at.edge(texel, emitter);
                    if let Some(window) = window
                        && found.irradiance.is_black()
                    {
                        // Less than the points of the closer look tell.
                        found.error = at.through(texel, (emitter, part), window).value.error;
                    }
                    found
                }
            }
        })
    }

    /// The mean of samples of every texel, and of `samples` of them where it is hard to measure, or
    /// `everywhere`. `measure` takes a texel, its stream and the samples of each replicate. Light may start
    /// at a `part`.
    ///
    /// Anything small hides a part of the sky. If only texels whose first samples met it were measured anew,
    /// the others would be too bright on average.
    fn by_samples(
        &mut self,
        run: MeasuredScene,
        part: Option<&NormalLight>,
        stream: &Stream,
        samples: u32,
        everywhere: bool,
        measure: impl Fn(&mut DirectLight, usize, &Stream, u32) -> Glance + Sync,
    ) -> Option<Vec<DirectTexel>> {
        let first = self.by_row(run, part, |at, texel| {
            measure(at, texel, &stream.split(texel as u64), SAMPLES)
        })?;
        let each = samples / REPLICATES;
        // Points of their own: the first points chose the texels, and this must not bias the second result.
        let again = stream.split(AGAIN);
        let (_, receiver, _) = run;
        self.by_row(run, part, |at, texel| {
            let value = first[texel].value;
            let is_hard = everywhere || is_near_edge(&first, texel, receiver) || is_rough(&value);
            if each > SAMPLES && is_hard {
                measure(at, texel, &again.split(texel as u64), each).value
            } else {
                value
            }
        })
    }

    /// `measure` of every texel, on all cores; counts the work.
    fn by_row<T: Send>(
        &mut self,
        (scene, receiver, stop): MeasuredScene,
        part: Option<&NormalLight>,
        measure: impl Fn(&mut DirectLight, usize) -> T + Sync,
    ) -> Option<Vec<T>> {
        let rows: Option<Vec<(Vec<T>, TraversalCounters)>> = (0..receiver.height())
            .into_par_iter()
            .map(|row| {
                let mut at = DirectLight {
                    scene,
                    receiver,
                    stop,
                    part,
                    counters: TraversalCounters::default(),
                };
                let mut texels = Vec::with_capacity(receiver.width());
                for column in 0..receiver.width() {
                    texels.push(measure(&mut at, row * receiver.width() + column));
                    // A texel that was given up halfway is no measurement.
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
