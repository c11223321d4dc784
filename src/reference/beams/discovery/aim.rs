//! Discovery for a sensor that sees little: paths are led there step by step.
//!
//! If one in a million places on first surfaces sends light to a sensor, places that are spread over all of
//! them miss it. But each chain of events maps light space to last legs, smoothly between borders. So each
//! place whose last leg passes near a point of the sensor begins a search. A step tries some places about the
//! best one so far and takes the best of them. The next step looks about that one, nearer by, and so on,
//! until light lands on the film. On a mesh the places about one are on the faces about its own.
//!
//! These steps may fail: light by way of something as small as the part that the sensor sees may still be
//! passed over.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::FRAC_PI_2;

use glam::{DMat2, DVec2, DVec3};
use rayon::prelude::*;

use super::faces::{Faces, MIDDLE};
use super::found::{Discovery, Landing, SignatureLight};
use super::inputs::{DiscoveryInputs, PLACES};
use super::look::LEAST_THROUGHPUT;
use super::places::StartPlace;
use crate::geometry::{Ray, World};
use crate::numeric::math;
use crate::numeric::{Stream, StreamKind};
use crate::transport::first_surface::{ChartPlace, SurfaceChart};
use crate::transport::fixed_signature::PathFollower;
use crate::transport::path_end::End;
use crate::transport::signature::Signature;

/// Number of places at which searches begin, for each signature and each point of the sensor.
const BEGINNINGS: usize = 6;

/// Number of places about the best one that each step tries.
const ABOUT: u64 = 8;

/// Most signatures that are searched for: those whose last legs carry most light.
const MOST_SIGNATURES: usize = 64;

/// Factor of the reach from one step to the next. In a square, with a probability of 1 − (1 − 0.7²)⁸ =
/// 99.5 %, one of eight places is nearer than this to the middle, along both sides. With 65 % one is as near
/// to a corner: then the next step goes as far again.
const NEARER: f64 = 0.7;

/// Most steps of a search.
const STEPS: u64 = 96;

/// Part of the reach over which Newton's method takes differences.
const NEWTON_STEP: f64 = 1e-3;

/// Number of reaches that Newton's method may lead.
const NEWTON_REACH: f64 = 64.0;

/// Number of steps after which a search ends if it has not halved its angle: its light does not come to its
/// point.
const PATIENCE: u64 = 12;

/// Number of places that measure how much light lands.
const AREA_PLACES: u64 = 64;

/// Events up to which every branch is followed to find places where searches begin.
const SPLIT_DEPTH: u32 = 6;

/// Key of the places' stream.
const SEED: u64 = 0x4149_4d00;

/// The inputs that all searches share.
struct Aims<'a> {
    inputs: &'a DiscoveryInputs<'a>,
    /// Points that the sensor measures.
    points: Vec<DVec3>,
    faces: Faces,
}

/// The beginning of a search.
#[derive(Clone, Copy)]
struct Beginning {
    /// Angle \[rad\], about, between the last leg and the way to the point.
    angle: f64,
    light: usize,
    place: StartPlace,
}

/// The result of a path that was followed with one signature.
struct Tried {
    /// The direction of its last leg less that to the point: for small angles, its length is the angle.
    miss: DVec3,
    /// Flux \[W\] by chart area, the part of the light that set out, and the place \[texels\], if it landed
    /// on the film.
    landed: Option<([f64; 2], DVec2)>,
}

