//! Very many, very few, very large, very small: sums, photons, texels, bounces (docs/accuracy.md, 7).

use glam::DVec3;
use nephroid::internals::film::Accumulator;
use nephroid::internals::geometry::{Ray, TraversalCounters};
use nephroid::internals::numeric::{ExactSum, FixedPoint};
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::reference::photons::run::Setup;
use nephroid::internals::run::{Estimate, LayerName, Progress};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::chain::{Arrival, ChainSettings, ChainSink, ChainTracer};
use nephroid::internals::transport::flux::Flux;
use nephroid::internals::transport::ledger::Fate;
use nephroid::internals::transport::signature::Signature;
use rayon::prelude::*;

use crate::support::beams::{beams, beams_to};
use crate::support::chains::light;
use crate::support::scenes::{Photons, bundled, layer, meter, over_floor, sensor_area};

/// A weight of 24 decades and its exact value in units of 2⁻⁵¹: twelve bits, shifted by up to 79.
fn weight(index: u64) -> (f64, i128) {
    // SplitMix64: any 64 bits will do, as long as all exponents come up.
    let mut bits = index.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits ^= bits >> 27;
    let mantissa = 0x800 | (bits & 0x7ff);
    let shift = (bits >> 16) % 80;
    let value = mantissa as f64 * 2f64.powi(shift as i32 - 51);
    (value, i128::from(mantissa) << shift)
}

/// Weights from 2⁻⁴⁰ to 2⁴⁰, 1e-12 to 1e12, are summed by integers beside: 2³⁴ of them below 2⁴⁰⁺⁵¹ stay
/// below 2¹²⁵. An `i128` converts to `f64` with one rounding to nearest, and 2⁻⁵¹ of it is exact: no
/// tolerance.
fn assert_sum_is_exact(count: u64) {
    const TASK: u64 = 1 << 20;
    let (sum, exact) = (0..count.div_ceil(TASK))
        .into_par_iter()
        .map(|task| {
            let (mut sum, mut exact) = (ExactSum::new(), 0i128);
            for index in task * TASK..((task + 1) * TASK).min(count) {
                let (value, integer) = weight(index);
                sum.add(value);
                exact += integer;
            }
            (sum, exact)
        })
        .reduce(
            || (ExactSum::new(), 0),
            |(mut sum, exact), (other, more)| {
                sum.merge(&other);
                (sum, exact + more)
            },
        );
    assert_eq!(
        sum.value(),
        exact as f64 * 2f64.powi(-51),
        "{count} weights"
    );
}

#[test]
fn ten_million_weights_of_24_decades_are_summed_to_the_last_bit() {
    assert_sum_is_exact(10_000_000);
}

#[test]
#[ignore = "two minutes"]
fn ten_thousand_million_weights_of_24_decades_are_summed_to_the_last_bit() {
    assert_sum_is_exact(10_000_000_000);
}

/// A film's quantum is 2⁻⁶⁰ of the flux that it is made for, rounded up to a power of two: each deposit is
/// off by half a quantum at most, and their sum by n halves, whatever the weights are. That, and one rounding
/// of the mean, is all.
#[test]
fn a_film_is_off_by_half_a_quantum_a_deposit_and_nothing_else() {
    const COUNT: u64 = 1 << 20;
    let exact: i128 = (0..COUNT).map(|index| weight(index).1).sum();
    let total = exact as f64 * 2f64.powi(-51);
    let scale = FixedPoint::for_total(total).unwrap();
    let mut film = Accumulator::new(1, 1, scale);
    (0..COUNT).into_par_iter().for_each(|index| {
        let quanta = scale.quantise(weight(index).0).unwrap();
        assert!(film.deposit(0, [quanta]));
    });
    film.flush().unwrap();
    let mean = film.estimate(0, 0).unwrap().mean;
    let allowed = total * (COUNT as f64 * 2f64.powi(-60) + f64::EPSILON);
    assert!(
        (mean - total).abs() <= allowed,
        "{mean:e} against {total:e}: off by {:e}, allowed {allowed:e}",
        mean - total
    );
}

/// All that arrives on the receiver \[W\].
fn received(estimate: &Estimate) -> f64 {
    let sum = estimate.ledger.sum();
    sum.received.mean() + sum.direct.mean()
}

