//! Stage `refraction`: how light leaves a specular object, exactly or by pictures of it.

use glam::{DVec2, DVec3};

use super::buffers::{Backs, Front, mean_curvature};
use super::lens::Lens;
use super::loss::Loss;
use super::settings::Settings;
use super::tally::Left;
use super::variants::{NoBackFace, Splat, Thickness, TotalReflection};
use crate::approximation::LightView;
use crate::approximation::interface::{Crossing, Fresnel, bent, cross, leaving, turning};
use crate::geometry::{Hit, Ray, SurfacePoint, TraversalCounters};
use crate::numeric::math;
use crate::optics::RayDerivative;
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::transport::scatter::{Bending, Way};

/// A photon that has left the specular object.
#[derive(Clone, Copy, Debug)]
pub struct Exit {
    /// From where it left.
    pub ray: Ray,
    /// The share of its flux that is still there.
    pub throughput: Rgb,
    /// The same by Fresnel's equations, whatever is modelled.
    pub by_fresnel: Rgb,
    /// The object, as lens equations see it.
    pub lens: Lens,
    /// How the ray changes with the two image coordinates of the light view, by pixel; zero where that is not
    /// wanted.
    pub derivatives: [RayDerivative; 2],
    /// Whether the place may be inside the object still, since it is approximate.
    pub may_be_inside: bool,
    /// Which smooth surfaces it met: neighbours with the same are one beam.
    pub topology: u64,
}

