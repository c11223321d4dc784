//! The plan of all methods: one for each class of a scene's light paths.

use crate::reference::beams;
use crate::reference::path::PathSettings;
use crate::scene::{Emitter, Material, MaterialId, Object, Scene, Sensor};
use crate::transport::bsdf::check_colors;
use crate::transport::camera::{Camera, CameraError};
use crate::transport::chain_limits::{first_rough, left_out_of_image, unseen_but_rough};
use crate::transport::domain::LightSpace;
use crate::transport::path_class::{PathClass, PathClasses};

/// A method that measures a class of light paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Finder {
    /// Paths from the camera.
    Path,
    /// Beams, connected to the camera.
    Beams,
    /// Photons, connected to the camera.
    Photons,
    /// Photon maps.
    PhotonMap,
}

impl Finder {
    /// The method's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Path => "path",
            Self::Beams => "beams",
            Self::Photons => "photons",
            Self::PhotonMap => "photon-map",
        }
    }
}

/// The method for each class, with notices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// The method of each class, in the order of [`PathClass::ALL`].
    finders: [Finder; PathClass::ALL.len()],
    /// Notices of light that is left out, or found slowly, and why.
    pub notices: Vec<String>,
}

impl Plan {
    /// The plan for a scene and a camera.
    ///
    /// If nothing mirrors or refracts there are no caustics, and paths measure all. They also do so if light
    /// cannot be followed from its emitters.
    ///
    /// # Errors
    ///
    /// If the sensor is no camera, if its numbers overflow, or if a colour is not known.
    pub fn new(scene: &Scene, sensor: &Sensor, path: &PathSettings) -> Result<Self, CameraError> {
        Camera::of_sensor(sensor)?;
        check_colors(scene)?;
        let mut plan = Self {
            finders: [Finder::Path; PathClass::ALL.len()],
            notices: Vec::new(),
        };
        let all = scene.materials();
        let is_interface = |object: &Object| {
            scene.material(object.material).is_specular(all)
                || is_unfollowed(scene, object.material)
        };
        let is_coat = |object: &&Object| scene.material(object.material).has_smooth_coat(all);
        let has_interfaces = scene.objects().iter().any(is_interface);
        let coat = scene.objects().iter().find(is_coat);
        let has_delta_events = has_interfaces || coat.is_some();
        let has_caustics = has_delta_events || first_rough(scene).is_some();
        // Light that shines on a surface and is scattered to the camera has two legs: a mirror before makes
        // three.
        let is_too_short = path.max_depth.is_some_and(|legs| legs < 3);
        if is_too_short || !has_caustics {
            return Ok(plan);
        }
        let mut reason = Self::why_paths(scene, path);
        let unfollowed = unfollowed(scene);
        let has_delta = |emitter: &Emitter| emitter.is_delta() && !emitter.strength().is_black();
        let has_delta = scene.emitters().iter().any(has_delta);
        let has_more = has_interfaces || has_delta || first_rough(scene).is_some();
        if let Some(coat) = coat.filter(|_| !has_more) {
            // Lamps that paths meet are large enough for a few percent of their light.
            reason.get_or_insert_with(|| {
                let id = &coat.id;
                format!("nothing mirrors without blur but coats (of shape \"{id}\")")
            });
        }
        if let Some(reason) = reason.or_else(|| unfollowed.clone().filter(|_| !has_delta)) {
            let lost = if has_delta {
                ", and those of lights that are a point or a direction never"
            } else {
                ""
            };
            plan.notices.push(format!(
                "{reason}: caustics are left to paths from the camera, which find them by chance{lost}"
            ));
            return Ok(plan);
        }
        if let Some(unfollowed) = unfollowed {
            plan.notices
                .push(format!("{unfollowed}: caustics by way of it are left out"));
        }
        if has_delta_events {
            plan.finders[PathClass::SeenCaustic.index()] = Finder::PhotonMap;
        }
        let (finder, reason) = Self::of_caustic(scene, sensor, has_delta_events);
        plan.finders[PathClass::Caustic.index()] = finder;
        if let Some(reason) = reason {
            plan.notices.push(format!(
                "{}: by {} instead of beams, as {reason}",
                PathClass::Caustic,
                finder.name()
            ));
        }
        if has_delta && has_delta_events && path.max_depth.is_none_or(|legs| legs > 3) {
            plan.notices.push(format!(
                "{} (a caustic's light that matt surfaces scatter on) of lights that are a point or a direction \
                 is left out: paths from a camera never find it",
                PathClass::IndirectCaustic
            ));
        }
        if has_delta_events && path.max_depth.is_some() {
            plan.notices.push(format!(
                "max_depth bounds the mirrors and glass of {} on either side of the surface that scatters, not \
                 their sum",
                PathClass::SeenCaustic
            ));
        }
        Ok(plan)
    }

