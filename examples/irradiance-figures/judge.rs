//! The turntables, tables of them made one by one, and errors of images.

use glam::{DMat3, DVec3};
use nephroid::internals::approximation::SensorFilm;
use nephroid::internals::approximation::local_irradiance::Settings;
use nephroid::internals::approximation::local_irradiance::directions::Blended;
use nephroid::internals::approximation::local_irradiance::layout::Layout;
use nephroid::internals::approximation::local_irradiance::object::SpecularObject;
use nephroid::internals::approximation::local_irradiance::prepare::{
    Goal, Lit, Shed, adapted_radii, even_radii, stream,
};
use nephroid::internals::approximation::local_irradiance::table::Table;
use nephroid::internals::approximation::local_irradiance::variants::Radii;
use nephroid::internals::approximation::local_irradiance::work::Work;
use nephroid::internals::method::Method;
use nephroid::internals::mitsuba;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::Rendering;
use nephroid::internals::run::format::three_digits;
use nephroid::internals::scene::Scene;

use crate::support::light_volume::{run_on, sensor};
use crate::support::scenes::bundled_file;

/// The irradiance of the sun across its light [W/m²].
pub const SUN: f64 = 10.0;

/// A turntable with some parameters.
pub fn turntable(name: &str, parameters: &[(&str, &str)]) -> Scene {
    let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
    let parameters: Vec<_> = parameters.iter().map(owned).collect();
    mitsuba::load(&bundled_file(&format!("turntable-{name}")), &parameters).unwrap()
}

/// A run on the floor.
pub fn on_floor(method: &Method, scene: &Scene) -> Rendering {
    run_on(method, scene, "floor")
}

/// The light of the floor, texel by texel.
pub fn floor(method: &Method, scene: &Scene) -> Vec<Rgb> {
    on_floor(method, scene).estimate.total.values
}

/// The sum of differences by the sum of the truth.
pub fn l1(truth: &[Rgb], image: &[Rgb]) -> f64 {
    let pairs = truth.iter().zip(image);
    let apart: f64 = pairs.map(|(a, b)| (a.mean() - b.mean()).abs()).sum();
    apart / sum(truth)
}

/// The sum over texels of the mean of channels.
pub fn sum(values: &[Rgb]) -> f64 {
    values.iter().map(|value| value.mean()).sum()
}

/// A share in percent.
pub fn percent(share: f64) -> String {
    three_digits(100.0 * share)
}

/// A turntable whose tables are made one by one, for the direction of its sun.
pub struct Bench {
    pub scene: Scene,
    pub object: SpecularObject,
    film: SensorFilm,
    /// To the sun, along the object's own axes.
    towards: DVec3,
}

impl Bench {
    /// A turntable, and its floor.
    pub fn new(name: &str, parameters: &[(&str, &str)]) -> Self {
        let scene = turntable(name, parameters);
        let mut all = SpecularObject::all(&scene).unwrap();
        assert_eq!(all.len(), 1, "one object");
        let object = all.remove(0);
        let film = SensorFilm::new(&scene, sensor(&scene, "floor")).unwrap();
        let degrees = |key: &str, other: f64| -> f64 {
            let found = parameters.iter().find(|(known, _)| *known == key);
            found
                .map_or(other, |(_, value)| value.parse().unwrap())
                .to_radians()
        };
        // The defaults of the scenes.
        let (azimuth, elevation) = if name == "ring" {
            (340.0, 40.0)
        } else {
            (30.0, 60.0)
        };
        let (a, e) = (degrees("azimuth", azimuth), degrees("elevation", elevation));
        let sun = DVec3::new(e.cos() * a.cos(), e.cos() * a.sin(), e.sin());
        let towards = object.to_own(sun).normalize();
        Self {
            scene,
            object,
            film,
            towards,
        }
    }

    /// The cells that settings ask for.
    pub fn layout(&self, settings: &Settings) -> Layout {
        let radius = settings.reach * self.object.radius;
        let radii = if settings.radii == Radii::Uniform {
            even_radii(settings.shells, radius)
        } else {
            adapted_radii(settings, &self.object, &mut Work::default()).unwrap()
        };
        Layout::new(settings, self.object.radius, &radii, 0.0)
    }

    /// Photons of one light direction into cells.
    pub fn shed(&self, settings: &Settings, layout: &Layout) -> Shed {
        let lit = Lit {
            settings,
            scene: &self.object.alone,
            object: &self.object,
            light: None,
            stop: &|| false,
        };
        let blended = Blended {
            sample: 0,
            towards: self.towards,
            weight: 1.0,
            turn: DMat3::IDENTITY,
        };
        let random = stream(settings, 0, 0);
        let photons = 0..settings.photons;
        lit.shed(&blended, random, photons, Goal::Cells(layout))
            .unwrap()
    }

    /// The floor as a table has it [W/m²], with `normal=fixed` and `region=clamp`.
    pub fn image(&self, settings: &Settings, layout: &Layout, table: &Table) -> Vec<Rgb> {
        let own = self.object.turn.transpose();
        let read = |point: &nephroid::internals::approximation::SensorPoint, work: &mut Work| {
            let away = point.point.position - self.object.center;
            let distance = away.length();
            let factor = (-point.normal.dot(away) / distance).max(0.0);
            let place = own * away * (layout.radius / distance).min(1.0);
            layout.read(settings, table, [place, DVec3::ZERO], &[], work) * (SUN * factor)
        };
        let (values, ..) = self.film.evaluate(&self.scene, settings.samples, read);
        values
    }
}
