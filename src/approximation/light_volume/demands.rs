//! Demands of a light volume on a scene. Errors name what the scene has too much, or not.

use super::settings::Settings;
use super::variants::{Accumulate, Cosine, ShadowCull};
use super::water::mean_normal;
use crate::approximation::sources::sources;
use crate::geometry::Shape;
use crate::run::Refusal;
use crate::scene::{Material, Object, Scene};
use crate::transport::first_surface::Source;

/// The plural of the technique, in errors.
const VOLUMES: &str = "light volumes";

/// The shape that is the water's surface.
///
/// # Errors
///
/// If nothing refracts, if several shapes do and no setting chooses one, and if the one is closed.
pub fn water(scene: &Scene, settings: &Settings) -> Result<u32, Refusal> {
    let wanted = settings.surface_shape.as_str();
    let refracts =
        |object: &Object| matches!(scene.material(object.material), Material::Dielectric { .. });
    let refracting: Vec<(u32, &Object)> = (0_u32..)
        .zip(scene.objects())
        .filter(|(_, object)| refracts(object))
        .collect();
    let is_chosen = |object: &Object| !wanted.is_empty() && object.id == wanted;
    let chosen = refracting.iter().find(|(_, object)| is_chosen(object));
    let shape = match (refracting.as_slice(), chosen) {
        (_, Some((shape, _))) => *shape,
        ([], None) if wanted.is_empty() => {
            return Err(Refusal::new(
                "no shape refracts: light volumes need a water surface of plugin dielectric",
            ));
        }
        ([(shape, _)], None) if wanted.is_empty() => *shape,
        ([(_, one), (_, other), ..], None) if wanted.is_empty() => {
            return Err(Refusal::new(format!(
                "shapes \"{}\" and \"{}\" refract, and a light volume has one water surface: surface-shape=ID \
                 chooses it",
                one.id, other.id
            )));
        }
        (all, None) => {
            let ids: Vec<&str> = all.iter().map(|(_, object)| object.id.as_str()).collect();
            return Err(Refusal::new(format!(
                "surface-shape is \"{wanted}\"; allowed are shapes of plugin dielectric: {}",
                ids.join(", ")
            )));
        }
    };
    if is_closed(&scene.world().shapes()[shape as usize]) {
        return Err(Refusal::new(format!(
            "shape \"{}\" is closed: light crosses it twice, and light volumes follow it through one open water surface",
            scene.objects()[shape as usize].id
        )));
    }
    Ok(shape)
}

/// True if a surface encloses a volume.
fn is_closed(shape: &Shape) -> bool {
    match shape {
        Shape::Sphere(_) => true,
        Shape::Mesh(mesh) => mesh.border().is_empty(),
        Shape::Rectangle(_) | Shape::Disk(_) | Shape::Cylinder(_) => false,
    }
}

/// The lights of a scene, which must all be points or directions above the water's plane.
///
/// # Errors
///
/// If one has a size, none shines, or one is under water.
pub fn lights(scene: &Scene, water: u32) -> Result<Vec<Source>, Refusal> {
    let sources = sources(scene, VOLUMES)?;
    let shape = &scene.world().shapes()[water as usize];
    let (normal, middle) = (mean_normal(shape), shape.bounds().center());
    if sources
        .iter()
        .any(|source| source.towards(middle).dot(normal) <= 0.0)
    {
        return Err(Refusal::new(format!(
            "a light is under water: light volumes follow light that comes from the outer side of shape \"{}\"",
            scene.objects()[water as usize].id
        )));
    }
    Ok(sources)
}

/// Refuses settings that exclude one another.
///
/// # Errors
///
/// Names both.
pub fn check(settings: &Settings) -> Result<(), Refusal> {
    if settings.cosine == Cosine::Vector && settings.accumulate == Accumulate::U8 {
        return Err(Refusal::new(
            "cosine=vector and accumulate=u8: vectors have signs, which 8 bits do not; allowed are auto, f16, f32 and \
             exact",
        ));
    }
    if settings.shadow_cull == ShadowCull::Hierarchy && settings.shadow_map == 0 {
        return Err(Refusal::new(
            "shadow-cull=hierarchy and shadow-map=0: nodes are compared with a shadow map; allowed are shadow-cull=dark \
             and exact, or shadow-map from 1 on",
        ));
    }
    if settings.grid == 1 {
        return Err(Refusal::new("grid is \"1\"; allowed are 0 and 2..=4097"));
    }
    let side = u64::from(settings.buckets) << settings.splits;
    if side * side > MOST_LEAVES {
        return Err(Refusal::new(format!(
            "buckets={} and splits={} make {} leaves; allowed are up to {MOST_LEAVES}: (buckets * 2^splits)^2",
            settings.buckets,
            settings.splits,
            side * side
        )));
    }
    Ok(())
}

/// The most leaves of a hierarchy.
const MOST_LEAVES: u64 = 1 << 24;
