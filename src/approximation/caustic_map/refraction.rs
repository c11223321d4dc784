//! Stage `refraction`: how light leaves a specular object, exactly or by pictures of it; with stage `fresnel`, how
//! much of it.

use glam::DVec3;

use super::buffers::{Back, Front, mean_curvature};
use super::lens::Lens;
use super::settings::{Fresnel, Splat};
use super::view::LightView;
use crate::geometry::{Hit, Ray, SurfacePoint, TraversalCounters};
use crate::optics::{RayDerivative, dielectric_reflectance, refract};
use crate::radiometry::Rgb;
use crate::scene::{Material, Scene};
use crate::transport::prescribed::next_hit;
use crate::transport::scatter::{Bending, Meeting, ShadingNormals, Way};

/// A photon that has left the specular object.
#[derive(Clone, Copy, Debug)]
pub struct Exit {
    /// From where it left.
    pub ray: Ray,
    /// The share of its flux that is still there.
    pub throughput: Rgb,
    /// The object, as lens equations see it.
    pub lens: Lens,
    /// How the ray changes with the two image coordinates of the light view, by pixel; zero where that is not wanted.
    pub derivatives: [RayDerivative; 2],
    /// Whether it left exactly there: an approximate place may be inside the object still.
    pub is_exact: bool,
    /// Which smooth surfaces it met: neighbours with the same are one beam.
    pub family: u64,
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
}

/// A photon's way through one interface.
struct Crossing {
    direction: DVec3,
    throughput: Rgb,
    bending: Bending,
}

/// Light that meets a surface, on one of the ways on; `None` where none goes there.
fn cross(
    scene: &Scene,
    shape: u32,
    point: &SurfacePoint,
    direction: DVec3,
    way: Way,
    fresnel: Fresnel,
) -> Option<Crossing> {
    let material = scene.material_of(shape);
    let meeting = Meeting::new(scene, material, point, direction, ShadingNormals::Flux);
    let share = meeting.share_of(way);
    if share <= 0.0 {
        return None;
    }
    let branch = meeting.branch::<3>(way)?;
    let factor = match (fresnel, relative_index(material, point, direction)) {
        (Fresnel::Exact, _) | (_, None) => share,
        (Fresnel::None, Some(_)) => 1.0,
        (Fresnel::Schlick, Some(eta)) => {
            let reflected = schlick(direction.dot(point.shading_normal).abs(), eta);
            if way == Way::Reflected {
                reflected
            } else {
                1.0 - reflected
            }
        }
    };
    Some(Crossing {
        direction: branch.direction,
        throughput: branch.tint.rgb() * factor,
        bending: meeting.bending(way),
    })
}

/// `n_transmitted / n_incident` of a plain dielectric.
fn relative_index(material: &Material, point: &SurfacePoint, direction: DVec3) -> Option<f64> {
    let Material::Dielectric {
        interior_ior,
        exterior_ior,
        ..
    } = material
    else {
        return None;
    };
    let eta = interior_ior / exterior_ior;
    let front = direction.dot(point.geometric_normal) < 0.0;
    Some(if front { eta } else { 1.0 / eta })
}

/// Reflectance by Schlick's approximation (1994), F₀ + (1 − F₀)(1 − cos)⁵, with the angle on the less dense side.
///
/// - `cos_incident`: on the side light arrives from.
/// - `eta`: `n_transmitted / n_incident`. Below 1, beyond the critical angle, it is 1.
pub fn schlick(cos_incident: f64, eta: f64) -> f64 {
    let normal = dielectric_reflectance(1.0, eta);
    let sin_squared = (1.0 - cos_incident * cos_incident) / (eta * eta);
    let cos = if eta < 1.0 {
        (1.0 - sin_squared).max(0.0).sqrt()
    } else {
        cos_incident
    };
    normal + (1.0 - normal) * (1.0 - cos).powi(5)
}

/// How a beam that arrives at a surface leaves it, its normal turning by `turn`.
fn bent(
    arriving: [RayDerivative; 2],
    direction: DVec3,
    bending: Bending,
    turn: impl Fn(DVec3) -> DVec3,
) -> Option<[RayDerivative; 2]> {
    let [a, b] = arriving.map(|derivative| match bending {
        Bending::Straight => Some(derivative),
        Bending::Reflection { normal } => {
            Some(derivative.reflected(direction, normal, turn(derivative.position)))
        }
        Bending::Refraction { normal, eta } => {
            derivative.refracted(direction, normal, turn(derivative.position), eta)
        }
    });
    Some([a?, b?])
}

