//! Light paths of one fixed signature: from a place on a first surface to the sensor.
//!
//! A chain follows light wherever it goes. Here the question is about one signature only. Does light that
//! starts at this place get to the sensor by these events, to which place, and how much of it? The answer
//! includes *which* surfaces took part, the path's topology: two neighbouring paths belong to one smooth map
//! only if their topologies are equal.

use glam::{DVec2, DVec3};

use super::first_surface::{ChartPlace, Source, SourceRay, SurfaceChart};
use super::flux::Flux;
use super::path_end::{End, next_hit};
use super::scatter::{Branch, Interaction, ShadingNormals, Way};
use super::screen::Screen;
use super::signature::{Event, Signature};
use crate::geometry::{Hit, Ray, Shape, SurfacePoint, TraversalCounters};
use crate::scene::{Material, Scene};

/// A path of fixed signature, followed to its end.
#[derive(Clone, Copy, Debug)]
pub struct PathEnd<const N: usize> {
    /// The path's end.
    pub end: End,
    /// Throughput from the source's strength to what arrives; black if the path did not land.
    pub throughput: Flux<N>,
    /// The light that set out, for a unit of chart area and of the source's strength: strength · emitted ·
    /// area is flux \[W\].
    pub emitted: f64,
    /// Topology: the same number for two paths that ended the same way by way of the same smooth surfaces.
    pub topology: u64,
    /// The direction in which light left the first surface; zero if none did.
    pub departure: DVec3,
    /// The faces of smooth meshes that light met after the first surface: the same number for two paths that
    /// met the same. Interpolated normals have a kink along each edge, and so has the map of light.
    pub faces: u64,
}

/// The last leg of a path, after its last event, whatever it meets there.
#[derive(Clone, Copy, Debug)]
pub struct LastLeg<const N: usize> {
    /// The ray from the last surface.
    pub ray: Ray,
    /// The share (0..=1) of the light that set out which goes on along it.
    pub share: Flux<N>,
}

/// Follower of paths of one source through one scene to one sensor.
pub struct PathFollower<'a, const N: usize> {
    scene: &'a Scene,
    source: &'a Source,
    screen: &'a Screen<'a>,
    events: Vec<Event>,
    shading_normals: ShadingNormals,
    /// Work done so far.
    pub counters: TraversalCounters,
}

impl<'a, const N: usize> PathFollower<'a, N> {
    /// A follower of one signature.
    pub fn new(
        scene: &'a Scene,
        source: &'a Source,
        screen: &'a Screen<'a>,
        signature: Signature,
        shading_normals: ShadingNormals,
    ) -> Self {
        Self {
            scene,
            source,
            screen,
            events: signature.events().collect(),
            shading_normals,
            counters: TraversalCounters::default(),
        }
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// The source whose light it follows.
    pub fn source(&self) -> &'a Source {
        self.source
    }

    /// A place of a chart, and the light that arrives there.
    #[inline]
    fn start(&self, chart: &SurfaceChart, at: DVec2) -> Option<(ChartPlace, SourceRay)> {
        let place = chart.place(self.scene.world(), at)?;
        Some((place, self.source.arrive(place.point.position)?))
    }

    /// The light that sets out towards a place of a chart, as [`PathEnd::emitted`], if `path`, which was
    /// followed from the same place of another face, is the path of this face, too. `None` if it is not.
    /// Faces that share a place share its normal, but not their planes: light that leaves one face may run
    /// into the plane of the next, and is lost there.
    #[inline]
    pub fn emitted_alike(&self, chart: &SurfaceChart, at: DVec2, path: &PathEnd<N>) -> Option<f64> {
        let Some((place, arrival)) = self.start(chart, at) else {
            return Some(0.0);
        };
        let normal = place.point.geometric_normal;
        let sides = arrival.ray.direction.dot(normal) * path.departure.dot(normal);
        let leaves = match self.events.first() {
            Some(Event::Reflection) => sides < 0.0,
            Some(Event::Transmission) => sides > 0.0,
            Some(Event::Glossy) | None => true,
        };
        (leaves || path.end == End::Hidden).then(|| arrival.emitted(&place))
    }

