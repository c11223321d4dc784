//! Objects that mirror or refract, each in its own space.

use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3};

use crate::geometry::{Bounds, Shape, Transform};
use crate::run::Refusal;
use crate::scene::{Material, MaterialId, Scene, SceneParts};

use super::settings::Settings;

/// Shapes that mirror or refract and whose boxes overlap: they share tables.
#[derive(Debug)]
pub struct SpecularObject {
    /// Its shapes, as indices into the scene's.
    pub shapes: Vec<u32>,
    /// Its box in the world.
    pub bounds: Bounds,
    /// The middle of its box in its own space, in the world.
    pub center: DVec3,
    /// The largest distance \[m\] of its surface from there: r.
    pub radius: f64,
    /// The rotation from its own axes to the world's.
    pub turn: DMat3,
    /// Itself and nothing else, in its own space.
    pub alone: Scene,
    /// The centre in its own space.
    pub own_center: DVec3,
}

impl SpecularObject {
    /// All objects of a scene, in the order of their first shapes.
    ///
    /// # Errors
    ///
    /// If there is none, or one has no form.
    pub fn all(scene: &Scene) -> Result<Vec<Self>, Refusal> {
        let groups = Self::groups(scene);
        if groups.is_empty() {
            return Err(Refusal::new(
                "no shape mirrors or refracts: local precomputed irradiance needs one of plugin dielectric, \
                 thindielectric or conductor",
            ));
        }
        groups
            .into_iter()
            .map(|(shapes, bounds)| Self::new(scene, shapes, bounds))
            .collect()
    }

    /// The shapes of each object, with their boxes.
    pub fn groups(scene: &Scene) -> Vec<(Vec<u32>, Bounds)> {
        let shapes = 0..scene.world().shapes().len() as u32;
        let specular =
            shapes.filter(|shape| scene.material_of(*shape).is_specular(scene.materials()));
        let mut groups: Vec<(Vec<u32>, Bounds)> = Vec::new();
        for shape in specular {
            let mut one = (vec![shape], scene.world().shapes()[shape as usize].bounds());
            // A box that grew may overlap others that it did not before.
            while let Some(other) = groups
                .iter()
                .position(|(_, bounds)| overlap(bounds, &one.1))
            {
                let (shapes, bounds) = groups.remove(other);
                one.0.extend(shapes);
                one.1 = one.1.union(bounds);
            }
            one.0.sort_unstable();
            groups.push(one);
        }
        groups.sort_by_key(|(shapes, _)| shapes[0]);
        groups
    }

    fn new(scene: &Scene, shapes: Vec<u32>, bounds: Bounds) -> Result<Self, Refusal> {
        let objects = scene.objects();
        let first = &objects[shapes[0] as usize];
        let to_world = first.to_world.matrix();
        let turn = rotation_of(DMat3::from_mat4(to_world));
        let origin = to_world.w_axis.truncate();
        let back = turn.transpose();
        let motion = DMat4::from_cols(
            back.x_axis.extend(0.0),
            back.y_axis.extend(0.0),
            back.z_axis.extend(0.0),
            (-(back * origin)).extend(1.0),
        );
        let refused = |why: String| {
            Refusal::new(format!(
                "shape \"{}\" has no form of its own: {why}",
                first.id
            ))
        };
        let motion = Transform::from_matrix(motion).map_err(|error| refused(error.to_string()))?;
        let own: Vec<Shape> = shapes
            .iter()
            .map(|shape| scene.world().shapes()[*shape as usize].moved(&motion))
            .collect::<Result<_, _>>()
            .map_err(refused)?;
        let own_bounds = own
            .iter()
            .fold(Bounds::EMPTY, |all, shape| all.union(tight_bounds(shape)));
        let own_center = own_bounds.center();
        let distances = own.iter().map(|shape| shape.farthest_from(own_center));
        let radius = distances.fold(0.0, f64::max);
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(refused(format!("its radius is {radius}")));
        }
        let alone = Scene::new(SceneParts {
            path: scene.path().to_owned(),
            shapes: own,
            objects: shapes
                .iter()
                .map(|shape| objects[*shape as usize].clone())
                .collect(),
            materials: scene.materials().to_vec(),
            textures: scene.textures().to_vec(),
            ..SceneParts::default()
        })
        .map_err(|error| refused(error.to_string()))?;
        Ok(Self {
            shapes,
            bounds,
            center: origin + turn * own_center,
            radius,
            turn,
            alone,
            own_center,
        })
    }

    /// A name (a hash, in hex) for tables: all that they are made from, wherever the object is and however it
    /// is turned.
    pub fn form(&self, settings: &Settings) -> Arc<str> {
        let mut hasher = blake3::Hasher::new();
        let mut feed = |bytes: &[u8]| {
            hasher.update(&(bytes.len() as u64).to_le_bytes());
            hasher.update(bytes);
        };
        feed(settings.of_tables().as_bytes());
        for (shape, object) in self.alone.world().shapes().iter().zip(self.alone.objects()) {
            match shape {
                Shape::Mesh(mesh) => {
                    for place in mesh.positions() {
                        for x in place.to_array() {
                            feed(&x.to_le_bytes());
                        }
                    }
                    for triangle in mesh.triangles() {
                        for corner in triangle {
                            feed(&corner.to_le_bytes());
                        }
                    }
                    for normal in mesh.vertex_normals() {
                        for x in normal.to_array() {
                            feed(&x.to_le_bytes());
                        }
                    }
                    feed(&[u8::from(mesh.are_normals_flipped())]);
                }
                other => feed(format!("{other:?}").as_bytes()),
            }
            feed(format!("{:?}", materials(&self.alone, object.material)).as_bytes());
        }
        hasher.finalize().to_hex().as_str().into()
    }

    /// A vector of the world along the object's own axes.
    #[inline]
    pub fn to_own(&self, vector: DVec3) -> DVec3 {
        self.turn.transpose() * vector
    }
}

