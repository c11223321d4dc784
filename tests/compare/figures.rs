//! Each figure of a comparison is its formula, on images for which the formula can be worked out.

use nephroid::internals::film::Image;
use nephroid::internals::metric::{
    CompareError, CompareSettings, Comparison, ImageSide, LayerComparison, Maps, Pairing, Verdict,
    Window, compare,
};

use crate::support::images::{grey, source};

/// All light of two grey images.
fn compared(reference: Image, other: Image) -> LayerComparison {
    let report = compare(
        &source("a.exr", reference),
        &source("b.exr", other),
        &CompareSettings::default(),
    );
    report.unwrap().layers.remove(0)
}

/// Sums of a few thousand terms of one sign round to a few thousand ulps at worst.
fn close(got: f64, expected: f64) {
    assert!(
        (got - expected).abs() <= 1e-12 * expected.abs(),
        "{got} {expected}"
    );
}

#[test]
fn constant_images_have_the_figures_of_their_formulas() {
    let size = [40, 30];
    let it = compared(grey(size, |_, _| 2.0, None), grey(size, |_, _| 2.5, None));
    let d = &it.difference;
    assert_eq!(d.lit, 1200);
    close(d.mean_reference, 2.0);
    close(d.mean_other, 2.5);
    close(d.rmse, 0.5);
    close(d.relative_rmse.unwrap(), 0.25);
    close(d.mae, 0.5);
    close(d.rel_mse_epsilon, 0.04);
    close(d.rel_mse.unwrap(), 0.25 / 4.04);
    close(d.smape_epsilon, 0.02);
    close(d.smape.unwrap(), 0.5 / 4.52);
    close(d.energy_ratio.unwrap(), 1.25);
    close(d.psnr.unwrap(), 10.0 * 16f64.log10());
    close(it.equivalence.bias.bias, 0.5);
    close(it.equivalence.bias.relative.unwrap(), 0.25);
    assert!(d.percentiles.iter().all(|one| one.value == 0.5));
    // Means 2 and 2.5 without variance: the second factor is C₂/C₂, up to the cancellation in variances
    // of some 1e-15 beside C₂ = (0.03 · 2)².
    let c1 = 0.02f64 * 0.02;
    let expected = (10.0 + c1) / (10.25 + c1);
    assert!((it.similarity.unwrap().ssim - expected).abs() < 1e-11);
    assert_eq!(it.equivalence.verdict, Verdict::Different);
}

#[test]
fn an_image_and_itself_differ_in_nothing() {
    let image = || {
        grey(
            [33, 21],
            |x, y| ((x * y) % 7) as f64 * 1e-3,
            Some(&|_, _| 1e-5),
        )
    };
    let it = compared(image(), image());
    let d = &it.difference;
    for zero in [
        d.rmse,
        d.relative_rmse.unwrap(),
        d.rel_mse.unwrap(),
        d.smape.unwrap(),
        d.mae,
        d.worst.difference,
        it.flip.unwrap().mean,
        it.flip.unwrap().max,
        it.equivalence.bias.bias,
        it.equivalence.bias.relative.unwrap(),
        it.equivalence.bias.standard_error.unwrap(),
        it.equivalence.texels.unexplained.unwrap(),
        it.significance.as_ref().unwrap().mean_square_z,
    ] {
        assert_eq!(zero, 0.0);
    }
    assert_eq!(d.energy_ratio, Some(1.0));
    assert_eq!(d.psnr, None);
    assert_eq!(it.similarity.unwrap().ssim, 1.0);
    assert_eq!(it.equivalence.verdict, Verdict::Equivalent);
    assert!(!it.significance.unwrap().family.different);
}

#[test]
fn relative_figures_are_over_lit_texels() {
    // The left half is dark in the reference; the other image is off by 1 everywhere.
    let reference = grey([20, 10], |x, _| if x < 10 { 0.0 } else { 4.0 }, None);
    let other = grey([20, 10], |x, _| if x < 10 { 1.0 } else { 5.0 }, None);
    let d = compared(reference, other).difference;
    assert_eq!(d.lit, 100);
    close(d.mean_lit, 4.0);
    close(d.mean_reference, 2.0);
    close(d.relative_rmse.unwrap(), 0.25);
    close(d.rmse, 1.0);
    // ε = 0.01 · 2² and 0.01 · 2.
    close(d.rel_mse.unwrap(), 0.5 * (1.0 / 0.04 + 1.0 / 16.04));
    close(d.smape.unwrap(), 0.5 * (1.0 / 1.02 + 1.0 / 9.02));
}

