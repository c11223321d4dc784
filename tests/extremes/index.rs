//! Indices of refraction near 1, far from 1, inside out, matched, nested, and with next to nothing between them.
//!
//! The oracle is a body of concentric balls under a lamp: light stays in a plane through the axis, and n r sin θ is the same
//! all along a ray (Bouguer; Born and Wolf, *Principles of Optics*, 7th edition, 3.2.2 (7)).

use std::f64::consts::{FRAC_PI_2, PI, SQRT_2, TAU};
use std::fmt::Write as _;

use glam::{DVec2, DVec3};
use nephroid::geometry::{Ray, TraversalCounters};
use nephroid::numeric::distributions::critical_value;
use nephroid::optics::dielectric_reflectance;
use nephroid::reference::closed_form::{GlassBall, RadialMap, RadialSheet, TexelGrid};
use nephroid::scene::Scene;
use nephroid::transport::chain::{Arrival, ChainSettings, ChainSink, ChainTracer};
use nephroid::transport::flux::Flux;
use nephroid::transport::ledger::Fate;
use nephroid::transport::signature::Signature;

use crate::support::extremes::{
    ORACLE, U, assert_as_asked, beams, distance, error_as_asked, judged, layer, photons, red,
    scene, specular,
};

/// Concentric balls under a lamp, over a receiver.
#[derive(Clone, Debug)]
struct Shells {
    /// Outermost first.
    radii: Vec<f64>,
    /// Of the surroundings, then inside each ball; one more than radii.
    indices: Vec<f64>,
}

/// The lamp's height over the receiver, and the balls' centre's.
const LAMP: f64 = 4.0;
const CENTER: f64 = 1.4;
const INTENSITY: f64 = 100.0;
/// Half the receiver's width.
const HALF: f64 = 2.0;

impl Shells {
    fn ball(outside: f64, inside: f64) -> Self {
        Self {
            radii: vec![1.0],
            indices: vec![outside, inside],
        }
    }

    /// The signature of light that is transmitted by every surface, twice: `LT...TD`.
    fn signature(&self) -> String {
        format!("L{}D", "T".repeat(2 * self.radii.len()))
    }

    /// sin of the angle of incidence on the outermost surface up to which light gets through all of them: n r sin θ must not
    /// exceed n r on either side of any surface.
    fn widest_sin(&self) -> f64 {
        let outermost = self.indices[0] * self.radii[0];
        (0..self.radii.len())
            .flat_map(|i| [i, i + 1].map(|medium| self.indices[medium] * self.radii[i] / outermost))
            .fold(1.0, f64::min)
    }

