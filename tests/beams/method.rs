//! Beams as a method: balance, determinism, what they refuse and when they stop; and two independent
//! witnesses of their results, photons and root finding.

use std::f64::consts::TAU;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::OnceLock;
use std::time::Duration;

use glam::DVec2;
use nephroid::internals::film::exr;
use nephroid::internals::mitsuba;
use nephroid::internals::reference::beams::pass::SignatureReport;
use nephroid::internals::reference::beams::run::Setup;
use nephroid::internals::reference::beams::supports;
use nephroid::internals::reference::beams::{BeamReport, BeamSettings};
use nephroid::internals::run::Budget;
use nephroid::internals::run::{Estimate, LayerName, Progress};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::chain::ChainSettings;
use nephroid::internals::transport::receiver::Receiver;

use crate::support::beams::{beams, held, known_by};
use crate::support::oracles::{DEPTH, dish_fluxes};
use crate::support::probes::{of, probe_at, sum};
use crate::support::scenes::meter;
use crate::support::{Compared, Photons, bundled, bundled_file, scene_files};

/// The shipped scenes whose light all comes from points or from infinity.
const SCENES: [&str; 18] = [
    "glass-ball",
    "glass-ball-mesh",
    "coffee-cup",
    "mirror-ring",
    "water",
    "pool",
    "prism",
    "cube",
    "diamond",
    "lens",
    "cornell-caustics",
    "parabolic-mirror",
    "turntable-ball",
    "turntable-cube",
    "turntable-prism",
    "turntable-ring",
    "turntable-bumpy",
    "turntable-terrain",
];

// ---- balance ------------------------------------------------------------------------------------

/// A shipped scene at 64 x 64 texels, to a tenth.
struct Coarse {
    name: &'static str,
    scene: Scene,
    estimate: Estimate,
    report: BeamReport,
}

/// All of them, run once for all tests.
fn coarse() -> &'static [Coarse] {
    static RUNS: OnceLock<Vec<Coarse>> = OnceLock::new();
    RUNS.get_or_init(|| {
        let run = |name| {
            let scene = bundled(name, 64);
            let (estimate, report) = beams(&scene, 0.1);
            Coarse {
                name,
                scene,
                estimate,
                report,
            }
        };
        SCENES.map(run).into_iter().collect()
    })
}

/// Sums on the film are integers, of a quantum of 2⁻⁶² of the flux or less; each of n deposits in a texel is
/// rounded once. 10⁶ deposits are off by 10⁶ · 2⁻⁶² · 64 < 1e-11 of a texel's flux at the very worst, by the
/// root of that at random: 1e-12 of all light is asked for.
#[test]
fn the_films_sum_is_what_the_cells_booked_in_every_signature() {
    for Coarse { name, report, .. } in coarse() {
        assert!(!report.signatures.is_empty(), "{name}");
        for one in &report.signatures {
            assert!(
                one.balance_error <= 1e-12,
                "{name} {}: {:e}",
                one.name,
                one.balance_error
            );
        }
    }
}

/// The extrapolated sums of dark texels may be below zero; the values are not, and lie in their bounds, layer
/// by layer and all together. The ledger has their sums: a thousand additions of flux that is a part of the
/// whole.
#[test]
fn values_lie_within_their_bounds_and_the_ledger_has_their_sums() {
    let mut lifted = 0;
    for Coarse {
        name,
        scene,
        estimate,
        report,
    } in coarse()
    {
        let receiver = Receiver::new(scene, meter(scene)).unwrap();
        for layer in std::iter::once(&estimate.total).chain(&estimate.layers) {
            let bounds = layer.interval.as_ref().unwrap();
            for (texel, value) in layer.values.iter().enumerate() {
                let (low, high) = (bounds.low[texel], bounds.high[texel]);
                for channel in 0..3 {
                    let inside = low.0[channel]..=high.0[channel];
                    assert!(
                        low.0[channel] >= 0.0 && inside.contains(&value.0[channel]),
                        "{name} {} texel {texel}: {value:?} outside {inside:?}",
                        layer.name
                    );
                }
            }
            let LayerName::Path(signature) = layer.name else {
                continue;
            };
            let texels = layer.values.iter().enumerate();
            let sum: f64 = texels
                .map(|(texel, value)| value.mean() * receiver.texel_area(texel))
                .sum();
            if let Some(row) = estimate.ledger.rows.get(&signature) {
                let said = row.received.mean();
                assert!((sum - said).abs() <= 1e-12 * said, "{name} {}", layer.name);
                let own = |one: &&SignatureReport| one.name == layer.name.to_string();
                let Some(booked) = report.signatures.iter().find(own) else {
                    // Photons measured it.
                    assert!(report.by_photons.is_some(), "{name} {}", layer.name);
                    continue;
                };
                lifted += u32::from(said > booked.received.mean() * (1.0 + 1e-9));
            }
        }
        assert_eq!(estimate.ledger.closure_error(), None);
    }
    // Else there was nothing to test.
    assert!(lifted > 0, "no texel of any scene was below zero");
}

