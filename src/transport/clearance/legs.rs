//! The straight parts of a cell's six paths, side by side.

use glam::DVec3;

use super::trail::{Straight, Trail};
use crate::geometry::{Bounds, Hit, Hull, Ray, range};
use crate::scene::Scene;
use crate::transport::first_surface::SurfaceChart;
use crate::transport::fixed_signature::PathFollower;
use crate::transport::path_end::End;
use crate::transport::screen::Screen;

/// The thing at an end of a leg.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LegContact {
    /// The light source.
    Source,
    /// A shape.
    Surface(u32),
    /// The plane of this shape, the receiver: the rectangle or disc itself, or its extension beyond the
    /// border.
    Plane(u32),
    /// The camera that sees where light landed.
    Eye,
    /// Nothing: the light left the scene.
    Nothing,
}

/// A leg of six paths that start and end on the same things.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leg {
    pub(super) start: [DVec3; 6],
    pub(super) end: [DVec3; 6],
    pub(super) from: LegContact,
    pub(super) to: LegContact,
    /// Faces of the meshes that they start on; 0 elsewhere.
    pub(super) from_faces: [u32; 6],
    /// Faces of the meshes that they end on; 0 elsewhere.
    pub(super) to_faces: [u32; 6],
    /// The sensor's knowledge of it.
    pub(super) sight: LegSight,
}

/// A sensor's knowledge of a leg.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LegSight {
    /// The leg has light for the sensor, or other legs follow.
    NotAsked,
    /// It is a last leg that brings this receiver no light.
    DarkOver(u32),
    /// The camera sees nothing of the whole bundle, whatever the bundle meets.
    OutOfView,
    /// The camera sees nothing of the bundle as far as the leg's end.
    OutOfViewToEnd,
    /// The camera sees nothing of the surface at the end, if all light ends there.
    EndUnseen,
    /// The camera might see surface between the six ends.
    MaybeSeen,
}

impl Leg {
    pub(super) fn starts_on(&self, shape: u32) -> bool {
        self.from == LegContact::Surface(shape)
    }

    pub(super) fn ends_on(&self, shape: u32) -> bool {
        matches!(self.to, LegContact::Surface(on) | LegContact::Plane(on) if on == shape)
    }

    /// The vectors from its starts to its ends.
    pub(super) fn along(&self) -> [DVec3; 6] {
        std::array::from_fn(|i| self.end[i] - self.start[i])
    }
}

/// The shared legs of six paths.
pub(super) struct LegRecord {
    /// The legs, as far as all six met the same things.
    pub(super) legs: Vec<Leg>,
    /// True if all six ended the same way by way of the same surfaces.
    pub(super) one_topology: bool,
    /// True if none of the six has its first surface in sight: the only leg ends at what hides it.
    pub(super) hidden: bool,
}

/// One end of one leg of one path.
#[derive(Clone, Copy)]
struct Stop {
    at: DVec3,
    met: LegContact,
    face: u32,
}

/// Reads six trails that started on a chart.
pub(super) fn record<const N: usize>(
    follower: &mut PathFollower<'_, N>,
    chart: &SurfaceChart,
    trails: &[Trail; 6],
) -> LegRecord {
    let mut paths: [Vec<Stop>; 6] = Default::default();
    let mut ends: [Option<(End, u64)>; 6] = [None; 6];
    for (trail, (stops, end)) in trails.iter().zip(paths.iter_mut().zip(&mut ends)) {
        *end = read(follower, chart, trail, stops).map(|()| (trail.end, trail.topology));
    }
    let [Some((_, topology)), ..] = ends else {
        return LegRecord {
            legs: Vec::new(),
            one_topology: false,
            hidden: false,
        };
    };
    let is_hidden = |end: &Option<(End, u64)>| matches!(end, Some((End::Hidden, _)));
    let hidden = ends.iter().all(is_hidden);
    let mut legs = Vec::with_capacity(paths[0].len());
    // If some see the surface and some do not, no leg is shared by all six.
    let shared = if !hidden && ends.iter().any(is_hidden) {
        0
    } else {
        paths.iter().map(Vec::len).min().unwrap_or(0)
    };
    let complete = paths.iter().all(|stops| stops.len() == shared);
    for index in 1..shared {
        let [from, to] = [index - 1, index];
        let is_last = index > follower.events();
        let is_dark = is_last
            && ends
                .iter()
                .all(|end| end.is_some_and(|(end, _)| !matches!(end, End::Landed(_))));
        if is_dark {
            look_through(follower.scene(), &mut paths, to);
        }
        let met = paths[0][to].met;
        if paths.iter().any(|stops| stops[to].met != met) {
            break;
        }
        let points = |index: usize| paths.each_ref().map(|stops| stops[index].at);
        let faces = |index: usize| paths.each_ref().map(|stops| stops[index].face);
        let (start, end) = (points(from), points(to));
        legs.push(Leg {
            start,
            end,
            from: paths[0][from].met,
            to: met,
            from_faces: faces(from),
            to_faces: faces(to),
            sight: match follower.screen() {
                _ if !is_dark => LegSight::NotAsked,
                Screen::Receiver(receiver) => LegSight::DarkOver(receiver.shape()),
                Screen::Camera { .. } => sight(follower, met, &start, &end),
            },
        });
    }
    let is_finite = |leg: &Leg| {
        leg.start
            .iter()
            .chain(&leg.end)
            .all(|point| point.is_finite())
    };
    let one_topology = complete
        && legs.len() + 1 == shared
        && legs.iter().all(is_finite)
        && ends
            .iter()
            .all(|end| end.is_some_and(|(_, other)| other == topology));
    legs.truncate(legs.iter().take_while(|leg| is_finite(leg)).count());
    LegRecord {
        legs,
        one_topology,
        hidden,
    }
}

