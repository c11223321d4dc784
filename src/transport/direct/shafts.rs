//! Texels that see all of a delta emitter, or nothing of it, without a ray for each.
//!
//! A shaft is all the space between an emitter and a square of texels on a flat receiver. Visibility can
//! differ within it only if something of these is in it:
//!
//! - an edge of a mesh's [silhouette](crate::geometry::Mesh::silhouette), or of a rectangle;
//! - a face that touches the receiver;
//! - a part of a ball or disc, but not all of the shaft's cross section: these are convex, so that they hide
//!   all of a square if they hide its four corners;
//! - a tube, or a mask.
//!
//! If there is none, one ray tells for all of the square. Otherwise its quarters are asked, down to texels
//! and on to parts of them (`divided.rs`). Shafts were introduced for this by Haines and Wallace, "Shaft
//! culling for efficient ray-traced radiosity" (1991).

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::arriving::ends_in_a_step;
use super::edge::CORNERS;
use crate::geometry::{Bounds, Shape, Sphere, TraversalCounters};
use crate::numeric::math;
use crate::scene::{Emitter, Material, Scene};
use crate::transport::receiver::Receiver;
use crate::transport::visibility::transmittance;

/// Texels a side of the squares to begin with.
const SQUARE: usize = 64;

/// Distance from the receiver's plane, relative to coordinates, at which a face counts as touching it.
const TOUCHING: f64 = 1e-9;

/// Part of a convex shape's size by which rays at a square's corners must pass within its outline.
const WITHIN: f64 = 1e-9;

/// The origin of a delta emitter's light.
#[derive(Clone, Copy)]
enum Origin {
    At(DVec3),
    /// The unit vector towards an emitter that is infinitely far.
    Towards(DVec3),
}

impl Origin {
    /// The origin of an emitter; `None` if it has a size, or throws an image.
    fn of(emitter: &Emitter) -> Option<Self> {
        match emitter {
            Emitter::Point { position, .. } => Some(Self::At(*position)),
            Emitter::Spot { to_world, .. } => Some(Self::At(to_world.point(DVec3::ZERO))),
            Emitter::Directional { direction, .. } => Some(Self::Towards(-*direction)),
            Emitter::Projector { .. }
            | Emitter::Area { .. }
            | Emitter::DirectionalArea { .. }
            | Emitter::Constant { .. }
            | Emitter::Envmap(_)
            | Emitter::Sunsky(_) => None,
        }
    }

    /// The vector from a place to it, of any length.
    fn from(self, place: DVec3) -> DVec3 {
        match self {
            Self::At(position) => position - place,
            Self::Towards(direction) => direction,
        }
    }

    /// The plane through it and an edge: its normal, and a point of it.
    fn sweep(self, [a, b]: [DVec3; 2]) -> (DVec3, DVec3) {
        ((b - a).cross(self.from(a)), a)
    }

    /// Positive if it sees these corners counter-clockwise.
    fn facing(self, [a, b, c]: [DVec3; 3]) -> f64 {
        (b - a).cross(c - a).dot(self.from(a))
    }
}

/// Things that may be between the emitter and some places only.
#[derive(Clone, Copy)]
pub(super) enum Obstacle {
    /// An edge that a shadow may end at.
    Edge([DVec3; 2]),
    /// A face that touches the receiver's plane.
    Face([DVec3; 3]),
    Ball(DVec3, f64),
    /// A middle and two half axes.
    Disk(DVec3, [DVec3; 2]),
    /// All within these bounds.
    Box(Bounds),
}

impl Obstacle {
    /// True if it makes one line between light and shadow.
    fn is_simple(&self) -> bool {
        matches!(self, Self::Edge(_) | Self::Ball(..) | Self::Disk(..))
    }
}

/// True if the shadows of these are likely to end at one line with one corner at most: two edges that meet
/// make one.
pub(super) fn are_simple(obstacles: &[Obstacle]) -> bool {
    match obstacles {
        [one] => one.is_simple(),
        [Obstacle::Edge(one), Obstacle::Edge(other)] => one.iter().any(|end| other.contains(end)),
        _ => false,
    }
}

/// Most lines that are kept for a texel. One with more is looked at by points alone.
const MOST_LINES: usize = 64;

/// The space between an emitter and a square of the receiver.
struct Shaft {
    origin: Origin,
    corners: [DVec3; 4],
    /// Outward normals, and the largest product with them of the shaft's points.
    planes: [(DVec3, f64); 6],
}

