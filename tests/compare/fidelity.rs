//! How much light, how far from its place, right at which scale: closed forms, and the least cost of all
//! plans by brute force.

use nephroid::{
    Bounded, CompareImage, CompareSettings, Displacement, Fidelity, Image, LayerComparison, compare,
};

/// A grey image of one layer.
fn image(size: [usize; 2], value: impl Fn(usize, usize) -> f64) -> Image {
    let mut image = Image::new(size[0], size[1]);
    let texels = (0..size[0] * size[1]).map(|i| [value(i % size[0], i / size[0]); 3]);
    image.add_rgb("E", &texels.collect::<Vec<_>>());
    image
}

fn compared(truth: Image, other: Image) -> LayerComparison {
    let settings = CompareSettings {
        pixels_per_degree: None,
        ..CompareSettings::default()
    };
    let (truth, other) = (
        CompareImage::new("truth", truth),
        CompareImage::new("other", other),
    );
    let comparison = compare(&truth, &other, &settings).unwrap();
    comparison.layers.into_iter().next().unwrap()
}

fn fidelity(truth: Image, other: Image) -> Fidelity {
    compared(truth, other).fidelity
}

fn displaced(truth: Image, other: Image) -> Displacement {
    fidelity(truth, other).displaced.unwrap()
}

/// A blob of light without symmetry that stays away from the image's border.
fn blob(x: usize, y: usize) -> f64 {
    let (x, y) = (x as f64, y as f64);
    let near = (-((x - 20.0).powi(2) / 18.0 + (y - 24.0).powi(2) / 50.0)).exp();
    let near = if near > 1e-3 { near } else { 0.0 };
    let bar = f64::from(u8::from(
        (14.0..18.0).contains(&x) && (18.0..33.0).contains(&y),
    ));
    near + 0.4 * bar
}

/// The same blob as a file has it: an `f32` for each texel.
fn shifted(by: [usize; 2]) -> Image {
    image([64, 64], |x, y| {
        if x >= by[0] && y >= by[1] {
            blob(x - by[0], y - by[1])
        } else {
            0.0
        }
    })
}

#[test]
fn a_black_image_scores_one_wherever_a_figure_is_relative() {
    for size in [[64, 64], [37, 20]] {
        let found = fidelity(image(size, blob), image(size, |_, _| 0.0));
        assert_eq!(found.energy.unwrap().value, 0.0);
        assert_eq!(found.l1.unwrap().value, 1.0);
        assert_eq!(found.l2.unwrap().value, 1.0);
        assert!(found.scales.iter().all(|one| one.l2.value == 1.0));
        assert_eq!(found.resolution, None);
        assert_eq!(found.misplaced, None);
        assert_eq!(found.displaced, None);
    }
}

#[test]
fn a_dark_truth_has_no_relative_figures() {
    let found = fidelity(image([8, 8], |_, _| 0.0), image([8, 8], |_, _| 1.0));
    assert!(found.energy.is_none() && found.l1.is_none() && found.l2.is_none());
    assert!(found.scales.is_empty() && found.displaced.is_none());
}

#[test]
fn equal_images_have_no_difference_at_any_scale() {
    let found = fidelity(image([40, 23], blob), image([40, 23], blob));
    assert_eq!(found.energy.unwrap().value, 1.0);
    assert_eq!(found.l1.unwrap().value, 0.0);
    assert_eq!(found.misplaced.unwrap().value, 0.0);
    assert_eq!(found.resolution.unwrap().texels.value, 1.0);
    let texels = found.displaced.unwrap().texels;
    assert_eq!((texels.value, texels.high), (0.0, Some(0.0)));
}

#[test]
fn light_that_is_shifted_along_rows_or_columns_is_displaced_by_the_shift() {
    for by in [[1, 0], [3, 0], [0, 7], [20, 0]] {
        let expected = (by[0] + by[1]) as f64;
        let texels = displaced(shifted([0, 0]), shifted(by)).texels;
        // Sums of 4096 shares, each rounded: 4096 · 2⁻⁵³ of sixty texels.
        assert!((texels.value - expected).abs() < 1e-10, "{by:?} {texels:?}");
        // The cheapest plan found moves each texel by the shift.
        let high = texels.high.unwrap();
        assert!((high - expected).abs() < 1e-10, "{by:?} {texels:?}");
    }
}