/// The sum over texels of irradiance times area \[W\], direct light left out.
fn caustic_flux(scene: &Scene, estimate: &Estimate) -> f64 {
    let texels = estimate.total.values.len();
    let sum: ExactSum = estimate
        .layers
        .iter()
        .filter(|layer| !matches!(layer.name, LayerName::Path(path) if path.is_empty()))
        .flat_map(|layer| layer.values.iter().map(|value| value.mean()))
        .collect();
    sum.value() * sensor_area(scene) / texels as f64
}

#[test]
fn one_photon_is_a_result_without_an_error_bar() {
    let scene = bundled("glass-ball", 8);
    let estimate = Photons::new(1).replicates(1).estimate(&scene);
    assert_eq!(estimate.paths, 1);
    assert_eq!(estimate.relative_error, None);
    // Where it is said at all, the error is not known; it is never said to be zero.
    for layer in estimate
        .layers
        .iter()
        .filter(|layer| layer.name != LayerName::Path("LD".parse().unwrap()))
    {
        let errors = &layer.standard_error;
        assert!(
            errors.iter().all(|error| error.0[0].is_nan()),
            "{:?}",
            layer.name
        );
    }
    // Its flux is all there is, and it is somewhere: 1 photon of at most 32 branches, rounded 2⁻⁶⁰ each; and
    // u for each of eight rows that are added up.
    let closure = estimate.ledger.closure_error().unwrap();
    assert!(
        closure <= 32.0 * 2f64.powi(-60) + 4.0 * f64::EPSILON,
        "{closure:e}"
    );
}

/// Texels share the receiver exactly: beams of one tolerance deal the same light to one texel or to 64 x 64.
/// Both know it to their bounds.
#[test]
fn one_texel_gets_what_four_thousand_get() {
    let [one, many] = [1, 64].map(|side| {
        let scene = bundled("glass-ball", side);
        let (estimate, _) = beams(&scene, 1e-3);
        let area = sensor_area(&scene) / (side * side) as f64;
        let bounds = estimate.total.interval.as_ref().unwrap();
        let flux = |values: &[nephroid::internals::radiometry::Rgb]| {
            area * values.iter().map(|value| value.mean()).sum::<f64>()
        };
        [
            flux(&bounds.low),
            flux(&estimate.total.values),
            flux(&bounds.high),
        ]
    });
    println!("one texel {one:?} W, 64 x 64 texels {many:?} W");
    assert!(
        one[0] <= many[2] && many[0] <= one[2],
        "{one:?} against {many:?}"
    );
    // One texel's value is not sharper than asked, nor is the sum of many.
    assert!(
        (one[1] / many[1] - 1.0).abs() < 2e-3,
        "{one:?} against {many:?}"
    );
}

/// The film of 2²⁶ texels: what its texels sum to is what the ledger says it received. Each photon is in one
/// texel, rounded to a quantum by both; the mean of a texel is rounded once: n 2⁻⁶⁰ + 2⁻⁵³, and the sum here
/// is exact.
#[test]
#[ignore = "a minute, and 16 GB of memory"]
fn a_film_of_8192_x_8192_texels_sums_to_what_it_received() {
    let count = 1 << 22;
    let scene = bundled("glass-ball", 8192);
    let settings = PhotonSettings {
        replicates: 2,
        max_layers: 0,
        ..PhotonSettings::default()
    };
    let estimate = Photons { settings, count }.estimate(&scene);
    let (texels, ledger) = (
        caustic_flux(&scene, &estimate),
        estimate.ledger.sum().received.mean(),
    );
    println!(
        "{texels} W in texels, {ledger} W in the ledger: {:.1e}",
        texels / ledger - 1.0
    );
    assert!((texels / ledger - 1.0).abs() <= count as f64 * 2f64.powi(-60) + 0.5 * f64::EPSILON);
}

/// The photons of a stone in which light goes on and on, followed to this many events.
fn diamond(max_depth: u32, max_layers: usize) -> Estimate {
    let scene = bundled("diamond", 16);
    let settings = PhotonSettings {
        replicates: 4,
        max_layers,
        chains: ChainSettings {
            max_depth,
            ..ChainSettings::default()
        },
        ..PhotonSettings::default()
    };
    Photons {
        settings,
        count: 1 << 16,
    }
    .estimate(&scene)
}

