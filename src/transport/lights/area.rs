//! Shapes that shine.

use glam::{DVec2, DVec3};

use super::sample::LightSample;
use super::sphere::BallView;
use crate::geometry::{Hit, Mesh, Ray, Shape, Sphere, SurfacePoint};
use crate::numeric::WeightedChoice;
use crate::radiometry::Rgb;
use crate::scene::{Scene, ShapeId, TextureId, TexturePoint};

/// A shape whose front shines, with the same radiance from each of its points in all directions.
#[derive(Clone, Debug)]
pub(super) struct AreaLight<'a> {
    scene: &'a Scene,
    shape: ShapeId,
    form: AreaForm<'a>,
    /// Area [m²].
    area: f64,
    /// Radiance [W/m²/sr], or a factor on the texture.
    radiance: Rgb,
    /// The texture of the radiance. Directions are chosen without a look at it; Mitsuba prefers bright
    /// texels.
    texture: Option<TextureId>,
}

/// The shape, by the choice of directions towards it.
#[derive(Clone, Debug)]
enum AreaForm<'a> {
    /// Uniform over the directions in which it is seen.
    Ball(&'a Sphere),
    /// Uniform over its area: faces by their area, `None` if there is none.
    Mesh(&'a Mesh, Option<WeightedChoice>),
    /// Uniform over its area.
    Patch(&'a Shape),
}

impl<'a> AreaLight<'a> {
    /// A shape of the scene that shines.
    pub(super) fn new(
        scene: &'a Scene,
        shape: ShapeId,
        radiance: Rgb,
        texture: Option<TextureId>,
    ) -> Self {
        let surface = &scene.world().shapes()[shape.0 as usize];
        let form = match surface {
            Shape::Sphere(sphere) => AreaForm::Ball(sphere),
            Shape::Mesh(mesh) => AreaForm::Mesh(mesh, faces_by_area(mesh)),
            Shape::Rectangle(_) | Shape::Disk(_) | Shape::Cylinder(_) => AreaForm::Patch(surface),
        };
        let area = match &form {
            AreaForm::Mesh(_, faces) => faces.as_ref().map_or(0.0, WeightedChoice::total),
            _ => surface.area(),
        };
        Self {
            scene,
            shape,
            form,
            area,
            radiance,
            texture,
        }
    }

    /// Radiance [W/m²/sr] that comes back along the ray that hit it.
    pub(super) fn emitted(&self, ray: &Ray, hit: &Hit) -> Rgb {
        let world = self.scene.world();
        // Only textures need uv, which takes time on round shapes.
        let point = match self.texture {
            Some(_) => world.surface_point(ray, hit),
            None => world.bounce_point(ray, hit),
        };
        if self.cosine(hit.face, &point, -ray.direction) > 0.0 {
            self.radiance_at(hit, &point)
        } else {
            Rgb::BLACK
        }
    }

    /// The cosine between the normal on the side that shines and a direction away from `point`.
    fn cosine(&self, face: u32, point: &SurfacePoint, away: DVec3) -> f64 {
        let cosine = point.geometric_normal.dot(away);
        match self.form {
            AreaForm::Mesh(mesh, _) => cosine * mesh.shining_side(face),
            AreaForm::Ball(_) | AreaForm::Patch(_) => cosine,
        }
    }

    /// Radiance [W/m²/sr] of the front at `point`.
    fn radiance_at(&self, hit: &Hit, point: &SurfacePoint) -> Rgb {
        self.texture.map_or(self.radiance, |texture| {
            let at = TexturePoint::new(self.scene, hit, point);
            self.scene.texture_value(texture, &at) * self.radiance
        })
    }

    /// The density [1/sr] of the direction from `from` to `point` of a face, a unit vector, in
    /// [`Self::sample`].
    pub(super) fn pdf_solid_angle(
        &self,
        from: DVec3,
        face: u32,
        point: &SurfacePoint,
        direction: DVec3,
    ) -> f64 {
        let cos_light = self.cosine(face, point, -direction);
        if cos_light <= 0.0 {
            return 0.0;
        }
        match self.form {
            AreaForm::Ball(ball) => BallView::new(ball, from).pdf_solid_angle(),
            AreaForm::Mesh(..) | AreaForm::Patch(_) => {
                // dω = cos θ' dA / r²
                from.distance_squared(point.position) / (self.area * cos_light)
            }
        }
    }

    /// A direction to it from `from`; `None` if the front cannot be seen.
    pub(super) fn sample(&self, from: &SurfacePoint, u: [f64; 2]) -> Option<LightSample> {
        match &self.form {
            AreaForm::Ball(ball) => self.sample_ball(ball, from, u),
            AreaForm::Mesh(mesh, faces) => {
                let (face, barycentric) = uniform_on_mesh(faces.as_ref()?, u);
                // Only faces with an area are chosen: they need no other normal.
                let target = mesh.at_barycentric(face, barycentric, DVec3::ZERO);
                self.sample_point(from, &target, face, barycentric)
            }
            AreaForm::Patch(shape) => {
                let target = uniform_on_patch(shape, u)?;
                self.sample_point(from, &target, 0, DVec2::ZERO)
            }
        }
    }

    /// The direction to a point chosen uniformly over the area.
    fn sample_point(
        &self,
        from: &SurfacePoint,
        target: &SurfacePoint,
        face: u32,
        barycentric: DVec2,
    ) -> Option<LightSample> {
        let offset = target.position - from.position;
        let distance = offset.length();
        let direction = offset.try_normalize()?;
        let cos_light = self.cosine(face, target, -direction);
        if cos_light <= 0.0 {
            return None;
        }
        let hit = Hit {
            distance,
            shape: self.shape.0,
            face,
            barycentric,
        };
        AreaDirection {
            direction,
            distance,
            cos_light,
            pdf_solid_angle: distance * distance / (self.area * cos_light),
            margin: target.position_error.length() + from.position_error.length(),
        }
        .sample(|| self.radiance_at(&hit, target))
    }

    fn sample_ball(&self, ball: &Sphere, from: &SurfacePoint, u: [f64; 2]) -> Option<LightSample> {
        let view = BallView::new(ball, from.position);
        let found = view.sample(ball, u)?;
        let error = ball.along(DVec3::Z).position_error;
        AreaDirection {
            direction: found.direction,
            distance: found.distance,
            cos_light: found.cos_light,
            pdf_solid_angle: view.pdf_solid_angle(),
            margin: error.length() + from.position_error.length(),
        }
        .sample(|| {
            let hit = Hit {
                distance: found.distance,
                shape: self.shape.0,
                face: 0,
                barycentric: DVec2::ZERO,
            };
            let ray = Ray::new(from.position, found.direction);
            self.radiance_at(&hit, &self.scene.world().surface_point(&ray, &hit))
        })
    }
}

/// The direction from a point to a place on a light.
struct AreaDirection {
    direction: DVec3,
    distance: f64,
    /// Cosine between the light's normal and the way back.
    cos_light: f64,
    pdf_solid_angle: f64,
    /// Distance by which the two ends may be off their surfaces.
    margin: f64,
}

impl AreaDirection {
    /// The sample, given the radiance [W/m²/sr] that the place sends.
    fn sample(self, radiance: impl FnOnce() -> Rgb) -> Option<LightSample> {
        // A distance of zero has no direction, and squares of lengths may leave the range of f64.
        if !(self.pdf_solid_angle > 0.0 && self.pdf_solid_angle.is_finite()) {
            return None;
        }
        Some(LightSample {
            direction: self.direction,
            distance: self.distance,
            // A ray that comes in at a slant passes the surface's margin over a longer way.
            reach: self.distance * (1.0 - 8.0 * f64::EPSILON) - 2.0 * self.margin / self.cos_light,
            radiance_over_pdf: radiance() / self.pdf_solid_angle,
            pdf_solid_angle: self.pdf_solid_angle,
            is_delta: false,
            emitter: 0,
        })
    }
}

/// A face, and barycentric weights on it, uniform over a mesh's area.
fn uniform_on_mesh(faces: &WeightedChoice, u: [f64; 2]) -> (u32, DVec2) {
    let face = faces.choose(u[0]);
    // Turk 1990: the density of √u cancels the narrowing towards the corner.
    let root = face.rest.sqrt();
    let barycentric = DVec2::new(root * (1.0 - u[1]), root * u[1]);
    (face.index as u32, barycentric)
}

/// A point of any other shape but a ball, uniform over the shape's area.
fn uniform_on_patch(shape: &Shape, u: [f64; 2]) -> Option<SurfacePoint> {
    shape.at_uv(match shape {
        // Rings of a disc have equal area.
        Shape::Disk(_) => DVec2::new(u[0].sqrt(), u[1]),
        // Parameters of the other shapes keep areas in proportion.
        _ => DVec2::new(u[0], u[1]),
    })
}

/// Faces in proportion to their area. Of faces at the same place only the first counts, as rays meet no
/// other.
fn faces_by_area(mesh: &Mesh) -> Option<WeightedChoice> {
    let mut areas = vec![0.0; mesh.triangle_count()];
    for face in mesh.distinct_faces() {
        areas[face as usize] = mesh.face_area(face);
    }
    WeightedChoice::new(areas)
}
