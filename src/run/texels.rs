//! The description of a receiver's texels, for whoever reads the file alone.

use crate::film::Image;
use crate::geometry::Shape;
use crate::metric::texel_grid::{AREA, SIZE, SURFACE};
use crate::scene::{Scene, Sensor, SensorKind};
use crate::transport::receiver::Receiver;

/// The cosine of the angle between a rectangle's edges, above which it is no rectangle.
const SKEWED: f64 = 1e-9;

/// What a file says of a receiver's texels.
pub struct Description {
    /// Key and value.
    pub metadata: (&'static str, String),
    /// The area of each texel \[m²\], where areas differ.
    pub areas: Option<Vec<f64>>,
}

/// Adds the [`Description`] of a sensor's texels, if there is one.
pub fn describe(image: &mut Image, scene: &Scene, sensor: &Sensor) {
    let Some(description) = describe_texels(scene, sensor) else {
        return;
    };
    let (key, value) = description.metadata;
    image.add_metadata(key, value);
    if let Some(areas) = description.areas {
        image.add_scalar(AREA, areas);
    }
}

/// The size of the texels \[m\] of a rectangle. Of other surfaces it is their name, and the area of each
/// texel where areas differ. A camera's pixels have neither.
pub fn describe_texels(scene: &Scene, sensor: &Sensor) -> Option<Description> {
    let SensorKind::IrradianceMeter { shape } = sensor.kind else {
        return None;
    };
    let name = match &scene.world().shapes()[shape.0 as usize] {
        Shape::Rectangle(rectangle) => {
            let [u, v] = rectangle.edges();
            let film = &sensor.film;
            if u.dot(v).abs() <= SKEWED * u.length() * v.length() {
                let size = [
                    u.length() / f64::from(film.width),
                    v.length() / f64::from(film.height),
                ];
                return Some(Description {
                    metadata: (SIZE, serde_json::json!(size).to_string()),
                    areas: None,
                });
            }
            "a skewed rectangle"
        }
        Shape::Cylinder(_) => "a cylinder",
        Shape::Disk(_) => "a disc",
        Shape::Sphere(_) => "a sphere",
        Shape::Mesh(_) => "a mesh",
    };
    let areas = Receiver::new(scene, sensor).ok().map(|receiver| {
        let texels = 0..receiver.texels();
        texels.map(|texel| receiver.texel_area(texel)).collect()
    });
    let differ = |areas: &Vec<f64>| areas.iter().any(|area| *area != areas[0]);
    Some(Description {
        metadata: (SURFACE, name.to_owned()),
        areas: areas.filter(differ),
    })
}
