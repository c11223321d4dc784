//! Images by paths: independent ways agree, classes part the light, and nothing depends on the machine.

use nephroid::internals::numeric::StreamKind;
use nephroid::internals::reference::path::{LightSampling, PathSettings, run};
use nephroid::internals::run::{Budget, Error};
use nephroid::internals::run::{Estimate, LayerName, Progress};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::path_class::{PathClass, PathClasses};

use crate::support;
use crate::support::paths::{
    BOX, bits, camera, class, film, image, layer_bits, mean, scene, with_32_replicates,
};

/// A room of many materials under a broad lamp, a glass ball in it.
fn room(film: &str) -> Scene {
    let materials = [
        (
            "-0.9",
            "<bsdf type=\"roughconductor\"><string name=\"material\" value=\"Al\"/>\
            <float name=\"alpha\" value=\"0.3\"/></bsdf>",
        ),
        ("-0.3", "<bsdf type=\"dielectric\"/>"),
        (
            "0.3",
            "<bsdf type=\"roughplastic\"><float name=\"alpha\" value=\"0.2\"/></bsdf>",
        ),
        (
            "0.9",
            "<bsdf type=\"roughdielectric\"><float name=\"alpha\" value=\"0.3\"/></bsdf>",
        ),
    ];
    let balls = materials.map(|(x, bsdf)| {
        format!(
            "<shape type=\"sphere\"><point name=\"center\" value=\"{x}, 0, -0.6\"/>\
             <float name=\"radius\" value=\"0.28\"/>{bsdf}</shape>"
        )
    });
    let floor = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"3\"/>\
        <translate z=\"-1\"/></transform><bsdf type=\"plastic\"/></shape>";
    let wall = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"3\"/>\
        <rotate x=\"1\" angle=\"90\"/><translate y=\"1.5\"/></transform><bsdf type=\"diffuse\">\
        <rgb name=\"reflectance\" value=\"0.7, 0.4, 0.2\"/></bsdf></shape>";
    let lamp = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"1.5\"/>\
        <rotate x=\"1\" angle=\"180\"/><translate z=\"2\"/></transform><emitter type=\"area\">\
        <rgb name=\"radiance\" value=\"2, 3, 4\"/></emitter></shape>";
    scene(&format!(
        "{}{}{floor}{wall}{lamp}",
        camera(45.0, film),
        balls.concat()
    ))
}

/// Mean z² of the difference of two images, over pixels.
fn mean_squared_z(a: &Estimate, b: &Estimate) -> f64 {
    let mut sum = 0.0;
    for pixel in 0..a.total.values.len() {
        let of = |image: &Estimate| {
            let (value, error) = (image.total.values[pixel], image.total.standard_error[pixel]);
            (value.0[1], error.0[1])
        };
        let ((x, of_x), (y, of_y)) = (of(a), of(b));
        sum += (x - y).powi(2) / (of_x * of_x + of_y * of_y);
    }
    sum / a.total.values.len() as f64
}

#[test]
fn three_ways_to_find_light_agree_in_every_pixel() {
    let scene = room(&film(16, 12, BOX));
    let ways = [
        LightSampling::Power,
        LightSampling::Balance,
        LightSampling::Emitters,
        LightSampling::Surfaces,
    ];
    let images: Vec<Estimate> = ways
        .into_iter()
        .enumerate()
        .map(|(index, light_sampling)| {
            let settings = PathSettings {
                light_sampling,
                seed: index as u64,
                // So that no replicate's mean is far from normal: long chains between mirrors carry little.
                max_depth: Some(8),
                ..with_32_replicates()
            };
            image(&scene, settings, 1024)
        })
        .collect();
    // Differences of independent means of 32 replicates: Welch's t of 31 to 62 degrees of freedom; the wider
    // is bounded.
    let expected = support::student::moments(31);
    let pixels = images[0].total.values.len() as f64;
    let tolerance = 5.0 * expected.deviation_of_square / pixels.sqrt();
    for (i, a) in images.iter().enumerate() {
        for (j, b) in images.iter().enumerate().skip(i + 1) {
            let squared = mean_squared_z(a, b);
            assert!(
                squared < expected.variance + tolerance,
                "{:?} and {:?}: mean z² {squared}",
                ways[i],
                ways[j]
            );
            for channel in 0..3 {
                let ((x, of_x), (y, of_y)) = (mean(&a.total, channel), mean(&b.total, channel));
                let z = (x - y) / of_x.hypot(of_y);
                assert!(z.abs() < 4.0, "{:?} and {:?}: z {z}", ways[i], ways[j]);
                assert!(of_x < 0.02 * x, "{:?} is too noisy to say", ways[i]);
            }
        }
    }
    // And weights are worth their while.
    let error = |image: &Estimate| image.relative_error.unwrap();
    assert!(error(&images[0]) < error(&images[2]) && error(&images[0]) < error(&images[3]));
}

