//! A floor's irradiance as a camera sees it: E ρ/π, averaged over a pixel.

use glam::DVec2;

use nephroid::internals::geometry::TraversalCounters;
use nephroid::internals::mitsuba;
use nephroid::internals::reference::beams;
use nephroid::internals::reference::beams::{BeamReport, BeamSettings};
use nephroid::internals::run::Budget;
use nephroid::internals::run::{Estimate, Progress};
use nephroid::internals::scene::{Crop, Scene, Sensor, SensorKind};
use nephroid::internals::transport::camera::Camera;

/// A scene with cameras of this size, and meters of `texels` x `texels`.
pub fn with_films(file: &std::path::Path, pixels: [usize; 2], texels: usize) -> Scene {
    let mut parts = mitsuba::load_parts(file, &[]).unwrap();
    for sensor in &mut parts.sensors {
        let [width, height] = match sensor.kind {
            SensorKind::IrradianceMeter { .. } => [texels as u32; 2],
            _ => pixels.map(|side| side as u32),
        };
        (sensor.film.width, sensor.film.height) = (width, height);
        sensor.film.crop = Crop {
            offset_x: 0,
            offset_y: 0,
            width,
            height,
        };
    }
    Scene::new(parts).unwrap()
}

/// The sensor with this id.
pub fn sensor<'a>(scene: &'a Scene, id: &str) -> &'a Sensor {
    scene.sensors().iter().find(|one| one.id == id).unwrap()
}

/// Beams to a likely error, with a layer for every signature.
pub fn by_beams(scene: &Scene, id: &str, relative_error: f64) -> (Estimate, BeamReport) {
    let budget = Budget {
        relative_error: Some(relative_error),
        ..Budget::default()
    };
    let settings = BeamSettings {
        max_layers: 64,
        ..BeamSettings::default()
    };
    let sensor = sensor(scene, id);
    beams::run(scene, sensor, settings, &budget, &Progress::default()).unwrap()
}

/// Light from specular chains: value and half the distance of its bounds, texel by texel.
pub struct Map {
    pub width: usize,
    pub value: Vec<f64>,
    pub bar: Vec<f64>,
}

impl Map {
    /// The map of all specular signatures of a method with bounds.
    pub fn of(estimate: &Estimate) -> Self {
        Self::of_layers(estimate, |name| name != "LD")
    }

    /// The map of some signatures.
    pub fn of_layers(estimate: &Estimate, wanted: impl Fn(&str) -> bool) -> Self {
        let texels = estimate.width * estimate.height;
        let mut map = Self {
            width: estimate.width,
            value: vec![0.0; texels],
            bar: vec![0.0; texels],
        };
        for layer in &estimate.layers {
            if !wanted(&layer.name.to_string()) {
                continue;
            }
            let interval = layer.interval.as_ref().unwrap();
            for texel in 0..texels {
                let value = layer.values[texel].mean();
                let (low, high) = (interval.low[texel].mean(), interval.high[texel].mean());
                map.value[texel] += value;
                // Bounds below zero were cut off.
                map.bar[texel] += (high - value).max(value - low).abs();
            }
        }
        map
    }

    fn at(&self, column: usize, row: usize) -> f64 {
        self.value[row * self.width + column]
    }

    /// Irradiance at a point in texels, bilinear between texels' centres, and how far that may be
    /// from the truth; `None` at the border.
    ///
    /// With E'' constant over some texels of side h, the interpolation is off by at most h²/8 (|E_uu| +
    /// |E_vv|), a texel's average from its centre's value by h²/24 (E_uu + E_vv); h² E'' is a second
    /// difference.
    pub fn interpolated(&self, at: DVec2) -> Option<(f64, f64)> {
        let from = (at - 0.5).floor();
        let part = at - 0.5 - from;
        let last = self.width as f64 - 3.0;
        let inside = from.cmpge(DVec2::ONE).all() && from.cmple(DVec2::splat(last)).all();
        let (x, y) = inside.then_some((from.x as usize, from.y as usize))?;
        let (mut value, mut error) = (0.0, 0.0);
        let mut bend: f64 = 0.0;
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (x, y) = (x + dx, y + dy);
            let weight = (if dx == 1 { part.x } else { 1.0 - part.x })
                * (if dy == 1 { part.y } else { 1.0 - part.y });
            value += weight * self.at(x, y);
            error += weight * self.bar[y * self.width + x];
            let middle = 2.0 * self.at(x, y);
            bend = bend.max(
                (self.at(x - 1, y) + self.at(x + 1, y) - middle).abs()
                    + (self.at(x, y - 1) + self.at(x, y + 1) - middle).abs(),
            );
        }
        Some((value, error + bend / 6.0))
    }
}

/// A square floor about the origin, in the plane z = 0, that a camera looks at.
pub struct FloorView<'a> {
    /// The scene, with nothing but the floor where the camera is to see it.
    pub scene: &'a Scene,
    /// The camera.
    pub camera: &'a Camera,
    /// Id of the floor's shape.
    pub floor: &'a str,
    /// Half the floor's side \[m\].
    pub half_side: f64,
    /// Its irradiance.
    pub map: &'a Map,
}

/// Points across a pixel, each way: a pixel's average by midpoints is off by a part (1/24)²/24 of its second
/// difference.
const POINTS: usize = 24;

impl FloorView<'_> {
    /// The place on the floor's film that the camera sees, if it sees the floor.
    fn seen(&self, at: DVec2) -> Option<DVec2> {
        let view = self.camera.pixel_ray(at);
        let world = self.scene.world();
        let hit = world.closest_hit(&view.ray, view.reach, &mut TraversalCounters::default())?;
        let point = world.surface_point(&view.ray, &hit);
        let is_floor = self.scene.objects()[hit.shape as usize].id == self.floor;
        let place = point.position.truncate() / self.half_side * 0.5 + 0.5;
        is_floor.then_some(place * self.map.width as f64)
    }

    /// The average over a pixel of the floor's irradiance, and how far that may be from the truth; `None`
    /// where the pixel sees anything else, or a map too rough for its error to be known.
    pub fn average(&self, corner: DVec2) -> Option<(f64, f64)> {
        self.average_of(corner, |_| 1.0)
    }

    /// The average over a pixel of irradiance times a factor of the place on the camera's film.
    pub fn average_of(&self, corner: DVec2, factor: impl Fn(DVec2) -> f64) -> Option<(f64, f64)> {
        let count = (POINTS * POINTS) as f64;
        let (mut sum, mut errors) = (0.0, 0.0);
        for index in 0..POINTS * POINTS {
            let place = DVec2::new((index % POINTS) as f64, (index / POINTS) as f64);
            let at = corner + (place + 0.5) / POINTS as f64;
            let (value, error) = self.map.interpolated(self.seen(at)?)?;
            // Where the map bends more, it is not smooth, and the estimate of the error means nothing.
            if value <= 0.0 || error >= 0.05 * value {
                return None;
            }
            sum += value * factor(at);
            errors += error * factor(at);
        }
        Some((sum / count, errors / count))
    }
}
