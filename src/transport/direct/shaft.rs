//! The space between a delta emitter and a square of a flat receiver, and what may divide it.

use glam::{DVec2, DVec3};

use crate::geometry::Bounds;
use crate::numeric::math;
use crate::scene::Emitter;

/// Part of a convex shape's size by which rays at a square's corners must pass within its outline.
pub(super) const WITHIN: f64 = 1e-9;

/// The origin of a delta emitter's light.
#[derive(Clone, Copy)]
pub(super) enum Origin {
    At(DVec3),
    /// The unit vector towards an emitter that is infinitely far.
    Towards(DVec3),
}

impl Origin {
    /// The origin of an emitter; `None` if it has a size, or throws an image.
    pub(super) fn of(emitter: &Emitter) -> Option<Self> {
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
    pub(super) fn from(self, place: DVec3) -> DVec3 {
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
    pub(super) fn facing(self, [a, b, c]: [DVec3; 3]) -> f64 {
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
    /// A tube's rim: a circle that a shadow may end at, given as a disc is.
    Rim(DVec3, [DVec3; 2]),
    /// All within these bounds.
    Box(Bounds),
}

impl Obstacle {
    /// True if it makes one line between light and shadow.
    pub(super) fn is_simple(&self) -> bool {
        matches!(self, Self::Edge(_)) || self.is_curved()
    }

    /// True if it is a tube's rim, and the outline of a disc given.
    pub(super) fn is_rim_of(&self, disc: &Self) -> bool {
        let (Self::Rim(center, [u, v]), Self::Disk(middle, [s, t])) = (self, disc) else {
            return false;
        };
        let near = WITHIN * u.length();
        let normal = s.cross(*t).normalize_or_zero();
        center.distance(*middle) <= near
            && (u.length() - s.length()).abs() <= near
            && (u.length() - t.length()).abs() <= near
            && s.dot(*t).abs() <= near * u.length()
            && normal.dot(*u).abs().max(normal.dot(*v).abs()) <= near
    }

    /// True if the shadow of it ends at a curve.
    pub(super) fn is_curved(&self) -> bool {
        matches!(self, Self::Ball(..) | Self::Disk(..) | Self::Rim(..))
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

/// True if the shadows of these may leave a sliver that runs along many cells: two curves may touch.
pub(super) fn are_tangled(obstacles: &[Obstacle]) -> bool {
    obstacles.iter().filter(|it| it.is_curved()).count() > 1
}

/// True if a texel that these divide is cut along them without a glance at it by points. Most edges of a mesh
/// end no shadow that points do not see, and they are many.
pub(super) fn are_to_be_cut(obstacles: &[Obstacle]) -> bool {
    are_simple(obstacles) || are_tangled(obstacles)
}

/// The space between an emitter and a square of the receiver.
pub(super) struct Shaft {
    origin: Origin,
    corners: [DVec3; 4],
    /// Outward normals, and the largest product with them of the shaft's points.
    planes: [(DVec3, f64); 6],
    /// Largest coordinate of anything around: the size whose rounding planes have.
    reach: f64,
}

impl Shaft {
    /// The shaft to a square whose corners are in order around it.
    pub(super) fn new(origin: Origin, corners: [DVec3; 4], normal: DVec3, reach: f64) -> Self {
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
            reach,
        }
    }

    /// True if a convex thing may be in it, by its least reach along a direction.
    fn may_hold(&self, least: impl Fn(DVec3) -> f64) -> bool {
        self.planes.iter().all(|(outward, most)| {
            // Products are rounded: a little more room does no harm.
            let room = 1e-12 * outward.length() * self.reach;
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
                self.may_hold_disk(*center, *half)
                    && !self
                        .corners
                        .iter()
                        .all(|at| self.passes_disk(*at, *center, *half, 0.0))
            }
            // What lies behind the receiver's plane is no matter: all of the square is within the circle.
            Obstacle::Rim(center, half) => {
                self.may_hold_disk(*center, *half)
                    && !self
                        .corners
                        .iter()
                        .all(|at| self.passes_disk(*at, *center, *half, f64::NEG_INFINITY))
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

    /// True if a disc, or its outline, may be in it.
    fn may_hold_disk(&self, center: DVec3, half: [DVec3; 2]) -> bool {
        let reach = |along: DVec3| math::hypot(along.dot(half[0]), along.dot(half[1]));
        self.may_hold(|along| along.dot(center) - reach(along)) && !self.passes_rim(center, half)
    }

    /// True if the line from a place to the emitter leads through a disc, beyond `least` of the way and short
    /// of the emitter.
    fn passes_disk(&self, at: DVec3, center: DVec3, [u, v]: [DVec3; 2], least: f64) -> bool {
        let way = self.origin.from(at);
        let normal = u.cross(v);
        let t = (center - at).dot(normal) / way.dot(normal);
        let is_between = t > least && (matches!(self.origin, Origin::Towards(_)) || t < 1.0);
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
    pub(super) fn dividing(&self, obstacles: &[Obstacle]) -> Vec<Obstacle> {
        let divides = |one: &&Obstacle| self.is_divided_by(one);
        obstacles.iter().filter(divides).copied().collect()
    }
}