    /// The screen that the light falls on.
    pub fn screen(&self) -> &'a Screen<'a> {
        self.screen
    }

    /// Number of events that a path has until its last leg.
    pub fn events(&self) -> usize {
        self.events.len()
    }

    /// The path that meets the chart's surface at `at`. `in_sight` is true if it is known that nothing is
    /// between the source and the surface; then that is not tested.
    #[inline]
    pub fn follow(&mut self, chart: &SurfaceChart, at: DVec2, in_sight: bool) -> PathEnd<N> {
        self.follow_legs(chart, at, in_sight, |_, _| {})
    }

    /// The same path as of [`Self::follow`]. `leg` is called with each straight part of the path as it is
    /// found: the ray along it, and its hit. The first part ends at the chart's surface, even if something
    /// hides that; later ones start past any surface that changes nothing.
    #[inline]
    pub fn follow_legs(
        &mut self,
        chart: &SurfaceChart,
        at: DVec2,
        in_sight: bool,
        mut leg: impl FnMut(&Ray, Option<&Hit>),
    ) -> PathEnd<N> {
        let world = self.scene.world();
        let mut topology = Topology::default();
        let dark = |end: End, emitted: f64, topology: &Topology| PathEnd {
            end,
            throughput: Flux::BLACK,
            emitted,
            topology: topology.with(end_mark(end)),
            departure: DVec3::ZERO,
            faces: 0,
        };
        let Some((place, arrival)) = self.start(chart, at) else {
            return dark(End::Hidden, 0.0, &topology);
        };
        let mut point = place.point;
        let mut direction = arrival.ray.direction;
        let facing = -direction.dot(point.geometric_normal);
        let emitted = arrival.emitted(&place);
        topology.mix(u64::from(arrival.zone));
        if arrival.density == 0.0 {
            return dark(End::Hidden, emitted, &topology);
        }
        topology.pass(self.scene, chart.shape(), chart.face(), facing > 0.0);
        let mut throughput = Flux::WHITE;
        let first = Hit {
            distance: arrival.distance,
            shape: chart.shape(),
            face: chart.face(),
            barycentric: at,
        };
        leg(&arrival.ray, Some(&first));
        if !in_sight && !self.sees(&arrival, chart) {
            return dark(End::Hidden, emitted, &topology);
        }
        let mut shape = chart.shape();
        let mut departure = DVec3::ZERO;
        let mut faces = Topology::default();
        for index in 0..self.events.len() {
            let left = leave(
                self.scene,
                shape,
                &point,
                direction,
                self.events[index],
                self.shading_normals,
            );
            let Some((share, branch)) = left else {
                let is_glass = matches!(self.scene.material_of(shape), Material::Dielectric { .. });
                let end = if is_glass {
                    End::TurnedBack
                } else {
                    End::Stopped
                };
                return PathEnd {
                    departure,
                    ..dark(end, emitted, &topology)
                };
            };
            topology.event(share);
            throughput = throughput * branch.tint * share;
            direction = branch.direction;
            if index == 0 {
                departure = direction;
            }
            let ray = point.spawn(direction);
            if index + 1 == self.events.len() {
                return PathEnd {
                    departure,
                    faces: faces.0,
                    ..self.land(ray, throughput, emitted, topology, leg)
                };
            }
            let Some((ray, hit)) = self.next_hit(ray) else {
                leg(&ray, None);
                return PathEnd {
                    departure,
                    ..dark(End::Escaped, emitted, &topology)
                };
            };
            leg(&ray, Some(&hit));
            point = world.bounce_point(&ray, &hit);
            let front = direction.dot(point.geometric_normal) < 0.0;
            topology.pass(self.scene, hit.shape, hit.face, front);
            if is_smooth_mesh(self.scene, hit.shape) {
                faces.mix(u64::from(hit.face));
            }
            shape = hit.shape;
        }
        dark(End::Stopped, emitted, &topology)
    }

