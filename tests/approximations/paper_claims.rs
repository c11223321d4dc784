//! Claims of Wyman and Dachsbacher 2006 about their splats, as inequalities on errors measured against the
//! truth.
//!
//! Only the splat varies: refraction, hits, flux and Fresnel are exact, maps have 512² texels, and look-ups
//! are averaged over a meter of 256². The report's meshes are looked for in the folder beside the crate;
//! their tests are run by hand, and fail without them; a ball and a bumpy ball of 82,000 triangles are always there.

use std::sync::LazyLock;

use nephroid::internals::method::Method;
use nephroid::internals::run::Rendering;
use nephroid::internals::scene::Scene;
use nephroid::internals::study::attribution::Truth;

use crate::support::approximation::{
    GLASS, ball, bumpy_ball_over_floor, error, exact_but, mesh_over_floor, over_floor, rendered,
    row, scene_of, shared_mesh, truth, with_splat,
};

const SIDE: usize = 256;

/// The stand-in for scanned meshes, and its light: made once for all tests.
static BUMPY: LazyLock<(Scene, Truth)> = LazyLock::new(|| {
    let scene = bumpy_ball_over_floor(SIDE);
    let truth = truth(&scene, "LTTD", 2e-2);
    (scene, truth)
});

/// The splats that the report makes claims about.
const CLAIMED: [&str; 3] = ["fixed", "multi-resolution", "thin-lens"];

/// With those that it names as extensions; then the first four with the filter of Wyman's demo of 2008.
const SPLATS: [&str; 9] = [
    "fixed",
    "multi-resolution",
    "thin-lens",
    "thick-lens",
    "two-curvatures",
    "fixed 2008",
    "multi-resolution 2008",
    "thin-lens 2008",
    "thick-lens 2008",
];

/// A map with a splat by its name, with " 2008" for that filter.
fn of_name(splat: &str, photons: &str) -> Method {
    match splat.strip_suffix(" 2008") {
        Some(splat) => with_splat(splat, "wyman-2008", photons),
        None => with_splat(splat, "gaussian", photons),
    }
}

fn means(rendering: &Rendering) -> Vec<f64> {
    rendering
        .estimate
        .total
        .values
        .iter()
        .map(|value| value.mean())
        .collect()
}

/// Errors of some splats with 512² and 1024² photons, printed.
fn table<const N: usize>(
    name: &str,
    scene: &Scene,
    truth: &Truth,
    splats: [&str; N],
) -> [[f64; N]; 2] {
    println!(
        "| {name}, truth ± {:.1} % | {} |",
        100.0 * truth.relative_error.unwrap_or(f64::NAN),
        splats.join(" | ")
    );
    ["512", "1024"].map(|photons| {
        let found = splats.map(|splat| error(&of_name(splat, photons), scene, truth));
        println!("{}", row(&format!("N = {photons}"), &found));
        found
    })
}

/// The spectrum by octaves, finest first: Σ (mean over squares of 2ᵏ texels − mean over squares of 2ᵏ⁺¹)²,
/// over all texels; each octave has what is seen in stripes about 2ᵏ texels wide.
fn octaves(values: &[f64]) -> Vec<f64> {
    let (mut level, mut side) = (values.to_vec(), SIDE);
    let mut bands = Vec::new();
    while side > 1 {
        let half = side / 2;
        let coarser: Vec<f64> = (0..half * half)
            .map(|at| {
                let corner = at / half * 2 * side + at % half * 2;
                let four = [0, 1, side, side + 1].map(|step| level[corner + step]);
                four.iter().sum::<f64>() / 4.0
            })
            .collect();
        let squares: f64 = (0..side * side)
            .map(|at| (level[at] - coarser[at / side / 2 * half + at % side / 2]).powi(2))
            .sum();
        bands.push(squares * ((SIDE / side) as f64).powi(2));
        (level, side) = (coarser, half);
    }
    bands
}

#[test]
fn octaves_add_up_to_the_variance_and_tell_stripes_apart() {
    // Stripes four texels wide are all in the octave of squares of four against squares of eight.
    let stripes: Vec<f64> = (0..SIDE * SIDE).map(|at| (at / 4 % 2) as f64).collect();
    let bands = octaves(&stripes);
    let all = (SIDE * SIDE) as f64 / 4.0;
    for (octave, found) in bands.iter().enumerate() {
        let expected = if octave == 2 { all } else { 0.0 };
        assert_eq!(*found, expected, "{bands:?}");
    }
}

/// Two frames' mean and half difference, by texel: photons shifted within their pixels.
struct Frames {
    mean: Vec<f64>,
    /// With the variance of one frame's noise.
    noise: Vec<f64>,
}