/// The lamp stands at a distance D = 2.6 of a ball of radius 1: its solid angle is 2π (1 − cos asin(1/D)).
///
/// All signatures' cells cover that angle, and sum it up by three points a cell, on cells that are as
/// fine as that signature needs. A cell of angular size h errs by h⁴ or, at the terminator, where
/// emission begins with a kink, by h² of its own light; a cell ends with at most 1/16 of the light of a root
/// (level 2, as the discovery's 2¹⁴ nodes and the first tolerance ask for): 1e-3.
#[test]
fn what_sets_out_towards_the_ball_is_its_solid_angle() {
    let (_, report) = beams(&bundled("glass-ball", 64), 1e-3);
    let exact = 100.0 * TAU * (1.0 - (1.0_f64 - 1.0 / (2.6 * 2.6)).sqrt());
    for one in &report.signatures {
        println!("{}: {:.2e}", one.name, one.emitted / exact - 1.0);
        assert!((one.emitted / exact - 1.0).abs() < 1e-3, "{}", one.name);
    }
}

// ---- the same bits ------------------------------------------------------------------------------

/// Every bit of a result.
fn bits((estimate, report): &(Estimate, BeamReport)) -> Vec<u64> {
    let mut bits = vec![estimate.paths];
    for layer in std::iter::once(&estimate.total).chain(&estimate.layers) {
        let bounds = layer.interval.as_ref().unwrap();
        for values in [&layer.values, &bounds.low, &bounds.high] {
            bits.extend(values.iter().flat_map(|value| value.0.map(f64::to_bits)));
        }
    }
    bits.push(estimate.relative_error.map_or(0, f64::to_bits));
    let counters = estimate.counters;
    bits.extend([
        counters.rays,
        counters.node_visits,
        counters.primitive_tests,
    ]);
    for one in &report.signatures {
        bits.extend([one.cells, one.cut_cells, one.unresolved_cells]);
        bits.extend([one.emitted.to_bits(), one.balance_error.to_bits()]);
        bits.extend(one.received.0.map(f64::to_bits));
        bits.extend(one.uncertain.0.map(f64::to_bits));
    }
    bits
}

#[test]
fn one_two_three_and_eight_threads_give_the_same_bits() {
    // A ball, mirrors, flat facets, interpolated normals and three channels; and a prism of five facets above
    // hills, of whose light one thread leaves most to the others.
    for (name, error) in [
        ("glass-ball", 0.01),
        ("coffee-cup", 0.01),
        ("cube", 0.01),
        ("parabolic-mirror", 0.01),
        ("turntable-terrain", 0.1),
    ] {
        let scene = bundled(name, 48);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build()
                .unwrap()
                .install(|| bits(&beams(&scene, error)))
        };
        let alone = on(1);
        for threads in [2, 3, 8] {
            assert!(on(threads) == alone, "{name} differs on {threads} threads");
        }
    }
}

fn nephroid(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_nephroid"))
        .args(arguments)
        .output()
        .unwrap()
}