    /// Follows paths from a place up to `max_depth` events.
    ///
    /// They are all branches of the first `split_depth` events that keep at least `least` of the light; from
    /// there on each has one branch only. That branch is chosen with the probability of its share, by a
    /// number in 0..1 that `choice` makes of the events so far. `found` is called for each path with its
    /// signature, its last leg, its end, and the probability of all choices on the way. Nothing is found if
    /// something hides the place from the source.
    pub fn follow_some(
        &mut self,
        chart: &SurfaceChart,
        at: DVec2,
        [split_depth, max_depth]: [u32; 2],
        least: f64,
        choice: &mut impl FnMut(Signature) -> f64,
        found: &mut impl FnMut(Signature, &LastLeg<N>, PathEnd<N>, f64),
    ) {
        const WAYS: [Way; 2] = [Way::Reflected, Way::Transmitted];
        let world = self.scene.world();
        let Some((place, arrival)) = self.start(chart, at) else {
            return;
        };
        if !self.sees(&arrival, chart) {
            return;
        }
        let emitted = arrival.emitted(&place);
        let topology = Topology::default();
        let mut pending = vec![(
            place.point,
            chart.shape(),
            arrival.ray.direction,
            (Flux::<N>::WHITE, 1.0),
            Signature::DIRECT,
        )];
        while let Some((point, shape, direction, (throughput, probability), signature)) =
            pending.pop()
        {
            let events = signature.len();
            if events >= max_depth as usize {
                continue;
            }
            let material = self.scene.material_of(shape);
            let interaction = Interaction::new(
                self.scene,
                material,
                &point,
                direction,
                self.shading_normals,
            );
            let chosen = (events >= split_depth as usize).then(|| {
                let [reflected, transmitted] = WAYS.map(|way| interaction.share_of(way));
                let share = reflected / (reflected + transmitted);
                if choice(signature) < share {
                    (Way::Reflected, share)
                } else {
                    (Way::Transmitted, 1.0 - share)
                }
            });
            for way in WAYS {
                let probability = match chosen {
                    Some((only, share)) if only == way => probability * share,
                    Some(_) => continue,
                    None => probability,
                };
                let share = interaction.share_of(way);
                let (Some(event), Some(branch)) = (way.event(), interaction.branch::<N>(way))
                else {
                    continue;
                };
                let throughput = throughput * branch.tint * share;
                if throughput.max_magnitude() < least {
                    continue;
                }
                let signature = signature.then(event);
                let ray = point.spawn(branch.direction);
                let path = self.land(ray, throughput, emitted, topology, |_, _| ());
                let share = throughput;
                found(signature, &LastLeg { ray, share }, path, probability);
                if let Some((ray, hit)) = self.next_hit(ray) {
                    let point = world.bounce_point(&ray, &hit);
                    let light = (throughput, probability);
                    pending.push((point, hit.shape, branch.direction, light, signature));
                }
            }
        }
    }

    /// The end of a path whose last leg is `ray`.
    #[inline]
    fn land(
        &mut self,
        ray: Ray,
        throughput: Flux<N>,
        emitted: f64,
        topology: Topology,
        mut leg: impl FnMut(&Ray, Option<&Hit>),
    ) -> PathEnd<N> {
        let (ray, hit) = match self.next_hit(ray) {
            Some((ray, hit)) => (ray, Some(hit)),
            None => (ray, None),
        };
        leg(&ray, hit.as_ref());
        let counters = &mut self.counters;
        let (end, factor, mark) = self.screen.end(self.scene, &ray, hit.as_ref(), counters);
        let throughput = match end {
            End::Landed(_) => throughput * Flux::of(self.source.strength() * factor),
            _ => Flux::BLACK,
        };
        PathEnd {
            end,
            throughput,
            emitted,
            topology: topology.with(last_end_mark(end) ^ mark),
            departure: DVec3::ZERO,
            faces: 0,
        }
    }

    #[inline]
    pub(super) fn next_hit(&mut self, ray: Ray) -> Option<(Ray, Hit)> {
        next_hit(self.scene, ray, &mut self.counters)
    }

