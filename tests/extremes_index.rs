//! Indices of refraction near 1, far from 1, inside out, matched, nested, and with next to nothing between them.
//!
//! The oracle is a body of concentric balls under a lamp: light stays in a plane through the axis, and n r sin θ is the same
//! all along a ray (Bouguer; Born and Wolf, *Principles of Optics*, 7th edition, 3.2.2 (7)).

mod extremes_support;

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write as _;

use extremes_support::{U, beams, distance, layer, photons, red, scene};
use glam::{DVec2, DVec3};
use nephroid::geometry::{Ray, TraversalCounters};
use nephroid::optics::dielectric_reflectance;
use nephroid::reference::closed_form::{RadialMap, RadialSheet, TexelGrid};
use nephroid::reference::{Estimate, Layer};
use nephroid::scene::Scene;
use nephroid::transport::chain::{Arrival, ChainSettings, ChainSink, ChainTracer};
use nephroid::transport::flux::Flux;
use nephroid::transport::ledger::Fate;
use nephroid::transport::signature::Signature;

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

    /// The ray that meets the outermost ball at this sine.
    fn ray(&self, sin: f64, azimuth: f64) -> Ray {
        let sin = self.radii[0] / (LAMP - CENTER) * sin;
        let across = DVec2::from_angle(azimuth) * sin;
        let direction = across.extend(-((1.0 - sin) * (1.0 + sin)).sqrt());
        Ray::new(DVec3::Z * LAMP, direction)
    }

    fn xml(&self) -> String {
        let mut xml = format!(
            r#"<emitter type="point"><point name="position" x="0" y="0" z="{LAMP:?}"/><rgb name="intensity" value="{INTENSITY:?}"/></emitter>"#
        );
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

/// The worst difference of landings from the closed form, and of flux left, over rays up to `most` of the widest.
fn worst_landing(shells: &Shells, most: f64) -> (f64, f64) {
    let scene = shells.scene(1);
    let (mut off_place, mut off_flux) = (0.0_f64, 0.0_f64);
    for step in 1..60 {
        let sin = shells.widest_sin() * most * f64::from(step) / 60.0;
        let Some((radius, passed)) = shells.landing(sin) else {
            continue;
        };
        if radius.abs() > HALF * 0.99 {
            continue;
        }
        let Some((position, flux)) = followed(shells, &scene, sin) else {
            panic!("{shells:?}: sin i {sin} does not land");
        };
        let expected = DVec2::from_angle(0.3) * radius;
        off_place = off_place.max((position.truncate() - expected).length());
        off_flux = off_flux.max((flux / passed - 1.0).abs());
    }
    (off_place, off_flux)
}

/// How far the truth is beyond a layer's bounds, and its error, relative to the brightest texel.
fn judged(layer: &Layer, truth: &[f64]) -> (f64, f64) {
    let bounds = layer.interval.as_ref().expect("beams have bounds");
    let brightest = truth.iter().copied().fold(0.0, f64::max);
    let beyond = truth.iter().enumerate().map(|(texel, truth)| {
        (bounds.low[texel].0[0] - truth).max(truth - bounds.high[texel].0[0])
    });
    let worst = beyond.fold(
        0.0,
        |worst: f64, one| if one.is_nan() { one } else { worst.max(one) },
    );
    (worst / brightest, distance(truth, &red(layer)))
}

const SIDE: usize = 16;

fn sum(values: &[f64]) -> f64 {
    values.iter().sum()
}

/// All light on the receiver.
fn total(estimate: &Estimate) -> Vec<f64> {
    red(&estimate.total)
}

#[test]
fn glass_that_is_next_to_nothing_changes_next_to_nothing() {
    println!("index 1 + x: change of all light, relative to no ball at all, by beams and photons");
    let nothing = scene(
        &format!(
            r#"<emitter type="point"><point name="position" x="0" y="0" z="{LAMP:?}"/><rgb name="intensity" value="{INTENSITY:?}"/></emitter>{FLOOR}"#
        ),
        None,
        SIDE,
    );
    let nothing = total(&beams(&nothing, 1e-3, 3));
    for away in [
        1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 0.0, -1e-12, -1e-6,
    ] {
        let shells = Shells::ball(1.0, 1.0 + away);
        let scene = shells.scene(SIDE);
        let found = beams(&scene, 1e-3, 3);
        let by_photons = photons(&scene, 1 << 16, 3);
        let truth = shells.sheet().map(&TexelGrid::square(HALF, SIDE));
        let (beyond, off) = judged(layer(&found, "LTTD").expect("light through"), &truth);
        println!(
            "  {away:+.0e}: {:.1e}, {:.1e}; LTTD off by {off:.1e}, beyond {beyond:.1e}; sums {:+.1e} {:+.1e}",
            distance(&nothing, &total(&found)),
            distance(&nothing, &total(&by_photons)),
            sum(&total(&found)) / sum(&nothing) - 1.0,
            sum(&total(&by_photons)) / sum(&nothing) - 1.0,
        );
    }
}

#[test]
fn dense_glass_and_bubbles_are_as_the_closed_form_has_them() {
    println!(
        "LTTD of a ball by its index inside and outside: error of beams, truth beyond bounds; rays"
    );
    for (outside, inside) in [
        (1.0, 1.5),
        (1.0, 2.418),
        (1.0, 10.0),
        (1.0, 100.0),
        (1.5, 1.0),
        (1.33, 1.0),
        (100.0, 1.0),
        (1.0, 0.99),
    ] {
        let shells = Shells::ball(outside, inside);
        let truth = shells.sheet().map(&TexelGrid::square(HALF, SIDE));
        let scene = shells.scene(SIDE);
        let found = beams(&scene, 1e-2, 3);
        let landings = worst_landing(&shells, 0.99);
        match layer(&found, "LTTD") {
            Some(layer) => {
                let (beyond, off) = judged(layer, &truth);
                println!(
                    "  {inside} in {outside}: {off:.1e}, {beyond:.1e}; {:.1e} {:.1e}",
                    landings.0, landings.1
                );
            }
            None => println!("  {inside} in {outside}: none, truth {:e}", sum(&truth)),
        }
    }
}

#[test]
fn balls_in_balls_bend_rays_as_bouguer_says() {
    println!("nested balls: landings of rays beside the closed form, and their flux");
    for depth in 1..=8_usize {
        let shells = Shells {
            radii: (0..depth).map(|i| 1.0 - 0.1 * i as f64).collect(),
            indices: std::iter::once(1.0)
                .chain((0..depth).map(|i| [1.5, 1.33, 1.7, 1.2][i % 4]))
                .collect(),
        };
        let (place, flux) = worst_landing(&shells, 0.95);
        println!("  {depth}: {place:.1e} {flux:.1e}");
    }
}

#[test]
fn a_film_however_thin_is_not_stepped_over() {
    println!("film of water on a glass ball: landings beside the closed form, and their flux");
    for gap in [1e-1, 1e-3, 4e-5, 1e-7, 1e-9, 1e-11, 1e-13, 1e-14] {
        let shells = Shells {
            radii: vec![1.0, 1.0 - gap],
            indices: vec![1.0, 1.33, 1.5],
        };
        let (place, flux) = worst_landing(&shells, 0.95);
        println!("  {gap:.0e}: {place:.1e} {flux:.1e}");
    }
}

#[test]
fn touching_blocks_of_the_same_glass_are_one_block() {
    let block = |things: &str| {
        scene(
            &format!(
                r#"<emitter type="directional"><vector name="direction" x="0.3" y="0.1" z="-1"/><rgb name="irradiance" value="1000"/></emitter>
{things}{FLOOR}"#
            ),
            None,
            SIDE,
        )
    };
    let surface = |height: f64, below: f64, above: f64| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><scale value="5"/><translate z="{height:?}"/></transform>
<bsdf type="dielectric"><float name="int_ior" value="{below:?}"/><float name="ext_ior" value="{above:?}"/></bsdf></shape>"#
        )
    };
    let one = block(&[surface(2.0, 1.5, 1.0), surface(1.0, 1.0, 1.5)].concat());
    let two = block(
        &[
            surface(2.0, 1.5, 1.0),
            surface(1.5, 1.5, 1.5),
            surface(1.0, 1.0, 1.5),
        ]
        .concat(),
    );
    let one_map = red(layer(&beams(&one, 1e-3, 3), "LTTD").expect("light"));
    let two_map = red(layer(&beams(&two, 1e-3, 3), "LTTTD").expect("light"));
    println!("touching blocks: {:.1e}", distance(&one_map, &two_map));
    assert!(distance(&one_map, &two_map) <= 64.0 * U);
}