fn render(scene: &str, arguments: &[&str], output: &Path) -> Output {
    let scene = bundled_file(scene);
    let common = ["render", scene.to_str().unwrap(), "-D", "size=48", "-o"];
    nephroid(&[&common[..], &[output.to_str().unwrap()], arguments].concat())
}

#[test]
fn files_are_the_same_on_any_threads_but_for_their_timing_and_work() {
    let folder = tempfile::tempdir().unwrap();
    let image = |threads: &str| {
        let path = folder.path().join(format!("{threads}.exr"));
        let done = render(
            "glass-ball",
            &["--error", "1%", "--threads", threads],
            &path,
        );
        assert!(done.status.success());
        let mut image = exr::read(&path).unwrap();
        image
            .metadata
            .retain(|(key, _)| key != "timing" && key != "summary");
        image
    };
    let alone = image("1");
    for channel in ["E.lo.R", "E.hi.B", "LTTD.lo.G", "LTTD.hi.R"] {
        assert!(alone.channel(channel).is_some(), "{channel}");
    }
    assert!(alone.channel("E.stderr.R").is_none());
    for threads in ["2", "3", "8"] {
        assert!(image(threads) == alone, "{threads} threads");
    }
}

// ---- photons as a witness -----------------------------------------------------------------------

/// The probability that a right program fails a test of photons against beams.
const ALPHA: f64 = 1e-6;

/// More than the comparisons made: 10 scenes of at most 10 layers of 64 x 64 texels.
const COMPARISONS: usize = 400_000;

/// In each layer that has a thousandth of the light or more, photons (32 replicates) scatter about beams as
/// their error bars say: each z-score is below Student's quantile (Bonferroni's bound on Šidák's), and where
/// there are enough texels, their mean and variance are Student's. A z-score is taken from the nearer end of
/// the beams' bounds, and where a scene has 300 texels to judge, from the beams' answer itself, whose error
/// is far below the photons'. Where light is spread over all 64 x 64 texels, it takes 2²¹ photons for 30 in
/// each and every replicate.
fn assert_photons_agree(name: &str, error: f64, count: u64) {
    let scene = bundled(name, 64);
    let (estimate, report) = beams(&scene, error);
    let mut photons = Photons::new(count);
    photons.settings.max_layers = 64;
    photons.settings.chains = ChainSettings {
        max_depth: DEPTH,
        ..ChainSettings::default()
    };
    let witness = photons.estimate(&scene);
    let flux: f64 = report
        .signatures
        .iter()
        .map(|one| one.received.mean())
        .sum();
    let mut judged = 0;
    for (layer, known) in estimate.layers.iter().zip(known_by(&estimate)).skip(1) {
        let signature = known.signature.to_string();
        let own = report.signatures.iter().find(|one| one.name == signature);
        if own.is_none_or(|own| own.received.mean() < 1e-3 * flux) {
            continue;
        }
        let answer: Vec<f64> = layer.values.iter().map(|value| value.0[0]).collect();
        let ones = vec![1.0; answer.len()];
        let per_irradiance = Compared::new(&scene, &photons, &witness, &signature, &ones).photons;
        let mut it = Compared::new(&scene, &photons, &witness, &signature, &answer);
        let about = it.agreement();
        println!("{name} {signature}: {about:?}");
        if about.texels >= 300 {
            it.assert_honest_errors(300, ALPHA, COMPARISONS);
        }
        judged += about.texels;
        // Where beams see nothing, photons tell which texels can be judged: a thousand of them are no chance.
        for texel in 0..answer.len() {
            it.photons[texel] = it.estimate[texel].max(answer[texel]) * per_irradiance[texel];
        }
        (it.low, it.high) = (known.low, known.high);
        it.assert_every_texel_agrees(0, ALPHA, COMPARISONS);
    }
    assert!(judged >= 30, "{name}: {judged} texels judged");
    // And what photons find, beams find.
    let total: f64 = witness
        .ledger
        .rows
        .values()
        .map(|row| row.received.mean())
        .sum();
    for (signature, row) in &witness.ledger.rows {
        let share = row.received.mean() / total;
        let wanted = LayerName::Path(*signature);
        assert!(
            share < 1e-3 || estimate.layers.iter().any(|layer| layer.name == wanted),
            "{name}: {signature}, {share:.1e} of the light, is not followed"
        );
    }
}