    /// True if only passed surfaces are between the source and a place of the chart.
    fn sees(&mut self, arrival: &SourceRay, chart: &SurfaceChart) -> bool {
        let scene = self.scene;
        let own = chart.shape();
        // Another surface at the place itself is not in front of it. Both distances are sums of coordinates,
        // each with some sixteen roundings, which count by 1/cos θ: up to 64 times. Light that is nearer to
        // grazing than that is negligible.
        let place = arrival.ray.at(arrival.distance);
        let size = arrival.distance + place.length() + arrival.ray.origin.length();
        let near = arrival.distance - 16.0 * 64.0 * (0.5 * f64::EPSILON) * size;
        // The surface itself is met again within rounding, or at a grazing angle within the square root of
        // that. Light that a tube lets in that near to grazing is the square of it.
        let own_near = near - 1e-6 * scene.world().shapes()[own as usize].bounds().radius();
        let convex = matches!(chart, SurfaceChart::Cap { .. });
        !scene.world().any_hit(
            &arrival.ray,
            near,
            |hit| {
                !(scene.material_of(hit.shape).is_passed(scene.materials())
                    || hit.shape == own
                        && (convex
                            || hit.distance > own_near
                            || hit.face == chart.face() && is_mesh(scene, own)))
            },
            &mut self.counters,
        )
    }
}

/// Light that travels along `direction` at a point of `shape`, after `event`: the share (0..=1) of its flux
/// that goes on, and its new branch. `None` if no light goes on that way.
#[inline]
pub(super) fn leave<const N: usize>(
    scene: &Scene,
    shape: u32,
    point: &SurfacePoint,
    direction: DVec3,
    event: Event,
    shading_normals: ShadingNormals,
) -> Option<(f64, Branch<N>)> {
    let way = match event {
        Event::Reflection => Way::Reflected,
        Event::Transmission => Way::Transmitted,
        // It has no one direction.
        Event::Glossy => return None,
    };
    let material = scene.material_of(shape);
    let interaction = Interaction::new(scene, material, point, direction, shading_normals);
    let share = interaction.share_of(way);
    (share > 0.0)
        .then(|| interaction.branch(way))
        .flatten()
        .map(|branch| (share, branch))
}

fn is_mesh(scene: &Scene, shape: u32) -> bool {
    matches!(scene.world().shapes()[shape as usize], Shape::Mesh(_))
}

/// True for a mesh whose normals are interpolated.
#[inline]
fn is_smooth_mesh(scene: &Scene, shape: u32) -> bool {
    matches!(&scene.world().shapes()[shape as usize], Shape::Mesh(mesh) if mesh.has_vertex_normals())
}

fn end_mark(end: End) -> u64 {
    match end {
        End::Landed(_) => 1,
        End::Escaped => 2,
        End::Hidden => 3,
        End::Stopped => 4,
        End::TurnedBack => 6,
    }
}

/// Mark of a last leg's end. All light that does not get to the sensor after its last event has one topology,
/// whatever it meets: it is lost.
fn last_end_mark(end: End) -> u64 {
    match end {
        End::Landed(_) => 1,
        _ => 5,
    }
}

/// The surfaces that took part so far, as a hash.
#[derive(Clone, Copy, Default)]
struct Topology(u64);

impl Topology {
    #[inline]
    fn mix(&mut self, value: u64) {
        // Steele, Lea and Flood's finaliser: equal sequences stay equal, others part.
        let mut z = (self.0 ^ value).wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        self.0 = z ^ (z >> 31);
    }

    /// Adds a surface that the path met. Faces of a mesh whose normals are interpolated are one smooth
    /// surface; flat faces are a surface each.
    #[inline]
    fn pass(&mut self, scene: &Scene, shape: u32, face: u32, front: bool) {
        let facet = match &scene.world().shapes()[shape as usize] {
            Shape::Mesh(mesh) if !mesh.has_vertex_normals() => u64::from(face) + 1,
            _ => 0,
        };
        self.mix(u64::from(shape) << 34 | facet << 1 | u64::from(front));
    }

    /// Adds an event that sent on this share of the light: all of it (total reflection, a metal) or a part. A
    /// kink is between the two.
    #[inline]
    fn event(&mut self, share: f64) {
        self.mix(u64::from(share == 1.0));
    }

    #[inline]
    fn with(mut self, mark: u64) -> u64 {
        self.mix(mark);
        self.0
    }
}