impl Shaft {
    /// The shaft to a square whose corners are in order around it.
    fn new(origin: Origin, corners: [DVec3; 4], normal: DVec3) -> Self {
        let middle = corners.iter().sum::<DVec3>() / 4.0;
        let mut planes = [(DVec3::ZERO, 0.0); 6];
        for (index, plane) in planes[..4].iter_mut().enumerate() {
            let (a, b) = (corners[index], corners[(index + 1) % 4]);
            let across = (b - a).cross(origin.from(a));
            let outward = if across.dot(middle - a) > 0.0 {
                -across
            } else {
                across
            };
            *plane = (outward, f64::max(outward.dot(a), outward.dot(b)));
        }
        planes[4] = (-normal, -normal.dot(middle));
        planes[5] = match origin {
            Origin::At(position) => (normal, normal.dot(position)),
            Origin::Towards(_) => (DVec3::ZERO, 0.0),
        };
        Self {
            origin,
            corners,
            planes,
        }
    }

    /// True if a convex thing may be in it, by its least reach along a direction.
    fn may_hold(&self, least: impl Fn(DVec3) -> f64) -> bool {
        self.planes.iter().all(|(outward, most)| {
            // Products are rounded: a little more room does no harm.
            let room = 1e-12 * outward.length() * self.corners[0].length().max(1e-300);
            least(*outward) <= most + room
        })
    }

    /// True if visibility may differ between the square's points because of this.
    fn is_divided_by(&self, obstacle: &Obstacle) -> bool {
        match obstacle {
            Obstacle::Edge(points) => {
                self.may_hold_points(points) && !self.is_beside(self.origin.sweep(*points))
            }
            Obstacle::Face(points) => self.may_hold_points(points),
            Obstacle::Ball(center, radius) => {
                self.may_hold(|along| along.dot(*center) - radius * along.length())
                    && !self.passes_by(*center, *radius)
                    && !self
                        .corners
                        .iter()
                        .all(|at| self.passes_ball(*at, *center, *radius))
            }
            Obstacle::Disk(center, half) => {
                let reach = |along: DVec3| math::hypot(along.dot(half[0]), along.dot(half[1]));
                self.may_hold(|along| along.dot(*center) - reach(along))
                    && !self.passes_rim(*center, *half)
                    && !self
                        .corners
                        .iter()
                        .all(|at| self.passes_disk(*at, *center, *half))
            }
            Obstacle::Box(bounds) => self.may_hold(|along| {
                along.dot(bounds.center()) - 0.5 * along.abs().dot(bounds.extent())
            }),
        }
    }

    /// True if all of it is on one side of a plane through the origin, given by its normal and a point.
    fn is_beside(&self, (normal, point): (DVec3, DVec3)) -> bool {
        let sides = self.corners.map(|corner| normal.dot(corner - point));
        sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0)
    }

    /// True if it passes a ball on the side on which its middle does.
    fn passes_by(&self, center: DVec3, radius: f64) -> bool {
        let middle = self.corners.iter().sum::<DVec3>() / 4.0;
        let way = self.origin.from(middle);
        let foot = middle + way * ((center - middle).dot(way) / way.length_squared());
        let along = (center - foot).normalize_or_zero();
        let reach = |point: DVec3| along.dot(point);
        let most = self.corners.iter().map(|corner| reach(*corner));
        let most = most.fold(f64::NEG_INFINITY, f64::max);
        let most = match self.origin {
            Origin::At(position) => most.max(reach(position)),
            Origin::Towards(_) => most,
        };
        reach(center) - radius > most
    }

    fn may_hold_points(&self, points: &[DVec3]) -> bool {
        self.may_hold(|along| {
            let reaches = points.iter().map(|point| along.dot(*point));
            reaches.fold(f64::INFINITY, f64::min)
        })
    }

    /// True if the way from a place to the emitter, which is outside of a ball, leads through it.
    fn passes_ball(&self, at: DVec3, center: DVec3, radius: f64) -> bool {
        let way = self.origin.from(at);
        let to_center = center - at;
        let inside = radius * (1.0 - WITHIN);
        let most = match self.origin {
            Origin::At(position) if position.distance(center) <= radius => return false,
            Origin::At(_) => 1.0,
            Origin::Towards(_) => f64::INFINITY,
        };
        let t = (to_center.dot(way) / way.length_squared()).clamp(0.0, most);
        (way * t - to_center).length() < inside
    }

    /// True if the way from a place to the emitter leads through a disc.
    fn passes_disk(&self, at: DVec3, center: DVec3, [u, v]: [DVec3; 2]) -> bool {
        let way = self.origin.from(at);
        let normal = u.cross(v);
        let t = (center - at).dot(normal) / way.dot(normal);
        let is_between = t > 0.0 && (matches!(self.origin, Origin::Towards(_)) || t < 1.0);
        let offset = at + way * t - center;
        let scale = normal.length_squared();
        let place = DVec2::new(
            offset.cross(v).dot(normal) / scale,
            u.cross(offset).dot(normal) / scale,
        );
        is_between && place.length() < 1.0 - WITHIN
    }

    /// True if it passes a disc on the side on which its middle does: beyond the plane through the origin and
    /// the tangent at the nearest point of the rim.
    fn passes_rim(&self, center: DVec3, [u, v]: [DVec3; 2]) -> bool {
        let middle = self.corners.iter().sum::<DVec3>() / 4.0;
        let way = self.origin.from(middle);
        let normal = u.cross(v);
        let crossing = middle + way * ((center - middle).dot(normal) / way.dot(normal)) - center;
        let place = DVec2::new(
            crossing.dot(u) / u.length_squared(),
            crossing.dot(v) / v.length_squared(),
        );
        let nearest = place.normalize_or_zero();
        let rim = center + u * nearest.x + v * nearest.y;
        let (across, _) = self
            .origin
            .sweep([rim, rim - u * nearest.y + v * nearest.x]);
        self.is_beside((across, rim)) && across.dot(center - rim) * across.dot(middle - rim) < 0.0
    }

    /// Those of some obstacles that visibility may differ by within it.
    fn dividing(&self, obstacles: &[Obstacle]) -> Vec<Obstacle> {
        let divides = |one: &&Obstacle| self.is_divided_by(one);
        obstacles.iter().filter(divides).copied().collect()
    }
}