/// How the normal of a bending turns at a hit: the surface's own, or its opposite.
fn turning<'a>(
    scene: &'a Scene,
    hit: &'a Hit,
    point: &SurfacePoint,
    bending: Bending,
) -> impl Fn(DVec3) -> DVec3 + use<'a> {
    let sign = match bending {
        Bending::Straight => 0.0,
        Bending::Reflection { normal } | Bending::Refraction { normal, .. } => {
            normal.dot(point.shading_normal).signum()
        }
    };
    move |along| scene.world().normal_derivative(hit, along) * sign
}

/// The beam of a front pixel where it meets the object.
fn at_front(view: &LightView, at: glam::DVec2, front: &Front) -> [RayDerivative; 2] {
    let distance = front.point.position.distance(view.ray(at).origin);
    view.ray_derivatives(at).map(|derivative| {
        derivative.transferred(front.ray.direction, distance, front.point.geometric_normal)
    })
}

/// `1/d_front` [1/m].
fn vergence(view: &LightView, at: glam::DVec2, front: &Front) -> f64 {
    if view.is_parallel() {
        0.0
    } else {
        1.0 / front.point.position.distance(view.ray(at).origin)
    }
}

/// Which smooth surface a hit is on: the shape, and of flat faces the face.
fn surface(scene: &Scene, hit: &Hit) -> u64 {
    let element = scene.world().element(hit);
    u64::from(element.shape) << 32 | element.face.map_or(0, |face| u64::from(face) + 1)
}

/// Refraction by the ray that is traced through the object: `LTT`.
pub fn through(
    scene: &Scene,
    view: &LightView,
    at: glam::DVec2,
    front: &Front,
    fresnel: Fresnel,
    wanted: Wanted,
    counters: &mut TraversalCounters,
) -> Option<Exit> {
    let arriving = front.ray.direction;
    let way = Way::Transmitted;
    let first = cross(scene, front.hit.shape, &front.point, arriving, way, fresnel)?;
    let (inside, hit) = next_hit(scene, front.point.spawn(first.direction), counters)?;
    let point = scene.world().bounce_point(&inside, &hit);
    let second = cross(scene, hit.shape, &point, inside.direction, way, fresnel)?;
    let thickness = point.position.distance(front.point.position);
    let derivatives = if wanted == Wanted::Derivatives {
        let turn = turning(scene, &front.hit, &front.point, first.bending);
        let beam = bent(at_front(view, at, front), arriving, first.bending, turn)?;
        let beam = beam.map(|derivative| {
            derivative.transferred(inside.direction, thickness, point.geometric_normal)
        });
        let turn = turning(scene, &hit, &point, second.bending);
        bent(beam, inside.direction, second.bending, turn)?
    } else {
        Default::default()
    };
    let curvature = |hit: &Hit, point: &SurfacePoint| match wanted {
        Wanted::Curvatures => mean_curvature(scene, hit, point),
        _ => 0.0,
    };
    let eta = match first.bending {
        Bending::Refraction { eta, .. } => eta,
        _ => 1.0,
    };
    Some(Exit {
        ray: point.spawn(second.direction),
        throughput: first.throughput * second.throughput,
        lens: Lens {
            vergence: vergence(view, at, front),
            front: curvature(&front.hit, &front.point),
            back: curvature(&hit, &point),
            eta,
            thickness,
        },
        derivatives,
        is_exact: true,
        family: surface(scene, &front.hit).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ surface(scene, &hit),
    })
}

/// One mirror reflection: `LR`.
pub fn reflected(
    scene: &Scene,
    view: &LightView,
    at: glam::DVec2,
    front: &Front,
    fresnel: Fresnel,
) -> Option<Exit> {
    let arriving = front.ray.direction;
    let crossing = cross(
        scene,
        front.hit.shape,
        &front.point,
        arriving,
        Way::Reflected,
        fresnel,
    )?;
    let turn = turning(scene, &front.hit, &front.point, crossing.bending);
    let derivatives = bent(at_front(view, at, front), arriving, crossing.bending, turn)?;
    let facing = -arriving.dot(front.point.geometric_normal).signum();
    Some(Exit {
        ray: front.point.spawn(crossing.direction),
        throughput: crossing.throughput,
        lens: Lens {
            vergence: vergence(view, at, front),
            front: facing * mean_curvature(scene, &front.hit, &front.point),
            back: 0.0,
            eta: 1.0,
            thickness: 0.0,
        },
        derivatives,
        is_exact: true,
        family: surface(scene, &front.hit) << 1 | u64::from(facing > 0.0),
    })
}