/// Signatures by which light gets to the surfaces that the sensor sees, and about how much; those that are
/// `known` are not searched for.
pub(super) fn aim(inputs: &DiscoveryInputs, known: &Discovery) -> Discovery {
    let aims = Aims {
        inputs,
        points: inputs.screen.points(inputs.scene),
        faces: Faces::new(inputs.scene),
    };
    let beginnings: Vec<((Signature, usize), Vec<Beginning>)> =
        aims.beginnings(known).into_iter().collect();
    let found: Vec<Option<SignatureLight>> = beginnings
        .par_iter()
        .enumerate()
        .map(|(index, ((signature, point), beginnings))| {
            let stream = Stream::new(StreamKind::Random, SEED).split(index as u64);
            let mut searches = beginnings.iter().enumerate();
            searches.find_map(|(index, beginning)| {
                let stream = stream.split(index as u64);
                aims.search(*signature, aims.points[*point], beginning, &stream)
            })
        })
        .collect();
    let mut discovery = Discovery::default();
    for ((signature, _), found) in beginnings.iter().map(|(key, _)| key).zip(found) {
        if let Some(found) = found {
            // Searches for other points may have found the same light.
            let known = discovery.signatures.entry(*signature).or_default();
            known.peak = known.peak.max(found.peak);
            if found.flux > known.flux {
                let peak = known.peak;
                *known = SignatureLight { peak, ..found };
            }
        }
    }
    discovery
}

impl Aims<'_> {
    /// The places whose last legs pass nearest to a point, nearest first, by signature and point.
    fn beginnings(&self, known: &Discovery) -> BTreeMap<(Signature, usize), Vec<Beginning>> {
        let mut nearest: BTreeMap<(Signature, usize), Vec<Beginning>> = BTreeMap::new();
        let mut light_by: BTreeMap<Signature, f64> = BTreeMap::new();
        let inputs = self.inputs;
        for index in 0..inputs.lights.len() {
            let stream = Stream::new(StreamKind::Random, SEED ^ 1).split(index as u64);
            let places = inputs.places(index, PLACES);
            let look = |(number, place): (usize, &StartPlace)| {
                let mut follower = inputs.follower(index, Signature::DIRECT);
                let mut legs = Vec::new();
                follower.follow_some(
                    &place.chart,
                    place.at,
                    [SPLIT_DEPTH, inputs.max_depth],
                    LEAST_THROUGHPUT,
                    &mut |signature| stream.extra(number as u64, signature.key()),
                    &mut |signature, leg, path, probability| {
                        if !known.signatures.contains_key(&signature) {
                            let set_out = path.emitted * place.area / probability;
                            legs.push((signature, leg.ray, leg.share.rgb().mean() * set_out));
                        }
                    },
                );
                legs
            };
            let legs: Vec<_> = places.par_iter().enumerate().map(look).collect();
            for (place, legs) in places.iter().zip(&legs) {
                for (signature, ray, light) in legs {
                    *light_by.entry(*signature).or_default() += light;
                    for (number, point) in self.points.iter().enumerate() {
                        let angle = miss(ray, *point).length();
                        let best = nearest.entry((*signature, number)).or_default();
                        let rank = best.partition_point(|one| one.angle <= angle);
                        if rank < BEGINNINGS {
                            best.truncate(BEGINNINGS - 1);
                            let beginning = Beginning {
                                angle,
                                light: index,
                                place: *place,
                            };
                            best.insert(rank, beginning);
                        }
                    }
                }
            }
        }
        let mut signatures: Vec<(Signature, f64)> = light_by.into_iter().collect();
        signatures.sort_by(|(a, x), (b, y)| y.total_cmp(x).then(a.cmp(b)));
        let brightest = signatures.iter().take(MOST_SIGNATURES);
        let brightest: BTreeSet<Signature> = brightest.map(|(signature, _)| *signature).collect();
        nearest.retain(|(signature, _), _| brightest.contains(signature));
        nearest
    }

    /// The light that a search from one place finds.
    fn search(
        &self,
        signature: Signature,
        point: DVec3,
        beginning: &Beginning,
        stream: &Stream,
    ) -> Option<SignatureLight> {
        let mut follower = self.inputs.follower(beginning.light, signature);
        let mut about = Surroundings::new(self, beginning);
        let mut angle = beginning.angle;
        let mut halved = (angle, 0);
        for step in 0..STEPS {
            let mut next = None;
            let straight = about.newton(&mut follower, point);
            let some = (0..ABOUT).map(|number| about.place(stream.point4(step * ABOUT + number)));
            for place in straight.into_iter().chain(some.flatten()) {
                let Some(tried) = follow(&mut follower, &place, point) else {
                    continue;
                };
                if tried.landed.is_some() {
                    about.best = place;
                    return measure(&mut follower, about, point, &stream.split(step));
                }
                if tried.miss.length() < angle {
                    (next, angle) = (Some(place), tried.miss.length());
                }
            }
            about.move_to(next);
            if angle < 0.5 * halved.0 {
                halved = (angle, step);
            }
            if step - halved.1 > PATIENCE {
                break;
            }
        }
        None
    }
}

