//! The description of a receiver's texels, for whoever reads the file alone.

use crate::film::Image;
use crate::geometry::Shape;
use crate::metric::texel_grid::{AREA, SIZE, SURFACE};
use crate::scene::{Scene, Sensor, SensorKind};
use crate::transport::receiver::Receiver;

/// The cosine of the angle between a rectangle's edges, above which it is no rectangle.
const SKEWED: f64 = 1e-9;

/// Adds the size of the texels \[m\] of a rectangle. Of other surfaces it adds their name, and the area of
/// each texel \[m²\] where areas differ. A camera's pixels have neither.
pub fn describe(image: &mut Image, scene: &Scene, sensor: &Sensor) {
    let SensorKind::IrradianceMeter { shape } = sensor.kind else {
        return;
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
                image.add_metadata(SIZE, serde_json::json!(size).to_string());
                return;
            }
            "a skewed rectangle"
        }
        Shape::Cylinder(_) => "a cylinder",
        Shape::Disk(_) => "a disc",
        Shape::Sphere(_) => "a sphere",
        Shape::Mesh(_) => "a mesh",
    };
    image.add_metadata(SURFACE, name);
    let Ok(receiver) = Receiver::new(scene, sensor) else {
        return;
    };
    let areas: Vec<f64> = (0..receiver.texels())
        .map(|texel| receiver.texel_area(texel))
        .collect();
    if areas.iter().any(|area| *area != areas[0]) {
        image.add_scalar(AREA, areas);
    }
}