/// Wyman's two-interface refraction (*An approximate image-space approach for interactive refraction*, SIGGRAPH 2005):
/// the exit point is P₂ = P₁ + d̃ T₁ with
///
/// ```text
/// d̃ = (θt/θi) d_V + (1 − θt/θi) d_N
/// ```
///
/// where `d_V` is the object's thickness along the light's ray, to its farthest back face, and `d_N` the one along the inverted
/// normal, which a device has precomputed for each vertex (here a ray that is counted). The normal there
/// is read from the picture of back faces, at the pixel that P₂ is seen in. `None` where that pixel has none, and
/// where that interface would reflect all: the technique knows no total internal reflection.
pub fn image_space(
    scene: &Scene,
    view: &LightView,
    at: glam::DVec2,
    front: &Front,
    backs: &[Option<Back>],
    fresnel: Fresnel,
    counters: &mut TraversalCounters,
) -> Option<Exit> {
    let arriving = front.ray.direction;
    let way = Way::Transmitted;
    let first = cross(scene, front.hit.shape, &front.point, arriving, way, fresnel)?;
    let Bending::Refraction { normal, eta } = first.bending else {
        return None;
    };
    let fetch = |at: glam::DVec2| {
        let side = view.side();
        view.holds(at)
            .then(|| backs[at.y as usize * side + at.x as usize])
            .flatten()
            .filter(|back| back.shape == front.hit.shape)
    };
    let start = view.ray(at).origin;
    let along_view = fetch(at)?.distance - front.point.position.distance(start);
    let inward = front.point.spawn(-normal);
    let along_normal = scene
        .world()
        .closest_hit(&inward, f64::INFINITY, counters)
        .map_or(along_view, |hit| hit.distance);
    let incident = (-arriving.dot(normal)).clamp(0.0, 1.0).acos();
    let transmitted = (-first.direction.dot(normal)).clamp(0.0, 1.0).acos();
    // The limit of the quotient towards normal incidence is that of the sines.
    let ratio = if incident > 1e-6 {
        transmitted / incident
    } else {
        1.0 / eta
    };
    let thickness = (ratio * along_view + (1.0 - ratio) * along_normal).max(0.0);
    let exit = front.point.position + first.direction * thickness;
    let back = fetch(view.project(exit)?.at)?;
    let facing = -back.normal;
    let inside = first.direction;
    let direction = refract(inside, facing, 1.0 / eta)?;
    let cos = -inside.dot(facing);
    if cos <= 0.0 {
        return None;
    }
    let passed = match fresnel {
        Fresnel::None => 1.0,
        Fresnel::Schlick => 1.0 - schlick(cos, 1.0 / eta),
        Fresnel::Exact => 1.0 - dielectric_reflectance(cos, 1.0 / eta),
    };
    let turn = turning(scene, &front.hit, &front.point, first.bending);
    let beam = bent(at_front(view, at, front), arriving, first.bending, turn)?
        .map(|derivative| derivative.transferred(inside, thickness, facing));
    // Of the back only its mean curvature is known; its normal, turned round, bends the other way.
    let bending = Bending::Refraction {
        normal: facing,
        eta: 1.0 / eta,
    };
    let derivatives = bent(beam, inside, bending, |along| along * -back.curvature)?;
    Some(Exit {
        ray: Ray::new(exit, direction.normalize()),
        throughput: first.throughput * tint(scene, front.hit.shape) * passed,
        lens: Lens {
            vergence: vergence(view, at, front),
            front: mean_curvature(scene, &front.hit, &front.point),
            back: back.curvature,
            eta,
            thickness,
        },
        derivatives,
        is_exact: false,
        family: surface(scene, &front.hit),
    })
}

/// What an interface takes of transmitted light beside Fresnel's share.
fn tint(scene: &Scene, shape: u32) -> Rgb {
    match scene.material_of(shape) {
        Material::Dielectric {
            specular_transmittance,
            ..
        } => specular_transmittance.even(),
        _ => Rgb::WHITE,
    }
}