/// At each facet some light leaves; what is cut off falls from depth to depth, and never below what is cut
/// off later. Each ledger closes to the rounding of its photons: 2¹⁶ with some three ends each, half a
/// quantum of 2⁻⁶⁰ each.
///
/// The flux that is cut off has no closed form here (a slab has, below). But all of it has had as many events
/// as are allowed: where some is cut off at 127, paths of 127 events were followed. And they are the same
/// paths at each depth, as their choices are keyed by what happened before: so light is only ever added, in
/// each texel, to the last bit.
#[test]
fn light_is_followed_through_a_diamond_for_more_than_64_bounces() {
    let mut before = f64::INFINITY;
    let mut lit: Option<Vec<f64>> = None;
    for depth in [8, 16, 32, 64, 96, 127] {
        let estimate = diamond(depth, 8);
        let ledger = &estimate.ledger;
        let cut_off = ledger.sum().cut_off.mean() / ledger.emitted.mean();
        println!(
            "depth {depth}: {cut_off:.2e} of the light is cut off, {:.6} W received",
            received(&estimate)
        );
        assert!(
            0.0 < cut_off && cut_off < before,
            "depth {depth}: {cut_off:e} after {before:e}"
        );
        before = cut_off;
        let closure = ledger.closure_error().unwrap();
        assert!(
            closure <= 4.0 * 65536.0 * 2f64.powi(-60),
            "depth {depth}: {closure:e}"
        );
        let texels = estimate.total.values.iter().map(|value| value.0[0]);
        let texels: Vec<f64> = texels.collect();
        if let Some(less) = &lit {
            let fewer = |(less, more): (&f64, &f64)| less > more;
            assert!(!less.iter().zip(&texels).any(fewer), "depth {depth}");
            assert_ne!(less, &texels, "depth {depth}: nothing more is received");
        }
        lit = Some(texels);
    }
}

/// A slab of this index in the sun, which stands straight above: an interface 1.2 above the floor and one 1
/// above it, each of half width 1/2. Light goes up and down in it along one line, and what leaves it below
/// meets the floor.
fn slab(index: f64, side: usize) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let face = |name: &str, [inside, outside]: [f64; 2], height: f64| {
        format!(
            r#"<bsdf type="dielectric" id="{name}"><float name="int_ior" value="{inside}"/><float name="ext_ior" value="{outside}"/></bsdf>
  <shape type="rectangle">
    <transform name="to_world"><scale x="0.5" y="0.5"/><translate z="{height}"/></transform>
    <ref id="{name}"/>
  </shape>"#
        )
    };
    let things = format!(
        r#"<emitter type="directional"><vector name="direction" x="0" y="0" z="-1"/><rgb name="irradiance" value="{SUN}, {SUN}, {SUN}"/></emitter>
  {}
  {}"#,
        face("top", [index, 1.0], 1.2),
        face("bottom", [1.0, index], 1.0),
    );
    over_floor(folder.path(), &things, side)
}

/// The sun's irradiance \[W/m²\].
const SUN: f64 = 2.0;

/// Of a slab at normal incidence: F = ((n − 1) / (n + 1))², and how well the program knows F and 1 − F,
/// relatively.
///
/// Within the slab η = 1/n, cos θᵢ = 1 and (see `dielectric_reflectance`) a = (η − 1)(η + 1), off by 3 u; a +
/// 1 = η² is off by as much, and its root w = η by (1.5 n + 2) u. r_s = a / (1 + w)² is off by (3 n + 11) u
/// of it. In r_p, w + η² stands below, twice: 1.5 n² + 5 each; (η² + 1) − 1 above: n² + 1; a, two quotients
/// and a product: 6, that is (4 n² + 17) u. F is the mean of their squares, which are equal: off by the sum
/// of the two, a square's rounding, the sum's, and up to 7 u for that of η from n = 1.33 on: (4 n² + 3 n +
/// 37) u. From outside, η = n, nothing cancels: less.
struct Normal {
    reflectance: f64,
    transmittance: f64,
    of_reflectance: f64,
    of_transmittance: f64,
}