#[test]
fn light_that_is_shifted_aslant_is_displaced_by_the_shift_to_the_error_that_is_said() {
    // Of 64 directions the mean of |cos| is short by 1 − cos(π / 128) = 3.0e-4 at most.
    for by in [[3, 4], [12, 5], [1, 1]] {
        let expected = (by[0] as f64).hypot(by[1] as f64);
        let texels = displaced(shifted([0, 0]), shifted(by)).texels;
        assert!(texels.value <= expected + 1e-10, "{by:?} {texels:?}");
        assert!(texels.value >= 0.9996 * expected, "{by:?} {texels:?}");
        assert!(
            (texels.high.unwrap() - expected).abs() < 1e-10,
            "{texels:?}"
        );
    }
}

#[test]
fn two_points_are_as_far_apart_as_they_are_in_texels_and_in_metres() {
    let point = |column, row| {
        let mut image = image([32, 16], |x, y| {
            f64::from(u8::from([x, y] == [column, row]))
        });
        // Texels twice as wide as high.
        image.add_metadata("texel-size", "[0.02,0.01]");
        image
    };
    let found = displaced(point(4, 3), point(20, 11));
    let (texels, metres) = (16f64.hypot(8.0), 0.32f64.hypot(0.08));
    let near = |found: Bounded, expected: f64| {
        found.value <= expected * (1.0 + 1e-12)
            && found.value >= 0.9996 * expected
            && (found.high.unwrap() / expected - 1.0).abs() < 1e-12
    };
    assert!(near(found.texels, texels), "{found:?}");
    assert!(near(found.metres.unwrap(), metres), "{found:?}");
}

/// Coverage of a texel by a disc about the image's centre, by 16 x 16 points.
fn disc(radius: f64, size: usize) -> Image {
    image([size, size], |x, y| {
        let centre = 0.5 * size as f64;
        let inside = (0..256).filter(|i| {
            let at = |cell: usize, point: i32| cell as f64 + (f64::from(point) + 0.5) / 16.0;
            (at(x, i % 16) - centre).hypot(at(y, i / 16) - centre) < radius
        });
        inside.count() as f64
    })
}

#[test]
fn light_that_is_spread_about_a_point_is_displaced_as_its_closed_form_says() {
    // Uniform discs of radii r and q r: the map x -> q x is the gradient of a convex function of the
    // distance, all rays lead outward, and W₁ = (q − 1) E|x| = (q − 1) 2 r / 3.
    let (radius, factor) = (60.0, 1.3);
    let texels = displaced(disc(radius, 200), disc(factor * radius, 200)).texels;
    let expected = (factor - 1.0) * 2.0 / 3.0 * radius;
    // A texel at the rim has its light at its centre, off by half a diagonal at most: of two discs, 2 / r of
    // the light each.
    let off = 2.0 * 2.0 / radius * 0.71;
    assert!(
        (texels.value - expected).abs() < off,
        "{texels:?} {expected}"
    );
    let high = texels.high.unwrap();
    assert!(
        high >= texels.value && high - expected < off,
        "{texels:?} {expected}"
    );
}