/// The points of a texel, as an emitter sees them.
pub(super) enum TexelView<'a> {
    /// All see this share of it.
    Same(f64),
    /// They may see different shares, because of these lines.
    Divided(&'a [Obstacle]),
    /// They may see different shares, because of many lines, or of something whose shadow has no known
    /// outline.
    Unknown,
}

/// The views of all texels.
pub(super) struct Views {
    /// Shares by texel, row by row; no number where they may differ.
    shares: Vec<f64>,
    /// The lines of those that lines divide.
    lines: BTreeMap<usize, Vec<Obstacle>>,
}

impl Views {
    /// The view of a texel.
    pub(super) fn of(&self, texel: usize) -> TexelView<'_> {
        let share = self.shares[texel];
        match self.lines.get(&texel) {
            _ if !share.is_nan() => TexelView::Same(share),
            Some(lines) => TexelView::Divided(lines),
            None => TexelView::Unknown,
        }
    }
}

/// An emitter's visibility from the texels of a flat receiver.
pub(super) struct Shafts<'a> {
    scene: &'a Scene,
    receiver: &'a Receiver,
    origin: Origin,
    normal: DVec3,
}

/// What was found of a part of the film, and the work that it took.
#[derive(Default)]
struct Found {
    /// First columns and rows, last ones and one more, and the share that all of these texels see.
    same: Vec<([usize; 2], [usize; 2], f64)>,
    lines: Vec<(usize, Vec<Obstacle>)>,
    counters: TraversalCounters,
}

impl<'a> Shafts<'a> {
    /// The shafts of an emitter without size. `None` for others, and if the receiver is not a rectangle or
    /// shows the emitter its back.
    pub(super) fn new(scene: &'a Scene, receiver: &'a Receiver, emitter: &Emitter) -> Option<Self> {
        let shape = &scene.world().shapes()[receiver.shape() as usize];
        let (Shape::Rectangle(floor), Some(origin)) = (shape, Origin::of(emitter)) else {
            return None;
        };
        if ends_in_a_step(emitter) {
            return None;
        }
        let normal = floor.normal();
        let is_front = normal.dot(origin.from(floor.center())) > 0.0;
        is_front.then_some(Self {
            scene,
            receiver,
            origin,
            normal,
        })
    }

    /// The views of all texels, row by row.
    pub(super) fn views(
        &self,
        stop: &(dyn Fn() -> bool + Sync),
        counters: &mut TraversalCounters,
    ) -> Views {
        let obstacles = self.obstacles();
        let side = |texels: usize| texels.div_ceil(SQUARE);
        let (width, across) = (self.receiver.width(), side(self.receiver.width()));
        let squares: Vec<Found> = (0..across * side(self.receiver.height()))
            .into_par_iter()
            .map(|index| {
                let from = [index % across * SQUARE, index / across * SQUARE];
                let mut found = Found::default();
                // What is left out then is thrown away with the rest.
                if !stop() {
                    self.divide(from, SQUARE, &obstacles, &mut found);
                }
                found
            })
            .collect();
        let mut views = Views {
            shares: vec![f64::NAN; self.receiver.texels()],
            lines: BTreeMap::new(),
        };
        for found in squares {
            *counters += found.counters;
            for (from, end, share) in found.same {
                for row in from[1]..end[1] {
                    views.shares[row * width + from[0]..row * width + end[0]].fill(share);
                }
            }
            views.lines.extend(found.lines);
        }
        views
    }

    /// Those of some obstacles that visibility may differ by within a square, given its corners in order.
    pub(super) fn dividing(&self, corners: [DVec3; 4], obstacles: &[Obstacle]) -> Vec<Obstacle> {
        Shaft::new(self.origin, corners, self.normal).dividing(obstacles)
    }

