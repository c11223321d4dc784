//! Stage `refraction`: how light leaves a specular object, exactly or by pictures of it.

use glam::{DVec2, DVec3};

use super::buffers::{Back, Front, mean_curvature};
use super::lens::Lens;
use super::settings::Splat;
use crate::approximation::LightView;
use crate::approximation::interface::{Crossing, Fresnel, bent, cross, schlick, tint, turning};
use crate::geometry::{Hit, Ray, SurfacePoint, TraversalCounters};
use crate::optics::{RayDerivative, dielectric_reflectance, refract};
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::transport::path_end::next_hit;
use crate::transport::scatter::{Bending, Way};

/// A photon that has left the specular object.
#[derive(Clone, Copy, Debug)]
pub struct Exit {
    /// From where it left.
    pub ray: Ray,
    /// The share of its flux that is still there.
    pub throughput: Rgb,
    /// The object, as lens equations see it.
    pub lens: Lens,
    /// How the ray changes with the two image coordinates of the light view, by pixel; zero where that is not
    /// wanted.
    pub derivatives: [RayDerivative; 2],
    /// Whether it left exactly there: an approximate place may be inside the object still.
    pub is_exact: bool,
    /// Which smooth surfaces it met: neighbours with the same are one beam.
    pub topology: u64,
}

/// What a splat's width depends on, beside where its photon lands: only that is worked out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// Nothing.
    Nothing,
    /// The surfaces' mean curvatures.
    Curvatures,
    /// The beam's derivatives.
    Derivatives,
}

impl Wanted {
    /// By a variant of stage `splat`.
    pub fn by(splat: Splat) -> Self {
        match splat {
            Splat::ThinLens | Splat::ThickLens => Self::Curvatures,
            Splat::TwoCurvatures => Self::Derivatives,
            _ => Self::Nothing,
        }
    }

    /// Mean curvature [1/m], where it is wanted.
    fn curvature(self, scene: &Scene, hit: &Hit, point: &SurfacePoint) -> f64 {
        match self {
            Self::Curvatures => mean_curvature(scene, hit, point),
            _ => 0.0,
        }
    }
}

/// A photon at the specular object's front.
#[derive(Clone, Copy, Debug)]
pub struct Arrival<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The photon buffer's view.
    pub view: &'a LightView,
    /// Its image point.
    pub at: DVec2,
    /// Where it meets the object.
    pub front: &'a Front,
    /// What interfaces let through.
    pub fresnel: Fresnel,
    /// What its splat will need.
    pub wanted: Wanted,
}

/// Which smooth surface a hit is on: the shape, and of flat faces the face.
fn surface(scene: &Scene, hit: &Hit) -> u64 {
    let element = scene.world().element(hit);
    u64::from(element.shape) << 32 | element.face.map_or(0, |face| u64::from(face) + 1)
}