impl Normal {
    fn of(index: f64) -> Self {
        let amplitude = (index - 1.0) / (index + 1.0);
        let reflectance = amplitude * amplitude;
        // Not 1 − F, which would round off what it lacks.
        let transmittance = 4.0 * index / ((index + 1.0) * (index + 1.0));
        let of_reflectance = (4.0 * index * index + 3.0 * index + 37.0) * UNIT_ROUNDOFF;
        Self {
            reflectance,
            transmittance,
            of_reflectance,
            // The reflectance's error, and the rounding of the difference.
            of_transmittance: of_reflectance * reflectance / transmittance + UNIT_ROUNDOFF,
        }
    }

    /// The share of light that enters, is reflected so often, and leaves; and how far off that may be,
    /// relatively: each factor's error and the rounding of each product, and for the closed form 8 u a
    /// reflection (7 for the square of a quotient of sums, 1 for its product) and 4 u each for coming in and
    /// going out.
    fn passes(&self, reflections: u32) -> (f64, f64) {
        let count = f64::from(reflections);
        let share = self.transmittance.powi(2) * self.reflectance.powi(reflections as i32);
        let in_factors = count * self.of_reflectance + 2.0 * self.of_transmittance;
        (share, in_factors + 9.0 * (count + 2.0) * UNIT_ROUNDOFF)
    }
}

const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// The longest path below a slab: in, 124 reflections, out.
const MOST_REFLECTIONS: u32 = 124;

fn after(reflections: u32) -> Signature {
    let name = format!("LT{}TD", "R".repeat(reflections as usize));
    name.parse().expect("a signature")
}

/// Fate of a ray's light: what landed, by signature; what was cut off.
#[derive(Default)]
struct Ends {
    landed: Vec<(Signature, f64)>,
    cut_off: Vec<(Signature, f64)>,
}

impl ChainSink<1> for Ends {
    fn arrived(&mut self, _: &Arrival<1>, _: &mut TraversalCounters) -> Fate {
        Fate::Received
    }
    fn ended(&mut self, signature: Signature, fate: Fate, flux: Flux<1>) {
        match fate {
            Fate::Received => self.landed.push((signature, flux.0[0])),
            Fate::CutOff => self.cut_off.push((signature, flux.0[0])),
            _ => {}
        }
    }
    fn gained(&mut self, _: Flux<1>) {}
}

/// One ray and all its branches. (1 − F)² F^2m comes out below after 2m reflections; where it is followed to
/// d events, (1 − F) F^(d − 1) is cut off, all in one place. Nothing is drawn by lot, and nothing is rounded
/// but to `f64`.
#[test]
fn light_in_a_slab_is_followed_for_126_events_and_falls_by_f_at_each() {
    for index in [1.33, 2.42, 10.0, 100.0, 1000.0] {
        let scene = slab(index, 1);
        let normal = Normal::of(index);
        let (mut worst, mut of_allowed, mut longest) = (0.0_f64, 0.0_f64, 0);
        let mut check = |path: &Signature, found: f64, (expected, allowed): (f64, f64)| {
            let off = (found / expected - 1.0).abs();
            worst = worst.max(off);
            of_allowed = of_allowed.max(off / allowed);
            assert!(
                off <= allowed,
                "n = {index}, {path}: off by {off:e}, allowed {allowed:e}"
            );
        };
        for depth in [3, 8, 16, 32, 64, 65, 96, 126, 127] {
            let settings = ChainSettings {
                max_depth: depth,
                split_depth: depth,
                ..ChainSettings::default()
            };
            let ray = Ray::new(DVec3::new(0.1, 0.2, 3.0), DVec3::NEG_Z);
            let mut ends = Ends::default();
            ChainTracer::<1>::new(&scene, settings).trace(&light(ray), &mut ends);
            ends.landed.sort_unstable_by_key(|(path, _)| *path);
            // After 0, 2, 4, ... reflections it is at the lower side; what leaves by the upper one escapes.
            assert_eq!(
                ends.landed.len(),
                depth as usize / 2,
                "n = {index}, depth {depth}"
            );
            for (exit, (path, flux)) in ends.landed.iter().enumerate() {
                let reflections = 2 * exit as u32;
                assert_eq!(*path, after(reflections));
                check(path, *flux, normal.passes(reflections));
                longest = longest.max(path.len());
            }
            let [(path, flux)] = ends.cut_off[..] else {
                panic!("n = {index}, depth {depth}: cut off {:?}", ends.cut_off)
            };
            assert_eq!(path.len(), depth as usize);
            let (share, allowed) = normal.passes(depth - 1);
            check(&path, flux, (share / normal.transmittance, allowed));
        }
        println!(
            "n = {index}: up to {longest} events, off by {worst:.1e} at most, {of_allowed:.1e} of what is allowed"
        );
        assert_eq!(longest, 126);
    }
}

