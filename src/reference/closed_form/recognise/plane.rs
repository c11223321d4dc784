//! The receiver's own coordinates, and its film in them.

use glam::{DVec2, DVec3};

use crate::geometry::{Rectangle, Shape};
use crate::reference::closed_form::{TexelGrid, TexelRect};
use crate::run::Refusal;
use crate::scene::{Film, Material, Scene, Sensor, SensorKind};

/// Largest distance, as a part of the scene's size, of places that must coincide.
const COINCIDENCE: f64 = 1e-13;

/// A rectangular receiver: the origin of coordinates is its middle, x runs along its u, z along its normal.
#[derive(Clone, Debug)]
pub(super) struct ReceiverPlane {
    /// The shape's index in the scene.
    pub(super) shape: u32,
    center: DVec3,
    axes: [DVec3; 3],
    /// Half the sides, along x and y.
    half: DVec2,
    /// True if v runs against y.
    is_flipped: bool,
    film: Film,
}

/// A film as a grid of some frame in the receiver's plane.
pub(super) struct FilmGrid {
    /// The film's part that is computed.
    pub(super) grid: TexelGrid,
    /// True if the grid's columns run along v.
    is_transposed: bool,
    /// For x and for y of the frame: true if the film's index falls along it.
    falls: [bool; 2],
}

impl ReceiverPlane {
    /// The plane of a sensor.
    ///
    /// # Errors
    ///
    /// If the sensor is no irradiance meter, or its shape no rectangle that is diffuse.
    pub(super) fn new(scene: &Scene, sensor: &Sensor) -> Result<Self, Refusal> {
        let SensorKind::IrradianceMeter { shape } = sensor.kind else {
            return Err(Refusal::new(format!(
                "sensor \"{}\" is a {}: closed forms give irradiance; sensors of plugin irradiancemeter are allowed",
                sensor.id,
                sensor.plugin()
            )));
        };
        let object = &scene.objects()[shape.0 as usize];
        let Shape::Rectangle(rectangle) = &scene.world().shapes()[shape.0 as usize] else {
            return Err(Refusal::new(format!(
                "sensor \"{}\" measures shape \"{}\" ({}): closed forms know the light on a flat rectangle",
                sensor.id, object.id, object.plugin
            )));
        };
        let is_diffuse = |material: &Material| matches!(material, Material::Diffuse { .. });
        let material = scene.material(object.material);
        let ends_light = is_diffuse(material)
            || matches!(material, Material::TwoSided { front, back }
                if is_diffuse(scene.material(*front)) && is_diffuse(scene.material(*back)));
        if !ends_light {
            return Err(Refusal::new(format!(
                "sensor \"{}\" measures shape \"{}\" of material {}: closed forms need a receiver that is diffuse",
                sensor.id,
                object.id,
                material.plugin()
            )));
        }
        Self::of_rectangle(rectangle, shape.0, &sensor.film).ok_or_else(|| {
            Refusal::new(format!(
                "sensor \"{}\" measures shape \"{}\", whose sides are not at a right angle: closed forms need a \
                 rectangle that is not sheared",
                sensor.id, object.id
            ))
        })
    }

    fn of_rectangle(rectangle: &Rectangle, shape: u32, film: &Film) -> Option<Self> {
        let [u, v] = rectangle.edges();
        let half = 0.5 * DVec2::new(u.length(), v.length());
        if u.dot(v).abs() > COINCIDENCE * u.length() * v.length() {
            return None;
        }
        let x = u.normalize();
        let z = rectangle.normal();
        let y = z.cross(x).normalize();
        Some(Self {
            shape,
            center: rectangle.center(),
            axes: [x, y, z],
            half,
            is_flipped: y.dot(v) < 0.0,
            film: film.clone(),
        })
    }

    /// The coordinates of a point of the world.
    pub(super) fn point(&self, world: DVec3) -> DVec3 {
        self.vector(world - self.center)
    }

    /// The coordinates of a vector of the world.
    pub(super) fn vector(&self, world: DVec3) -> DVec3 {
        DVec3::from_array(self.axes.map(|axis| axis.dot(world)))
    }

