//! Every bsdf samples what it says: by its density, and with weights that add up to its value.

use glam::{DVec2, DVec3};
use nephroid::internals::numeric::distributions::chi_squared_survival;
use nephroid::internals::numeric::{Stream, StreamKind};
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::transport::bsdf::{Bsdf, Scattering, Transport};

use crate::support::bsdf::{Bins, Surface, bsdfs, direction};

/// Both sides, normal and grazing incidence.
const WI: [(f64, f64); 6] = [
    (0.0, 0.0),
    (40.0, 25.0),
    (70.0, 200.0),
    (86.0, 310.0),
    (115.0, 75.0),
    (165.0, 260.0),
];

const SAMPLES: u64 = 50_000;

/// More cases than the oracle's: sharp lobes of both distributions.
fn cases() -> Vec<String> {
    let mut cases = bsdfs();
    // Light goes through an index of 1.001 nearly straight on: the bins are too wide for its lobe.
    let is_straight = ["name=\"eta\" value=\"1\"", "name=\"specular\" value=\"0\""];
    cases.retain(|case| !is_straight.iter().any(|part| case.contains(part)));
    for distribution in ["ggx", "beckmann"] {
        for (plugin, more) in [
            ("roughconductor", ""),
            ("roughdielectric", ""),
            ("roughdielectric", "<float name=\"int_ior\" value=\"1.3\"/>"),
            ("roughplastic", ""),
        ] {
            cases.push(format!(
                "<bsdf type=\"{plugin}\"><string name=\"distribution\" value=\"{distribution}\"/>\
                 <float name=\"alpha\" value=\"0.05\"/>{more}</bsdf>"
            ));
        }
    }
    cases
}

/// Samples with a density, by bin.
fn histogram(bsdf: &Bsdf, wi: DVec3, bins: &Bins, stream: &Stream) -> Vec<u64> {
    let mut counts = vec![0; bins.rows * bins.columns];
    for index in 0..SAMPLES {
        let [a, b, c, _] = stream.point4(index);
        if let Some(sample) = bsdf.sample(wi, [a, b, c], Transport::Radiance)
            && !sample.is_delta
        {
            counts[bins.of(sample.wo)] += 1;
        }
    }
    counts
}

/// The p-value of Pearson's test that counts follow the expected ones. Samples without a bin (delta
/// lobes, and None) are one more; bins that expect fewer than 5 are thrown together.
fn p_value(counts: &[u64], shares: &[f64]) -> f64 {
    let total = SAMPLES as f64;
    let none = (
        total - counts.iter().sum::<u64>() as f64,
        (total * (1.0 - shares.iter().sum::<f64>())).max(0.0),
    );
    let binned = counts.iter().zip(shares);
    let all = binned.map(|(&count, &share)| (count as f64, total * share));
    let (many, few): (Vec<_>, Vec<_>) = all
        .chain([none])
        .partition(|(_, expected)| *expected >= 5.0);
    let few = few
        .into_iter()
        .fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0, sum.1 + pair.1));
    let pairs: Vec<_> = many
        .into_iter()
        .chain((few.1 >= 5.0).then_some(few))
        .collect();
    if few.1 < 5.0 && few.0 > 25.0 {
        return 0.0; // Poisson's 5 exceeds 25 once in 10¹¹
    }
    if pairs.len() < 2 {
        return 1.0;
    }
    let chi_squared: f64 = pairs
        .iter()
        .map(|(found, expected)| (found - expected).powi(2) / expected)
        .sum();
    chi_squared_survival(chi_squared, (pairs.len() - 1) as f64)
}

const BINS: Bins = Bins {
    rows: 12,
    columns: 16,
};

/// Quadrature may be off by this share of all samples in a bin: a tenth of one sample's, where bins expect 5
/// or more and scatter by 2.2 or more.
const QUADRATURE: f64 = 1e-1 / SAMPLES as f64;

