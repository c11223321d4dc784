//! Interfaces at the same place, of which light meets only one.
//!
//! A ray that leaves a surface starts beyond it by a bound on rounding. So it starts beyond any other surface
//! at the same place, too. Water modelled as a solid of its own that fills a glass has two surfaces where it
//! touches the glass. Light would go from glass to air without ever entering the water. The scene does not
//! say in which order two surfaces at one place lie, and no order is made up. A warning names the two
//! instead.

use std::collections::HashSet;

use glam::{DVec2, DVec3};

use super::validate::needs_inside;
use super::{Material, Object, Warning};
use crate::geometry::{Bounds, Mesh, Shape};
use crate::numeric::math;

/// Most pairs that are named: a scene of a thousand equal balls is one mistake.
const MOST_NAMED: usize = 32;

/// Most work that is spent on comparing, in comparisons of two boxes: about a second's.
const MOST_WORK: usize = 1 << 28;

/// Work of comparing two shapes, in comparisons of two boxes.
const WORK_OF_SHAPES: usize = 16;

/// One warning for each pair of shapes with surfaces at the same place, at least one of which refracts. One
/// more warning follows if there may be pairs that are not named.
///
/// The pairs compared are two spheres, two cylinders, two flat shapes, and a flat shape and a mesh's faces.
/// Two meshes are compared for faces over the same three points.
pub(super) fn warnings(
    shapes: &[Shape],
    objects: &[Object],
    materials: &[Material],
) -> Vec<Warning> {
    let material = |index: usize| &materials[objects[index].material.0 as usize];
    let refracts: Vec<bool> = (0..shapes.len())
        .map(|index| needs_inside(material(index), materials))
        .collect();
    if !refracts.contains(&true) {
        return Vec::new();
    }
    // Sorted along x, so that only shapes are compared whose extents along x overlap.
    let mut along_x: Vec<(usize, Bounds)> = (0..shapes.len())
        .filter(|&index| *material(index) != Material::Null)
        .map(|index| (index, shapes[index].bounds()))
        .collect();
    along_x.sort_by(|(_, a), (_, b)| a.min.x.total_cmp(&b.min.x));
    let most_room = along_x
        .iter()
        .map(|(_, bounds)| room(bounds, bounds))
        .fold(0.0, f64::max);
    let (mut pairs, mut work) = (Vec::new(), 0);
    'all: for (place, (first, bounds)) in along_x.iter().enumerate() {
        for (second, other) in &along_x[place + 1..] {
            if other.min.x > bounds.max.x + most_room {
                break;
            }
            work += 1;
            if work >= MOST_WORK {
                break 'all;
            }
            let room = room(bounds, other);
            let is_apart = bounds.min.cmpgt(other.max + room).any()
                || other.min.cmpgt(bounds.max + room).any();
            if is_apart || !(refracts[*first] || refracts[*second]) {
                continue;
            }
            work += WORK_OF_SHAPES;
            if coincide(&shapes[*first], &shapes[*second], room) {
                pairs.push([*first.min(second), *first.max(second)]);
            }
            if pairs.len() == MOST_NAMED {
                break 'all;
            }
        }
    }
    let are_all_known = pairs.len() < MOST_NAMED && work < MOST_WORK;
    pairs.sort_unstable();
    let unknown = Warning {
        at: None,
        message: "too many shapes overlap to tell all that have surfaces at the same place"
            .to_owned(),
    };
    pairs
        .into_iter()
        .map(|[first, second]| {
            let (a, b) = (&objects[first], &objects[second]);
            Warning {
                at: Some(b.declared_at.clone()),
                message: format!(
                    "shapes \"{}\" and \"{}\" have surfaces at the same place, of which light meets only one: \
                     move them apart, or give their common surface once, with int_ior and ext_ior of its two sides",
                    a.id, b.id
                ),
            }
        })
        .chain((!are_all_known).then_some(unknown))
        .collect()
}

/// Distance, relative to coordinates and sizes, up to which surfaces are at the same place. Rays start up to
/// 32 roundings off one surface, and the other is as uncertain.
const ROOM: f64 = 64.0 * (0.5 * f64::EPSILON);

/// Largest distance between surfaces of two shapes that count as being at the same place.
fn room(a: &Bounds, b: &Bounds) -> f64 {
    let reach = |bounds: &Bounds| bounds.min.abs().max(bounds.max.abs()).max_element();
    ROOM * reach(a).max(reach(b))
}

