//! A sensor of fewer texels, on which many runs cost little.

use crate::geometry::Shape;
use crate::radiometry::Rgb;
use crate::scene::{Crop, Scene, Sensor, SensorKind};

/// A sensor whose texels are squares of another's.
#[derive(Clone, Debug, PartialEq)]
pub struct ReducedSensor {
    /// The sensor.
    pub sensor: Sensor,
    /// Its texels are squares of so many of the other's texels.
    pub step: usize,
}

impl ReducedSensor {
    /// The coarsest sensor of which the longer side still has `side` texels or more, or the sensor itself;
    /// steps are powers of two. Only rectangles are reduced: texels of other receivers may differ in area,
    /// and a camera's filter spreads light over pixels.
    pub fn new(scene: &Scene, sensor: &Sensor, side: usize) -> Self {
        let mut reduced = Self {
            sensor: sensor.clone(),
            step: 1,
        };
        let SensorKind::IrradianceMeter { shape } = sensor.kind else {
            return reduced;
        };
        let shapes = scene.world().shapes();
        if !matches!(shapes[shape.0 as usize], Shape::Rectangle(_)) {
            return reduced;
        }
        while let Some(half) = half(&reduced.sensor) {
            let [width, height] = half.size();
            if width.max(height) < side {
                break;
            }
            reduced.sensor = half;
            reduced.step *= 2;
        }
        reduced
    }

    /// Means over the squares of values on the other sensor, whose texels have one area.
    pub fn means(&self, values: &[Rgb]) -> Vec<Rgb> {
        let [width, height] = self.sensor.size();
        let share = 1.0 / (self.step * self.step) as f64;
        let mut means = vec![Rgb::BLACK; width * height];
        for (texel, value) in values.iter().enumerate() {
            let (x, y) = (
                texel % (width * self.step) / self.step,
                texel / (width * self.step * self.step),
            );
            means[y * width + x] += *value * share;
        }
        means
    }
}

/// The sensor with half as many columns and rows; `None` if a number is odd.
fn half(sensor: &Sensor) -> Option<Sensor> {
    let half = |number: u32| number.is_multiple_of(2).then_some(number / 2);
    let film = &sensor.film;
    let crop = Crop {
        offset_x: half(film.crop.offset_x)?,
        offset_y: half(film.crop.offset_y)?,
        width: half(film.crop.width)?,
        height: half(film.crop.height)?,
    };
    let mut reduced = sensor.clone();
    reduced.film.width = half(film.width)?;
    reduced.film.height = half(film.height)?;
    reduced.film.crop = crop;
    Some(reduced)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reduced(size: &str, side: usize) -> ReducedSensor {
        let scene = crate::load("scenes/glass-ball.xml".as_ref(), &[("size", size)]).unwrap();
        ReducedSensor::new(&scene, &scene.sensors()[0], side)
    }

    #[test]
    fn the_coarsest_sensor_with_enough_texels_is_taken() {
        let steps = [
            ("512", 4),
            ("256", 2),
            ("255", 1),
            ("128", 1),
            ("64", 1),
            ("1000", 4),
        ];
        for (size, step) in steps {
            assert_eq!(reduced(size, 128).step, step, "{size}");
        }
        let reduced = reduced("512", 128);
        assert_eq!(reduced.sensor.size(), [128, 128]);
    }

    #[test]
    fn means_are_those_of_squares() {
        let reduced = reduced("4", 2);
        assert_eq!(reduced.step, 2);
        let values: Vec<Rgb> = (0..16).map(|i| Rgb::grey(f64::from(i))).collect();
        let means: Vec<f64> = reduced.means(&values).iter().map(|it| it.mean()).collect();
        assert_eq!(means, [2.5, 4.5, 10.5, 12.5]);
    }
}