#[test]
fn samples_follow_their_density() {
    let mut results = Vec::new();
    for (number, case) in cases().iter().enumerate() {
        let surface = Surface::square(case, DVec2::new(0.3, 0.7));
        let bsdf = surface.bsdf();
        if bsdf.is_delta() {
            continue;
        }
        for (index, (theta, phi)) in WI.into_iter().enumerate() {
            let wi = direction(theta, phi);
            let stream = Stream::new(StreamKind::Random, (number * WI.len() + index) as u64);
            let counts = histogram(&bsdf, wi, &BINS, &stream);
            let shares = BINS.integrals(|wo| bsdf.pdf_solid_angle(wi, wo), QUADRATURE);
            results.push((p_value(&counts, &shares), case.clone(), theta, phi));
        }
    }
    // Šidák: all together may fail by chance once in a hundred seeds.
    let level = 1.0 - 0.99f64.powf(1.0 / results.len() as f64);
    let wrong: Vec<_> = results.iter().filter(|(p, ..)| *p < level).collect();
    println!("{} tests at level {level:.2e}", results.len());
    assert!(results.len() > 150);
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_test_of_densities_tells_roughness_0_30_from_0_31() {
    let of = |alpha: f64| {
        Surface::square(
            &format!(
                "<bsdf type=\"roughconductor\"><float name=\"alpha\" value=\"{alpha}\"/></bsdf>"
            ),
            DVec2::splat(0.5),
        )
    };
    let (one, other) = (of(0.30), of(0.31));
    let wi = direction(40.0, 25.0);
    let counts = histogram(&one.bsdf(), wi, &BINS, &Stream::new(StreamKind::Random, 1));
    let shares =
        |surface: &Surface| BINS.integrals(|wo| surface.bsdf().pdf_solid_angle(wi, wo), QUADRATURE);
    assert!(p_value(&counts, &shares(&one)) > 1e-3);
    assert!(p_value(&counts, &shares(&other)) < 1e-9);
}

/// Samples of which weights are averaged.
const WEIGHED: u64 = 20_000;

/// Mean weight of samples with a density and of all, with the standard error of both.
struct Albedo {
    spread: [Rgb; 2],
    all: [Rgb; 2],
}

fn albedo(bsdf: &Bsdf, wi: DVec3, mode: Transport) -> Albedo {
    let stream = Stream::new(StreamKind::Random, 5);
    let mut sums = [[Rgb::BLACK; 2]; 2];
    for index in 0..WEIGHED {
        let [a, b, c, _] = stream.point4(index);
        let Some(sample) = bsdf.sample(wi, [a, b, c], mode) else {
            continue;
        };
        let squared = sample.weight * sample.weight;
        sums[1][0] += sample.weight;
        sums[1][1] += squared;
        if !sample.is_delta {
            sums[0][0] += sample.weight;
            sums[0][1] += squared;
        }
    }
    let n = WEIGHED as f64;
    let finished = |[sum, squares]: [Rgb; 2]| {
        let mean = sum / n;
        let variance = squares / n - mean * mean;
        [mean, variance.map(|v| (v.max(0.0) / n).sqrt())]
    };
    Albedo {
        spread: finished(sums[0]),
        all: finished(sums[1]),
    }
}

#[test]
fn weights_add_up_to_the_value_and_no_surface_makes_light() {
    for case in cases() {
        let surface = Surface::square(&case, DVec2::new(0.3, 0.7));
        let bsdf = surface.bsdf();
        for (theta, phi) in [WI[1], WI[3], WI[4]] {
            let wi = direction(theta, phi);
            for mode in [Transport::Radiance, Transport::Flux] {
                let found = albedo(&bsdf, wi, mode);
                // Red differs from blue where anything is coloured.
                let c = if mode == Transport::Flux { 0 } else { 2 };
                {
                    let integral: f64 = BINS
                        .integrals(|wo| bsdf.eval(wi, wo, mode).0[c], 1e-6)
                        .iter()
                        .sum();
                    // Five standard errors: one in 10⁶ by chance. Quadrature is off by the sum of 192 bins'
                    // tolerances and, where a turned normal cuts the value off, by the smallest squares cut.
                    let error = 5.0 * found.spread[1].0[c] + 2e-4 + 1e-4 * integral;
                    assert!(
                        (found.spread[0].0[c] - integral).abs() <= error,
                        "{case}\n{theta}, {phi}, {mode:?}: weights {}, integral {integral}",
                        found.spread[0].0[c]
                    );
                    // Turned normals change how much light a surface seems to receive: by no more than
                    // they change its cosine, which has no bound at grazing angles. Disney's parts know nothing of
                    // each other: a sheen adds light at grazing angles.
                    let adds = |part: &str| case.contains("principled") && case.contains(part);
                    let is_bounded =
                        !case.contains("map\"") && !adds("sheen") && !adds("clearcoat");
                    let is_flux = mode == Transport::Flux && is_bounded;
                    if is_flux {
                        let total = found.all[0].0[c];
                        let noise = 5.0 * found.all[1].0[c] + 1e-12;
                        assert!(total <= 1.0 + noise, "{case}\n{theta}, {phi}: {total}");
                    }
                }
            }
        }
    }
}

/// f is linear in the parts of a blend, delta lobes too: (1 − w) f₀ + w f₁. So is what samples of it average to.
///
/// (Mitsuba 3.9.1 darkens a mirror beside a density: see `tests/mitsuba/bsdf_oracle.py`.)
#[test]
fn a_blend_is_as_bright_as_its_parts_in_their_shares() {
    let matt = "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.7, 0.4, 0.2\"/></bsdf>";
    let gold = "<bsdf type=\"conductor\"><string name=\"material\" value=\"Au\"/></bsdf>";
    let rough = "<bsdf type=\"roughconductor\"><float name=\"alpha\" value=\"0.3\"/></bsdf>";
    let glass = "<bsdf type=\"dielectric\"/>";
    let both = format!("<bsdf type=\"twosided\">{gold}</bsdf>");
    let sheet = "<bsdf type=\"principledthin\"><float name=\"spec_trans\" value=\"0.5\"/>\
        <float name=\"diff_trans\" value=\"1.5\"/></bsdf>";
    let weight = 0.3;
    for [first, second] in [
        [matt, gold],
        [gold, matt],
        [matt, rough],
        [glass, gold],
        [glass, matt],
        [&both, matt],
        [&both, sheet],
    ] {
        let blend = format!(
            "<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"{weight}\"/>{first}{second}</bsdf>"
        );
        let of = |case: &str| Surface::square(case, DVec2::splat(0.5));
        let surfaces = [of(&blend), of(first), of(second)];
        for (theta, phi) in WI {
            for mode in [Transport::Radiance, Transport::Flux] {
                let [blend, first, second] = surfaces
                    .each_ref()
                    .map(|surface| albedo(&surface.bsdf(), direction(theta, phi), mode).all);
                let expected = first[0] * (1.0 - weight) + second[0] * weight;
                for c in 0..3 {
                    // Five standard errors, and roundings where there is none.
                    let errors = [blend, first, second].map(|it| it[1].0[c].powi(2));
                    let error = 5.0 * errors.iter().sum::<f64>().sqrt() + 1e-12;
                    assert!(
                        (blend[0].0[c] - expected.0[c]).abs() <= error,
                        "{theta}, {phi}, {mode:?}: {:?}, not {expected:?}",
                        blend[0]
                    );
                    assert!(error < 0.06, "{error}");
                }
            }
        }
    }
}

#[test]
fn samples_of_a_blend_have_the_density_of_all_of_its_parts() {
    let case = "<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"0.3\"/><bsdf type=\"diffuse\"/>\
        <bsdf type=\"roughconductor\"><float name=\"alpha\" value=\"0.3\"/></bsdf></bsdf>";
    let surface = Surface::square(case, DVec2::splat(0.5));
    let bsdf = surface.bsdf();
    let (wi, stream) = (direction(40.0, 25.0), Stream::new(StreamKind::Sobol, 3));
    let mut counts = [0; 2];
    for index in 0..256 {
        let [a, b, c, _] = stream.point4(index);
        for mode in [Transport::Radiance, Transport::Flux] {
            let Some(sample) = bsdf.sample(wi, [a, b, c], mode) else {
                continue;
            };
            counts[usize::from(sample.scattering == Scattering::Diffuse)] += 1;
            let density = bsdf.pdf_solid_angle(wi, sample.wo);
            let weight = bsdf.eval(wi, sample.wo, mode).0[0] / density;
            // Some roundings, amplified by the slope of the lobe: by 100 at most.
            assert!((sample.pdf_solid_angle / density - 1.0).abs() < 1e-12);
            assert!((sample.weight.0[0] / weight - 1.0).abs() < 1e-12);
        }
    }
    assert!(counts.into_iter().min() > Some(100), "{counts:?}");
}

#[test]
fn lossless_smooth_interfaces_keep_all_flux_in_every_sample() {
    let eta = 1.5046 / 1.000277;
    for (case, scales) in [
        ("<bsdf type=\"dielectric\"/>", true),
        ("<bsdf type=\"thindielectric\"/>", false),
        ("<bsdf type=\"conductor\"/>", false),
        ("<bsdf type=\"null\"/>", false),
        (
            "<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.3\"/><bsdf type=\"conductor\"/></bsdf>",
            false,
        ),
    ] {
        let surface = Surface::square(case, DVec2::splat(0.5));
        let bsdf = surface.bsdf();
        assert!(bsdf.is_delta());
        for (theta, phi) in WI {
            let wi = direction(theta, phi);
            if wi.z < 0.0 && case.contains("conductor") {
                continue; // black from behind
            }
            let stream = Stream::new(StreamKind::Sobol, 3);
            for index in 0..256 {
                let [a, b, c, _] = stream.point4(index);
                let sample = bsdf.sample(wi, [a, b, c], Transport::Flux).unwrap();
                // Veach's factor is 1 but for a few roundings.
                assert!(
                    (sample.weight.0[1] - 1.0).abs() < 1e-14,
                    "{case} {sample:?}"
                );
                let radiance = bsdf.sample(wi, [a, b, c], Transport::Radiance).unwrap();
                let expected = match (scales, sample.scattering) {
                    (true, Scattering::Transmitted) if wi.z > 0.0 => 1.0 / (eta * eta),
                    (true, Scattering::Transmitted) => eta * eta,
                    _ => 1.0,
                };
                assert!((radiance.weight.0[1] / expected - 1.0).abs() < 1e-14);
            }
        }
    }
}

/// A lossless rough interface loses just the light that meets a second facet: more the rougher it is, and
/// in the limit of a smooth one nothing.
#[test]
fn rough_lossless_interfaces_lose_more_the_rougher_and_nothing_in_the_smooth_limit() {
    for plugin in ["roughdielectric", "roughconductor"] {
        for distribution in ["beckmann", "ggx"] {
            let mut before = 1.0;
            for alpha in [1e-4, 0.02, 0.1, 0.3, 0.6] {
                let surface = Surface::square(
                    &format!(
                        "<bsdf type=\"{plugin}\"><string name=\"distribution\" value=\"{distribution}\"/>\
                         <float name=\"alpha\" value=\"{alpha}\"/></bsdf>"
                    ),
                    DVec2::splat(0.5),
                );
                let [mean, error] =
                    albedo(&surface.bsdf(), direction(60.0, 20.0), Transport::Flux).all;
                println!(
                    "{plugin} {distribution} {alpha}: loses {:.4}",
                    1.0 - mean.0[1]
                );
                if alpha == 1e-4 {
                    // The fit of G₁ is exactly 1 there, and GGX loses (α tan θ)²/4 for each direction.
                    assert!(
                        (mean.0[1] - 1.0).abs() <= 5.0 * error.0[1] + 2e-8,
                        "{mean:?}"
                    );
                }
                assert!(mean.0[1] <= before + 5.0 * error.0[1] + 2e-8);
                before = mean.0[1];
            }
            assert!(before < 0.98, "{plugin} {distribution}: {before}");
        }
    }
}