#[test]
fn percentiles_are_ranks_and_the_worst_texel_is_told_with_its_place() {
    // |d| is 0, 1, ..., 999 in an order that is not sorted; 700 · 7 = 4900 = 900 modulo 1000.
    let d = |x: usize, y: usize| ((x + 40 * y) * 7 % 1000) as f64;
    let reference = grey([40, 25], |_, _| 1000.0, None);
    let other = grey(
        [40, 25],
        |x, y| 1000.0 + d(x, y) * if x % 2 == 0 { 1.0 } else { -1.0 },
        None,
    );
    let it = compared(reference, other).difference;
    // The smallest value that 50, 90, 95, 99, 99.9 % of 1000 do not exceed.
    let values: Vec<f64> = it.percentiles.iter().map(|one| one.value).collect();
    assert_eq!(values, [499.0, 899.0, 949.0, 989.0, 998.0]);
    // 7 i = 999 modulo 1000 for i = 857 = 17 + 40 · 21.
    assert_eq!((it.worst.x, it.worst.y), (17, 21));
    assert_eq!(it.worst.difference, 999.0);
    assert_eq!((it.worst.reference[0], it.worst.other[0]), (1000.0, 1.0));
}

#[test]
fn ssim_is_that_of_scikit_image() {
    // tests/compare/ssim_oracle.py, scikit-image 0.26.0.
    let (dynamic_range, expected) = (2.467919588, 0.944027853644);
    let size = [53, 40];
    let at = |x: usize, y: usize| (x as f64, y as f64);
    let reference = grey(
        size,
        |x, y| {
            let (x, y) = at(x, y);
            1.5 + (0.4 * x).sin() * (0.3 * y).cos()
        },
        None,
    );
    let other = grey(
        size,
        |x, y| {
            let (x, y) = at(x, y);
            1.5 + 0.9 * (0.4 * x + 0.2).sin() * (0.3 * y).cos() + 0.1 * (2.1 * x + 1.7 * y).sin()
        },
        None,
    );
    let it = compared(reference, other).similarity.unwrap();
    assert!((it.dynamic_range - dynamic_range).abs() < 1e-8);
    // Both in f64; variances below 1 are differences of moments of some 4, and C₂ = 0.0056.
    assert!((it.ssim - expected).abs() < 1e-9, "{}", it.ssim);
}

#[test]
fn a_common_factor_is_known_without_scatter_whatever_the_image() {
    let caustic =
        |x: usize, y: usize| 0.1 + 1000.0 / (1.0 + ((x * x + y * y) as f64 - 300.0).powi(2));
    let reference = grey([64, 64], caustic, None);
    let other = grey(
        [64, 64],
        |x, y| 1.01 * f64::from(caustic(x, y) as f32),
        None,
    );
    let it = compared(reference, other).equivalence;
    // Each texel of the copy is rounded to f32: 6e-8 of itself.
    assert!((it.bias.relative.unwrap() - 0.01).abs() < 1e-7);
    assert!(it.bias.standard_error.unwrap() < 1e-7);
    let [low, high] = it.bias.interval.unwrap();
    assert!(0.01 - 1e-6 < low && high < 0.01 + 1e-6);
}

#[test]
fn three_equal_channels_are_the_same_as_one() {
    let value = |x: usize, y: usize| 1.0 + ((x * 3 + y * 5) % 11) as f64;
    let test = |x: usize, y: usize| value(x, y) * (1.0 + 0.01 * (x as f64).sin());
    let size = [24, 24];
    let rgb = |value: &dyn Fn(usize, usize) -> f64| {
        let mut image = Image::new(24, 24);
        let values: Vec<[f64; 3]> = (0..576).map(|i| [value(i % 24, i / 24); 3]).collect();
        image.add_rgb("", &values);
        image
    };
    let colour = compared(rgb(&value), rgb(&test));
    let grey = compared(grey(size, value, None), grey(size, test, None));
    assert_eq!(colour.difference, grey.difference);
    assert_eq!(colour.flip, grey.flip);
    assert_eq!(colour.equivalence, grey.equivalence);
}