#[test]
fn the_classes_are_all_light_and_leaving_some_out_changes_no_bit_of_the_others() {
    let scene = room(&film(16, 12, BOX));
    let whole = image(&scene, PathSettings::default(), 64);
    assert_eq!(
        whole.layers.len(),
        PathClass::ALL.len(),
        "every class is lit"
    );
    for (pixel, total) in whole.total.values.iter().enumerate() {
        let sum: f64 = whole
            .layers
            .iter()
            .map(|layer| layer.values[pixel].0[0])
            .sum();
        // Sums of 64 samples in two orders.
        assert!((sum - total.0[0]).abs() <= 1e-13 * total.0[0]);
    }
    let settings = PathSettings {
        classes: PathClasses::ALL.without(PathClasses::CAUSTICS),
        ..PathSettings::default()
    };
    let rest = image(&scene, settings, 64);
    let names: Vec<_> = rest.layers.iter().map(|layer| layer.name).collect();
    let kept = [PathClass::Emitted, PathClass::Direct, PathClass::Indirect];
    assert_eq!(names, kept.map(LayerName::Class));
    for name in kept {
        let [a, b] = [&whole, &rest].map(|image| layer_bits(class(image, name).unwrap()));
        assert_eq!(a, b, "{name}");
    }
}

#[test]
fn points_of_fewer_replicates_have_less_noise_and_tell_as_well_how_much() {
    let lamp = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"0.5\"/>\
        <rotate x=\"1\" angle=\"180\"/><translate z=\"1\"/></transform><emitter type=\"area\"/></shape>";
    let scene = scene(&format!(
        "{}<shape type=\"sphere\"><bsdf type=\"diffuse\"/><float name=\"radius\" value=\"0.5\"/></shape>\
         <shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"3\"/><translate z=\"-0.6\"/>\
         </transform><bsdf type=\"diffuse\"/></shape>{lamp}",
        camera(45.0, &film(16, 12, BOX))
    ));
    let by = |replicates, seed, samples| {
        let settings = PathSettings {
            replicates,
            seed,
            ..PathSettings::default()
        };
        image(&scene, settings, samples).total
    };
    let truth = by(8, 1000, 1 << 16);
    // The sum of squared errors, and what is said of it.
    let of = |replicates| {
        let (mut squares, mut said) = (0.0, 0.0);
        for seed in 0..16 {
            let found = by(replicates, seed, 512);
            for (pixel, truth) in truth.values.iter().enumerate() {
                squares += (found.values[pixel].0[1] - truth.0[1]).powi(2);
                said += found.standard_error[pixel].0[1].powi(2);
            }
        }
        [squares, said]
    };
    let [by_default, by_32] = [PathSettings::default().replicates, 32].map(of);
    let gain = by_32[0] / by_default[0];
    let told = [by_default, by_32].map(|[squares, said]| said / squares);
    println!("variance of 32 replicates {gain} times that of the default; said by true {told:?}");
    // A sum of squares of 16 images of 192 pixels is known to √(2/3072) = 3 % if errors are alike, and to 15 % if
    // one pixel in thirty has most of it, as those on edges do. Points that are all independent gain nothing.
    assert!(gain > 2.0, "{gain}");
    assert!(told.iter().all(|it| (0.55..1.45).contains(it)), "{told:?}");
}

#[test]
fn the_same_bits_come_from_any_number_of_threads() {
    // Tiles that overlap, and a border that is sampled.
    let filters = [
        BOX.to_owned(),
        "<rfilter type=\"mitchell\"/><boolean name=\"sample_border\" value=\"true\"/>".to_owned(),
    ];
    for filter in filters {
        let scene = room(&film(37, 21, &filter));
        let images = [1, 2, 5].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap()
                .install(|| bits(&image(&scene, PathSettings::default(), 32)))
        });
        assert_eq!(images[0], images[1], "{filter}");
        assert_eq!(images[0], images[2], "{filter}");
    }
}