#[test]
fn photons_agree_with_beams_on_the_glass_ball() {
    assert_photons_agree("glass-ball", 1e-3, 1 << 20);
}

#[test]
#[ignore = "ten seconds each: cargo test --release --test beams method:: -- --ignored"]
fn photons_agree_with_beams_on_the_ball_of_triangles() {
    assert_photons_agree("glass-ball-mesh", 1e-3, 1 << 20);
}

#[test]
fn photons_agree_with_beams_in_the_coffee_cup() {
    assert_photons_agree("coffee-cup", 1e-3, 1 << 20);
}

#[test]
fn photons_agree_with_beams_in_the_mirror_ring() {
    assert_photons_agree("mirror-ring", 1e-3, 1 << 20);
}

#[test]
fn photons_agree_with_beams_below_ripples() {
    assert_photons_agree("water", 1e-3, 1 << 21);
}

#[test]
fn photons_agree_with_beams_in_the_pool() {
    assert_photons_agree("pool", 1e-3, 1 << 23);
}

#[test]
fn photons_agree_with_beams_below_the_prism() {
    assert_photons_agree("prism", 1e-3, 1 << 20);
}

#[test]
#[ignore = "ten seconds each: cargo test --release --test beams method:: -- --ignored"]
fn photons_agree_with_beams_behind_the_lens() {
    assert_photons_agree("lens", 1e-3, 1 << 20);
}

#[test]
#[ignore = "ten seconds each: cargo test --release --test beams method:: -- --ignored"]
fn photons_agree_with_beams_above_the_dish() {
    assert_photons_agree("parabolic-mirror", 1e-3, 1 << 21);
}

// ---- root finding as a witness ------------------------------------------------------------------

/// Where light is smooth, the mean of the pointwise irradiance at 2 x 2 Gauss points is the texel's, but for
/// (h/L)⁴/4320 of it, with h the texel and L the length on which light changes: below 1e-7 in texels that
/// differ by less than a tenth from their neighbours. It lies within the bounds.
#[test]
fn probes_lie_within_the_bounds_where_light_is_smooth() {
    const SIDE: usize = 256;
    const GAUSS: f64 = 0.288_675_134_594_812_9;
    let scene = bundled("glass-ball", SIDE);
    let (estimate, _) = beams(&scene, 1e-3);
    let known = known_by(&estimate);
    let layer = known
        .iter()
        .find(|one| one.signature.to_string() == "LTTD")
        .unwrap();
    let is_smooth = |at: usize| {
        [1, SIDE].iter().all(|step| {
            [at - step, at + step]
                .iter()
                .all(|near| (layer.truth(*near) / layer.truth(at) - 1.0).abs() < 0.1)
        })
    };
    let mut probed = 0;
    for at in (SIDE + 1..SIDE * (SIDE - 1) - 1).step_by(37) {
        if probed == 5 || layer.low[at] == 0.0 || !is_smooth(at) {
            continue;
        }
        let middle = DVec2::new((at % SIDE) as f64 + 0.5, (at / SIDE) as f64 + 0.5);
        let mean = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
            .iter()
            .map(|&(x, y)| {
                let place = (middle + DVec2::new(x, y) * GAUSS) * (4.0 / SIDE as f64) - 2.0;
                sum(&of(&probe_at(&scene, 2.0, place, 2), "LTTD"))
            })
            .sum::<f64>()
            / 4.0;
        let allowed = 1e-7 * mean;
        assert!(
            (layer.low[at] - allowed..=layer.high[at] + allowed).contains(&mean),
            "texel {at}: {mean} beside {}..{}",
            layer.low[at],
            layer.high[at]
        );
        probed += 1;
    }
    assert!(probed >= 5, "{probed}");
}

// ---- colours --------------------------------------------------------------------------------------

