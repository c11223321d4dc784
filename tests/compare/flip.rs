//! FLIP is what its authors' package computes (`tests/compare/flip_oracle.py` says how it was asked).

use nephroid::internals::metric::flip::{Exposures, Images, PIXELS_PER_DEGREE, hdr, ldr};

const WIDTH: usize = 61;
const HEIGHT: usize = 47;

/// Red, green and blue of one image.
type Rgb = [f64; 3];

/// The reference and the test image at a texel.
type Pair = fn(f64, f64) -> [Rgb; 2];

fn waves(x: f64, y: f64) -> [Rgb; 2] {
    let red = 0.5 + 0.4 * (0.21 * x + 0.05 * y).sin();
    let green = 0.5 + 0.4 * (0.13 * y - 0.02 * x).sin();
    let blue = 0.5 + 0.4 * (0.17 * x + 0.11 * y).cos();
    let test = 0.5 + 0.4 * (0.21 * (x + 1.5) + 0.05 * y).sin();
    [[red, green, blue], [test, 0.95 * green, blue + 0.05]]
}

fn edges(x: f64, y: f64) -> [Rgb; 2] {
    let board = ((x / 9.0).floor() + (y / 9.0).floor()) % 2.0;
    let is_point = x % 13.0 == 6.0 && y % 11.0 == 5.0;
    let test = 0.1 + 0.8 * board + if is_point { 0.5 } else { 0.0 };
    [[board; 3], [test; 3]]
}

fn caustic(x: f64, y: f64) -> [Rgb; 2] {
    let distance = (x - 30.0).hypot(y - 23.0);
    let ring = |radius: f64| 0.02 + 40.0 / (1.0 + (distance - radius).powi(2));
    [[ring(12.0); 3], [ring(12.4); 3]]
}

fn coloured(x: f64, y: f64) -> [Rgb; 2] {
    let red = 10f64.powf(-3.0 + 5.0 * x / (WIDTH - 1) as f64);
    let green = 10f64.powf(-2.0 + 3.0 * y / (HEIGHT - 1) as f64);
    let blue = 0.3 + 0.2 * (0.3 * x).sin() * (0.2 * y).cos();
    let factor = 1.0 + 0.06 * (1.1 * x).sin() * (0.7 * y).sin();
    [[red, green, blue], [red * factor, green, blue / factor]]
}

/// Planes of the reference and of the test image.
fn planes(pair: Pair, width: usize, height: usize) -> [[Vec<f32>; 3]; 2] {
    [0, 1].map(|image| {
        [0, 1, 2].map(|channel| {
            (0..width * height)
                .map(|i| pair((i % width) as f64, (i / width) as f64)[image][channel] as f32)
                .collect()
        })
    })
}

fn images(planes: &[[Vec<f32>; 3]; 2], width: usize, height: usize) -> Images<'_> {
    let [reference, test] = planes;
    Images {
        reference: [0, 1, 2].map(|c| reference[c].as_slice()),
        test: [0, 1, 2].map(|c| test[c].as_slice()),
        width,
        height,
    }
}

#[test]
fn flip_is_that_of_its_authors_on_every_texel_asked() {
    let lines = include_str!("flip_oracle.txt").lines();
    let mut asked = 0;
    for line in lines {
        let words: Vec<&str> = line.split(' ').collect();
        let pair: Pair = match words[0] {
            "waves" => waves,
            "edges" => edges,
            "caustic" => caustic,
            "coloured" => coloured,
            name => panic!("no pair {name}"),
        };
        let numbers: Vec<f32> = words[2..].iter().map(|w| w.parse().unwrap()).collect();
        let planes = planes(pair, WIDTH, HEIGHT);
        let images = images(&planes, WIDTH, HEIGHT);
        let map = if words[1] == "HDR" {
            let exposures = Exposures::of(images.reference).unwrap();
            // Logarithms of quotients in f32, printed with six digits.
            assert!((exposures.start - numbers[1]).abs() < 2e-5, "{exposures:?}");
            assert!((exposures.stop - numbers[2]).abs() < 2e-5, "{exposures:?}");
            assert_eq!(exposures.count as f32, numbers[3]);
            hdr(&images, PIXELS_PER_DEGREE, &exposures)
        } else {
            ldr(&images, PIXELS_PER_DEGREE)
        };
        // The bar, 1e-3, is far above what f32 allows: sums of some 21² terms and four powers,
        // the last with an exponent down to zero, which widens the error of small differences.
        let mean = map.iter().sum::<f32>() / map.len() as f32;
        assert!((mean - numbers[0]).abs() < 1e-4, "{line:.60}: {mean}");
        for (texel, expected) in map.iter().step_by(7).zip(&numbers[4..]) {
            assert!(
                (texel - expected).abs() < 1e-3,
                "{line:.60}: {texel} {expected}"
            );
            asked += 1;
        }
        assert_eq!(numbers.len() - 4, map.len().div_ceil(7));
    }
    assert_eq!(asked, 5 * (WIDTH * HEIGHT).div_ceil(7));
}

