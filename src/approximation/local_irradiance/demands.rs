//! Demands of local precomputed irradiance on a scene and on settings.

use super::directions::Samples;
use super::lamp::SeenLight;
use super::object::SpecularObject;
use super::settings::Settings;
use super::variants::{
    Directions, Interpolation, Light, Normal, SampleAt, Space, Storage, Surroundings, Symmetry,
};
use crate::approximation::SensorFilm;
use crate::approximation::sources::sources;
use crate::run::Refusal;
use crate::scene::Scene;
use crate::setting::Words as _;
use crate::transport::chain_limits;
use crate::transport::first_surface::Source;

/// The technique, in errors.
const TECHNIQUE: &str = "tables of local precomputed irradiance";

/// Refuses settings that cannot go together.
///
/// # Errors
///
/// Names both, and what is allowed.
pub fn check(settings: &Settings) -> Result<(), Refusal> {
    let refused = |reason: String| Err(Refusal::new(reason));
    let coefficients = settings.order * settings.order;
    let is_harmonic = settings.directions == Directions::Harmonics;
    let of_shells = settings.space == Space::ShellHarmonics;
    let is_positive = matches!(settings.storage, Storage::U8 | Storage::Rgb9e5);
    if settings.normal == Normal::Vector && settings.space != Space::Exact {
        if is_harmonic || !matches!(settings.space, Space::Grid | Space::Shells) {
            return refused(format!(
                "normal=vector, space={} and directions={}: vectors are in the cells of a sample; allowed with \
                 normal=vector are space=grid, shells and exact without directions=harmonics",
                settings.space.word(),
                settings.directions.word()
            ));
        }
        if is_positive {
            return refused(format!(
                "normal=vector and storage={}: vectors have negative parts, too; allowed are storage=f16, f32 and exact",
                settings.storage.word()
            ));
        }
    }
    if is_positive && (is_harmonic && settings.space != Space::Exact || of_shells) {
        return refused(format!(
            "storage={} and spherical harmonics: coefficients are negative, too; allowed are storage=f16, f32 and \
             exact",
            settings.storage.word()
        ));
    }
    if is_harmonic {
        if settings.symmetry != Symmetry::None {
            return refused(
                "directions=harmonics and a symmetry: harmonics are fitted to samples all round; allowed is \
                 symmetry=none"
                    .to_owned(),
            );
        }
        let samples = Samples::count(settings);
        if samples < 2 * coefficients {
            return refused(format!(
                "order={} has {coefficients} coefficients, and frequency={} only {samples} light directions: \
                 allowed are orders with at most half as many coefficients as directions",
                settings.order, settings.frequency
            ));
        }
    }
    if of_shells && (20u32 << (2 * settings.shell_level)) < 2 * coefficients {
        return refused(format!(
            "order={} has {coefficients} coefficients, and shell-level={} only {} triangles: allowed are orders \
             with at most half as many coefficients as triangles",
            settings.order,
            settings.shell_level,
            20u32 << (2 * settings.shell_level)
        ));
    }
    let blends = matches!(
        settings.directions,
        Directions::Aligned | Directions::Barycentric
    );
    if settings.sample_at == SampleAt::Centres && blends && settings.symmetry == Symmetry::None {
        return refused(
            "sample-at=centres and directions that are blended: a light is between vertices; allowed with \
             sample-at=centres are directions=nearest, harmonics and exact"
                .to_owned(),
        );
    }
    if of_shells && settings.interpolation == Interpolation::Nearest {
        return refused(
            "space=shell-harmonics and interpolation=nearest: harmonics have no cells; allowed is \
             interpolation=linear"
                .to_owned(),
        );
    }
    Ok(())
}

/// The objects and lights of a scene, checked.
///
/// # Errors
///
/// If nothing mirrors or refracts, a light has a size or is within an object, an object does not have the
/// symmetry that settings claim, or the sensor is on an object.
pub fn of_scene(
    scene: &Scene,
    film: &SensorFilm,
    settings: &Settings,
) -> Result<(Vec<SpecularObject>, Vec<Source>), Refusal> {
    check(settings)?;
    chain_limits::check_starts(scene).map_err(|error| Refusal::new(error.to_string()))?;
    let sources = sources(scene, TECHNIQUE)?;
    let objects = SpecularObject::all(scene)?;
    for object in &objects {
        let name = || scene.objects()[object.shapes[0] as usize].id.clone();
        if let Some(shape) = film.shape().filter(|shape| object.shapes.contains(shape)) {
            return Err(Refusal::new(format!(
                "the sensor is on shape \"{}\", which mirrors or refracts: tables hold light for surfaces that do \
                 neither",
                scene.objects()[shape as usize].id
            )));
        }
        for source in &sources {
            let light = SeenLight::new(source, object.center, settings);
            let distance = light.map_or(0.0, |light| light.distance);
            if distance <= object.radius {
                return Err(Refusal::new(format!(
                    "a light is {distance:.3} m from the centre of shape \"{}\", whose radius is {:.3} m: allowed \
                     are lights outside of it",
                    name(),
                    object.radius
                )));
            }
        }
        check_symmetry(settings, object, &name())?;
    }
    Ok((objects, sources))
}