    /// True if lengths that differ by `offset` count as the same, next to others of size `scale`.
    pub(super) fn coincide(&self, offset: f64, scale: f64) -> bool {
        let rounding = 4.0 * f64::EPSILON * self.center.length();
        offset.abs() <= COINCIDENCE * scale.max(self.reach()) + rounding
    }

    /// True if a point is on the normal through the receiver's middle.
    pub(super) fn is_on_axis(&self, point: DVec3) -> bool {
        self.coincide(point.truncate().length(), point.z.abs())
    }

    /// Distance of the corners from the middle.
    pub(super) fn reach(&self) -> f64 {
        self.half.length()
    }

    /// The four corners.
    pub(super) fn corners(&self) -> [DVec2; 4] {
        let DVec2 { x, y } = self.half;
        [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| DVec2::new(x, y))
    }

    /// The film in the plane's own coordinates.
    pub(super) fn grid(&self) -> FilmGrid {
        self.grid_about(DVec2::ZERO, 0)
    }

    /// The film in a frame whose origin is `origin` and whose x axis is this plane's, turned by so many right
    /// angles from x to y.
    pub(super) fn grid_about(&self, origin: DVec2, quarter_turns: u32) -> FilmGrid {
        let Film {
            width,
            height,
            crop,
            ..
        } = &self.film;
        let range = |offset: u32, kept: u32, whole: u32, half: f64, is_flipped: bool| {
            let along = |index: u32| half * (2.0 * f64::from(index) / f64::from(whole) - 1.0);
            let (from, to) = (along(offset), along(offset + kept));
            if is_flipped { (-to, -from) } else { (from, to) }
        };
        let x = range(crop.offset_x, crop.width, *width, self.half.x, false);
        let y = range(
            crop.offset_y,
            crop.height,
            *height,
            self.half.y,
            self.is_flipped,
        );
        let shifted = |range: (f64, f64), by: f64| (range.0 - by, range.1 - by);
        let turned = |range: (f64, f64)| (-range.1, -range.0);
        let (x, y) = (shifted(x, origin.x), shifted(y, origin.y));
        let (columns, rows) = (crop.width as usize, crop.height as usize);
        // The frame's axes are (x, y), (y, −x), (−x, −y), (−y, x) of the plane.
        let quarter = quarter_turns % 4;
        let is_transposed = quarter % 2 == 1;
        let (mut first, mut second) = if is_transposed { (y, x) } else { (x, y) };
        let against = [quarter >= 2, quarter == 1 || quarter == 2];
        if against[0] {
            first = turned(first);
        }
        if against[1] {
            second = turned(second);
        }
        let film_falls = if is_transposed {
            [self.is_flipped, false]
        } else {
            [false, self.is_flipped]
        };
        let (columns, rows) = if is_transposed {
            (rows, columns)
        } else {
            (columns, rows)
        };
        FilmGrid {
            grid: TexelGrid {
                bounds: TexelRect::new(first.0, second.0, first.1, second.1),
                columns,
                rows,
            },
            is_transposed,
            falls: [film_falls[0] != against[0], film_falls[1] != against[1]],
        }
    }
}

/// True if a unit vector of the receiver's coordinates is along its normal, either way.
pub(super) fn is_along_normal(direction: DVec3) -> bool {
    direction.truncate().length() <= COINCIDENCE
}

impl FilmGrid {
    /// A map in the order of [`TexelGrid::map`], in the film's order.
    pub(super) fn in_film_order(&self, map: &[f64]) -> Vec<f64> {
        let TexelGrid { columns, rows, .. } = self.grid;
        let (width, height) = if self.is_transposed {
            (rows, columns)
        } else {
            (columns, rows)
        };
        let turned = |index: usize, count: usize, falls: bool| {
            if falls { count - 1 - index } else { index }
        };
        (0..width * height)
            .map(|texel| {
                let (u, v) = (texel % width, texel / width);
                let (x, y) = if self.is_transposed { (v, u) } else { (u, v) };
                let column = turned(x, columns, self.falls[0]);
                let row = turned(y, rows, self.falls[1]);
                map[row * columns + column]
            })
            .collect()
    }
}