/// W₁ of two distributions by the least cost of all plans: successive shortest paths (Bellman and Ford) in the
/// graph of all texels, exact to rounding.
fn least_cost(from: &[f64], to: &[f64], width: usize) -> f64 {
    let place = |i: usize| ((i % width) as f64, (i / width) as f64);
    let distance = |i: usize, j: usize| {
        let ((a, b), (c, d)) = (place(i), place(j));
        (a - c).hypot(b - d)
    };
    let n = from.len();
    let total: f64 = from.iter().sum();
    let (mut supply, mut demand) = (from.to_vec(), to.to_vec());
    let mut flow = vec![0.0; n * n];
    // Potentials of sources and sinks keep reduced costs from falling below zero, as Dijkstra needs.
    let mut potential = vec![0.0; 2 * n];
    let mut left = total;
    while left > 1e-9 * total {
        let mut cost: Vec<f64> = (0..2 * n)
            .map(|i| {
                if i < n && supply[i] > 0.0 {
                    0.0
                } else {
                    f64::INFINITY
                }
            })
            .collect();
        let mut before = vec![usize::MAX; 2 * n];
        let mut done = vec![false; 2 * n];
        let end = loop {
            let open = (0..2 * n).filter(|i| !done[*i] && cost[*i].is_finite());
            let at = open.min_by(|a, b| cost[*a].total_cmp(&cost[*b])).unwrap();
            done[at] = true;
            if at >= n && demand[at - n] > 0.0 {
                break at;
            }
            for next in 0..n {
                let (to, step) = if at < n {
                    (n + next, distance(at, next))
                } else if flow[next * n + at - n] > 0.0 {
                    (next, -distance(next, at - n))
                } else {
                    continue;
                };
                let reduced = (step + potential[at] - potential[to]).max(0.0);
                if cost[at] + reduced < cost[to] {
                    cost[to] = cost[at] + reduced;
                    before[to] = at;
                }
            }
        };
        let most = cost[end];
        for i in 0..2 * n {
            potential[i] += cost[i].min(most);
        }
        let mut path = vec![end];
        while before[*path.last().unwrap()] != usize::MAX {
            path.push(before[*path.last().unwrap()]);
        }
        path.reverse();
        let mut amount = supply[path[0]].min(demand[end - n]);
        for pair in path.windows(2).filter(|pair| pair[0] >= n) {
            amount = amount.min(flow[pair[1] * n + pair[0] - n]);
        }
        for pair in path.windows(2) {
            if pair[0] < n {
                flow[pair[0] * n + pair[1] - n] += amount;
            } else {
                flow[pair[1] * n + pair[0] - n] -= amount;
            }
        }
        supply[path[0]] -= amount;
        demand[end - n] -= amount;
        left -= amount;
    }
    let costs = (0..n * n).map(|i| flow[i] * distance(i / n, i % n));
    costs.sum::<f64>() / total
}

/// Whole numbers without order, the same every time.
fn shuffled(seed: u64) -> impl FnMut() -> u64 {
    let mut state = seed;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        state >> 33
    }
}

/// The value of a texel, by column, row and a lot.
type Map = fn(usize, usize, u64) -> f64;

#[test]
fn the_least_cost_of_all_plans_is_between_the_bounds() {
    const WIDTH: usize = 16;
    let maps: [(&str, Map); 4] = [
        ("noise", |_, _, lot| (lot % 8) as f64),
        ("ring", |x, y, _| {
            let r = (x as f64 - 8.0).hypot(y as f64 - 7.0);
            f64::from(u8::from((4.0..5.5).contains(&r)))
        }),
        ("slope", |x, y, _| (x + 2 * y) as f64),
        ("spots", |_, _, lot| f64::from(u8::from(lot % 23 == 0))),
    ];
    for (i, (name, from)) in maps.iter().enumerate() {
        for (other, to) in &maps[i..] {
            let mut lots = [shuffled(1 + i as u64), shuffled(77)];
            let mut values = |map: &Map, lot: usize| -> Vec<f64> {
                let texels = 0..WIDTH * WIDTH;
                texels
                    .map(|i| map(i % WIDTH, i / WIDTH, lots[lot]()))
                    .collect()
            };
            let (from, to) = (values(from, 0), values(to, 1));
            let sums = [from.iter().sum::<f64>(), to.iter().sum::<f64>()];
            let alike: Vec<f64> = to.iter().map(|value| value * sums[0] / sums[1]).collect();
            let exact = least_cost(&from, &alike, WIDTH);
            let at = |values: &[f64]| image([WIDTH; 2], |x, y| values[y * WIDTH + x]);
            let texels = displaced(at(&from), at(&to)).texels;
            println!("{name} to {other}: {exact:.4} in {texels:?}");
            // Paths end when 1e-9 of the light is left, which is 23 texels from its place at most.
            assert!(texels.value <= exact + 3e-8, "{name} to {other}");
            assert!(texels.high.unwrap() >= exact - 1e-9, "{name} to {other}");
        }
    }
}