#[test]
fn a_filter_spreads_constant_light_evenly_and_crops_change_no_mean() {
    let wall = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"20\"/>\
        <rotate x=\"1\" angle=\"90\"/></transform><emitter type=\"area\">\
        <rgb name=\"radiance\" value=\"3\"/></emitter></shape>";
    let crop =
        "<integer name=\"crop_offset_x\" value=\"2\"/><integer name=\"crop_width\" value=\"5\"/>";
    let border = "<boolean name=\"sample_border\" value=\"true\"/>";
    for filter in ["tent", "gaussian", "mitchell", "catmullrom", "lanczos"] {
        for more in ["", border, crop] {
            let film = film(8, 6, &format!("<rfilter type=\"{filter}\"/>{more}"));
            let scene = scene(&format!("{}{wall}", camera(50.0, &film)));
            let settings = PathSettings {
                max_depth: Some(1),
                ..with_32_replicates()
            };
            let found = image(&scene, settings, 128);
            assert_eq!(found.width, if more == crop { 5 } else { 8 });
            for (value, error) in found.total.values.iter().zip(&found.total.standard_error) {
                // The weights cancel: what is left is some thousand roundings; in the error, squares of theirs' root.
                assert!(
                    (value.0[0] - 3.0).abs() < 1e-11,
                    "{filter} {more}: {value:?}"
                );
                assert!(error.0[0] < 1e-6, "{filter} {more}: {error:?}");
            }
        }
    }
}

#[test]
fn a_filter_is_a_convolution_of_the_image() {
    // A lamp's straight edge at the middle of the film, far from the border: pixel i holds ∫ f over the lit
    // side.
    let lamp = "<shape type=\"rectangle\"><transform name=\"to_world\"><translate x=\"-1\"/>\
        <scale value=\"20\"/><rotate x=\"1\" angle=\"90\"/></transform><emitter type=\"area\">\
        <rgb name=\"radiance\" value=\"1\"/></emitter></shape>";
    for name in ["tent", "gaussian", "mitchell", "catmullrom", "lanczos"] {
        let film = film(16, 9, &format!("<rfilter type=\"{name}\"/>"));
        let scene = scene(&format!("{}{lamp}", camera(50.0, &film)));
        let filter = scene.sensors()[0].film.filter;
        let found = image(&scene, with_32_replicates(), 4096);
        let integral = |from: f64, to: f64| {
            let rule = nephroid::internals::numeric::quadrature::GaussLegendre::new(40).unwrap();
            // Cubics have knots at whole pixels.
            let steps = (from.floor() as i32)..(to.ceil() as i32);
            steps
                .map(|i| {
                    rule.integrate(from.max(i.into()), to.min((i + 1).into()), |x| {
                        filter.eval(x)
                    })
                })
                .sum::<f64>()
        };
        let radius = filter.radius();
        let whole = integral(-radius, radius);
        for column in 4..12 {
            let pixel = 4 * 16 + column;
            // The lit side's end (x = 0, the camera's x is the image's left), as seen from the pixel's
            // centre.
            let edge = (column as f64 + 0.5 - 8.0).clamp(-radius, radius);
            let left_is_lit = found.total.values[4 * 16].0[0] > 0.5;
            let lit = if left_is_lit {
                integral(edge, radius)
            } else {
                integral(-radius, edge)
            };
            let (value, error) = (
                found.total.values[pixel].0[0],
                found.total.standard_error[pixel].0[0],
            );
            // Five standard errors of 31 degrees of freedom; 40 pixels are looked at. Quotients of means are
            // biased by 1/n: 4096 samples a pixel.
            assert!(
                (value - lit / whole).abs() <= 5.0 * error + 2.0 / 4096.0,
                "{name}, column {column}: {value} ± {error} is not {}",
                lit / whole
            );
        }
    }
}