    /// Everything that may hide the emitter from some places only.
    fn obstacles(&self) -> Vec<Obstacle> {
        let (scene, world) = (self.scene, self.scene.world());
        let mut obstacles = Vec::new();
        for (index, shape) in world.shapes().iter().enumerate() {
            let material = scene.material_of(index as u32);
            if index as u32 == self.receiver.shape() {
                continue;
            }
            if matches!(material, Material::Mask { .. }) {
                obstacles.push(Obstacle::Box(shape.bounds()));
                continue;
            }
            if material.is_passed(scene.materials()) {
                continue;
            }
            match shape {
                // A ball round the emitter hides it from all places outside.
                Shape::Sphere(ball) if self.is_within(ball) => {}
                Shape::Sphere(ball) => {
                    obstacles.push(Obstacle::Ball(ball.center(), ball.radius()));
                }
                Shape::Rectangle(plate) => {
                    let [a, b, c, d] = CORNERS.map(|uv| plate.point(uv));
                    obstacles.extend([[a, b], [b, c], [c, d], [d, a]].map(Obstacle::Edge));
                    obstacles.extend(
                        self.touching([a, b, c])
                            .into_iter()
                            .chain(self.touching([c, d, a])),
                    );
                }
                Shape::Disk(plate) => {
                    obstacles.push(Obstacle::Disk(plate.center(), plate.half_axes()));
                }
                Shape::Cylinder(_) => obstacles.push(Obstacle::Box(shape.bounds())),
                Shape::Mesh(mesh) => {
                    let outline = mesh.silhouette(|corners| self.origin.facing(corners));
                    obstacles.extend(outline.into_iter().map(Obstacle::Edge));
                    let faces = 0..mesh.triangle_count() as u32;
                    obstacles.extend(faces.filter_map(|face| self.touching(mesh.corners(face))));
                }
            }
        }
        obstacles
    }

    /// True if the emitter is in a ball that does not reach the receiver's plane.
    fn is_within(&self, ball: &Sphere) -> bool {
        let Origin::At(position) = self.origin else {
            return false;
        };
        let floor = &self.scene.world().shapes()[self.receiver.shape() as usize];
        let inside = ball.radius() * (1.0 - WITHIN);
        let outside = ball.radius() * (1.0 + WITHIN);
        position.distance(ball.center()) < inside
            && floor
                .plane()
                .is_some_and(|[center, _]| self.normal.dot(ball.center() - center) > outside)
    }

    /// A face as an obstacle if it touches the receiver's plane: then its shadow ends there, too.
    fn touching(&self, corners: [DVec3; 3]) -> Option<Obstacle> {
        let floor = &self.scene.world().shapes()[self.receiver.shape() as usize];
        let [center, _] = floor.plane()?;
        let heights = corners.map(|corner| self.normal.dot(corner - center));
        let near = corners.map(|corner| TOUCHING * (corner.length() + center.length()));
        let is_above = (0..3).all(|i| heights[i] > near[i]);
        let is_below = (0..3).all(|i| heights[i] < -near[i]);
        (!is_above && !is_below).then_some(Obstacle::Face(corners))
    }

    /// Finds the views of a square's texels.
    fn divide(&self, from: [usize; 2], size: usize, obstacles: &[Obstacle], found: &mut Found) {
        let (width, height) = (self.receiver.width(), self.receiver.height());
        let end = [(from[0] + size).min(width), (from[1] + size).min(height)];
        if from[0] >= end[0] || from[1] >= end[1] {
            return;
        }
        let first = from[1] * width + from[0];
        let reach = DVec2::new((end[0] - from[0]) as f64, (end[1] - from[1]) as f64);
        let at = |part: DVec2| self.receiver.point(self.scene, first, part * reach);
        let corners = CORNERS.map(at);
        let ([Some(a), Some(b), Some(c), Some(d)], Some(middle)) = (corners, at(DVec2::splat(0.5)))
        else {
            return;
        };
        let within = self.dividing([a, b, c, d].map(|point| point.position), obstacles);
        if within.is_empty() {
            let way = self.origin.from(middle.position);
            let distance = match self.origin {
                Origin::At(_) => way.length(),
                Origin::Towards(_) => f64::INFINITY,
            };
            let towards = way.normalize();
            let share = transmittance(self.scene, &middle, towards, distance, &mut found.counters);
            found.same.push((from, end, share));
        } else if size > 1 {
            let half = size / 2;
            for (x, y) in [(0, 0), (half, 0), (0, half), (half, half)] {
                self.divide([from[0] + x, from[1] + y], half, &within, found);
            }
        } else if within.len() <= MOST_LINES && within.iter().all(Obstacle::is_simple) {
            found.lines.push((first, within));
        }
    }
}