#[test]
fn light_in_finer_detail_than_the_truths_is_right_from_the_scale_of_that_detail() {
    // Squares of 4 x 4 texels have their light in one of them: means over 4 texels are right.
    let truth = image([64, 64], |x, y| 1.0 + (x / 4 + y / 4) as f64);
    let other = image([64, 64], |x, y| {
        let has_all = x % 4 == 1 && y % 4 == 2;
        if has_all {
            16.0 * (1.0 + (x / 4 + y / 4) as f64)
        } else {
            0.0
        }
    });
    let found = fidelity(truth, other);
    let l2: Vec<f64> = found.scales.iter().map(|one| one.l2.value).collect();
    // One texel of sixteen is 15 too large, the others 1 too small: √((15² + 15) / 16) = √15. One square of
    // four is 3 too large, the others 1 too small: √((9 + 3) / 4) = √3.
    assert!((l2[0] - 15f64.sqrt()).abs() < 1e-6, "{l2:?}");
    assert!((l2[1] - 3f64.sqrt()).abs() < 1e-6, "{l2:?}");
    assert!(l2[2..].iter().all(|l2| *l2 < 1e-6), "{l2:?}");
    // Linear in the logarithm of the scale between 2 (√3) and 4 (0).
    let expected = 2.0 * 2f64.powf((3f64.sqrt() - 0.1) / 3f64.sqrt());
    let texels = found.resolution.unwrap().texels;
    assert!((texels.value - expected).abs() < 1e-6, "{texels:?}");
}

#[test]
fn figures_do_not_depend_on_how_much_of_the_receiver_is_dark() {
    let pair = |size: usize| {
        let within = move |x: usize, y: usize| if x < 48 && y < 48 { blob(x, y) } else { 0.0 };
        let truth = image([size, size], within);
        let other = image([size, size], move |x, y| {
            if x >= 2 { 0.8 * within(x - 2, y) } else { 0.0 }
        });
        fidelity(truth, other)
    };
    let (small, large) = (pair(64), pair(256));
    assert!((small.l1.unwrap().value / large.l1.unwrap().value - 1.0).abs() < 1e-12);
    assert!((small.l2.unwrap().value / large.l2.unwrap().value - 1.0).abs() < 1e-12);
    assert_eq!(small.energy.unwrap().value, large.energy.unwrap().value);
    let texels = [&small, &large].map(|one| one.displaced.as_ref().unwrap().texels.value);
    assert!((texels[0] - texels[1]).abs() < 1e-9, "{texels:?}");
}

#[test]
fn misplaced_light_is_that_in_a_wrong_texel_whatever_its_amount() {
    // A quarter of the light goes from the left half to the right one, and three eighths of all are left.
    let truth = image([8, 4], |_, _| 1.0);
    let other = image([8, 4], |x, _| if x < 4 { 0.1875 } else { 0.5625 });
    let found = fidelity(truth, other);
    assert!((found.energy.unwrap().value - 0.375).abs() < 1e-12);
    assert!((found.misplaced.unwrap().value - 0.25).abs() < 1e-12);
    // (16 · 0.8125 + 16 · 0.4375) / 32.
    assert!((found.l1.unwrap().value - 0.625).abs() < 1e-12);
}

#[test]
fn texels_count_by_their_area() {
    let mut truth = image([4, 1], |_, _| 1.0);
    truth.add_scalar("area.Y", [1.0, 1.0, 2.0, 4.0]);
    truth.add_metadata("texel-surface", "a disc");
    let other = image([4, 1], |x, _| if x == 3 { 0.5 } else { 1.0 });
    let found = compared(truth, other);
    assert!(found.is_total);
    let found = found.fidelity;
    assert!((found.energy.unwrap().value - 0.75).abs() < 1e-12);
    assert!((found.l1.unwrap().value - 0.25).abs() < 1e-12);
    assert!((found.l2.unwrap().value - (4.0 * 0.25 / 8.0f64).sqrt()).abs() < 1e-12);
    assert!(found.displaced.is_none());
    assert!(found.not_displaced.unwrap().contains("a disc"));
}

/// A truth with bounds a part of its value below and above.
fn bounded(part: f64, value: impl Fn(usize, usize) -> f64) -> Image {
    let size = [64, 64];
    let mut truth = image(size, &value);
    for (name, factor) in [("E.lo", 1.0 - part), ("E.hi", 1.0 + part)] {
        let scaled = image(size, |x, y| factor * value(x, y));
        for mut channel in scaled.channels {
            channel.name = channel.name.replacen('E', name, 1);
            truth.channels.push(channel);
        }
    }
    truth
}

