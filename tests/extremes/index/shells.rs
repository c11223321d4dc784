//! A body of concentric balls under a lamp, by Bouguer's law and as a scene.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write as _;

use glam::{DVec2, DVec3};
use nephroid::internals::geometry::{Ray, TraversalCounters};
use nephroid::internals::optics::dielectric_reflectance;
use nephroid::internals::reference::closed_form::{RadialMap, RadialSheet, TexelGrid};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::chain::{Arrival, ChainSettings, ChainSink, ChainTracer};
use nephroid::internals::transport::flux::Flux;
use nephroid::internals::transport::ledger::Fate;
use nephroid::internals::transport::signature::Signature;

use crate::support::chains::light;
use crate::support::extremes::{U, scene};

/// Concentric balls under a lamp, over a receiver.
#[derive(Clone, Debug)]
pub struct Shells {
    /// Outermost first.
    pub radii: Vec<f64>,
    /// Indices of the surroundings, then inside each ball; one more than radii.
    pub indices: Vec<f64>,
}

/// The lamp's height over the receiver, and the balls' centre's.
const LAMP: f64 = 4.0;

const CENTER: f64 = 1.4;

const INTENSITY: f64 = 100.0;

/// Half the receiver's width.
pub const HALF: f64 = 2.0;

impl Shells {
    pub fn ball(outside: f64, inside: f64) -> Self {
        Self {
            radii: vec![1.0],
            indices: vec![outside, inside],
        }
    }

    /// The signature of light that is transmitted by every surface, twice: `LT...TD`.
    pub fn signature(&self) -> String {
        format!("L{}D", "T".repeat(2 * self.radii.len()))
    }

    /// sin of the angle of incidence on the outermost surface up to which light gets through all of them: n r
    /// sin θ must not exceed n r on either side of any surface.
    pub fn widest_sin(&self) -> f64 {
        let outermost = self.indices[0] * self.radii[0];
        (0..self.radii.len())
            .flat_map(|i| [i, i + 1].map(|medium| self.indices[medium] * self.radii[i] / outermost))
            .fold(1.0, f64::min)
    }

    /// Place at which a ray lands whose angle of incidence on the outermost ball has this sine, and the
    /// factor on its flux.
    ///
    /// It meets surface j at asin(b/(n r)) with the index of the layer it comes from, and leaves it likewise:
    /// each is turned by their difference twice, and about the centre the ray goes on by what is between.
    pub fn landing(&self, sin: f64) -> Option<(f64, f64)> {
        let b = self.indices[0] * self.radii[0] * sin;
        let angle = |medium: usize, surface: usize| {
            (b / (self.indices[medium] * self.radii[surface]))
                .min(1.0)
                .asin()
        };
        let theta = (self.radii[0] / (LAMP - CENTER) * sin).asin();
        let (mut swept, mut turned, mut passed) = (0.0, 0.0, 1.0);
        let surfaces = self.radii.len();
        for surface in 0..surfaces {
            let (arrives, leaves) = (angle(surface, surface), angle(surface + 1, surface));
            turned += 2.0 * (arrives - leaves);
            if surface + 1 < surfaces {
                swept += 2.0 * (angle(surface + 1, surface + 1) - leaves);
            } else {
                swept += PI - 2.0 * leaves;
            }
            let eta = self.indices[surface + 1] / self.indices[surface];
            passed *= (1.0 - dielectric_reflectance(arrives.cos(), eta)).powi(2);
        }
        let place = sin.asin() - theta + swept;
        let direction = theta - turned;
        let height = CENTER + self.radii[0] * place.cos();
        let radius = self.radii[0] * place.sin() + height * direction.tan();
        // Else it leaves upward.
        (direction.cos() > 1e-12).then_some((radius, passed))
    }

    /// Light through all surfaces, on the receiver.
    pub fn sheet(&self) -> RadialSheet {
        RadialSheet::new(Through(self.clone()))
    }

    /// Light that the outermost surface reflects, on the receiver: at the angles at which light may pass it,
    /// and at those where it is reflected totally.
    pub fn reflected(&self) -> [RadialSheet; 2] {
        let eta = self.indices[1] / self.indices[0];
        let critical = eta.min(1.0).asin();
        [(0.0, critical), (critical, FRAC_PI_2)].map(|range| {
            let ratio = self.radii[0] / (LAMP - CENTER);
            RadialSheet::new(Reflected {
                radius: self.radii[0],
                ratio,
                eta,
                range,
            })
        })
    }