/// The same by a run of photons, from sun to film and ledger: each signature's layer, all its texels
/// together, has (1 − F)² F^2m of what the slab meets, and nothing is drawn by lot, as all branches are
/// followed. What the slab meets is what sets out but for what passes it by, as the ledger has them.
///
/// Each of n photons is rounded by half a quantum, below 2⁻⁶⁰ of all light, where it sets out, where it
/// passes the slab by, and where it ends: 3 n 2⁻⁶⁰ of the light. 66 rows and some conversions are rounded
/// once each: 128 u.
#[test]
fn photons_in_a_slab_fill_a_layer_for_each_of_63_exits() {
    const PHOTONS: u64 = 64;
    let index = 100.0;
    let scene = slab(index, 4);
    let settings = PhotonSettings {
        replicates: 2,
        max_layers: 64,
        chains: ChainSettings {
            max_depth: 127,
            split_depth: 127,
            ..ChainSettings::default()
        },
        ..PhotonSettings::default()
    };
    let estimate = Photons {
        settings,
        count: 2 * PHOTONS,
    }
    .estimate(&scene);
    let ledger = &estimate.ledger;
    let emitted = ledger.emitted.mean();
    let met = emitted - ledger.rows[&Signature::DIRECT].total().mean();
    assert!(met > 0.25 * emitted, "{met} W of {emitted} W meet the slab");
    let normal = Normal::of(index);
    let (mut of_allowed, mut longest) = (0.0_f64, 0);
    let mut check = |what: &str, found: f64, (share, allowed): (f64, f64)| {
        let off = (found - share * met).abs();
        let quanta = 3.0 * PHOTONS as f64 * 2f64.powi(-60) * emitted;
        let allowed = share * met * (allowed + 128.0 * UNIT_ROUNDOFF) + quanta;
        of_allowed = of_allowed.max(off / allowed);
        assert!(
            off <= allowed,
            "{what}: {found:e} W, off by {off:e}, allowed {allowed:e}"
        );
    };
    for reflections in (0..=MOST_REFLECTIONS).step_by(2) {
        let path = after(reflections);
        let expected = normal.passes(reflections);
        let name = path.to_string();
        let texels = layer(&estimate, &name, 0).0;
        let sum: ExactSum = texels.iter().copied().collect();
        let in_texels = sum.value() * sensor_area(&scene) / texels.len() as f64;
        check(&name, in_texels, expected);
        check(&name, ledger.rows[&path].received.mean(), expected);
        longest = longest.max(path.len());
    }
    // Nothing else is received, and one place cuts off.
    assert_eq!(ledger.rows.len(), 64);
    let (share, allowed) = normal.passes(126);
    let expected = (share / normal.transmittance, allowed);
    check("cut off", ledger.sum().cut_off.mean(), expected);
    println!(
        "photons: 63 layers of up to {longest} events, {of_allowed:.1e} of what is allowed at most"
    );
    assert_eq!(longest, 126);
}

