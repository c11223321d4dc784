//! Pictures are written whole, say what their colours mean, and show what is no number.
//!
//! Each test leaves its pictures in cargo's folder for temporaries, to look at.

use std::path::{Path, PathBuf};

use image::{Rgb, RgbImage};
use nephroid::internals::film::Grid;
use nephroid::internals::film::picture;
use nephroid::internals::film::picture::{BarRange, Content, PictureError, PictureSpec, Scale};
use proptest::prelude::*;

const MAGENTA: Rgb<u8> = Rgb([255, 0, 255]);
const WHITE: Rgb<u8> = Rgb([255, 255, 255]);

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// Writes a picture and reads it again.
fn picture(name: &str, title: &str, content: Content, range: Option<BarRange>) -> RgbImage {
    let spec = PictureSpec {
        title,
        unit: "W/m²",
        content,
        range,
    };
    picture::write(&path(name), &spec).unwrap();
    image::open(path(name)).unwrap().to_rgb8()
}

/// A bright nephroid over a slow slope; zero outside the unit circle.
fn cup(width: usize, height: usize) -> Grid<f32> {
    Grid::from_fn(width, height, |x, y| {
        let place = |i: usize, size: usize| (i as f64 + 0.5) / size as f64 * 2.2 - 1.1;
        let (x, y) = (place(x, width), place(y, height));
        let squared = x * x + y * y;
        // The nephroid inside the unit circle: 4 (x² + y² − 1/4)³ = 27/16 y².
        let level = 4.0 * (squared - 0.25).powi(3) - 27.0 / 16.0 * y * y;
        let irradiance = 0.2 + 0.05 / (level.abs() + 1e-4).sqrt() + 0.1 * x;
        if squared > 1.0 {
            0.0
        } else {
            irradiance as f32
        }
    })
}

/// The upper left pixel of the map: inside a margin of 12 font pixels, below title and frame.
fn map_origin(font: u32, title_lines: u32) -> (u32, u32) {
    (12 * font, 12 * font + title_lines * 11 * font + 3 * font)
}

/// True if the outermost pixels all have the background's colour: nothing is cut off.
fn has_clean_margin(picture: &RgbImage, margin: u32) -> bool {
    picture.enumerate_pixels().all(|(x, y, &colour)| {
        let inside = x >= margin
            && y >= margin
            && x < picture.width() - margin
            && y < picture.height() - margin;
        inside || colour == WHITE
    })
}

#[test]
fn nothing_is_cut_off_at_any_size() {
    let sizes = [
        (1, 1),
        (8, 8),
        (64, 64),
        (200, 150),
        (512, 512),
        (2048, 2048),
        (900, 20),
        (20, 900),
    ];
    for (width, height) in sizes {
        let values = cup(width, height);
        for scale in [Scale::Linear, Scale::Logarithmic] {
            let name = format!("cup_{width}x{height}_{scale:?}.png");
            let content = Content::FalseColour {
                values: &values,
                scale,
            };
            let title = "glass.xml: irradiance of all layers, beams";
            let picture = picture(&name, title, content, None);
            // The tightest margin is above the title's capitals: one font pixel less than 12.
            assert!(has_clean_margin(&picture, 8), "{name}");
            assert!(
                picture.width() as usize >= width + 24 && picture.height() as usize >= height + 24
            );
        }
    }
}

#[test]
fn small_maps_are_enlarged_by_a_whole_factor() {
    let values = Grid::from_fn(10, 10, |x, y| (10 * y + x) as f32);
    let content = Content::FalseColour {
        values: &values,
        scale: Scale::Linear,
    };
    let picture = picture("enlarged.png", "enlarged", content, None);
    let (left, top) = map_origin(1, 1);
    let zoom = 26; // the least that reaches 256
    for y in 0..260 {
        for x in 0..260 {
            let first = picture.get_pixel(left + x / zoom * zoom, top + y / zoom * zoom);
            assert_eq!(picture.get_pixel(left + x, top + y), first);
        }
    }
    // Row 0 is the top: the darkest texel is the first, the brightest the last.
    let sum = |x, y| {
        picture
            .get_pixel(left + x, top + y)
            .0
            .iter()
            .map(|&c| u32::from(c))
            .sum::<u32>()
    };
    assert!(sum(0, 0) < sum(259, 0) && sum(259, 0) < sum(0, 259) && sum(0, 259) < sum(259, 259));
}

#[test]
fn what_is_no_number_is_magenta_and_nothing_else_is() {
    let mut values = cup(256, 256);
    assert!(values.set(100, 50, f32::NAN));
    assert!(values.set(0, 255, f32::NAN));
    let rgb = values.map(|&value| [value, 0.5 * value, 0.0]);
    let contents = [
        Content::FalseColour {
            values: &values,
            scale: Scale::Linear,
        },
        Content::FalseColour {
            values: &values,
            scale: Scale::Logarithmic,
        },
        Content::Signed { values: &values },
        Content::ToneMapped { values: &rgb },
    ];
    for (i, content) in contents.into_iter().enumerate() {
        let picture = picture(&format!("nan_{i}.png"), "holes", content, None);
        let (left, top) = map_origin(1, 1);
        let places: Vec<(u32, u32)> = picture
            .enumerate_pixels()
            .filter(|(_, _, colour)| **colour == MAGENTA)
            .map(|(x, y, _)| (x - left, y - top))
            .collect();
        assert_eq!(places, [(100, 50), (0, 255)], "content {i}");
    }
}

