//! Surfaces that catch all light of a leg that ends on them: no light falls on their border.

use glam::DVec3;

use super::cell::Clearance;
use super::legs::{Leg, LegContact};
use super::tube::tube_catches;
use crate::geometry::{Disk, Mesh, Rectangle, Shape, Sphere, longest, range};

impl Clearance<'_> {
    /// True if all light of a leg falls on the thing at its end, provided that nothing is in the way.
    ///
    /// A smooth mesh catches all that comes towards it if the leg's hull holds neither a border nor a
    /// silhouette. The search of the mesh's faces tells that.
    pub(super) fn is_caught(&self, leg: &Leg) -> bool {
        let shapes = self.scene.world().shapes();
        match leg.to {
            LegContact::Source | LegContact::Eye | LegContact::Nothing => true,
            LegContact::Plane(shape) => shapes[shape as usize]
                .plane()
                .is_some_and(|[_, normal]| is_one_sided(leg, normal)),
            LegContact::Surface(shape) => match &shapes[shape as usize] {
                Shape::Sphere(ball) => leg.starts_on(shape) || ball_catches(leg, ball),
                Shape::Rectangle(rectangle) => rectangle_catches(leg, rectangle),
                Shape::Disk(disk) => disk_catches(leg, disk),
                Shape::Cylinder(tube) => tube_catches(leg, tube, leg.starts_on(shape)),
                Shape::Mesh(mesh) => mesh.has_vertex_normals() || face_catches(leg, mesh),
            },
        }
    }
}

/// True if all light goes through planes of this normal the same way.
fn is_one_sided(leg: &Leg, normal: DVec3) -> bool {
    let [low, high] = range(&leg.along().map(|along| along.dot(normal)));
    low > 0.0 || high < 0.0
}

/// True if a ball catches all light: from inside always, from outside if each line passes its centre nearer
/// than r.
fn ball_catches(leg: &Leg, ball: &Sphere) -> bool {
    let from_center = leg.start.map(|start| start - ball.center());
    if longest(&from_center) < ball.radius() {
        return true;
    }
    let along = leg.along();
    let feet = std::array::from_fn(|i| {
        let direction = along[i].normalize_or_zero();
        from_center[i] - direction * from_center[i].dot(direction)
    });
    longest(&feet) < ball.radius()
}

fn rectangle_catches(leg: &Leg, rectangle: &Rectangle) -> bool {
    let [u, v] = rectangle.edges();
    let places = parameters(leg, rectangle.center(), [0.5 * u, 0.5 * v]);
    is_one_sided(leg, rectangle.normal())
        && [places.map(|at| at.x), places.map(|at| at.y)]
            .iter()
            .all(|values| {
                let [low, high] = range(values);
                -1.0 <= low && high <= 1.0
            })
}

fn disk_catches(leg: &Leg, disk: &Disk) -> bool {
    is_one_sided(leg, disk.normal())
        && longest(&parameters(leg, disk.center(), disk.half_axes())) <= 1.0
}

/// True if one flat face catches all light: a flat face is a surface of its own.
fn face_catches(leg: &Leg, mesh: &Mesh) -> bool {
    let face = leg.to_faces[0];
    if leg.to_faces.iter().any(|other| *other != face) {
        return false;
    }
    let [a, b, c] = mesh.corners(face);
    let places = parameters(leg, a, [b - a, c - a]);
    let least = |values: [f64; 6]| range(&values)[0];
    is_one_sided(leg, (b - a).cross(c - a))
        && least(places.map(|at| at.x)) >= 0.0
        && least(places.map(|at| at.y)) >= 0.0
        && least(places.map(|at| 1.0 - at.x - at.y)) >= 0.0
}

/// Coordinates of the leg's ends along `u` and `v` from `origin`.
fn parameters(leg: &Leg, origin: DVec3, [u, v]: [DVec3; 2]) -> [DVec3; 6] {
    let cross = u.cross(v);
    let scale = cross.length_squared();
    leg.end.map(|end| {
        let offset = end - origin;
        let x = offset.cross(v).dot(cross) / scale;
        let y = u.cross(offset).dot(cross) / scale;
        DVec3::new(x, y, 0.0)
    })
}