    /// The ray that meets the outermost ball at this sine.
    pub fn ray(&self, sin: f64, azimuth: f64) -> Ray {
        let sin = self.radii[0] / (LAMP - CENTER) * sin;
        let across = DVec2::from_angle(azimuth) * sin;
        let direction = across.extend(-((1.0 - sin) * (1.0 + sin)).sqrt());
        Ray::new(DVec3::Z * LAMP, direction)
    }

    pub fn xml(&self) -> String {
        let mut xml = lamp();
        for (i, radius) in self.radii.iter().enumerate() {
            let (outside, inside) = (self.indices[i], self.indices[i + 1]);
            let _ = write!(
                xml,
                r#"<shape type="sphere"><point name="center" x="0" y="0" z="{CENTER:?}"/><float name="radius" value="{radius:?}"/>
<bsdf type="dielectric"><float name="int_ior" value="{inside:?}"/><float name="ext_ior" value="{outside:?}"/></bsdf></shape>"#
            );
        }
        xml + FLOOR
    }

    pub fn scene(&self, side: usize) -> Scene {
        scene(&self.xml(), None, side)
    }
}

pub const FLOOR: &str = r#"<shape type="rectangle"><transform name="to_world"><scale x="2" y="2"/></transform>
<bsdf type="diffuse"/>{meter}</shape>"#;

/// u is the angle of incidence on the outermost ball.
struct Through(Shells);

impl RadialMap for Through {
    fn range(&self) -> (f64, f64) {
        (0.0, self.0.widest_sin().asin().min(FRAC_PI_2))
    }

    fn radius(&self, u: f64) -> Option<f64> {
        self.0.landing(u.sin()).map(|(radius, _)| radius)
    }

    /// dΦ = 2π I (R/D)² sin i cos i / cos θ di, as of one ball.
    fn flux_density(&self, u: f64) -> f64 {
        let (sin, cos) = u.sin_cos();
        let ratio = self.0.radii[0] / (LAMP - CENTER);
        let theta = (ratio * sin).asin();
        let passed = self.0.landing(sin).map_or(0.0, |(_, passed)| passed);
        TAU * INTENSITY * ratio * ratio * sin * cos / theta.cos() * passed
    }
}

/// u is the angle of incidence on a ball.
struct Reflected {
    radius: f64,
    /// The radius by the lamp's distance from the centre.
    ratio: f64,
    eta: f64,
    range: (f64, f64),
}

impl RadialMap for Reflected {
    fn range(&self) -> (f64, f64) {
        self.range
    }

    /// It leaves where it came, at i on the normal's other side.
    fn radius(&self, u: f64) -> Option<f64> {
        let theta = (self.ratio * u.sin()).asin();
        let (place, direction) = (u - theta, theta + PI - 2.0 * u);
        let height = CENTER + self.radius * place.cos();
        (direction.cos() > 1e-12).then(|| self.radius * place.sin() + height * direction.tan())
    }

    fn flux_density(&self, u: f64) -> f64 {
        let (sin, cos) = u.sin_cos();
        let theta = (self.ratio * sin).asin();
        let reflected = dielectric_reflectance(cos, self.eta);
        TAU * INTENSITY * self.ratio * self.ratio * sin * cos / theta.cos() * reflected
    }
}

/// Place at which light lands that every surface transmits, and the flux that is left of it.
struct Landing {
    signature: Signature,
    receiver: u32,
    found: Option<(DVec3, f64)>,
}

impl ChainSink<1> for Landing {
    fn arrived(&mut self, arrival: &Arrival<1>, _: &mut TraversalCounters) -> Fate {
        if arrival.hit.shape == self.receiver && arrival.signature == self.signature {
            self.found = Some((arrival.point.position, arrival.flux.0[0]));
        }
        Fate::Received
    }
    fn ended(&mut self, _: Signature, _: Fate, _: Flux<1>) {}
    fn gained(&mut self, _: Flux<1>) {}
}