/// The camera's knowledge of last legs, none of whose six ends it sees.
fn sight<const N: usize>(
    follower: &PathFollower<'_, N>,
    met: LegContact,
    start: &[DVec3; 6],
    end: &[DVec3; 6],
) -> LegSight {
    let (scene, screen) = (follower.scene(), follower.screen());
    // Light that passes by the thing that the six met goes on, but nothing is to be seen outside the box
    // round the scene.
    let along: [DVec3; 6] = std::array::from_fn(|i| (end[i] - start[i]).normalize_or_zero());
    let way = way_through(scene.world().bounds(), start, &along);
    let beyond = std::array::from_fn(|i| {
        let way = way.unwrap_or_else(|| way_out(scene, start[i]));
        start[i] + along[i] * way
    });
    if screen.sees_nothing_of(&Hull::new(start, &beyond)) {
        return LegSight::OutOfView;
    }
    if screen.sees_nothing_of(&Hull::new(start, end)) {
        return LegSight::OutOfViewToEnd;
    }
    match met {
        LegContact::Surface(shape)
            if screen.may_see(scene, shape) && !screen.sees_nothing_of(&Hull::new(end, end)) =>
        {
            LegSight::MaybeSeen
        }
        _ => LegSight::EndUnseen,
    }
}

/// Extends six last legs without light for the sensor out of the scene if they end on different things. Then
/// nothing that they met need catch them.
fn look_through(scene: &Scene, paths: &mut [Vec<Stop>; 6], last: usize) {
    let met = paths[0][last].met;
    if paths.iter().all(|stops| stops[last].met == met) {
        return;
    }
    for stops in paths {
        stops[last] = Stop {
            at: way_on(scene, stops[last - 1].at, stops[last].at),
            met: LegContact::Nothing,
            face: 0,
        };
    }
}

/// Reads where the legs of a path start and end; `None` if it has no legs.
fn read<const N: usize>(
    follower: &mut PathFollower<'_, N>,
    chart: &SurfaceChart,
    trail: &Trail,
    stops: &mut Vec<Stop>,
) -> Option<()> {
    let first = trail.legs.first()?;
    stops.push(Stop {
        at: first.ray.origin,
        met: LegContact::Source,
        face: 0,
    });
    stops.extend(trail.legs.iter().map(|leg| match &leg.hit {
        Some(hit) => surface(&leg.ray, hit),
        None => Stop {
            at: leg.ray.origin,
            met: LegContact::Nothing,
            face: 0,
        },
    }));
    // A place that faces share counts as the chart's own.
    stops[1].face = chart.face();
    let &Straight { ray, hit } = trail.legs.last()?;
    let end = stops.last_mut()?;
    match trail.end {
        End::Hidden => {
            let (ray, blocker) = follower.next_hit(ray)?;
            *end = surface(&ray, &blocker);
        }
        End::Landed(_) => {
            let shape = match follower.screen() {
                Screen::Receiver(receiver) => receiver.shape(),
                Screen::Camera { camera, .. } => {
                    // Light landed on the surface that it met, as far as the camera sees that.
                    let seen = camera.project(end.at)?;
                    let at = end.at + seen.towards * seen.distance;
                    stops.push(Stop {
                        at,
                        met: LegContact::Eye,
                        face: 0,
                    });
                    return Some(());
                }
            };
            let receiver = &follower.scene().world().shapes()[shape as usize];
            if receiver.plane().is_some() {
                let distance = match hit {
                    Some(hit) if hit.shape == shape => hit.distance,
                    _ => receiver.meet_beyond(&ray)?.0,
                };
                *end = Stop {
                    at: ray.at(distance),
                    met: LegContact::Plane(shape),
                    face: 0,
                };
            }
        }
        End::Escaped => end.at = ray.at(way_out(follower.scene(), ray.origin)),
        End::Stopped | End::TurnedBack => {}
    }
    Some(())
}

fn surface(ray: &Ray, hit: &Hit) -> Stop {
    Stop {
        at: ray.at(hit.distance),
        met: LegContact::Surface(hit.shape),
        face: hit.face,
    }
}