/// As in `tests/photons/closed_forms/`: the paraboloid's flux, without the receiver's shadow and without
/// the slivers between the rim's polygon and the circle; normals of the mesh are known to 1e-6 of the flux.
#[test]
fn each_channel_of_a_coloured_metal_has_its_own_flux() {
    let scene = bundled("parabolic-mirror", 64);
    let (estimate, report) = beams(&scene, 1e-3);
    let received = report.signatures[0].received;
    for (channel, flux) in dish_fluxes().into_iter().enumerate() {
        let off = (received.0[channel] / flux - 1.0).abs();
        println!("channel {channel}: off by {off:.1e}");
        assert!(off <= 1e-3, "channel {channel}: {off:e}");
        let sum = |values: &[nephroid::internals::radiometry::Rgb]| {
            values.iter().map(|value| value.0[channel]).sum::<f64>() * 0.0256 / 4096.0
        };
        let bounds = estimate.layers[1].interval.as_ref().unwrap();
        let (low, high) = (sum(&bounds.low), sum(&bounds.high));
        assert!(low * (1.0 - 1e-6) <= flux && flux <= high * (1.0 + 1e-6));
    }
    assert!(received.0[0] != received.0[1] && received.0[1] != received.0[2]);
}

// ---- what beams refuse ----------------------------------------------------------------------------

const MASKED: &str = r#"<scene version="3.0.0">
    <emitter type="point"><point name="position" x="0" y="0" z="3"/></emitter>
    <shape type="sphere" id="veil">
        <transform name="to_world"><translate z="1.5"/></transform>
        <bsdf type="mask">
            <float name="opacity" value="0.5"/>
            <bsdf type="dielectric"/>
        </bsdf>
    </shape>
    <shape type="rectangle">
        <bsdf type="diffuse"/>
        <sensor type="irradiancemeter">
            <film type="hdrfilm">
                <integer name="width" value="16"/><integer name="height" value="16"/>
                <rfilter type="box"/>
            </film>
        </sensor>
    </shape>
</scene>"#;

fn masked() -> (tempfile::TempDir, Scene) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("masked.xml");
    std::fs::write(&file, MASKED).unwrap();
    let scene = mitsuba::load(&file, &[]).unwrap();
    (folder, scene)
}

#[test]
fn half_open_masks_are_refused_by_name() {
    let (_folder, scene) = masked();
    let message = supports(&scene).unwrap_err().to_string();
    assert!(
        message.contains("half open mask \"veil\"") && message.contains("use photons"),
        "{message}"
    );
}

/// A lamp, a glass ball and a floor; the lamp's radiance is given.
fn lit_by_a_lamp(radiance: &str) -> Scene {
    let parts = scene_files::scene(&format!(
        r#"<emitter type="point"/>
           <shape type="disk" id="lamp"><emitter type="area"><rgb name="radiance" value="{radiance}"/></emitter></shape>
           <shape type="sphere"><bsdf type="dielectric"/></shape>
           <shape type="rectangle"><sensor type="irradiancemeter"/></shape>"#
    ));
    Scene::new(parts.unwrap()).unwrap()
}

#[test]
fn area_lights_are_refused_by_emitter_and_shape_if_they_shine() {
    let message = supports(&lit_by_a_lamp("0, 1, 0")).unwrap_err().to_string();
    for part in ["emitter 1", "area light", "shape \"lamp\"", "use photons"] {
        assert!(message.contains(part), "{part} is not in {message}");
    }
    assert_eq!(supports(&lit_by_a_lamp("0")), Ok(()));
}

#[test]
fn the_commands_default_is_beams_where_they_can_follow_all_light_and_photons_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a.exr");
    let method = |output: Output| {
        let text = String::from_utf8(output.stdout).unwrap();
        let json: serde_json::Value = serde_json::from_str(&text).unwrap();
        json["method"].as_str().unwrap().to_owned()
    };
    let short = ["--json", "--error", "50%"];
    assert_eq!(method(render("glass-ball", &short, &out)), "beams");
    let masked = masked();
    let arguments = [
        "render",
        masked.1.path().to_str().unwrap(),
        "--json",
        "--error",
        "50%",
        "-o",
        out.to_str().unwrap(),
    ];
    assert_eq!(method(nephroid(&arguments)), "photons");
}