/// Refuses a symmetry that an object has not: rays that the symmetry takes to others must go as far.
fn check_symmetry(settings: &Settings, object: &SpecularObject, name: &str) -> Result<(), Refusal> {
    use glam::{DMat3, DVec3};

    use super::variants::Axis;
    use crate::geometry::{Geodesic, Ray, TraversalCounters};
    use crate::numeric::rotation;
    /// Share of the radius by which two rays may differ: bumps that do not show in a caustic's outline.
    const ALLOWED: f64 = 0.02;
    let turns: Vec<DMat3> = match settings.symmetry {
        Symmetry::None => return Ok(()),
        Symmetry::Sphere => (1..6)
            .map(|turn| {
                let axis = DVec3::new(1.0, f64::from(turn), 0.5).normalize();
                rotation::about(axis, 0.9 * f64::from(turn))
            })
            .collect(),
        Symmetry::Axis => {
            let axis = match settings.axis {
                Axis::X => DVec3::X,
                Axis::Y => DVec3::Y,
                Axis::Z => DVec3::Z,
            };
            (1..6)
                .map(|turn| rotation::about(axis, 1.1 * f64::from(turn)))
                .collect()
        }
    };
    let mut counters = TraversalCounters::default();
    let mut meets = |turn: &DMat3, towards: DVec3, beside: DVec3| {
        let start = towards * (2.0 * object.radius) + beside;
        let ray = Ray::new(object.own_center + *turn * start, *turn * -towards);
        let hit = object
            .alone
            .world()
            .closest_hit(&ray, f64::INFINITY, &mut counters);
        hit.map(|hit| hit.distance)
    };
    let (mut rays, mut differ) = (0, 0);
    for towards in Geodesic::new(3).vertices() {
        let (x, y) = towards.any_orthonormal_pair();
        for beside in [
            DVec3::ZERO,
            x * (0.3 * object.radius),
            y * (0.6 * object.radius),
        ] {
            let own = meets(&DMat3::IDENTITY, *towards, beside);
            for turn in &turns {
                rays += 1;
                let other = meets(turn, *towards, beside);
                let same = match (own, other) {
                    (Some(a), Some(b)) => (a - b).abs() <= ALLOWED * object.radius,
                    (None, None) => true,
                    _ => false,
                };
                differ += u32::from(!same);
            }
        }
    }
    // At an outline one ray of two may pass.
    if f64::from(differ) > 0.02 * f64::from(rays) {
        return Err(Refusal::new(format!(
            "symmetry={} is not that of shape \"{name}\": {differ} of {rays} rays go on differently after a turn; \
             allowed are symmetry=none, and axis or sphere for objects that have it",
            if settings.symmetry == Symmetry::Sphere {
                "sphere"
            } else {
                "axis"
            },
        )));
    }
    Ok(())
}

/// Warnings on lights and samples.
pub fn warnings(
    scene: &Scene,
    objects: &[SpecularObject],
    sources: &[Source],
    settings: &Settings,
) -> Vec<String> {
    let mut warnings = chain_limits::left_out(scene);
    for object in objects {
        for source in sources {
            let Some(light) = SeenLight::new(source, object.center, settings) else {
                continue;
            };
            if settings.light == Light::Directional
                && light.distance < settings.reach * object.radius
            {
                warnings.push(format!(
                    "a light is {:.1} radii from shape \"{}\", within the region of {} radii: light=directional \
                     takes it to be far away",
                    light.distance / object.radius,
                    scene.objects()[object.shapes[0] as usize].id,
                    settings.reach
                ));
            }
        }
    }
    warnings
}

/// True if tables outlive a frame: nothing in them is of one scene, sensor or light alone.
pub fn are_kept(settings: &Settings) -> bool {
    use super::variants::{Noise, Region};
    settings.light == Light::Directional
        && settings.scene == Surroundings::Alone
        && settings.directions != Directions::Exact
        && settings.noise == Noise::Photons
        && settings.space != Space::Exact
        && settings.region != Region::Exact
        && settings.normal != Normal::Exact
}

/// Refuses settings that cannot go together, or whose tables do not outlive a frame.
///
/// # Errors
///
/// Names what is allowed.
pub fn check_kept(settings: &Settings) -> Result<(), Refusal> {
    check(settings)?;
    if are_kept(settings) {
        return Ok(());
    }
    Err(Refusal::new(
        "with these settings tables are those of one frame, of which nothing is kept: light, scene, directions, \
         noise, space, region and normal must not be exact",
    ))
}

/// The samples that settings ask for.
///
/// # Errors
///
/// If they do not determine harmonics.
pub fn samples(settings: &Settings) -> Result<Samples, Refusal> {
    Samples::new(settings).ok_or_else(|| {
        Refusal::new(format!(
            "order={}: the light directions do not determine its harmonics; allowed are lower orders",
            settings.order
        ))
    })
}