impl Arrival<'_> {
    /// The front, crossed or mirrored at.
    fn cross(&self, way: Way) -> Option<Crossing> {
        let Front { ray, hit, point } = self.front;
        cross(
            self.scene,
            hit.shape,
            point,
            ray.direction,
            way,
            self.fresnel,
        )
    }

    /// `d_front`, the light's distance \[m\]; of parallel light that of the view.
    fn distance(&self) -> f64 {
        let start = self.view.ray(self.at).origin;
        self.front.point.position.distance(start)
    }

    /// `1/d_front` [1/m].
    fn vergence(&self) -> f64 {
        if self.view.is_parallel() {
            0.0
        } else {
            1.0 / self.distance()
        }
    }

    /// The beam that leaves the front, its rays' changes by pixel.
    fn bent(&self, bending: Bending) -> Option<[RayDerivative; 2]> {
        let Front { ray, hit, point } = self.front;
        let distance = self.distance();
        let arriving = self.view.ray_derivatives(self.at).map(|derivative| {
            derivative.transferred(ray.direction, distance, point.geometric_normal)
        });
        let turn = turning(self.scene, hit, point, bending);
        bent(arriving, ray.direction, bending, turn)
    }

    /// Refraction by the ray that is traced through the object: `LTT`.
    pub fn through(&self, counters: &mut TraversalCounters) -> Option<Exit> {
        let (scene, front, wanted) = (self.scene, self.front, self.wanted);
        let way = Way::Transmitted;
        let first = self.cross(way)?;
        let (inside, hit) = next_hit(scene, front.point.spawn(first.direction), counters)?;
        let point = scene.world().bounce_point(&inside, &hit);
        let direction = inside.direction;
        let second = cross(scene, hit.shape, &point, direction, way, self.fresnel)?;
        let thickness = point.position.distance(front.point.position);
        let derivatives = if wanted == Wanted::Derivatives {
            let beam = self.bent(first.bending)?.map(|derivative| {
                derivative.transferred(direction, thickness, point.geometric_normal)
            });
            let turn = turning(scene, &hit, &point, second.bending);
            bent(beam, direction, second.bending, turn)?
        } else {
            Default::default()
        };
        let eta = match first.bending {
            Bending::Refraction { eta, .. } => eta,
            _ => 1.0,
        };
        Some(Exit {
            ray: point.spawn(second.direction),
            throughput: first.throughput * second.throughput,
            lens: Lens {
                vergence: self.vergence(),
                front: wanted.curvature(scene, &front.hit, &front.point),
                back: wanted.curvature(scene, &hit, &point),
                eta,
                thickness,
            },
            derivatives,
            is_exact: true,
            topology: surface(scene, &front.hit).wrapping_mul(0x9e37_79b9_7f4a_7c15)
                ^ surface(scene, &hit),
        })
    }

    /// One mirror reflection: `LR`.
    pub fn reflected(&self) -> Option<Exit> {
        let (scene, front) = (self.scene, self.front);
        let crossing = self.cross(Way::Reflected)?;
        let derivatives = if self.wanted == Wanted::Derivatives {
            self.bent(crossing.bending)?
        } else {
            Default::default()
        };
        let facing = -front
            .ray
            .direction
            .dot(front.point.geometric_normal)
            .signum();
        let curvature = self.wanted.curvature(scene, &front.hit, &front.point);
        Some(Exit {
            ray: front.point.spawn(crossing.direction),
            throughput: crossing.throughput,
            lens: Lens {
                vergence: self.vergence(),
                front: facing * curvature,
                back: 0.0,
                eta: 1.0,
                thickness: 0.0,
            },
            derivatives,
            is_exact: true,
            topology: surface(scene, &front.hit) << 1 | u64::from(facing > 0.0),
        })
    }

    /// Wyman's two-interface refraction (*An approximate image-space approach for interactive refraction*,
    /// SIGGRAPH 2005): the exit point is P₂ = P₁ + d̃ T₁ with
    ///
    /// ```text
    /// d̃ = (θt/θi) d_V + (1 − θt/θi) d_N
    /// ```
    ///
    /// where `d_V` is the object's thickness along the light's ray, to its farthest back face, and `d_N` the
    /// one along the inverted normal, which a device has precomputed for each vertex (here a ray that is
    /// counted). The normal there is read from the picture of back faces, at the pixel that P₂ is seen in.
    /// `None` where that pixel has none, and where that interface would reflect all: the technique knows no
    /// total internal reflection.
    pub fn image_space(
        &self,
        backs: &[Option<Back>],
        counters: &mut TraversalCounters,
    ) -> Option<Exit> {
        let (scene, view, front, wanted) = (self.scene, self.view, self.front, self.wanted);
        let first = self.cross(Way::Transmitted)?;
        let Bending::Refraction { normal, eta } = first.bending else {
            return None;
        };
        let fetch = |at: DVec2| {
            let side = view.side();
            view.holds(at)
                .then(|| backs[at.y as usize * side + at.x as usize])
                .flatten()
                .filter(|back| back.shape == front.hit.shape)
        };
        let along_view = fetch(self.at)?.distance - self.distance();
        let inward = front.point.spawn(-normal);
        let along_normal = scene
            .world()
            .closest_hit(&inward, f64::INFINITY, counters)
            .map_or(along_view, |hit| hit.distance);
        let thickness = interpolated(
            front.ray.direction,
            first.direction,
            normal,
            eta,
            [along_view, along_normal],
        );
        let exit = front.point.position + first.direction * thickness;
        let back = fetch(view.project(exit)?.at)?;
        let facing = -back.normal;
        let inside = first.direction;
        let direction = refract(inside, facing, 1.0 / eta)?;
        let cos = -inside.dot(facing);
        if cos <= 0.0 {
            return None;
        }
        let passed = match self.fresnel {
            Fresnel::None => 1.0,
            Fresnel::Schlick => 1.0 - schlick(cos, 1.0 / eta),
            Fresnel::Exact => 1.0 - dielectric_reflectance(cos, 1.0 / eta),
        };
        let derivatives = if wanted == Wanted::Derivatives {
            let beam = self
                .bent(first.bending)?
                .map(|derivative| derivative.transferred(inside, thickness, facing));
            // Of the back only its mean curvature is known; its normal, turned round, bends the other way.
            let bending = Bending::Refraction {
                normal: facing,
                eta: 1.0 / eta,
            };
            bent(beam, inside, bending, |along| along * -back.curvature)?
        } else {
            Default::default()
        };
        Some(Exit {
            ray: Ray::new(exit, direction.normalize()),
            throughput: first.throughput * tint(scene, front.hit.shape) * passed,
            lens: Lens {
                vergence: self.vergence(),
                front: wanted.curvature(scene, &front.hit, &front.point),
                back: back.curvature,
                eta,
                thickness,
            },
            derivatives,
            is_exact: false,
            topology: surface(scene, &front.hit),
        })
    }
}

/// Wyman's d̃ \[m\] of light that arrives along `arriving`, goes on along `refracted`, from the thickness
/// along the view and the one along the normal.
fn interpolated(
    arriving: DVec3,
    refracted: DVec3,
    normal: DVec3,
    eta: f64,
    [along_view, along_normal]: [f64; 2],
) -> f64 {
    let incident = (-arriving.dot(normal)).clamp(0.0, 1.0).acos();
    let transmitted = (-refracted.dot(normal)).clamp(0.0, 1.0).acos();
    // The limit of the quotient towards normal incidence is that of the sines.
    let ratio = if incident > 1e-6 {
        transmitted / incident
    } else {
        1.0 / eta
    };
    (ratio * along_view + (1.0 - ratio) * along_normal).max(0.0)
}