#[test]
fn hidden_emitters_are_seen_through_and_mirrored() {
    // A lamp before a wall that a point light shines on; a mirror beside it shows the lamp's image.
    let lamp = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"0.2\"/>\
        <rotate x=\"1\" angle=\"90\"/></transform><emitter type=\"area\">\
        <rgb name=\"radiance\" value=\"5\"/></emitter></shape>";
    let wall = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"9\"/>\
        <rotate x=\"1\" angle=\"90\"/><translate y=\"1\"/></transform><bsdf type=\"diffuse\"/></shape>";
    let light = "<emitter type=\"directional\"><vector name=\"direction\" value=\"1, 1, 0\"/>\
        <rgb name=\"irradiance\" value=\"1\"/></emitter>";
    let seen = |hide: bool| {
        let elements = format!("{}{lamp}{wall}{light}", camera(2.0, &film(4, 4, BOX)));
        let settings = PathSettings {
            hide_emitters: hide,
            ..with_32_replicates()
        };
        image(&scene(&elements), settings, 64)
    };
    let (shown, hidden) = (seen(false), seen(true));
    assert!(mean(class(&shown, PathClass::Emitted).unwrap(), 0).0 == 5.0);
    assert!(class(&hidden, PathClass::Emitted).is_none());
    // Direct light on the wall behind it: ρ/π E cos 45°, the lamp's shadow falls elsewhere.
    let truth = 0.5 / std::f64::consts::PI * std::f64::consts::FRAC_1_SQRT_2;
    let (value, _) = mean(class(&hidden, PathClass::Direct).unwrap(), 0);
    assert!(
        (value / truth - 1.0).abs() < 1e-12,
        "{value} is not {truth}"
    );
}

/// A lamp over a slab of glass over a floor with a meter, seen by a camera between the two.
fn under_glass() -> Scene {
    scene(
        "<sensor type=\"orthographic\" id=\"eye\"><transform name=\"to_world\"><scale x=\"0.5\" y=\"0.5\"/>\
         <lookat origin=\"0, 0, 0.5\" target=\"0, 0, 0\" up=\"0, 1, 0\"/></transform>\
         <film type=\"hdrfilm\"><integer name=\"width\" value=\"4\"/><integer name=\"height\" value=\"4\"/>\
         <rfilter type=\"box\"/></film></sensor>\
         <shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"0.5\"/></transform>\
         <bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.8\"/></bsdf>\
         <sensor type=\"irradiancemeter\" id=\"floor\"><film type=\"hdrfilm\">\
         <integer name=\"width\" value=\"4\"/><integer name=\"height\" value=\"4\"/><rfilter type=\"box\"/>\
         </film></sensor></shape>\
         <shape type=\"cube\"><transform name=\"to_world\"><scale x=\"2\" y=\"2\" z=\"0.1\"/>\
         <translate z=\"1\"/></transform><bsdf type=\"dielectric\"/></shape>\
         <shape type=\"rectangle\"><transform name=\"to_world\"><rotate x=\"1\" angle=\"180\"/>\
         <translate z=\"2\"/></transform><bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0\"/></bsdf>\
         <emitter type=\"area\"><rgb name=\"radiance\" value=\"1\"/></emitter></shape>",
    )
}

#[test]
fn the_caustic_that_paths_find_by_chance_is_the_one_that_photons_measure() {
    let scene = under_glass();
    let eye = image(&scene, with_32_replicates(), 4096);
    let (radiance, of_radiance) = mean(class(&eye, PathClass::Caustic).unwrap(), 0);
    let photons = support::Photons::new(1 << 18).estimate(&scene);
    let specular: Vec<_> = photons
        .layers
        .iter()
        .filter(|layer| layer.name.to_string() != "LD")
        .collect();
    let texels = (photons.width * photons.height) as f64;
    let irradiance: f64 = specular
        .iter()
        .flat_map(|layer| &layer.values)
        .map(|value| value.0[0])
        .sum::<f64>()
        / texels;
    // Texels of a replicate share its photons: their errors are bounded by their sum.
    let of_irradiance: f64 = specular
        .iter()
        .flat_map(|layer| &layer.standard_error)
        .map(|error| error.0[0])
        .sum::<f64>()
        / texels;
    // L = ρ/π E.
    let factor = 0.8 / std::f64::consts::PI;
    let z = (radiance - factor * irradiance) / of_radiance.hypot(factor * of_irradiance);
    assert!(of_radiance < 5e-3 * radiance, "{radiance} ± {of_radiance}");
    assert!(
        z.abs() < 4.0,
        "{radiance} ± {of_radiance}, {}: z {z}",
        factor * irradiance
    );
}