impl Frames {
    fn of(scene: &Scene, settings: &[(&str, &str)]) -> Self {
        let one = means(&rendered(&exact_but(settings), scene));
        let both = [settings, &[("frames", "2")]].concat();
        let mean = means(&rendered(&exact_but(&both), scene));
        // The first of two is half their difference away from their mean, and their difference has twice the
        // variance.
        let pairs = one.iter().zip(&mean);
        let noise = pairs.map(|(a, b)| (a - b) * 2_f64.sqrt()).collect();
        Self { mean, noise }
    }

    /// Root mean square noise, relative to the mean over lit texels.
    fn relative(&self) -> f64 {
        let lit = self.mean.iter().filter(|value| **value > 0.0).count() as f64;
        let squares: f64 = self.noise.iter().map(|noise| noise * noise).sum();
        (squares / lit).sqrt() / (self.mean.iter().sum::<f64>() / lit)
    }

    /// Unevenness of the noise: standard deviation over mean of the noise in squares of 16 texels, each
    /// relative to the light in it, over squares that have a tenth of the mean light.
    fn unevenness(&self) -> f64 {
        const SQUARE: usize = 16;
        let all = self.mean.iter().sum::<f64>() / self.mean.len() as f64;
        let squares = SIDE / SQUARE;
        let local: Vec<f64> = (0..squares * squares)
            .filter_map(|square| {
                let corner = square / squares * SQUARE * SIDE + square % squares * SQUARE;
                let texels =
                    (0..SQUARE * SQUARE).map(|at| corner + at / SQUARE * SIDE + at % SQUARE);
                let count = (SQUARE * SQUARE) as f64;
                let light = texels.clone().map(|at| self.mean[at]).sum::<f64>() / count;
                let noise = texels.map(|at| self.noise[at].powi(2)).sum::<f64>() / count;
                (light > 0.1 * all).then(|| noise.sqrt() / light)
            })
            .collect();
        let mean = local.iter().sum::<f64>() / local.len() as f64;
        let variance = local
            .iter()
            .map(|noise| (noise - mean).powi(2))
            .sum::<f64>();
        (variance / local.len() as f64).sqrt() / mean
    }
}

fn shares(bands: &[f64]) -> Vec<f64> {
    let sum: f64 = bands.iter().sum();
    bands.iter().map(|band| band / sum).collect()
}

/// Whether multi-resolution and the thin lens have less error than fixed splats; then the same by the filter
/// of 2008.
fn lower(found: &[f64; 9]) -> [bool; 4] {
    let &[fixed, multi, thin, _, _, wide, wide_multi, wide_thin, _] = found;
    [
        multi < fixed,
        thin < fixed,
        wide_multi < wide,
        wide_thin < wide,
    ]
}

#[test]
fn variable_splats_lower_the_error_of_fixed_ones_on_a_ball() {
    let scene = scene_of(&over_floor(&ball(GLASS), SIDE));
    let truth = truth(&scene, "LTTD", 1e-2);
    for found in table("ball", &scene, &truth, SPLATS) {
        // By Gaussians, which are narrower than the authors' filter, multi-resolution does not at 512² photons.
        let [_, thin, wide_multi, wide_thin] = lower(&found);
        assert!(thin && wide_multi && wide_thin, "{found:?}");
    }
}

#[test]
fn variable_splats_lower_the_error_of_fixed_ones_on_a_bumpy_ball() {
    let (scene, truth) = &*BUMPY;
    for found in table("bumpy ball", scene, truth, SPLATS) {
        let [_, thin, wide_multi, wide_thin] = lower(&found);
        assert!(thin && wide_multi && wide_thin, "{found:?}");
    }
}

/// Measures one of the report's meshes: for 512² and 1024² photons which splats were found to lower the error
/// of fixed ones. That is a record: beams and maps give the same bits each time.
fn measured_on(name: &str, accuracy: f64, record: [[bool; 4]; 2]) {
    // Run by hand: without the mesh there is nothing to measure.
    let mesh = shared_mesh(name).expect("the mesh, in the folder of shared meshes");
    let scene = mesh_over_floor(mesh, SIDE);
    let truth = truth(&scene, "LTTD", accuracy);
    let found = table(name, &scene, &truth, SPLATS);
    assert_eq!(found.map(|found| lower(&found)), record, "{name}");
}

#[test]
#[ignore = "minutes of beams"]
fn variable_splats_lower_the_error_on_beethoven() {
    measured_on("beethoven_5k", 3e-2, [[true; 4]; 2]);
}

#[test]
#[ignore = "minutes of beams"]
fn variable_splats_lower_the_error_on_the_buddha() {
    measured_on("buddha_50k", 3e-2, [[true; 4]; 2]);
}

#[test]
#[ignore = "minutes of beams"]
fn variable_splats_lower_the_error_on_the_bunny() {
    measured_on("bunny_69k", 3e-2, [[true; 4]; 2]);
}