    /// The method for caustics that are seen directly; if the camera keeps a better one away, the reason.
    ///
    /// On rough interfaces light of smooth ones is seen. Without these nothing but rough interfaces matters
    /// little: light on them is for paths.
    fn of_caustic(
        scene: &Scene,
        sensor: &Sensor,
        has_delta_events: bool,
    ) -> (Finder, Option<String>) {
        let is_connectable = if has_delta_events {
            left_out_of_image(scene).is_empty()
        } else {
            unseen_but_rough(scene).is_empty()
        };
        if !is_connectable {
            // Maps are looked up on any surface that scatters.
            return (Finder::PhotonMap, None);
        }
        if let Err(error) = Camera::connectable(scene, sensor) {
            // Maps are looked up through any lens.
            return (Finder::PhotonMap, Some(error.to_string()));
        }
        if beams::supports(scene).is_err() || first_rough(scene).is_some() {
            return (Finder::Photons, None);
        }
        match Camera::new(scene, sensor) {
            Ok(_) => (Finder::Beams, None),
            Err(error) => (Finder::Photons, Some(error.to_string())),
        }
    }

    /// The reason to leave caustics to paths from the camera; `None` if there is none.
    fn why_paths(scene: &Scene, path: &PathSettings) -> Option<String> {
        if let Err(error) = LightSpace::check(scene) {
            return Some(error.to_string());
        }
        if path.hide_emitters && scene.emitters().iter().any(|it| it.shape().is_some()) {
            let reason = "hide_emitters lets the camera see through shapes that shine, which light \
                          that is connected to it does not pass";
            return Some(reason.to_owned());
        }
        None
    }

    /// The method that measures a class.
    pub fn finder(&self, class: PathClass) -> Finder {
        self.finders[class.index()]
    }

    /// The classes that a method measures.
    pub fn classes(&self, finder: Finder) -> PathClasses {
        PathClass::ALL
            .into_iter()
            .filter(|class| self.finder(*class) == finder)
            .fold(PathClasses::NONE, PathClasses::with)
    }
}

/// A shape that mirrors or refracts without blur in a way that chains from emitters do not follow, in words.
fn unfollowed(scene: &Scene) -> Option<String> {
    let object = scene
        .objects()
        .iter()
        .find(|object| is_unfollowed(scene, object.material))?;
    Some(format!(
        "shape \"{}\" ({}) mirrors in a way that light is not followed by",
        object.id,
        scene.material(object.material).plugin()
    ))
}

/// Smooth interfaces whose normals a texture turns, with smooth coats over a matt base, and such coats in a
/// blend.
fn is_unfollowed(scene: &Scene, id: MaterialId) -> bool {
    let (material, all) = (scene.material(id), scene.materials());
    let below = |test: &dyn Fn(&Material) -> bool| {
        let mut nested = material.nested();
        nested.any(|id| test(scene.material(id)) || is_unfollowed(scene, id))
    };
    match material {
        Material::Turned { .. } => below(&|it| it.is_specular(all) || it.has_smooth_coat(all)),
        Material::Blend { .. } => below(&|it| it.has_smooth_coat(all)),
        _ => below(&|_| false),
    }
}