/// By beams the sun itself is the measure: (1 − F)² F^2m E0 in every texel below the slab, none beside it,
/// within bounds; and to the error asked for.
#[test]
fn beams_in_a_slab_know_each_of_63_exits_within_bounds() {
    const SIDE: usize = 8;
    // For a larger one, the faintest exits are left out: the last brings 5e-4 of all.
    const ERROR: f64 = 1e-3;
    let index = 100.0;
    let (estimate, _) = beams_to(127, &slab(index, SIDE), ERROR);
    let normal = Normal::of(index);
    let (mut worst, mut widest, mut lit) = (0.0_f64, 0.0_f64, 0);
    for reflections in (0..=MOST_REFLECTIONS).step_by(2) {
        let path = after(reflections);
        let layer = estimate
            .layers
            .iter()
            .find(|layer| layer.name == LayerName::Path(path))
            .unwrap_or_else(|| panic!("{path} is not followed"));
        let bounds = layer.interval.as_ref().unwrap();
        let (share, allowed) = normal.passes(reflections);
        for texel in 0..SIDE * SIDE {
            // The slab is half as wide as the floor: its borders lie on borders of texels.
            let is_below = [texel % SIDE, texel / SIDE]
                .iter()
                .all(|at| (SIDE / 4..3 * SIDE / 4).contains(at));
            let truth = if is_below { share * SUN } else { 0.0 };
            let (low, high) = (bounds.low[texel].0[0], bounds.high[texel].0[0]);
            assert!(
                low <= truth * (1.0 + allowed) && truth * (1.0 - allowed) <= high,
                "{path}, texel {texel}: {truth:e} not in {low:e} to {high:e}"
            );
            let off = (layer.values[texel].0[0] - truth).abs() / (share * SUN);
            worst = worst.max(off);
            widest = widest.max((high - low) / (share * SUN));
            lit += usize::from(is_below);
        }
    }
    println!(
        "beams: 63 layers of up to {} events, off by {worst:.1e} at most, bounds {widest:.1e} wide",
        after(MOST_REFLECTIONS).len()
    );
    assert_eq!(lit, 63 * 16);
    assert!(worst <= ERROR, "{worst:e}");
}

#[test]
fn a_depth_that_no_signature_holds_is_refused_with_what_is_allowed() {
    let scene = bundled("diamond", 4);
    let settings = PhotonSettings {
        chains: ChainSettings {
            max_depth: 128,
            ..ChainSettings::default()
        },
        ..PhotonSettings::default()
    };
    let progress = Progress::default();
    let refusal = Setup::new(&scene, meter(&scene), settings, &progress);
    let message = refusal.err().expect("128 events are too many").to_string();
    assert!(
        message.contains("128") && message.contains("0 to 127"),
        "{message}"
    );
}

/// The same photons, however many of their signatures have a layer of their own: what has none is in `other`,
/// to the last quantum. Each of up to 66 rows of the ledger, and each texel of as many layers, is rounded
/// once: 66 u. Film and ledger have the same quanta of each photon that lands, so that they differ by such
/// roundings only: the ledger's rows and the mean of its channels (70 u), of texels a conversion, a quotient
/// by the area and its product, the area itself, a mean, and their sum (11 u).
#[test]
fn signatures_past_the_limit_are_in_the_ledger_and_in_the_last_layer() {
    let (few, many) = (diamond(32, 2), diamond(32, 64));
    let named = |estimate: &Estimate| {
        estimate
            .layers
            .iter()
            .filter(|layer| matches!(layer.name, LayerName::Path(path) if !path.is_empty()))
            .count()
    };
    assert_eq!(named(&few), 2);
    assert!(named(&many) > 16, "{}", named(&many));
    assert!(
        few.layers
            .iter()
            .any(|layer| layer.name == LayerName::Other)
    );
    let [a, b] = [&few, &many].map(|estimate| estimate.ledger.sum().received.mean());
    assert!((a / b - 1.0).abs() < 33.0 * f64::EPSILON, "{a} against {b}");
    let scene = bundled("diamond", 16);
    let [a, b] = [&few, &many].map(|estimate| caustic_flux(&scene, estimate));
    assert!((a / b - 1.0).abs() < 33.0 * f64::EPSILON, "{a} against {b}");
    for estimate in [&few, &many] {
        let (texels, ledger) = (
            caustic_flux(&scene, estimate),
            estimate.ledger.sum().received.mean(),
        );
        let off = (texels / ledger - 1.0).abs();
        println!(
            "{} layers: {texels} W in texels, {ledger} W in the ledger: off by {off:.1e}",
            named(estimate)
        );
        assert!(
            off <= 81.0 * UNIT_ROUNDOFF,
            "{texels} W in texels, {ledger} W in the ledger"
        );
    }
}