#[test]
#[ignore = "minutes of beams"]
fn the_thin_lens_raises_the_error_on_the_gargoyle() {
    let record = [[true, false, false, false], [false, false, false, true]];
    measured_on("gargoyle_96k", 5e-2, record);
}

#[test]
#[ignore = "minutes of beams"]
fn variable_splats_hardly_lower_the_error_on_the_dragon() {
    // Errors of 0.940 and 0.946, and of 0.639 and 0.604, are as near to each other as the truth can tell.
    let record = [[true, true, true, false], [false, true, true, true]];
    measured_on("dragon_200k", 1e-1, record);
}

#[test]
fn multi_resolution_loses_high_frequencies_and_the_thin_lens_keeps_more_of_them() {
    let (scene, truth) = &*BUMPY;
    // Relative to the light in each: multi-resolution adds some.
    let relative = |values: Vec<f64>| {
        let light: f64 = values.iter().sum();
        octaves(&values)
            .into_iter()
            .map(move |band| band / (light * light))
    };
    let modelled = || relative(truth.modelled.iter().map(|value| value.mean()).collect());
    let [_, multi, thin] = CLAIMED.map(|splat| {
        let bands = relative(means(&rendered(&of_name(splat, "512"), scene)));
        let shares: Vec<f64> = bands.zip(modelled()).map(|(a, b)| a / b).collect();
        println!(
            "{}",
            row(&format!("{splat}, octaves by the truth's"), &shares)
        );
        shares
    });
    // Stripes of one to four texels of the meter, two to eight of the map: the sizes of the splats.
    for octave in 0..3 {
        assert!(multi[octave] < 1.0, "{octave}: {multi:?}");
        assert!(multi[octave] < thin[octave], "{octave}: {multi:?} {thin:?}");
    }
}

#[test]
fn noise_falls_with_photons_a_texel_and_is_a_hundredth_at_sixteen() {
    let (scene, _) = &*BUMPY;
    let of_map = |map| {
        let settings = [
            ("photons", "512"),
            ("map", map),
            ("splat", "fixed"),
            ("splat-size", "1"),
            ("lookup", "bilinear"),
        ];
        Frames::of(scene, &settings).relative()
    };
    let (one, four, sixteen) = (of_map("512"), of_map("256"), of_map("128"));
    println!("noise at 1, 4 and 16 photons a texel: {one:.4} {four:.4} {sixteen:.4}");
    assert!(four < one && sixteen < four, "{one} {four} {sixteen}");
    // Independent photons would leave a quarter of the noise; a third is clear of that. What is left is
    // beside a mean of 1.
    assert!(sixteen < one / 3.0 && sixteen < 0.02, "{one} {sixteen}");
}

#[test]
fn the_thin_lens_leaves_more_noise_than_multi_resolution_but_no_blotches() {
    let (scene, _) = &*BUMPY;
    let [_, multi, thin] = CLAIMED.map(|splat| {
        let settings = [
            ("photons", "512"),
            ("map", "512"),
            ("splat", splat),
            ("lookup", "bilinear"),
        ];
        let frames = Frames::of(scene, &settings);
        let (noise, unevenness) = (frames.relative(), frames.unevenness());
        let spectrum = shares(&octaves(&frames.noise));
        let name = format!("{splat}: noise {noise:.4}, uneven by {unevenness:.2}, by octaves");
        println!("{}", row(&name, &spectrum));
        (noise, spectrum[0])
    });
    assert!(multi.0 < thin.0, "{multi:?} {thin:?}");
    // Noise that is independent from texel to texel has 3/4 of its squares in the finest octave: the mean of
    // four has a quarter.
    assert!(thin.1 > 0.75 && multi.1 < 0.75, "{multi:?} {thin:?}");
}

#[test]
fn multi_resolution_covers_the_most_texels_and_the_thin_lens_the_fewest() {
    let (scene, _) = &*BUMPY;
    let work = |splat: &str| {
        let counters = rendered(&of_name(splat, "512"), scene).counters;
        move |name: &str| {
            let found = counters.iter().find(|one| one.name == name);
            found.map_or(0, |one| one.count)
        }
    };
    let (fixed, multi, thin) = (work("fixed"), work("multi-resolution"), work("thin-lens"));
    println!(
        "fragments: fixed {}, multi-resolution {}, thin lens {}; bytes {} {} {}",
        fixed("fragments"),
        multi("fragments"),
        thin("fragments"),
        fixed("bytes"),
        multi("bytes"),
        thin("bytes")
    );
    // "Requires larger point sizes (15² instead of 7²)", and a second map and pass.
    assert!(multi("fragments") > 4 * fixed("fragments"));
    assert!(multi("bytes") > fixed("bytes"));
    // "Many splats cover only a few pixels": continuous sizes cost less than four at once.
    assert!(thin("fragments") < fixed("fragments"));
    assert_eq!(fixed("rays"), thin("rays"));
}