/// The places about one: a square of its chart's coordinates. On a mesh, if more faces than its own are near,
/// they are places on those.
struct Surroundings<'a> {
    world: &'a World,
    best: StartPlace,
    /// Half the square's side: in chart coordinates, or in space on a mesh.
    reach: f64,
    /// The reach at which searches begin.
    widest: f64,
    faces: &'a Faces,
}

impl<'a> Surroundings<'a> {
    fn new(aims: &'a Aims, beginning: &Beginning) -> Self {
        let (world, best) = (aims.inputs.scene.world(), beginning.place);
        let widest = if matches!(best.chart, SurfaceChart::Face { .. }) {
            // A good part of the mesh.
            0.25 * world.shapes()[best.chart.shape() as usize]
                .bounds()
                .radius()
        } else {
            // The distance of the next places that the discovery tried.
            2.0 * best.area.sqrt()
        };
        Self {
            world,
            best,
            reach: widest,
            widest,
            faces: &aims.faces,
        }
    }

    fn spot(&self, place: &StartPlace) -> Option<ChartPlace> {
        place.chart.place(self.world, place.at)
    }

    /// Length of a unit of the best place's chart on a mesh; 1 elsewhere, as reach is in coordinates there.
    fn unit(&self) -> f64 {
        let is_face = matches!(self.best.chart, SurfaceChart::Face { .. });
        let spot = is_face.then(|| self.spot(&self.best)).flatten();
        spot.map_or(1.0, |spot| spot.area.sqrt())
    }

    /// True if places are on more than one face.
    fn has_more_faces(&self) -> bool {
        matches!(self.best.chart, SurfaceChart::Face { .. }) && self.reach > self.unit()
    }

    /// Half the side of the square in the coordinates of the best place's chart.
    fn half_side(&self) -> f64 {
        self.reach / self.unit()
    }

    /// Goes on about another place, if any. The reach stays if that place was at the border, as the point may
    /// be beyond; else it shrinks.
    fn move_to(&mut self, next: Option<StartPlace>) {
        let is_far = next.is_some_and(|next| {
            if next.chart.face() == self.best.chart.face() {
                (next.at - self.best.at).abs().max_element() > 0.5 * self.half_side()
            } else {
                let both = self.spot(&self.best).zip(self.spot(&next));
                both.is_some_and(|(from, to)| {
                    from.point.position.distance(to.point.position) > 0.5 * self.reach
                })
            }
        });
        self.best = next.unwrap_or(self.best);
        self.reach *= if is_far { 1.0 } else { NEARER };
    }

    /// The place that three numbers in 0..1 stand for; `None` beyond the surface.
    fn place(&self, [x, y, z, _]: [f64; 4]) -> Option<StartPlace> {
        if self.has_more_faces() {
            let offset = self.reach * (2.0 * DVec3::new(x, y, z) - 1.0);
            let about = self.spot(&self.best)?.point.position + offset;
            return inside(self.faces.nearest(about)?, MIDDLE);
        }
        let offset = self.half_side() * (2.0 * DVec2::new(x, y) - 1.0);
        inside(self.best.chart, self.best.at + offset)
    }

    /// The chart area of all places together, with those beyond the surface; about, if they are on faces of
    /// similar size.
    fn area(&self) -> f64 {
        math::powi(2.0 * self.half_side(), 2)
    }