/// True if some area of one shape is within `room` of some area of the other.
fn coincide(a: &Shape, b: &Shape, room: f64) -> bool {
    match (a, b) {
        (Shape::Sphere(a), Shape::Sphere(b)) => {
            a.center().distance(b.center()) + (a.radius() - b.radius()).abs() <= room
        }
        (Shape::Cylinder(a), Shape::Cylinder(b)) => {
            let across = |point: DVec3| {
                let from_base = point - a.base();
                (from_base - a.axis() * from_base.dot(a.axis())).length()
            };
            let end = b.base() + b.axis() * b.length();
            let heights = [b.base(), end].map(|point| (point - a.base()).dot(a.axis()));
            let [low, high] = [heights[0].min(heights[1]), heights[0].max(heights[1])];
            (a.radius() - b.radius()).abs() <= room
                && across(b.base()).max(across(end)) <= room
                && low.max(0.0) + room < high.min(a.length())
        }
        (Shape::Mesh(a), Shape::Mesh(b)) => share_a_face(a, b),
        (Shape::Mesh(mesh), flat) | (flat, Shape::Mesh(mesh)) => {
            let Some(outline) = Outline::of(flat) else {
                return false;
            };
            (0..mesh.triangle_count() as u32).any(|face| {
                let corners = mesh.corners(face);
                outline.is_in_plane(&corners, room) && outline.overlaps(&corners, room)
            })
        }
        _ => match (Outline::of(a), Outline::of(b)) {
            (Some(a), Some(b)) => a.is_in_plane(&b.corners, room) && a.overlaps(&b.corners, room),
            _ => false,
        },
    }
}

/// True if two meshes have a face over the same three points.
fn share_a_face(a: &Mesh, b: &Mesh) -> bool {
    let key = |mesh: &Mesh, face: u32| {
        // Adding +0 makes −0 and +0 the same key.
        let bits = |corner: DVec3| corner.to_array().map(|x| (x + 0.0).to_bits());
        let mut corners = mesh.corners(face).map(bits);
        corners.sort_unstable();
        corners
    };
    let [few, many] = if a.triangle_count() < b.triangle_count() {
        [a, b]
    } else {
        [b, a]
    };
    let faces = |mesh: &Mesh| 0..mesh.triangle_count() as u32;
    let known: HashSet<_> = faces(few).map(|face| key(few, face)).collect();
    faces(many).any(|face| known.contains(&key(many, face)))
}

/// A convex polygon: a flat shape, or nearly all of it.
struct Outline {
    corners: Vec<DVec3>,
    /// Unit vectors along the plane, at a right angle.
    axes: [DVec3; 2],
    normal: DVec3,
}

impl Outline {
    /// The outline of a rectangle, or of a disc with straight lines between 32 places of its rim.
    fn of(shape: &Shape) -> Option<Self> {
        let (corners, normal): (Vec<DVec3>, DVec3) = match shape {
            Shape::Rectangle(rectangle) => {
                let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
                let point = |uv: [f64; 2]| rectangle.point(DVec2::from(uv));
                (corners.map(point).to_vec(), rectangle.normal())
            }
            Shape::Disk(disk) => {
                let [u, v] = disk.half_axes();
                let rim = (0..32).map(|i| {
                    let (sin, cos) = math::sin_cos(std::f64::consts::TAU * f64::from(i) / 32.0);
                    disk.center() + u * cos + v * sin
                });
                (rim.collect(), disk.normal())
            }
            _ => return None,
        };
        let (s, t) = normal.any_orthonormal_pair();
        Some(Self {
            corners,
            axes: [s, t],
            normal,
        })
    }

    fn is_in_plane(&self, points: &[DVec3], room: f64) -> bool {
        let height = |point: &DVec3| (*point - self.corners[0]).dot(self.normal).abs();
        points.iter().all(|point| height(point) <= room)
    }

    /// True if a convex polygon in the plane has area in common with this one. By the separating axis
    /// theorem, no edge of either then has all of the other on its far side.
    fn overlaps(&self, other: &[DVec3], room: f64) -> bool {
        let flat = |points: &[DVec3]| -> Vec<DVec2> {
            let place = |point: &DVec3| {
                let offset = *point - self.corners[0];
                DVec2::new(offset.dot(self.axes[0]), offset.dot(self.axes[1]))
            };
            points.iter().map(place).collect()
        };
        let (a, b) = (flat(&self.corners), flat(other));
        let reach = |points: &[DVec2], across: DVec2| {
            points
                .iter()
                .map(|point| point.dot(across))
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| {
                    [low.min(at), high.max(at)]
                })
        };
        let is_between = |polygon: &[DVec2]| {
            (0..polygon.len()).any(|i| {
                let edge = polygon[(i + 1) % polygon.len()] - polygon[i];
                let across = edge.perp().normalize_or_zero();
                let ([a_low, a_high], [b_low, b_high]) = (reach(&a, across), reach(&b, across));
                across == DVec2::ZERO || a_high <= b_low + room || b_high <= a_low + room
            })
        };
        !is_between(&a) && !is_between(&b)
    }
}
