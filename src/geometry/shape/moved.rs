//! Surfaces moved to another place.

use glam::{DMat4, DVec3};

use super::{Cylinder, Disk, Rectangle, Shape, Sphere};
use crate::geometry::{Mesh, Transform};
use crate::numeric::math;

impl Shape {
    /// The surface moved by a rigid motion, its numbers rounded to 1e-8 of its size.
    ///
    /// A form that a motion took to another place comes back with the same bits: rounding takes the motion's
    /// own rounding away.
    ///
    /// # Errors
    ///
    /// If rounding leaves no surface: one whose size is below 1e-7 of its distance from the origin.
    pub fn moved(&self, motion: &Transform) -> Result<Self, String> {
        let text = |error: super::ShapeError| error.to_string();
        match self {
            Self::Sphere(sphere) => {
                let placed = rounded(&motion.matrix().mul_mat4(&sphere.to_world().matrix()))?;
                let flip = sphere.is_inward() != placed.is_mirroring();
                Sphere::new(&placed, flip).map(Self::Sphere).map_err(text)
            }
            Self::Cylinder(cylinder) => {
                let placed = rounded(&motion.matrix().mul_mat4(&cylinder.to_world().matrix()))?;
                Cylinder::new(&placed, cylinder.is_inward())
                    .map(Self::Cylinder)
                    .map_err(text)
            }
            Self::Rectangle(flat) => {
                let [u, v] = flat.edges();
                let placed = flat_form(flat.center(), [0.5 * u, 0.5 * v], flat.normal());
                let placed = rounded(&motion.matrix().mul_mat4(&placed))?;
                Rectangle::new(&placed, false)
                    .map(Self::Rectangle)
                    .map_err(text)
            }
            Self::Disk(flat) => {
                let placed = flat_form(flat.center(), flat.half_axes(), flat.normal());
                let placed = rounded(&motion.matrix().mul_mat4(&placed))?;
                Disk::new(&placed, false).map(Self::Disk).map_err(text)
            }
            Self::Mesh(mesh) => moved_mesh(mesh, motion).map(Self::Mesh),
        }
    }

    /// The largest distance \[m\] of the surface from a place; of a disc or tube that of its box.
    pub fn farthest_from(&self, place: DVec3) -> f64 {
        let corners = |corners: &[DVec3]| {
            let distances = corners.iter().map(|corner| corner.distance(place));
            distances.fold(0.0, f64::max)
        };
        match self {
            Self::Sphere(sphere) => sphere.center().distance(place) + sphere.radius(),
            Self::Mesh(mesh) => corners(mesh.positions()),
            Self::Rectangle(flat) => {
                let [u, v] = flat.edges().map(|edge| 0.5 * edge);
                corners(&[u + v, u - v, v - u, -u - v].map(|corner| flat.center() + corner))
            }
            Self::Disk(_) | Self::Cylinder(_) => corners(&self.bounds().corners()),
        }
    }
}

fn flat_form(center: DVec3, [u, v]: [DVec3; 2], normal: DVec3) -> DMat4 {
    DMat4::from_cols(
        u.extend(0.0),
        v.extend(0.0),
        normal.extend(0.0),
        center.extend(1.0),
    )
}

/// Numbers of some size, rounded to steps of about 1e-8 of it.
#[derive(Clone, Copy)]
struct Steps(f64);

impl Steps {
    /// Steps for numbers up to `size`: a third of a power of two.
    ///
    /// The factor keeps round sizes away from powers of two, where the step changes.
    fn new(size: f64) -> Self {
        const ROUND_SIZES: f64 = 1.37;
        let power = math::log2(size.max(f64::MIN_POSITIVE) * ROUND_SIZES).floor();
        Self(3.0 * math::exp2(26.0 - power))
    }

    fn round(self, x: f64) -> f64 {
        // Numbers of few binary digits, as files have them, are multiples of 3/2ᵏ steps: a third of a step
        // beside them, none is in the middle between two, where rounding errors of a motion would decide.
        // A sum with 0 is never -0, which would have other bits.
        (x * self.0 + 1.0 / 3.0).round() / self.0 + 0.0
    }
}