#[test]
fn figures_do_not_depend_on_the_number_of_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let wave = |x: usize, y: usize| 1.0 + (0.1 * (x * y) as f64).sin();
            let error = |_: usize, _: usize| 0.01;
            let reference = grey([300, 200], wave, Some(&error));
            let other = grey(
                [300, 200],
                |x, y| wave(x, y) + 0.01 * (x as f64).cos(),
                Some(&error),
            );
            compared(reference, other)
        })
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(5));
}

#[test]
fn the_reference_is_the_one_named() {
    let a = source("a.exr", grey([16, 16], |_, _| 1.0, None));
    let b = source("b.exr", grey([16, 16], |_, _| 2.0, None));
    let bias = |reference| {
        let settings = CompareSettings {
            reference,
            ..CompareSettings::default()
        };
        let report: Comparison = compare(&a, &b, &settings).unwrap();
        report.layers[0].equivalence.bias.relative.unwrap()
    };
    assert_eq!(bias(ImageSide::A), 1.0);
    assert_eq!(bias(ImageSide::B), -0.5);
}

#[test]
fn layers_are_those_that_both_have_and_error_bars_are_none_of_them() {
    let image = |layers: &[&str]| {
        let mut image = Image::new(4, 4);
        for layer in layers {
            image.add_rgb(layer, &[[1.0; 3]; 16]);
        }
        image.add_scalar("count.Y", [5.0; 16]);
        image
    };
    let a = source(
        "a.exr",
        image(&["E", "E.stderr", "LD", "LTTD", "LTTD.lo", "LTTD.hi"]),
    );
    let b = source("b.exr", image(&["E", "E.lo", "E.hi", "LRD", "LTTD"]));
    let report = compare(&a, &b, &CompareSettings::default()).unwrap();
    let names: Vec<&str> = report.layers.iter().map(|it| it.layer.as_str()).collect();
    assert_eq!(names, ["E", "LTTD"]);
    assert!(report.layers[0].is_total);
    for (file, layer) in [("a.exr", "LD"), ("b.exr", "LRD")] {
        let expected = format!("only {file} has layers {layer}: not compared");
        assert!(report.notes.contains(&expected), "{:?}", report.notes);
    }
    let settings = CompareSettings {
        layers: vec!["LRD".to_owned()],
        ..CompareSettings::default()
    };
    let error = compare(&a, &b, &settings).unwrap_err().to_string();
    assert_eq!(
        error,
        "layer \"LRD\" is not in both images; those in both are E, LTTD"
    );
}

#[test]
fn what_cannot_be_compared_says_file_channel_and_pixel() {
    let size = [8, 6];
    let plain = || grey(size, |_, _| 1.0, None);
    let message = |a: Image, b: Image| {
        let report = compare(
            &source("a.exr", a),
            &source("b.exr", b),
            &CompareSettings::default(),
        );
        report.unwrap_err().to_string()
    };
    assert_eq!(
        message(plain(), grey([6, 8], |_, _| 1.0, None)),
        "a.exr has 8 x 6 texels, b.exr has 6 x 8: they must be the same"
    );
    let hole = |value: f64| {
        grey(
            size,
            move |x, y| if (x, y) == (3, 5) { value } else { 1.0 },
            None,
        )
    };
    assert_eq!(
        message(plain(), hole(f64::NAN)),
        "b.exr: channel Y is NaN at pixel (3, 5): allowed are finite numbers"
    );
    assert_eq!(
        message(hole(f64::INFINITY), plain()),
        "a.exr: channel Y is inf at pixel (3, 5): allowed are finite numbers"
    );
    let negative = |x: usize, _: usize| if x == 2 { -1.0 } else { 1.0 };
    assert!(
        message(plain(), grey(size, |_, _| 1.0, Some(&negative))).starts_with(
            "b.exr: channel stderr.Y, a standard error or variance, is -1 at pixel (2, 0)"
        )
    );
    let unknown_once = |x: usize, _: usize| if x == 2 { f64::NAN } else { 1.0 };
    assert!(
        message(plain(), grey(size, |_, _| 1.0, Some(&unknown_once)))
            .contains("channel stderr.Y is NaN at pixel (2, 0)")
    );
    let mut colour = Image::new(8, 6);
    colour.add_rgb("", &[[1.0; 3]; 48]);
    assert_eq!(
        message(plain(), colour),
        "layer total has channels Y in a.exr, but R, G, B in b.exr"
    );
    let mut depth = Image::new(8, 6);
    depth.add_scalar("depth.Z", [1.0; 48]);
    assert!(message(depth, plain()).contains("a.exr: no layer of all light"));
    let named = |name: &str| {
        let mut image = Image::new(8, 6);
        image.add_rgb(name, &[[1.0; 3]; 48]);
        image
    };
    assert_eq!(
        message(named("E"), named("L")),
        "a.exr holds E, b.exr holds L: they cannot be compared"
    );
    let mut crossed = named("E");
    crossed.add_rgb("E.lo", &[[2.0; 3]; 48]);
    crossed.add_rgb("E.hi", &[[1.0; 3]; 48]);
    assert!(
        message(crossed, named("E"))
            .contains("channel E.lo.R is 2 at pixel (0, 0), above its upper bound 1")
    );
}