#[test]
fn equal_images_have_no_flip_and_black_and_white_flip_all() {
    let planes = planes(coloured, WIDTH, HEIGHT);
    let mut same = images(&planes, WIDTH, HEIGHT);
    same.test = same.reference;
    let exposures = Exposures::of(same.reference).unwrap();
    assert!(
        hdr(&same, PIXELS_PER_DEGREE, &exposures)
            .iter()
            .all(|&e| e == 0.0)
    );
    let (black, white) = (vec![0.0; 100], vec![1.0; 100]);
    let images = Images {
        reference: [&black; 3],
        test: [&white; 3],
        width: 10,
        height: 10,
    };
    let map = ldr(&images, PIXELS_PER_DEGREE);
    // HyAB of black and white is 100. The largest is that of green and blue, whose CIELAB is well known,
    // after Hunt's adjustment of a and b by L/100.
    let [green, blue] = [[87.73f32, -86.18, 83.18], [32.30, 79.19, -107.86]]
        .map(|[l, a, b]| [l, 0.01 * l * a, 0.01 * l * b]);
    let chroma = (green[1] - blue[1]).hypot(green[2] - blue[2]);
    let part = (100.0 / (green[0] - blue[0] + chroma)).powf(0.7);
    assert!(part > 0.4);
    let expected = 0.95 + (part - 0.4) / 0.6 * 0.05;
    for error in map {
        // Lightness and chroma above have four digits, and their part in the error is 0.05 / 0.6.
        assert!((error - expected).abs() < 1e-4, "{error} {expected}");
    }
}

#[test]
fn a_texel_that_differs_is_seen_within_reach_alone() {
    let mut planes = planes(coloured, WIDTH, HEIGHT);
    planes[1] = planes[0].clone();
    planes[1][1][0] += 0.5;
    let images = images(&planes, WIDTH, HEIGHT);
    let map = ldr(&images, PIXELS_PER_DEGREE);
    assert!(map[0] > 0.01, "{}", map[0]);
    // Three standard deviations of the widest kernel at 67 pixels a degree.
    let reach = 10;
    for (texel, error) in map.iter().enumerate() {
        let is_near = texel % WIDTH <= reach && texel / WIDTH <= reach;
        assert!(is_near || *error == 0.0, "{texel}: {error}");
    }
}

#[test]
fn squares_join_without_a_seam() {
    // A pair wider and higher than a square of texels: the middle of it, computed alone with all that
    // is within reach, is the same.
    let (width, height) = (190, 170);
    let whole = planes(waves, width, height);
    let map = ldr(&images(&whole, width, height), PIXELS_PER_DEGREE);
    let (left, top, side) = (77, 61, 101);
    let part = whole.clone().map(|image| {
        image.map(|plane| {
            plane
                .chunks(width)
                .skip(top)
                .take(side)
                .flat_map(|row| row[left..left + side].to_vec())
                .collect::<Vec<f32>>()
        })
    });
    let part = ldr(&images(&part, side, side), PIXELS_PER_DEGREE);
    let reach = 10;
    for y in reach..side - reach {
        for x in reach..side - reach {
            let [one, other] = [part[y * side + x], map[(top + y) * width + left + x]];
            assert_eq!(one, other, "{x} {y}");
        }
    }
}

#[test]
fn an_image_more_than_half_dark_has_finite_exposures_and_a_dark_one_none() {
    let mut light = vec![0.0; 90];
    light.extend([4.0, 1.0, 0.25, 1.0, 2.0, 1.0, 0.5, 1.0, 1.0, 1.0]);
    let planes = [light.as_slice(); 3];
    let exposures = Exposures::of(planes).unwrap();
    // log₂ of the brightest over the median of those above zero.
    assert!(
        (exposures.stop - exposures.start - 2.0).abs() < 1e-5,
        "{exposures:?}"
    );
    assert_eq!(exposures.count, 2);
    assert_eq!(Exposures::of([&[0.0; 4]; 3]), None);
    assert_eq!(Exposures::of([&[-1.0; 4]; 3]), None);
}