/// Distance after which all rays of a bundle are out of a box, as six of them show. `None` if for each side
/// of the box some ray may run along it.
///
/// Towards a side with the normal n at n · p = c, a ray from p along d is out after (c − n · p) / (n · d). No
/// ray of the bundle goes on for longer than the largest numerator over the smallest denominator.
fn way_through(bounds: Bounds, start: &[DVec3; 6], along: &[DVec3; 6]) -> Option<f64> {
    let sides = [(DVec3::X, 0), (DVec3::Y, 1), (DVec3::Z, 2)];
    let ways = sides.iter().flat_map(|&(axis, index)| {
        [(axis, bounds.max[index]), (-axis, -bounds.min[index])].map(|(normal, at)| {
            let [slowest, _] = range(&along.map(|along| normal.dot(along)));
            let [_, farthest] = range(&start.map(|start| at - normal.dot(start)));
            (slowest > 0.0).then(|| (farthest / slowest).max(0.0))
        })
    });
    ways.flatten().reduce(f64::min)
}

/// A point on the line from `start` through `end` that is out of the scene.
fn way_on(scene: &Scene, start: DVec3, end: DVec3) -> DVec3 {
    start + (end - start).normalize_or_zero() * way_out(scene, start)
}

/// A distance at which a ray from `origin`, and its neighbours with it, has left the box round the scene.
pub(super) fn way_out(scene: &Scene, origin: DVec3) -> f64 {
    let bounds: Bounds = scene.world().bounds();
    // Twice the distance that the ray itself may need. If a fan of rays is so wide that its middle falls
    // short of the box, its bulge covers the rest.
    2.0 * ((origin - bounds.center()).length() + bounds.radius())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::math;
    use proptest::prelude::*;

    /// Distance, in lengths of `along`, at which a ray from within a box leaves it: the first of the sides
    /// that it goes towards.
    fn own_way(bounds: Bounds, start: DVec3, along: DVec3) -> f64 {
        let sides = DVec3::select(along.cmpgt(DVec3::ZERO), bounds.max, bounds.min);
        let ways = (sides - start) / along;
        (0..3)
            .filter(|&axis| along[axis] != 0.0)
            .map(|axis| ways[axis])
            .fold(f64::INFINITY, f64::min)
    }

    fn vector() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-1.0..1.0f64).prop_map(DVec3::from)
    }

    /// A point between three corners, for a bundle's starts and for its directions.
    fn between(corners: &[DVec3; 3], [b, c]: [f64; 2]) -> DVec3 {
        corners[0] * (1.0 - b - c) + corners[1] * b + corners[2] * c
    }

    fn nodes(corners: &[DVec3; 3]) -> [DVec3; 6] {
        let middles = [[0.5, 0.5], [0.0, 0.5], [0.5, 0.0]];
        let [a, b, c] = *corners;
        let [d, e, f] = middles.map(|at| between(corners, at));
        [a, b, c, d, e, f]
    }

    /// Two answers: are all rays of a bundle out at the distance of `way_through`, and does one go twice as
    /// far as the nodes?
    fn is_through(extent: DVec3, start: [DVec3; 3], along: [DVec3; 3]) -> (bool, bool) {
        let bounds = Bounds {
            min: -extent,
            max: extent,
        };
        let (starts, alongs) = (nodes(&start), nodes(&along));
        let Some(said) = way_through(bounds, &starts, &alongs) else {
            return (true, false);
        };
        let of_nodes = (0..6)
            .map(|node| own_way(bounds, starts[node], alongs[node]))
            .fold(0.0, f64::max);
        let steps = 40;
        let inner = (0..=steps).flat_map(|i| (0..=steps - i).map(move |j| [i, j]));
        let longest = inner
            .map(|at| at.map(|step| f64::from(step) / f64::from(steps)))
            .map(|at| own_way(bounds, between(&start, at), between(&along, at)))
            .fold(0.0, f64::max);
        // A dozen roundings of numbers that differ by no more than a factor of a thousand.
        let is_out = longest <= said * (1.0 + 1e-11);
        (is_out, longest > 2.0 * of_nodes)
    }

    /// In a flat box, most rays leave by the ceiling or the floor at once, and some between them at the far
    /// end.
    #[test]
    fn a_way_between_six_short_ones_may_be_long() {
        let fan = [3.0, -1.0, -1.0].map(|up| DVec3::new(1.0, 0.1, up));
        let extent = DVec3::new(100.0, 100.0, 1.0);
        assert_eq!(is_through(extent, [DVec3::ZERO; 3], fan), (true, true));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn no_ray_of_a_bundle_goes_on_for_longer_than_the_way_through(
            log_extent in vector(),
            start in prop::array::uniform3(vector()),
            along in prop::array::uniform3(vector()),
            push in vector(),
        ) {
            let extent = (log_extent * 3.0).map(math::exp);
            // Pushed one way, most bundles have a side that all of their rays go towards.
            let (along, start) = (along.map(|one| one + push * 2.0), start.map(|one| one * extent));
            prop_assert!(is_through(extent, start, along).0);
        }
    }
}