// ---- when beams stop --------------------------------------------------------------------------------

fn run(scene: &Scene, budget: &Budget, stop: bool) -> (Estimate, BeamReport) {
    let progress = Progress::default();
    if stop {
        progress.stop();
    }
    Setup::new(scene, meter(scene), BeamSettings::default(), &progress)
        .and_then(|mut setup| setup.run(budget))
        .unwrap()
}

/// Before the first pass there is nothing to show but that nothing is known.
fn assert_nothing_is_known((estimate, report): &(Estimate, BeamReport)) {
    assert!(estimate.incomplete);
    assert_eq!(report.passes, 0);
    assert_eq!(estimate.relative_error, None);
    let bounds = estimate.total.interval.as_ref().unwrap();
    let all = bounds.low.iter().chain(&bounds.high);
    let mut all = all.chain(&estimate.total.values);
    assert!(all.all(|value| value.0.iter().all(|channel| channel.is_nan())));
}

#[test]
fn stopped_at_once_a_run_says_that_nothing_is_known() {
    let scene = bundled("glass-ball", 16);
    assert_nothing_is_known(&run(&scene, &Budget::default(), true));
}

#[test]
fn without_any_time_a_run_says_that_nothing_is_known() {
    let scene = bundled("glass-ball", 16);
    let budget = Budget {
        time: Some(Duration::ZERO),
        ..Budget::default()
    };
    assert_nothing_is_known(&run(&scene, &budget, false));
    let folder = tempfile::tempdir().unwrap();
    let output = render(
        "glass-ball",
        &["--time", "0s"],
        &folder.path().join("a.exr"),
    );
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("nothing is known of the caustic"), "{text}");
}

#[test]
fn a_limit_on_rays_ends_the_passes_and_keeps_what_they_found() {
    let scene = bundled("glass-ball", 64);
    let passes = |rays: u64| {
        let budget = Budget {
            work: Some(rays),
            ..Budget::default()
        };
        run(&scene, &budget, false)
    };
    assert_nothing_is_known(&passes(1));
    // Direct light and a first pass take less than this.
    let enough = 6_000_000;
    let (few, first) = passes(enough);
    assert!(first.passes >= 1 && !few.incomplete);
    assert!(few.counters.rays <= enough);
    let (more, report) = passes(4 * enough);
    assert!(report.passes > first.passes);
    assert!(more.counters.rays <= 4 * enough);
    assert!(more.relative_error < few.relative_error);
}

#[test]
fn a_smaller_error_is_a_smaller_error() {
    let scene = bundled("glass-ball", 64);
    let (fine, _) = beams(&scene, 1e-4);
    let known = known_by(&fine);
    let errors = [1e-1, 1e-2, 1e-3].map(|error| {
        let (estimate, _) = beams(&scene, error);
        let layer = estimate
            .layers
            .iter()
            .find(|layer| layer.name.to_string() == "LTTD")
            .unwrap();
        let truth = known
            .iter()
            .find(|one| one.signature.to_string() == "LTTD")
            .unwrap();
        let middle: Vec<f64> = (0..64 * 64).map(|texel| truth.truth(texel)).collect();
        held(layer, &middle, &middle).rmse
    });
    assert!(errors[0] > errors[1] && errors[1] > errors[2], "{errors:?}");
}

/// The summary in the file tells how many rays there were, and `--rays` stops by their number.
#[test]
fn rays_are_as_many_on_any_threads() {
    let scene = bundled("glass-ball", 48);
    let rays = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let run = || beams(&scene, 0.01).0.counters.rays;
        pool.build().unwrap().install(run)
    };
    let alone = rays(1);
    for threads in [2, 3, 8] {
        assert_eq!(rays(threads), alone, "{threads} threads");
    }
}

#[test]
#[ignore = "ten seconds each: cargo test --release --test beams method:: -- --ignored"]
fn photons_agree_with_beams_below_the_cube() {
    assert_photons_agree("cube", 1e-3, 1 << 20);
}

#[test]
fn photons_agree_with_beams_below_the_diamond() {
    assert_photons_agree("diamond", 1e-2, 1 << 22);
}