#[test]
fn the_ends_of_intervals_are_reached_by_truths_at_the_end_of_their_bounds() {
    let (part, more) = (0.05, 1.3);
    let other = || image([64, 64], |x, y| more * blob(x, y));
    let found = fidelity(bounded(part, blob), other());
    for (end, factor) in [(0, 1.0 + part), (1, 1.0 - part)] {
        let there = fidelity(image([64, 64], |x, y| factor * blob(x, y)), other());
        for (name, of) in [
            (
                "energy",
                (|it: &Fidelity| it.energy) as fn(&Fidelity) -> Option<Bounded>,
            ),
            ("L1", |it| it.l1),
            ("L2", |it| it.l2),
        ] {
            let interval = of(&found).unwrap();
            let found = [interval.low, interval.high][end].unwrap();
            let expected = of(&there).unwrap().value;
            // Bounds are stored as f32.
            assert!(
                (found / expected - 1.0).abs() < 1e-5,
                "{name}: {found} {expected}"
            );
        }
    }
}

#[test]
fn intervals_hold_the_figures_of_every_truth_within_the_bounds() {
    let part = 0.1;
    let other = || shifted([2, 1]);
    let found = fidelity(bounded(part, blob), other());
    for seed in 0..12 {
        let mut lot = shuffled(seed);
        let deviations: Vec<f64> = (0..64 * 64)
            .map(|i| match seed % 3 {
                0 => (lot() % 1000) as f64 / 500.0 - 1.0,
                1 => {
                    if lot().is_multiple_of(2) {
                        1.0
                    } else {
                        -1.0
                    }
                }
                // All light on one side is weaker: the worst for what is displaced.
                _ => {
                    if i % 64 < 18 {
                        1.0
                    } else {
                        -1.0
                    }
                }
            })
            .collect();
        let truth = image([64, 64], |x, y| {
            (1.0 + 0.999 * part * deviations[y * 64 + x]) * blob(x, y)
        });
        let there = fidelity(truth, other());
        let holds = |interval: Bounded, value: f64| {
            interval.low.unwrap() <= value && value <= interval.high.unwrap()
        };
        assert!(holds(found.energy.unwrap(), there.energy.unwrap().value));
        assert!(holds(found.l1.unwrap(), there.l1.unwrap().value));
        assert!(holds(
            found.misplaced.unwrap(),
            there.misplaced.unwrap().value
        ));
        assert!(holds(found.l2.unwrap(), there.l2.unwrap().value));
        for (interval, scale) in found.scales.iter().zip(&there.scales) {
            assert!(holds(interval.l2, scale.l2.value), "{interval:?} {scale:?}");
        }
        let texels = there.displaced.unwrap().texels;
        let interval = found.displaced.as_ref().unwrap().texels;
        assert!(holds(interval, texels.value) && holds(interval, texels.high.unwrap()));
    }
}

/// A coloured image, larger than the parts of which sums are made.
fn coloured(factors: [f64; 3], wave: f64) -> Image {
    let size = [300, 200];
    let mut image = Image::new(size[0], size[1]);
    let texels = (0..size[0] * size[1]).map(|i| {
        let (x, y) = ((i % size[0]) as f64, (i / size[0]) as f64);
        factors.map(|factor| factor * (1.1 + (wave * x).sin() * (0.1 * y).cos()))
    });
    image.add_rgb("E", &texels.collect::<Vec<_>>());
    image
}

#[test]
fn figures_are_the_same_bits_on_any_number_of_threads() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let mut truth = coloured([1.0, 0.5, 0.25], 0.2);
            for mut channel in coloured([0.1, 0.01, 0.03], 0.2).channels {
                channel.name = channel.name.replacen('E', "E.stderr", 1);
                truth.channels.push(channel);
            }
            let found = fidelity(truth, coloured([0.9, 0.6, 0.2], 0.21));
            serde_json::to_string(&found).unwrap()
        })
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn images_below_zero_have_figures_too_and_intervals_in_order() {
    let truth = || bounded(0.1, blob);
    let negative = fidelity(truth(), image([64, 64], |x, y| -blob(x, y)));
    let energy = negative.energy.unwrap();
    assert!((energy.value + 1.0).abs() < 1e-12);
    let near = |found: Option<f64>, expected: f64| (found.unwrap() - expected).abs() < 1e-5;
    assert!(
        near(energy.low, -1.0 / 0.9) && near(energy.high, -1.0 / 1.1),
        "{energy:?}"
    );
    assert_eq!(negative.l1.unwrap().value, 2.0);
    assert!(negative.misplaced.is_none() && negative.displaced.is_none());
    // More light than there is, less some below zero: half of three times as much is in a wrong texel.
    let mixed = fidelity(
        truth(),
        image([64, 64], |x, y| {
            let sign = if x < 30 { 2.0 } else { -1.0 };
            sign * blob(x, y) + if x == 60 { 1.0 } else { 0.0 }
        }),
    );
    let misplaced = mixed.misplaced.unwrap();
    assert!(misplaced.low.unwrap() <= misplaced.value, "{misplaced:?}");
    assert!(misplaced.value <= misplaced.high.unwrap(), "{misplaced:?}");
}