fn rounded(matrix: &DMat4) -> Result<Transform, String> {
    let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis];
    let largest = columns[..3]
        .iter()
        .fold(0.0, |all: f64, column| all.max(column.truncate().length()));
    // Each edge by itself: a cylinder may be much longer than it is wide, and is to stay round.
    let [x, y, z, w] = std::array::from_fn(|index| {
        let column = columns[index];
        let own = column.truncate();
        let steps = Steps::new(if index < 3 { own.length() } else { largest });
        own.map(|x| steps.round(x)).extend(column.w + 0.0)
    });
    Transform::from_matrix(DMat4::from_cols(x, y, z, w)).map_err(|error| error.to_string())
}

fn moved_mesh(mesh: &Mesh, motion: &Transform) -> Result<Mesh, String> {
    let reach = mesh.positions().iter().fold(0.0, |all: f64, place| {
        all.max(motion.point(*place).length())
    });
    let (steps, units) = (Steps::new(reach), Steps::new(1.0));
    mesh.mapped(
        |place| motion.point(place).map(|x| steps.round(x)),
        |n| motion.vector(n).map(|x| units.round(x)),
    )
    .map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Geodesic, MeshParts};
    use crate::numeric::rotation;
    use glam::DMat3;

    fn motion() -> Transform {
        let turn = rotation::about(DVec3::new(1.0, 2.0, -0.5).normalize(), 1.1);
        let moved = DMat4::from_translation(DVec3::new(3.0, -7.0, 0.3)) * DMat4::from_mat3(turn);
        Transform::from_matrix(moved).unwrap()
    }

    #[test]
    fn what_is_moved_there_and_back_has_its_own_bits() {
        let geodesic = Geodesic::new(12);
        let bump = |d: &DVec3| *d * (1.0 + 0.1 * math::sin(3.0 * d.x + 5.0 * d.y * d.z));
        let mesh = Mesh::new(MeshParts {
            positions: geodesic.vertices().iter().map(bump).collect(),
            triangles: geodesic.triangles().to_vec(),
            ..MeshParts::default()
        });
        let mesh = Shape::Mesh(mesh.unwrap());
        let turn = rotation::about(DVec3::X, 0.4) * DMat3::from_diagonal(DVec3::splat(0.7));
        let tall = DMat4::from_translation(DVec3::new(0.2, 0.5, -0.1)) * DMat4::from_mat3(turn);
        let placed = Transform::from_matrix(tall).unwrap();
        let shapes = [
            mesh,
            Shape::Sphere(Sphere::new(&placed, true).unwrap()),
            Shape::Rectangle(Rectangle::new(&placed, false).unwrap()),
            Shape::Disk(Disk::new(&placed, true).unwrap()),
            Shape::Cylinder(Cylinder::new(&placed, true).unwrap()),
        ];
        let motion = motion();
        for shape in shapes {
            let own = shape.moved(&Transform::IDENTITY).unwrap();
            // In double precision, as a scene file would move it.
            let there = match &shape {
                Shape::Mesh(mesh) => {
                    let point = |place| motion.point(place);
                    Shape::Mesh(mesh.mapped(point, |n| motion.vector(n)).unwrap())
                }
                Shape::Sphere(_) => {
                    Shape::Sphere(Sphere::new(&motion.after(&placed).unwrap(), true).unwrap())
                }
                Shape::Rectangle(_) => {
                    let placed = motion.after(&placed).unwrap();
                    Shape::Rectangle(Rectangle::new(&placed, false).unwrap())
                }
                Shape::Disk(_) => {
                    Shape::Disk(Disk::new(&motion.after(&placed).unwrap(), true).unwrap())
                }
                Shape::Cylinder(_) => {
                    Shape::Cylinder(Cylinder::new(&motion.after(&placed).unwrap(), true).unwrap())
                }
            };
            let back = there.moved(&motion.inverse()).unwrap();
            assert_eq!(back, own);
            // Of equal numbers the text tells 0 from -0, too.
            assert_eq!(format!("{back:?}"), format!("{own:?}"));
        }
    }

    #[test]
    fn a_surface_keeps_its_side_and_size() {
        let placed = Transform::from_matrix(DMat4::from_scale(DVec3::splat(0.5))).unwrap();
        let sphere = Shape::Sphere(Sphere::new(&placed, true).unwrap());
        let Shape::Sphere(moved) = sphere.moved(&motion()).unwrap() else {
            panic!("a sphere stays one");
        };
        assert!(moved.is_inward());
        assert!((moved.radius() - 0.5).abs() < 1e-7);
        let at = moved.center();
        assert!((sphere.moved(&motion()).unwrap().farthest_from(at) - 0.5).abs() < 1e-7);
    }
}