#[test]
fn errors_that_are_all_unknown_count_as_no_errors() {
    let size = [12, 12];
    let unknown = grey(size, |_, _| 1.0, Some(&|_, _| f64::NAN));
    let it = compared(unknown, grey(size, |_, _| 1.0, None));
    assert_eq!(it.significance, None);
    assert!(!it.equivalence.texels.has_bars);
}

#[test]
fn a_window_is_compared_alone_and_its_places_are_those_of_the_file() {
    let reference = || grey([20, 20], |_, _| 1.0, None);
    let other = grey(
        [20, 20],
        |x, y| {
            if (x, y) == (7, 9) {
                3.0
            } else if x == 0 {
                50.0
            } else {
                1.0
            }
        },
        None,
    );
    let window = Window {
        corner: [4, 6],
        size: [10, 8],
    };
    let a = source("a.exr", reference()).cropped(window).unwrap();
    let b = source("b.exr", other).cropped(window).unwrap();
    let report = compare(&a, &b, &CompareSettings::default()).unwrap();
    let it = &report.layers[0].difference;
    assert_eq!((it.worst.x, it.worst.y, it.worst.difference), (7, 9, 2.0));
    close(it.mae, 2.0 / 80.0);
    for (corner, size) in [
        ([15, 0], [10, 1]),
        ([0, 0], [0, 4]),
        ([usize::MAX, 0], [2, 2]),
    ] {
        let error = source("a.exr", reference()).cropped(Window { corner, size });
        assert!(matches!(error, Err(CompareError::Window { .. })));
    }
}

#[test]
fn maps_are_differences_ratios_and_scores() {
    let a = source(
        "a.exr",
        grey(
            [3, 1],
            |x, _| [2.0, 0.0, 4.0][x],
            Some(&|x, _| [0.5, 0.0, 2.0][x]),
        ),
    );
    let b = source("b.exr", grey([3, 1], |x, _| [3.0, 1.0, 3.0][x], None));
    let pairing = Pairing::new(&a, &b, ImageSide::A, &[]).unwrap();
    let maps = Maps::of(&pairing.pairs[0]);
    assert_eq!(maps.difference.values(), [1.0, 1.0, -1.0]);
    assert_eq!(maps.relative.values()[0], 0.5);
    assert!(maps.relative.values()[1].is_nan());
    assert_eq!(maps.relative.values()[2], -0.25);
    let z = maps.z.unwrap();
    // Rounding adds 1e-14 to the variance.
    assert!((z.values()[0] - 2.0).abs() < 1e-6);
    assert!(z.values()[1].is_nan());
    assert!((z.values()[2] + 0.5).abs() < 1e-6);
}

#[test]
fn a_dark_reference_has_no_relative_figures_and_light_beside_it_is_a_difference() {
    let size = [16, 16];
    let it = compared(grey(size, |_, _| 0.0, None), grey(size, |_, _| 1.0, None));
    let d = &it.difference;
    assert_eq!(
        (d.relative_rmse, d.rel_mse, d.smape, d.energy_ratio, d.psnr),
        (None, None, None, None, None)
    );
    assert_eq!((d.rmse, it.equivalence.bias.bias), (1.0, 1.0));
    assert_eq!((it.flip, it.similarity), (None, None));
    assert_eq!(it.equivalence.verdict, Verdict::Different);
    let dark = compared(grey(size, |_, _| 0.0, None), grey(size, |_, _| 0.0, None));
    assert_eq!(dark.equivalence.verdict, Verdict::Equivalent);
}