#[test]
fn bars_in_other_channels_than_the_figures_say_nothing() {
    let mut truth = coloured([1.0; 3], 0.2);
    let size = truth.width * truth.height;
    for name in ["X", "Y", "Z"] {
        let mean = truth.channels[0]
            .samples
            .iter()
            .map(|value| f64::from(*value));
        let mean: Vec<f64> = mean.collect();
        truth.add_scalar(format!("m.{name}"), mean.clone());
        truth.add_scalar(format!("m2_m.{name}"), mean.iter().map(|m| 1.1 * m * m));
    }
    let settings = CompareSettings {
        pixels_per_degree: None,
        ..CompareSettings::default()
    };
    let truth = CompareImage {
        samples: Some(16),
        ..CompareImage::new("truth", truth)
    };
    let other = CompareImage::new("other", coloured([1.1; 3], 0.2));
    let layer = &compare(&truth, &other, &settings).unwrap().layers[0];
    assert!(layer.significance.is_some(), "{size} texels with moments");
    let l1 = layer.fidelity.l1.unwrap();
    assert!((l1.value - 0.1).abs() < 1e-6 && l1.low.is_none(), "{l1:?}");
}

/// A ring about the middle, one texel wide.
fn ring(radius: f64, light: f64, x: usize, y: usize) -> f64 {
    let r = (x as f64 - 49.5).hypot(y as f64 - 49.5);
    if (r - radius).abs() < 0.5 {
        light / radius
    } else {
        0.0
    }
}

#[test]
fn light_that_is_moved_in_and_out_about_a_point_does_not_cancel() {
    // A ring of radius 20; half of its light goes to radius 10 and half to 30: each by 10. Lines hardly see it,
    // since light goes to both sides of each place; distances from the middle do.
    let truth = image([100, 100], |x, y| ring(20.0, 2.0, x, y));
    let other = image([100, 100], |x, y| {
        ring(10.0, 1.0, x, y) + ring(30.0, 1.0, x, y)
    });
    let texels = displaced(truth, other).texels;
    // Light of a ring is half a texel from its radius at most, of the truth's and of the other's. Rings of
    // texels may have a few percent more or less light than their circles, and it then has 20 texels to go.
    let off = 1.0 + 0.05 * 20.0;
    assert!((texels.value - 10.0).abs() < off, "{texels:?}");
    assert!(texels.high.unwrap() >= texels.value, "{texels:?}");
    assert!(texels.high.unwrap() < 10.0 + off, "{texels:?}");
}

#[test]
fn standard_errors_make_intervals_of_their_mean_deviation() {
    let part = 0.05;
    let mut truth = image([64, 64], blob);
    let errors = image([64, 64], |x, y| part * blob(x, y));
    for mut channel in errors.channels {
        channel.name = channel.name.replacen('E', "E.stderr", 1);
        truth.channels.push(channel);
    }
    let found = fidelity(truth, image([64, 64], |x, y| 1.3 * blob(x, y)));
    let is = |interval: Bounded, low: f64, high: f64| {
        // Errors are stored as f32.
        let near =
            |found: Option<f64>, expected: f64| (found.unwrap() / expected - 1.0).abs() < 1e-5;
        near(interval.low, low) && near(interval.high, high)
    };
    // All texels off to one side by a standard error.
    let energy = found.energy.unwrap();
    assert!(
        is(energy, 1.3 / (1.0 + part), 1.3 / (1.0 - part)),
        "{energy:?}"
    );
    // The mean of |x| for a normal x of standard deviation σ is √(2/π) σ.
    let beta = (2.0 / std::f64::consts::PI).sqrt() * part;
    let l1 = found.l1.unwrap();
    assert!(
        is(l1, (0.3 - beta) / (1.0 + beta), (0.3 + beta) / (1.0 - beta)),
        "{l1:?}"
    );
    let l2 = found.l2.unwrap();
    assert!(
        is(l2, (0.3 - part) / (1.0 + part), (0.3 + part) / (1.0 - part)),
        "{l2:?}"
    );
}