/// A material and all that it wraps.
fn materials(scene: &Scene, id: MaterialId) -> Vec<&Material> {
    let material = scene.material(id);
    let mut all = vec![material];
    all.extend(material.nested().flat_map(|id| materials(scene, id)));
    all
}

/// The box of a surface without the margin for rounding, so that it is symmetric as the surface is.
fn tight_bounds(shape: &Shape) -> Bounds {
    match shape {
        Shape::Sphere(sphere) => Bounds::from_points([
            sphere.center() - sphere.radius(),
            sphere.center() + sphere.radius(),
        ]),
        Shape::Mesh(mesh) => Bounds::from_points(mesh.positions().iter().copied()),
        Shape::Rectangle(_) | Shape::Disk(_) | Shape::Cylinder(_) => shape.bounds(),
    }
}

fn overlap(a: &Bounds, b: &Bounds) -> bool {
    a.min.cmple(b.max).all() && b.min.cmple(a.max).all()
}

/// The rotation nearest to a matrix: the orthogonal factor of its polar decomposition, made proper.
///
/// Newton's iteration X ← (X + X⁻ᵀ)/2 (Higham 1986) converges quadratically. For a rotation R of a form M it
/// gives R times the form's own, so forms do not depend on how they are turned.
fn rotation_of(matrix: DMat3) -> DMat3 {
    let mut x = if matrix.determinant() < 0.0 {
        -matrix
    } else {
        matrix
    };
    // 100 steps halve scales of up to 1e30 before convergence begins.
    for _ in 0..100 {
        let next = (x + x.inverse().transpose()) * 0.5;
        let change = (next - x).to_cols_array();
        x = next;
        if change.iter().all(|change| change.abs() < 1e-15) {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::rotation;

    #[test]
    fn the_rotation_of_a_stretched_form_is_found_whatever_its_scale() {
        let turn =
            rotation::about(DVec3::X, 0.3) * rotation::about(DVec3::new(0.6, 0.0, 0.8), -1.2);
        for scale in [1e-6, 1.0, 37.0, 1e8] {
            let stretch = DMat3::from_diagonal(DVec3::new(1.0, 2.5, 0.4) * scale);
            let found = rotation_of(turn * stretch);
            let off = (found - turn).to_cols_array();
            assert!(off.iter().all(|off| off.abs() < 1e-13), "{scale}: {off:?}");
        }
    }

    #[test]
    fn a_mirrored_form_has_a_proper_rotation() {
        let mirrored = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
        assert!((rotation_of(mirrored).determinant() - 1.0).abs() < 1e-14);
    }
}