#[test]
fn the_colour_on_the_map_is_that_beside_its_number_on_the_bar() {
    // A map whose rows run from the upper end to the lower one as the bar's do.
    for scale in [Scale::Linear, Scale::Logarithmic] {
        let values = Grid::from_fn(300, 300, |_, y| {
            let position = 1.0 - (y as f64 + 0.5) / 300.0;
            match scale {
                Scale::Linear => (2.0 + 6.0 * position) as f32,
                Scale::Logarithmic => (0.01 * 1000f64.powf(position)) as f32,
            }
        });
        let range = match scale {
            Scale::Linear => BarRange {
                low: 2.0,
                high: 8.0,
            },
            Scale::Logarithmic => BarRange {
                low: 0.01,
                high: 10.0,
            },
        };
        let content = Content::FalseColour {
            values: &values,
            scale,
        };
        let picture = picture(&format!("bar_{scale:?}.png"), "bar", content, Some(range));
        let (left, top) = map_origin(1, 1);
        let bar = left + 300 + 12;
        for y in 0..300 {
            let [on_map, on_bar] = [left + 10, bar + 5].map(|x| picture.get_pixel(x, top + y).0);
            // The map's values were rounded to f32: at most one step of a byte.
            let near = on_map.iter().zip(on_bar).all(|(&a, b)| a.abs_diff(b) <= 1);
            assert!(near, "row {y}: {on_map:?} {on_bar:?}");
        }
    }
}

#[test]
fn zero_is_white_in_a_signed_map_and_black_in_the_others() {
    let values = Grid::from_fn(256, 256, |x, _| x as f32 - 100.0);
    let signed = picture(
        "signed.png",
        "beams - photons",
        Content::Signed { values: &values },
        None,
    );
    let (left, top) = map_origin(1, 1);
    assert_eq!(signed.get_pixel(left + 100, top), &Rgb([247, 247, 247]));
    let [red, _, blue] = signed.get_pixel(left + 255, top).0;
    assert!(red > blue);
    let [red, _, blue] = signed.get_pixel(left, top).0;
    assert!(blue > red);
    let rgb = Grid::from_fn(256, 256, |x, _| [x as f32, 0.5 * x as f32, 0.0]);
    let toned = picture(
        "toned.png",
        "LTTD",
        Content::ToneMapped { values: &rgb },
        None,
    );
    assert_eq!(toned.get_pixel(left, top), &Rgb([0, 0, 0]));
    // sRGB of 1 is 255, of 1/2 it is 188 (IEC 61966-2-1).
    assert_eq!(toned.get_pixel(left + 255, top), &Rgb([255, 188, 0]));
}

#[test]
fn the_same_map_gives_the_same_bytes() {
    let values = cup(128, 128);
    let content = Content::FalseColour {
        values: &values,
        scale: Scale::Logarithmic,
    };
    let bytes = [0, 1].map(|i| {
        let name = format!("same_{i}.png");
        picture(&name, "same", content, None);
        std::fs::read(path(&name)).unwrap()
    });
    assert_eq!(bytes[0], bytes[1]);
}

#[test]
fn maps_and_ranges_that_make_no_picture_are_refused() {
    let values = cup(8, 8);
    let write = |content, range| {
        let spec = PictureSpec {
            title: "bad",
            unit: "W/m²",
            content,
            range,
        };
        picture::write(&path("never.png"), &spec).unwrap_err()
    };
    let empty = Grid::from_fn(0, 5, |_, _| 0.0f32);
    let linear = Content::FalseColour {
        values: &values,
        scale: Scale::Linear,
    };
    let logarithmic = Content::FalseColour {
        values: &values,
        scale: Scale::Logarithmic,
    };
    let error = write(Content::Signed { values: &empty }, None);
    assert!(
        matches!(
            error,
            PictureError::Size {
                width: 0,
                height: 5
            }
        ),
        "{error}"
    );
    let ranges = [
        (linear, 1.0, 1.0),
        (linear, 2.0, 1.0),
        (linear, f64::NAN, 1.0),
        (linear, 0.0, f64::INFINITY),
        (logarithmic, 0.0, 1.0),
        (logarithmic, -1.0, 1.0),
    ];
    for (content, low, high) in ranges {
        let error = write(content, Some(BarRange { low, high }));
        assert!(
            matches!(error, PictureError::Range { .. }),
            "{low} {high}: {error}"
        );
    }
    assert!(!path("never.png").exists());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(50))]
    #[test]
    fn any_values_and_titles_make_a_picture(
        bits in prop::collection::vec(any::<u32>(), 6),
        title in any::<String>(),
        few in any::<bool>(),
    ) {
        // All bit patterns: subnormals, infinities, NaN; or just small whole numbers.
        let value = |i: usize| if few { (bits[i] % 3) as f32 } else { f32::from_bits(bits[i]) };
        let values = Grid::from_fn(3, 2, |x, y| value(3 * y + x));
        for content in [
            Content::FalseColour { values: &values, scale: Scale::Linear },
            Content::FalseColour { values: &values, scale: Scale::Logarithmic },
            Content::Signed { values: &values },
        ] {
            let picture = picture("any.png", &title, content, None);
            prop_assert!(picture.width() > 256);
        }
    }
}