    /// Where a ray lands whose angle of incidence on the outermost ball has this sine, and the factor on its flux.
    ///
    /// It meets surface j at asin(b/(n r)) with the index of the layer it comes from, and leaves it likewise: each is turned by
    /// their difference twice, and about the centre the ray goes on by what is between.
    fn landing(&self, sin: f64) -> Option<(f64, f64)> {
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
    fn sheet(&self) -> RadialSheet {
        RadialSheet::new(Through(self.clone()))
    }

    /// Light that the outermost surface reflects, on the receiver: at the angles at which light may pass it, and at those where it is
    /// reflected totally.
    fn reflected(&self) -> [RadialSheet; 2] {
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
    fn ray(&self, sin: f64, azimuth: f64) -> Ray {
        let sin = self.radii[0] / (LAMP - CENTER) * sin;
        let across = DVec2::from_angle(azimuth) * sin;
        let direction = across.extend(-((1.0 - sin) * (1.0 + sin)).sqrt());
        Ray::new(DVec3::Z * LAMP, direction)
    }

    fn xml(&self) -> String {
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

    fn scene(&self, side: usize) -> Scene {
        scene(&self.xml(), None, side)
    }
}

const FLOOR: &str = r#"<shape type="rectangle"><transform name="to_world"><scale x="2" y="2"/></transform>
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

/// Where light that is transmitted by every surface lands, and what is left of its flux.
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
    fn choice(&mut self, _: Signature, _: u32) -> f64 {
        0.5
    }
}

/// A ray along all its branches up to as many events as it takes to be transmitted everywhere.
fn followed(shells: &Shells, scene: &Scene, sin: f64) -> Option<(DVec3, f64)> {
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
    ChainTracer::<1>::new(scene, settings).trace(ray, Flux([1.0]), &mut sink);
    sink.found
}

/// How rays come out of a scene beside the closed form: worst error of where they land and of the flux left, and the worst share of
/// what is allowed.
#[derive(Debug, Default)]
struct Rays {
    place: f64,
    flux: f64,
    of_allowed: f64,
    followed: usize,
}

/// Rays that are tried.
const TRIED: usize = 59;

/// Follows rays up to `most` of the widest that gets through, of which at least so many must land on the receiver.
///
/// Each of 2 N events and the landing takes the roundings of a place (16 u, see `Sphere`) and of a direction (16 u), whose lever
/// is up to 4 long: 64 u, amplified by what a neighbouring ray lands farther off, and by η on the way out of a denser medium. The closed form's angles round alike. Flux takes 2 N
/// factors 1 − F, each of 16 roundings of 1 and so by up to 1/√(what is left) more, and follows the angles as much as a neighbouring ray's does; on the way out
/// of a dense medium the same 64 u in the cosine count (cos θᵢ / η cos θₜ)² times, about n².
fn rays(shells: &Shells, most: f64, least: usize) -> Rays {
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

const SIDE: usize = 16;

fn sum(values: &[f64]) -> f64 {
    values.iter().sum()
}

fn truth(shells: &Shells) -> Vec<f64> {
    shells.sheet().map(&TexelGrid::square(HALF, SIDE))
}

fn reflected(shells: &Shells) -> Vec<f64> {
    let [passing, total] = shells
        .reflected()
        .map(|sheet| sheet.map(&TexelGrid::square(HALF, SIDE)));
    added(&passing, &total)
}

fn added(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

fn lamp() -> String {
    format!(
        r#"<emitter type="point"><point name="position" x="0" y="0" z="{LAMP:?}"/><rgb name="intensity" value="{INTENSITY:?}"/></emitter>"#
    )
}

/// The probability that a right program fails the test of photons below.
const RISK: f64 = 1e-4;

/// E of a ball of index 1 + x is that of no ball, by a smooth function of x: both are closed forms of the light through it, and all
/// other light is next to nothing (LRD) or does not change (LD).
///
/// What the ball reflects: near grazing incidence, c² = 2x sinh² t, F is e^(−4t), and ∫ F 2c dc = 2x ∫ e^(−4t) sinh 2t dt = x/3 of light
/// that falls evenly on its cross-section. Of a ball less dense than its surroundings, light is reflected totally up to
/// c² = 2|x|, which is 2|x| more. The lamp is near, so that the ball's rim has 1/cos θ = 1.083 times as much as that.
///
/// Light is reflected where it enters and where it leaves; the rest lands on the receiver, all of it: it is turned by 2√(2|x|) at most,
/// which is 1.6° here. So all light differs from that without a ball by twice that part of what falls on the ball, less what of the
/// reflected lands there, too. That is a ring about the shadow, of radius 5/3, of which a texel has no more than its diagonal.
#[test]
fn glass_that_is_next_to_nothing_changes_next_to_nothing() {
    println!(
        "ball of index 1 + x: of LTTD by beams asked for 1e-3, worst texel and root mean square error; how far the truth of all light is out of their \
         bounds; all light / that of no ball − 1, by beams, by photons and their standard error; rays that land: how many, worst landing, of what is allowed"
    );
    let nothing = scene(&(lamp() + FLOOR), None, SIDE);
    let nothing = red(&beams(&nothing, 1e-3, 2).total);
    let straight = truth(&Shells::ball(1.0, 1.0));
    let indices = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 0.0, -1e-12, -1e-6];
    let errors = critical_value(1.0 - RISK / indices.len() as f64, 31.0);
    let texels = nothing.len() as f64;
    for x in indices {
        let shells = Shells::ball(1.0, 1.0 + x);
        let by_beams = beams(&shells.scene(SIDE), 1e-3, 2);
        let through = truth(&shells);
        let name = format!("{x:e}");
        let [off, error] = assert_as_asked(&name, &by_beams, "LTTD", &through, 1e-3);
        let all: Vec<f64> = (0..nothing.len())
            .map(|texel| nothing[texel] + (through[texel] - straight[texel]))
            .collect();
        let (all_missed, _) = judged(&by_beams.total, &all);
        let reflected = 1.083 * x.abs() / 3.0 * if x > 0.0 { 1.0 } else { 7.0 };
        let on_ball = GlassBall::SHIPPED.intercepted_flux();
        let texel = 2.0 * HALF / SIDE as f64;
        let in_texel = reflected * on_ball * (SQRT_2 * texel) / (TAU * 5.0 / 3.0);
        let brightest = all.iter().copied().fold(0.0, f64::max) * (texel * texel);
        // Beams do not follow so little.
        assert!(
            all_missed <= ORACLE + in_texel / brightest,
            "{x:e}: {all_missed:e}"
        );

        // On one texel, photons' standard error is that of the flux. Direct light is by quadrature, on small texels, with a bound.
        let by_photons = photons(&shells.scene(1), 1 << 17, 2);
        let [caught] = specular(&by_photons)[..] else {
            panic!("one texel");
        };
        let direct = layer(&by_beams, "LD").expect("direct light");
        let bounds = direct.interval.as_ref().expect("beams have bounds");
        let bar = |texel: usize| bounds.high[texel].0[0] - direct.irradiance[texel].0[0];
        let bars = (0..nothing.len()).map(bar).sum::<f64>() / texels;
        let standard_error = caught * by_photons.relative_error.expect("light on the receiver");
        let without = sum(&nothing) / texels;
        let change = sum(&red(direct)) / texels + caught - without;
        let reflected = 2.0 * reflected * on_ball / (2.0 * HALF).powi(2);
        assert!(
            change.abs() <= errors * standard_error + bars + reflected,
            "{x:e}: {change:e} ± {standard_error:e}, {bars:e}, {reflected:e}"
        );
        // Neither is so wide that anything would do: direct light's bounds hide nothing of what photons tell, and those are no worse than
        // points drawn at random, of which a share of p has a variance of (1 − p)/(p n). 32 replicates make 1.6 times as much of the true
        // standard error with a probability of 4e-6.
        assert!(bars <= standard_error, "{x:e}: {bars:e}");
        let share = caught * (2.0 * HALF).powi(2) / by_photons.ledger.emitted.0[0];
        let random = caught * ((1.0 - share) / (share * by_photons.paths as f64)).sqrt();
        assert!(standard_error <= 1.6 * random, "{x:e}: {standard_error:e}");
        let rays = rays(&shells, 0.99, TRIED);
        println!(
            "  {x:+.0e}: {off:.1e}, {error:.1e}; {all_missed:.1e}; {:+.1e}, {:+.1e} ± {:.1e}; {}, {:.1e}, {:.2}",
            sum(&red(&by_beams.total)) / sum(&nothing) - 1.0,
            change / without,
            standard_error / without,
            rays.followed,
            rays.place,
            rays.of_allowed,
        );
    }
}

#[test]
fn dense_glass_and_bubbles_are_as_the_closed_form_has_them() {
    println!(
        "ball by its index inside and outside: of LTTD by beams asked for 1e-2, worst texel, and root mean square error of it, of LRD and of both, relative to both; rays that \
         land: how many, worst landing, worst flux, of what is allowed"
    );
    // The more light is bent, the more of it leaves by the receiver's side or upward.
    for (outside, inside, landed) in [
        (1.0, 1.5, TRIED),
        (1.0, 2.418, 50),
        (1.0, 10.0, 40),
        (1.0, 15.0, 40),
        // Here F's valley at Brewster's angle lies between the nodes of a coarse run.
        (1.0, 24.0, 40),
        (1.0, 27.0, 40),
        (1.0, 30.0, 40),
        (1.0, 33.0, 40),
        (1.0, 100.0, 40),
        (1.0, 0.99, TRIED),
        (1.33, 1.0, 40),
        (1.5, 1.0, 40),
        (100.0, 1.0, 25),
    ] {
        let shells = Shells::ball(outside, inside);
        let rays = rays(&shells, 0.99, landed);
        let found = beams(&shells.scene(SIDE), 1e-2, 2);
        let name = format!("{inside} in {outside}");
        let (through, reflected) = (truth(&shells), reflected(&shells));
        let [_, of_reflected] = assert_as_asked(&name, &found, "LRD", &reflected, 1e-2);
        let of_through = if layer(&found, "LTTD").is_some() {
            let [off, error] = assert_as_asked(&name, &found, "LTTD", &through, 1e-2);
            format!("{off:.1e}, {error:.1e}")
        } else {
            // A bubble in an index of 100 lets 3e-7 of the light pass: less than beams follow.
            assert_eq!(outside, 100.0);
            "not followed".to_owned()
        };
        let both = error_as_asked(&found, &added(&through, &reflected), &specular(&found));
        assert!(both <= 1e-2, "{name}: {both:e}");
        println!(
            "  {name}: {of_through}, {of_reflected:.1e}, {both:.1e}; {}, {:.1e}, {:.1e}, {:.2}",
            rays.followed, rays.place, rays.flux, rays.of_allowed
        );
    }
}

#[test]
fn balls_in_balls_bend_rays_as_bouguer_says() {
    println!(
        "balls in balls: rays that land: how many, worst landing, worst flux, of what is allowed"
    );
    for depth in 1..=8_usize {
        let shells = Shells {
            radii: (0..depth).map(|i| 1.0 - 0.1 * i as f64).collect(),
            indices: std::iter::once(1.0)
                .chain((0..depth).map(|i| [1.5, 1.33, 1.7, 1.2][i % 4]))
                .collect(),
        };
        let rays = rays(&shells, 0.95, TRIED);
        println!(
            "  {depth}: {}, {:.1e}, {:.1e}, {:.2}",
            rays.followed, rays.place, rays.flux, rays.of_allowed
        );
    }
}

/// Four deep, every second index far from its neighbours' and each surface reflecting; eight deep, `LTTTTTTTTTTTTTTTTD`. All light that enters gets
/// through: n r is nowhere less than 1. What is reflected on the way in or out has other signatures.
#[test]
fn beams_through_balls_in_balls_are_as_bouguer_says() {
    println!(
        "balls in balls, all surfaces passed: of beams asked for 1e-2, worst texel and root mean square error; share of all specular light"
    );
    let [alternating, glassy]: [&[f64]; 2] = [
        &[1.0, 1.5, 1.33, 1.7, 1.2],
        &[1.0, 1.5, 1.4, 1.5, 1.4, 1.5, 1.4, 1.5, 1.4],
    ];
    for (indices, step) in [(alternating, 0.05), (glassy, 0.03)] {
        let depth = indices.len() - 1;
        let shells = Shells {
            radii: (0..depth).map(|i| 1.0 - step * i as f64).collect(),
            indices: indices.to_vec(),
        };
        assert_eq!(shells.widest_sin(), 1.0);
        let found = beams(&shells.scene(SIDE), 1e-2, 2 * depth as u32);
        let (signature, through) = (shells.signature(), truth(&shells));
        let name = format!("{depth} deep");
        let [off, error] = assert_as_asked(&name, &found, &signature, &through, 1e-2);
        assert_as_asked(&name, &found, "LRD", &reflected(&shells), 1e-2);
        let share = sum(&through) / sum(&specular(&found));
        println!("  {name}: {off:.1e}, {error:.1e}; {share:.3}");
        assert!(share > 0.9, "{name}: {share}");
    }
}

/// Water on a glass ball, the gap between their surfaces thick.
fn film(gap: f64) -> Shells {
    Shells {
        radii: vec![1.0, 1.0 - gap],
        indices: vec![1.0, 1.33, 1.5],
    }
}

/// A ray starts up to 32 u off a surface of radius 1 (16 u, and the step outward), and meets what is farther off than that.
#[test]
fn a_film_however_thin_is_not_stepped_over() {
    println!(
        "film on a ball: rays that land: how many, worst landing, worst flux, of what is allowed"
    );
    for gap in [1e-1, 1e-3, 4e-5, 1e-7, 1e-9, 1e-11, 1e-13, 64.0 * U] {
        let rays = rays(&film(gap), 0.95, TRIED);
        println!(
            "  {gap:.0e}: {}, {:.1e}, {:.1e}, {:.2}",
            rays.followed, rays.place, rays.flux, rays.of_allowed
        );
    }
}

/// Beams look for the surface that light meets first: however near the inner ball is behind the outer, it is not that.
#[test]
fn light_meets_the_film_first_and_then_the_ball() {
    println!(
        "film on a ball, LTTTTD: beams asked for 1e-2, worst texel and root mean square error"
    );
    for gap in [1e-1, 1e-3, 4e-5, 1e-7, 1e-10, 1e-12] {
        let shells = film(gap);
        let found = beams(&shells.scene(SIDE), 1e-2, 4);
        let name = format!("{gap:e}");
        let [off, error] = assert_as_asked(&name, &found, "LTTTTD", &truth(&shells), 1e-2);
        println!("  {gap:.0e}: {off:.1e}, {error:.1e}");
        // In water no ray passes farther than 1/1.33 from the centre: each meets the glass. And none meets the glass first.
        for wrong in ["LTTD", "LTTTD"] {
            assert!(
                layer(&found, wrong).is_none_or(|layer| red(layer).iter().all(|e| *e == 0.0)),
                "{gap:e}: light by way of some of four surfaces, {wrong}"
            );
        }
    }
}

fn sun(things: &str) -> Scene {
    scene(
        &format!(
            r#"<emitter type="directional"><vector name="direction" x="0.3" y="0.1" z="-1"/><rgb name="irradiance" value="1000"/></emitter>
{things}{FLOOR}"#
        ),
        None,
        SIDE,
    )
}

/// A wide flat surface.
fn surface(height: f64, below: f64, above: f64) -> String {
    format!(
        r#"<shape type="rectangle"><transform name="to_world"><scale value="5"/><translate z="{height:?}"/></transform>
<bsdf type="dielectric"><float name="int_ior" value="{below:?}"/><float name="ext_ior" value="{above:?}"/></bsdf></shape>"#
    )
}

/// Texels are 0.25 wide, and corners of light up to 10 off with some 16 roundings each: 4 · 16 u · 10 / 0.25, for each map.
#[test]
fn blocks_of_the_same_glass_with_one_surface_between_them_are_one_block() {
    let one = sun(&[surface(2.0, 1.5, 1.0), surface(1.0, 1.0, 1.5)].concat());
    let two = sun(&[
        surface(2.0, 1.5, 1.0),
        surface(1.5, 1.5, 1.5),
        surface(1.0, 1.0, 1.5),
    ]
    .concat());
    let one = red(layer(&beams(&one, 1e-3, 2), "LTTD").expect("light"));
    let two = red(layer(&beams(&two, 1e-3, 3), "LTTTD").expect("light"));
    let apart = distance(&one, &two);
    println!("matched media with a surface between them: change {apart:.1e}");
    assert!(apart <= 2.0 * 4.0 * 16.0 * U * 10.0 / 0.25, "{apart:e}");
}

/// What a scene says of surfaces at the same place.
fn coincidences(scene: &Scene) -> usize {
    let warnings = scene.warnings().iter();
    warnings
        .filter(|warning| warning.message.contains("at the same place"))
        .count()
}

#[test]
fn surfaces_at_the_same_place_are_met_once_and_the_scene_says_so() {
    // Glass that holds water with no gap at all: light enters the first declared, and never the second.
    let full = film(0.0).scene(SIDE);
    assert_eq!(coincidences(&full), 1, "{:?}", full.warnings());
    assert!(followed(&film(0.0), &full, 0.3).is_none());
    assert!(followed(&Shells::ball(1.0, 1.33), &full, 0.3).is_some());
    assert_eq!(coincidences(&film(1e-12).scene(SIDE)), 0);

    let cube = |height: f64, x: f64| {
        format!(
            r#"<shape type="cube"><transform name="to_world"><scale value="0.25"/><translate x="{x:?}" z="{height:?}"/></transform>
<bsdf type="dielectric"/></shape>"#
        )
    };
    let tube = |from: f64, to: f64| {
        format!(
            r#"<shape type="cylinder"><point name="p0" x="0" y="0" z="{from:?}"/><point name="p1" x="0" y="0" z="{to:?}"/>
<float name="radius" value="0.5"/><bsdf type="dielectric"/></shape>"#
        )
    };
    let disk = |x: f64| {
        format!(
            r#"<shape type="disk"><transform name="to_world"><scale value="0.5"/><translate x="{x:?}" z="1"/></transform>
<bsdf type="diffuse"/></shape>"#
        )
    };
    for (what, things, expected) in [
        ("a block that stands on the floor", cube(0.25, 0.0), 1),
        ("a block above it", cube(0.25 + 1e-12, 0.0), 0),
        ("a block beside the floor", cube(0.25, 2.25), 0),
        (
            "two blocks in one place",
            cube(0.75, 0.0) + &cube(0.75, 0.0),
            1,
        ),
        (
            "blocks that share an edge",
            cube(1.25, 0.5) + &cube(0.75, 0.0),
            0,
        ),
        (
            "two sheets in one plane",
            surface(1.0, 1.5, 1.0) + &surface(1.0, 1.33, 1.5),
            1,
        ),
        ("a disc on a sheet", surface(1.0, 1.5, 1.0) + &disk(0.0), 1),
        (
            "a disc that touches a sheet's side",
            surface(1.0, 1.5, 1.0) + &disk(5.5),
            0,
        ),
        ("tubes that overlap", tube(1.0, 2.0) + &tube(1.5, 3.0), 1),
        ("tubes end to end", tube(1.0, 2.0) + &tube(2.0, 3.0), 0),
        ("nothing that refracts", disk(0.0) + &disk(0.1), 0),
    ] {
        let scene = sun(&things);
        assert_eq!(
            coincidences(&scene),
            expected,
            "{what}: {:?}",
            scene.warnings()
        );
    }
}