impl Exit {
    /// What interfaces have let through.
    pub fn left(&self) -> Left {
        Left {
            throughput: self.throughput,
            by_fresnel: self.by_fresnel,
        }
    }
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
            Splat::Fixed | Splat::Mip | Splat::MipSplat | Splat::MultiResolution | Splat::Exact => {
                Self::Nothing
            }
        }
    }

    /// Mean curvature [1/m], where it is wanted.
    fn curvature(self, scene: &Scene, hit: &Hit, point: &SurfacePoint) -> f64 {
        match self {
            Self::Curvatures => mean_curvature(scene, hit, point),
            Self::Nothing | Self::Derivatives => 0.0,
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

    /// The front, crossed, and the ray on from there.
    ///
    /// # Errors
    ///
    /// Where it lets nothing through.
    pub fn entered(&self) -> Result<(Crossing, Ray), Loss> {
        let first = self.cross(Way::Transmitted).ok_or(Loss::Opaque)?;
        let ray = self.front.point.spawn(first.direction);
        Ok((first, ray))
    }

    /// Refraction by the ray that is traced through the object: `LTT`. `found` is what the ray meets that
    /// [`entered`](Self::entered) by `first`.
    ///
    /// # Errors
    ///
    /// Where the ray meets no second interface, or one that lets nothing through.
    pub fn through(&self, first: &Crossing, found: Option<(Ray, Hit)>) -> Result<Exit, Loss> {
        let (scene, front, wanted) = (self.scene, self.front, self.wanted);
        let way = Way::Transmitted;
        let (inside, hit) = found
            .filter(|(_, hit)| scene.material_of(hit.shape).is_specular(scene.materials()))
            .ok_or(Loss::NoSecondInterface)?;
        let point = scene.world().bounce_point(&inside, &hit);
        let direction = inside.direction;
        let second = cross(scene, hit.shape, &point, direction, way, self.fresnel)
            .ok_or(Loss::TotalReflection)?;
        let thickness = point.position.distance(front.point.position);
        let derivatives = if wanted == Wanted::Derivatives {
            let beam = self.bent(first.bending).ok_or(Loss::Opaque)?;
            let beam = beam.map(|derivative| {
                derivative.transferred(direction, thickness, point.geometric_normal)
            });
            let turn = turning(scene, &hit, &point, second.bending);
            bent(beam, direction, second.bending, turn).ok_or(Loss::TotalReflection)?
        } else {
            Default::default()
        };
        Ok(Exit {
            ray: point.spawn(second.direction),
            throughput: first.throughput * second.throughput,
            by_fresnel: first.by_fresnel * second.by_fresnel,
            lens: Lens {
                vergence: self.vergence(),
                front: wanted.curvature(scene, &front.hit, &front.point),
                back: wanted.curvature(scene, &hit, &point),
                eta: relative_index(first.bending),
                thickness,
            },
            derivatives,
            may_be_inside: false,
            topology: surface(scene, &front.hit).wrapping_mul(0x9e37_79b9_7f4a_7c15)
                ^ surface(scene, &hit),
        })
    }

    /// One interface, passed or mirrored at: `LT` or `LR`.
    ///
    /// # Errors
    ///
    /// Where the surface lets nothing go on this way.
    pub fn at_once(&self, way: Way) -> Result<Exit, Loss> {
        let (scene, front) = (self.scene, self.front);
        let crossing = self.cross(way).ok_or(Loss::Opaque)?;
        let derivatives = if self.wanted == Wanted::Derivatives {
            self.bent(crossing.bending).ok_or(Loss::Opaque)?
        } else {
            Default::default()
        };
        let facing = -front
            .ray
            .direction
            .dot(front.point.geometric_normal)
            .signum();
        let curvature = self.wanted.curvature(scene, &front.hit, &front.point);
        Ok(Exit {
            ray: front.point.spawn(crossing.direction),
            throughput: crossing.throughput,
            by_fresnel: crossing.by_fresnel,
            lens: Lens {
                vergence: self.vergence(),
                front: facing * curvature,
                back: 0.0,
                eta: relative_index(crossing.bending),
                thickness: 0.0,
            },
            derivatives,
            may_be_inside: false,
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
    /// where `d_V` is the object's thickness along the light's ray, to a back face, and `d_N` the one along
    /// the inverted normal, which a device has precomputed for each vertex (here a ray that is counted). The
    /// normal there is read from the picture of back faces, at the pixel that P₂ is seen in.
    ///
    /// What does not bend light (a thin pane, matched media) is left along the same ray, where `d_V` ends.
    ///
    /// # Errors
    ///
    /// Where the front lets nothing through, where no back face is behind the front, and what the variants
    /// of `no-back-face` and `total-reflection` drop.
    pub fn image_space(
        &self,
        backs: &Backs,
        settings: &Settings,
        counters: &mut TraversalCounters,
    ) -> Result<Exit, Loss> {
        let (scene, view, front, wanted) = (self.scene, self.view, self.front, self.wanted);
        let shape = front.hit.shape;
        let first = self.cross(Way::Transmitted).ok_or(Loss::Opaque)?;
        let eta = relative_index(first.bending);
        let inside = first.direction;
        let behind = backs.at(view, self.at, shape).ok_or(Loss::NoBackFace)?;
        let along_view = behind.distance - self.distance();
        let thickness = match (first.bending, settings.thickness) {
            (Bending::Refraction { normal, .. }, Thickness::Interpolated) => {
                let inward = front.point.spawn(-normal);
                let along_normal = scene
                    .world()
                    .closest_hit(&inward, f64::INFINITY, counters)
                    .map_or(along_view, |hit| hit.distance);
                let arriving = front.ray.direction;
                interpolated(arriving, inside, normal, eta, [along_view, along_normal])
            }
            (Bending::Straight | Bending::Reflection { .. }, _) | (_, Thickness::View) => {
                along_view
            }
        };
        let exit = front.point.position + inside * thickness;
        let seen = view.project(exit);
        let back = seen.and_then(|seen| backs.at(view, seen.at, shape));
        let (facing, back_curvature) = match (back, settings.no_back_face) {
            (Some(back), _) => (-back.normal, back.curvature),
            (None, NoBackFace::Side) => (-side_normal(view, inside)?, 0.0),
            (None, NoBackFace::Drop) => return Err(Loss::NoBackFace),
        };
        // Not always positive: the normal was read elsewhere.
        let cos = -inside.dot(facing);
        let direction = match (refracted(inside, facing, eta), settings.total_reflection) {
            (Some(direction), _) => direction,
            // Without its part along the normal, as the cosine of refraction is 0.
            (None, TotalReflection::Clamp) => inside + facing * cos,
            (None, TotalReflection::Drop) => return Err(Loss::TotalReflection),
        };
        let derivatives = if wanted == Wanted::Derivatives {
            let beam = self
                .bent(first.bending)
                .ok_or(Loss::Opaque)?
                .map(|derivative| derivative.transferred(inside, thickness, facing));
            // Of the back only its mean curvature is known; its normal, turned round, bends the other way.
            let bending = match first.bending {
                Bending::Refraction { .. } => Bending::Refraction {
                    normal: facing,
                    eta: 1.0 / eta,
                },
                straight => straight,
            };
            // A beam whose direction is clamped has no derivative there: it keeps that from inside.
            bent(beam, inside, bending, |along| along * -back_curvature).unwrap_or(beam)
        } else {
            Default::default()
        };
        Ok(Exit {
            ray: Ray::new(exit, direction.normalize()),
            throughput: first.throughput * leaving(scene, shape, cos.abs(), self.fresnel),
            by_fresnel: first.by_fresnel * leaving(scene, shape, cos.abs(), Fresnel::Exact),
            lens: Lens {
                vergence: self.vergence(),
                front: wanted.curvature(scene, &front.hit, &front.point),
                back: back_curvature,
                eta,
                thickness,
            },
            derivatives,
            may_be_inside: true,
            topology: surface(scene, &front.hit),
        })
    }
}

/// `n_transmitted / n_incident`; 1 of what does not refract.
fn relative_index(bending: Bending) -> f64 {
    match bending {
        Bending::Refraction { eta, .. } => eta,
        Bending::Straight | Bending::Reflection { .. } => 1.0,
    }
}

/// Light from inside of an object of relative index `eta`, refracted where the normal is `facing` it: η I +
/// (η c − √(1 − η²(1 − c²))) N with c = −I·N, as in the authors' shaders. `None` beyond the critical angle.
fn refracted(inside: DVec3, facing: DVec3, eta: f64) -> Option<DVec3> {
    if eta == 1.0 {
        return Some(inside);
    }
    let cos = -inside.dot(facing);
    let squared = 1.0 - eta * eta * (1.0 - cos * cos);
    (squared >= 0.0).then(|| inside * eta + facing * (eta * cos - squared.sqrt()))
}

/// The outward normal of a side that is not in the picture of back faces: across the axis of the view, in the
/// plane of the ray.
fn side_normal(view: &LightView, inside: DVec3) -> Result<DVec3, Loss> {
    let across = inside - view.axis() * inside.dot(view.axis());
    across.try_normalize().ok_or(Loss::NoBackFace)
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
    let incident = math::acos((-arriving.dot(normal)).clamp(0.0, 1.0));
    let transmitted = math::acos((-refracted.dot(normal)).clamp(0.0, 1.0));
    // The limit of the quotient towards normal incidence is that of the sines.
    let ratio = if incident > 1e-6 {
        transmitted / incident
    } else {
        1.0 / eta
    };
    (ratio * along_view + (1.0 - ratio) * along_normal).max(0.0)
}