    /// The next place of Newton's method, for the least squares of the last leg's miss. If light spreads by
    /// far more one way than the other, this follows the valley. `None` if it leads out of reach.
    fn newton(&self, follower: &mut PathFollower<3>, point: DVec3) -> Option<StartPlace> {
        if self.has_more_faces() {
            return None;
        }
        let step = NEWTON_STEP * self.half_side();
        let mut miss = |offset: DVec2| {
            let place = inside(self.best.chart, self.best.at + offset)?;
            Some(follow(follower, &place, point)?.miss)
        };
        let here = miss(DVec2::ZERO)?;
        let x = (miss(DVec2::new(step, 0.0))? - here) / step;
        let y = (miss(DVec2::new(0.0, step))? - here) / step;
        let squares = DMat2::from_cols_array(&[x.dot(x), x.dot(y), x.dot(y), y.dot(y)]);
        let offset = -(squares.inverse() * DVec2::new(x.dot(here), y.dot(here)));
        // False for NaN.
        (offset.abs().max_element() <= NEWTON_REACH * self.half_side())
            .then(|| inside(self.best.chart, self.best.at + offset))
            .flatten()
    }
}

/// The place at coordinates of a chart; `None` beyond its surface.
fn inside(chart: SurfaceChart, at: DVec2) -> Option<StartPlace> {
    let is_inside = match chart {
        // The azimuth is periodic.
        SurfaceChart::Cap { .. } => (0.0..=FRAC_PI_2).contains(&at.x),
        SurfaceChart::Parameters { .. } => {
            at.cmpge(DVec2::ZERO).all() && at.cmple(DVec2::ONE).all()
        }
        SurfaceChart::Face { .. } => at.cmpge(DVec2::ZERO).all() && at.x + at.y <= 1.0,
    };
    is_inside.then_some(StartPlace {
        chart,
        at,
        area: 0.0,
    })
}

/// The path from a place with all its events; `None` if it ended before the last leg.
fn follow(follower: &mut PathFollower<3>, place: &StartPlace, point: DVec3) -> Option<Tried> {
    let (mut legs, mut last) = (0, None);
    let path = follower.follow_legs(&place.chart, place.at, false, |ray, _| {
        legs += 1;
        last = Some(*ray);
    });
    let ray = last.filter(|_| legs == follower.events() + 1)?;
    let on_film = match path.end {
        End::Landed(at) if follower.screen().is_on_film(at) => Some(at),
        _ => None,
    };
    let throughput = path.throughput.rgb().mean();
    let strength = follower.source().strength().mean();
    Some(Tried {
        miss: miss(&ray, point),
        landed: on_film.map(|at| ([throughput * path.emitted, throughput / strength], at)),
    })
}

/// The light, about, that lands on the film from the surroundings of a place that sends some there.
fn measure(
    follower: &mut PathFollower<3>,
    mut about: Surroundings,
    point: DVec3,
    stream: &Stream,
) -> Option<SignatureLight> {
    let mut has_shrunk = false;
    for step in 0..STEPS {
        let stream = stream.split(step);
        let landed: Vec<([f64; 2], DVec2)> = (0..AREA_PLACES)
            .filter_map(|number| about.place(stream.point4(number)))
            .filter_map(|place| follow(follower, &place, point)?.landed)
            .collect();
        let count = landed.len() as u64;
        if count * 16 < AREA_PLACES {
            // Too few to tell how many.
            about.reach *= NEARER;
            has_shrunk = true;
        } else if count * 4 > AREA_PLACES && !has_shrunk && about.reach < about.widest {
            // Most send some: there is more beyond.
            about.reach *= 1.0 / NEARER;
        } else {
            let sum: f64 = landed.iter().map(|([flux, _], _)| flux).sum();
            let peak = landed.iter().map(|([_, delivered], _)| *delivered);
            let at = landed.first()?.1;
            let flux = sum * about.area() / AREA_PLACES as f64;
            return Some(SignatureLight {
                flux,
                peak: peak.fold(0.0, f64::max),
                on_film: flux,
                landings: vec![Landing { at, flux }],
            });
        }
    }
    None
}

/// The miss of a ray at a point: its direction less that to the point. Its length is the angle if that is
/// small.
fn miss(ray: &Ray, point: DVec3) -> DVec3 {
    ray.direction - (point - ray.origin).normalize_or_zero()
}