#[test]
fn a_run_stops_at_its_error_and_at_its_time() {
    let scene = room(&film(16, 12, BOX));
    let run = |budget: Budget| {
        let settings = with_32_replicates();
        run(
            &scene,
            &scene.sensors()[0],
            settings,
            &budget,
            &Progress::default(),
        )
        .unwrap()
    };
    let (image, report) = run(Budget {
        relative_error: Some(0.1),
        ..Budget::default()
    });
    assert!(image.relative_error.unwrap() <= 0.1 && !image.incomplete);
    assert!(
        report.samples >= 64,
        "one round cannot be that good: {}",
        report.samples
    );
    // With a limit on the samples as well, that one comes first.
    let (_, report) = run(Budget {
        relative_error: Some(1e-9),
        work: Some(224),
        ..Budget::default()
    });
    assert_eq!(report.samples, 224);
    // No time at all: nothing is known, and said so.
    let (image, report) = run(Budget {
        time: Some(std::time::Duration::ZERO),
        ..Budget::default()
    });
    assert!(image.incomplete && report.samples == 0 && image.total.is_unknown());
}

#[test]
fn rounds_of_random_points_are_one_run_in_parts() {
    // The mean of rounds of 1, 2 and 4 samples a replicate is as good as 7: errors fall with the root of
    // samples.
    let scene = room(&film(16, 12, BOX));
    let settings = PathSettings {
        stream: StreamKind::Random,
        max_depth: Some(3),
        ..with_32_replicates()
    };
    let budget = Budget {
        work: Some(7 * 32),
        relative_error: Some(1e-9),
        ..Budget::default()
    };
    let (rounds, _) = run(
        &scene,
        &scene.sensors()[0],
        settings,
        &budget,
        &Progress::default(),
    )
    .unwrap();
    let once = image(&scene, settings, 7 * 32);
    let ratio = rounds.relative_error.unwrap() / once.relative_error.unwrap();
    // A variance from 32 replicates is known to √(2/31) = 25 %; over 192 pixels to 2 %, twice; but bright
    // pixels count most.
    assert!((ratio - 1.0).abs() < 0.2, "{ratio}");
    let ((x, of_x), (y, of_y)) = (mean(&rounds.total, 0), mean(&once.total, 0));
    assert!(((x - y) / of_x.hypot(of_y)).abs() < 4.0);
}

#[test]
fn what_cannot_be_an_image_is_an_error_that_says_why() {
    let scene = under_glass();
    let meter = &scene.sensors()[1];
    let settings = PathSettings::default();
    let error = |sensor, settings| {
        run(
            &scene,
            sensor,
            settings,
            &Budget::default(),
            &Progress::default(),
        )
        .unwrap_err()
    };
    assert_eq!(
        error(meter, settings).to_string(),
        "sensor \"floor\" is an irradiancemeter: it measures a surface and is no camera"
    );
    let none = PathSettings {
        replicates: 0,
        ..settings
    };
    assert_eq!(
        error(&scene.sensors()[0], none).to_string(),
        "replicates is \"0\"; allowed are 1 to 255"
    );
    let no_leg = PathSettings {
        rr_depth: 0,
        ..settings
    };
    assert!(matches!(
        error(&scene.sensors()[0], no_leg),
        Error::Setting(_)
    ));
}

#[test]
fn samples_that_are_no_numbers_are_counted_and_fail_the_run() {
    // The radiance is a number, but not what an even choice of direction makes of it: by a density of 1/4π.
    let bright = "<emitter type=\"constant\"><rgb name=\"radiance\" value=\"1e308\"/></emitter>\
        <shape type=\"sphere\"><bsdf type=\"diffuse\"/></shape>";
    let scene = scene(&format!("{}{bright}", camera(20.0, &film(4, 4, BOX))));
    let budget = Budget {
        work: Some(64),
        ..Budget::default()
    };
    let settings = with_32_replicates();
    let progress = Progress::default();
    let error = run(&scene, &scene.sensors()[0], settings, &budget, &progress).unwrap_err();
    // Every sample of the first replicate meets the ball, 2 a pixel; half of the directions are below its horizon.
    let Error::NotRepresentable(message) = error else {
        panic!("{error}");
    };
    let numbers = message.split(|c: char| !c.is_ascii_digit() && c != '.');
    let numbers: Vec<f64> = numbers.filter_map(|word| word.parse().ok()).collect();
    let [count, x, y] = numbers[..] else {
        panic!("{message}");
    };
    assert!((4.0..=32.0).contains(&count), "{count}");
    assert!(
        (0.0..4.0).contains(&x) && (0.0..4.0).contains(&y),
        "{x} {y}"
    );
    assert_eq!(progress.unit(), "paths");
}