/// A ray along all its branches up to as many events as it takes to be transmitted everywhere.
pub fn followed(shells: &Shells, scene: &Scene, sin: f64) -> Option<(DVec3, f64)> {
    let events = 2 * shells.radii.len() as u32;
    let settings = ChainSettings {
        max_depth: events,
        split_depth: events,
        ..ChainSettings::default()
    };
    let mut sink = Landing {
        signature: shells.signature().parse().expect("a signature"),
        receiver: scene.objects().len() as u32 - 1,
        found: None,
    };
    let ray = shells.ray(sin, 0.3);
    ChainTracer::<1>::new(scene, settings).trace(&light(ray), &mut sink);
    sink.found
}

/// Rays of a scene beside the closed form: worst error of the places where they land and of the flux left,
/// and the worst share of what is allowed.
#[derive(Debug, Default)]
pub struct Rays {
    pub place: f64,
    pub flux: f64,
    pub of_allowed: f64,
    pub followed: usize,
}

/// Rays that are tried.
pub const TRIED: usize = 59;

/// Follows rays up to `most` of the widest that gets through, of which at least so many must land on the
/// receiver.
///
/// Each of 2 N events and the landing takes the roundings of a place (16 u, see `Sphere`) and of a direction
/// (16 u), whose lever is up to 4 long: 64 u, amplified by what a neighbouring ray lands farther off, and by
/// η on the way out of a denser medium. The closed form's angles round alike. Flux takes 2 N factors 1 − F,
/// each of 16 roundings of 1 and so by up to 1/√(what is left) more, and follows the angles as much as a
/// neighbouring ray's does; on the way out of a dense medium the same 64 u in the cosine count (cos θᵢ / η
/// cos θₜ)² times, about n².
pub fn rays(shells: &Shells, most: f64, least: usize) -> Rays {
    let scene = shells.scene(1);
    let events = 2.0 * shells.radii.len() as f64 + 1.0;
    let ratios = shells
        .indices
        .windows(2)
        .map(|pair| (pair[0] / pair[1]).max(pair[1] / pair[0]));
    let densest = ratios.fold(1.0, f64::max);
    let mut rays = Rays::default();
    for number in 1..=TRIED {
        let sin = shells.widest_sin() * most * number as f64 / (TRIED + 1) as f64;
        let step = 1e-7 * sin;
        let (Some((radius, passed)), Some(beside)) =
            (shells.landing(sin), shells.landing(sin + step))
        else {
            continue;
        };
        if radius.abs() > HALF * 0.99 {
            continue;
        }
        let Some((position, flux)) = followed(shells, &scene, sin) else {
            panic!("{shells:?}: sin i {sin} does not land");
        };
        let spread = 1.0 + (beside.0 - radius).abs() / step;
        let place = (position.truncate() - DVec2::from_angle(0.3) * radius).length();
        let allowed_place = events * 64.0 * U * spread * densest;
        assert!(place <= allowed_place, "{shells:?}, sin i {sin}: {place:e}");
        let fading = 1.0 + (beside.1 / passed - 1.0).abs() / step;
        let flux = (flux / passed - 1.0).abs();
        let allowed_flux =
            events * 64.0 * U * fading / passed.sqrt() + 64.0 * U * densest * densest;
        assert!(
            flux <= allowed_flux,
            "{shells:?}, sin i {sin}: flux {flux:e}"
        );
        rays.place = rays.place.max(place);
        rays.flux = rays.flux.max(flux);
        rays.of_allowed = rays
            .of_allowed
            .max(place / allowed_place)
            .max(flux / allowed_flux);
        rays.followed += 1;
    }
    assert!(
        rays.followed >= least,
        "{shells:?}: {} rays land on the receiver",
        rays.followed
    );
    rays
}

pub const SIDE: usize = 16;

pub fn sum(values: &[f64]) -> f64 {
    values.iter().sum()
}

pub fn truth(shells: &Shells) -> Vec<f64> {
    shells.sheet().map(&TexelGrid::square(HALF, SIDE))
}

pub fn reflected(shells: &Shells) -> Vec<f64> {
    let [passing, total] = shells
        .reflected()
        .map(|sheet| sheet.map(&TexelGrid::square(HALF, SIDE)));
    added(&passing, &total)
}

pub fn added(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

pub fn lamp() -> String {
    format!(
        r#"<emitter type="point"><point name="position" x="0" y="0" z="{LAMP:?}"/><rgb name="intensity" value="{INTENSITY:?}"/></emitter>"#
    )
}
