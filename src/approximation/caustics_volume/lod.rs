//! Level of detail (section 3.5): fewer slabs for what is far from the camera, none for what is out of view.

use super::demands::Volume;
use super::settings::Settings;
use crate::approximation::SensorFilm;

/// The slabs of a volume: max(1, ⌈S min(1, d₀/d)⌉) at the distance d of the camera from its middle.
pub fn slabs(settings: &Settings, volume: &Volume, film: &SensorFilm) -> u32 {
    let SensorFilm::Camera(camera) = film else {
        return settings.slabs;
    };
    if settings.lod_distance == 0.0 {
        return settings.slabs;
    }
    let distance = camera.eye().distance(volume.cuboid.middle());
    let share = (settings.lod_distance / distance).min(1.0);
    ((f64::from(settings.slabs) * share).ceil() as u32).max(1)
}

/// True if a part of a volume may be in the camera's view; true for a meter.
pub fn is_seen(volume: &Volume, film: &SensorFilm) -> bool {
    let SensorFilm::Camera(camera) = film else {
        return true;
    };
    let corners = volume.cuboid.corners();
    !camera.frustum().iter().any(|[point, outward]| {
        corners
            .iter()
            .all(|corner| (*corner - *point).dot(*outward) > 0.0)
    })
}
