//! What the examples share that make figures of documents: tables, figures of an image against another,
//! attributions and pictures.

use std::path::Path;
use std::time::Instant;

use image::{Rgb as Pixel, RgbImage};
use nephroid::internals::film::Image;
use nephroid::internals::metric::fidelity::{self, Fidelity};
use nephroid::internals::metric::{
    CompareImage, CompareSettings, Figure, LayerComparison, compare,
};
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::format::three_digits;
use nephroid::internals::run::texels;
use nephroid::internals::scene::{Scene, Sensor};
use nephroid::internals::study::attribution::Attribution;

use super::pool::line;

/// Makes the tables of a section from what sections share.
pub type Section<T> = fn(&mut T) -> Vec<String>;

/// Prints the sections that the command line names, or all.
pub fn print_sections<T: Default>(sections: &[(&str, Section<T>)]) {
    let named: Vec<String> = std::env::args().skip(1).collect();
    if let Some(unknown) = named
        .iter()
        .find(|name| sections.iter().all(|(known, _)| known != name))
    {
        let known: Vec<&str> = sections.iter().map(|(name, _)| *name).collect();
        eprintln!("no section {unknown}: there are {}", known.join(", "));
        std::process::exit(2);
    }
    let mut shared = T::default();
    for (name, tables) in sections {
        if named.is_empty() || named.iter().any(|it| it == name) {
            let start = Instant::now();
            println!("## {name}\n");
            for table in tables(&mut shared) {
                println!("{table}\n");
            }
            eprintln!("{name}: {:.1} s", start.elapsed().as_secs_f64());
        }
    }
}

/// Some values as an image that can be compared.
fn image_of(scene: &Scene, sensor: &Sensor, name: &str, values: &[Rgb]) -> CompareImage {
    let [width, height] = sensor.size();
    let mut image = Image::new(width, height);
    let triples: Vec<[f64; 3]> = values.iter().map(|value| value.0).collect();
    image.add_rgb("E", &triples);
    texels::describe(&mut image, scene, sensor);
    CompareImage::new(name, image)
}

/// The figures of light of some values against others.
pub fn figures(scene: &Scene, sensor: &Sensor, truth: &[Rgb], values: &[Rgb]) -> Fidelity {
    let image = |name: &str, values| image_of(scene, sensor, name, values);
    fidelity::of(&image("the truth", truth), &image("the image", values)).expect("two alike films")
}

/// All figures of some values against others, SSIM and FLIP among them.
pub fn compared(scene: &Scene, sensor: &Sensor, truth: &[Rgb], values: &[Rgb]) -> LayerComparison {
    let image = |name: &str, values| image_of(scene, sensor, name, values);
    let [truth, other] = [image("the truth", truth), image("the image", values)];
    let found = compare(&truth, &other, &CompareSettings::default()).expect("two alike films");
    found.layers.into_iter().next().expect("one layer")
}

/// A figure in percent, or in texels; energy as what there is of it.
pub fn shown(found: &Fidelity, figure: Figure) -> String {
    let Some(value) = figure.of_light(found).map(|it| it.value) else {
        return "-".to_owned();
    };
    match figure {
        Figure::Energy => three_digits(100.0 * (1.0 + value)),
        Figure::Displaced | Figure::Resolution => three_digits(value),
        _ => three_digits(100.0 * value),
    }
}

/// A table from its head and its lines; columns of a head that begins with `>` are numbers.
pub fn table(head: &[&str], lines: &[Vec<String>]) -> String {
    let names = head.iter().map(|it| it.trim_start_matches('>').to_owned());
    let rule = head
        .iter()
        .map(|it| if it.starts_with('>') { "--:" } else { "---" });
    let names: Vec<String> = names.collect();
    let mut all = vec![
        line(&names),
        format!("|{}|", rule.collect::<Vec<_>>().join("|")),
    ];
    all.extend(lines.iter().map(|cells| line(cells)));
    all.join("\n")
}

/// A whole number, by thousands.
pub fn whole(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Two tables of attributions, each with the seconds that it took: figures, and Shapley's values of L1.
pub fn attributions(all: &[(String, Attribution, f64)]) -> Vec<String> {
    let (mut figures, mut shares) = (Vec::new(), Vec::new());
    let mut names = Vec::new();
    for (name, found, seconds) in all {
        let whole = |figure: Figure, factor: f64, offset: f64| {
            let value = found.of(figure).map(|shares| shares.whole + offset);
            value.map_or("-".to_owned(), |value| three_digits(factor * value))
        };
        figures.push(vec![
            name.clone(),
            whole(Figure::Energy, 100.0, 1.0),
            whole(Figure::L1, 100.0, 0.0),
            whole(Figure::Misplaced, 100.0, 0.0),
            whole(Figure::Displaced, 1.0, 0.0),
            whole(Figure::L2, 100.0, 0.0),
            if found.not_modelled.is_nan() {
                "-".to_owned()
            } else {
                three_digits(100.0 * found.not_modelled)
            },
            found.runs.to_string(),
            format!("{seconds:.1}"),
        ]);
        let Some(l1) = found.of(Figure::L1) else {
            continue;
        };
        // Stages that add nothing anywhere are left out: those that meters or the defaults have exact.
        names = found.stages.iter().map(|it| it.name.clone()).collect();
        let mut cells = vec![name.clone(), three_digits(100.0 * l1.whole)];
        cells.extend(l1.stages.iter().map(|stage| {
            let percent = 100.0 * stage.share.value;
            if percent.abs() < 0.005 {
                "0".to_owned()
            } else {
                format!("{percent:+.2} ± {:.2}", 100.0 * stage.share.standard_error)
            }
        }));
        cells.push(three_digits(100.0 * l1.residual));
        shares.push(cells);
    }
    vec![
        table(
            &[
                "scene",
                ">energy",
                ">L1",
                ">misplaced",
                ">displaced [texels]",
                ">L2",
                ">not modelled",
                ">runs",
                ">s",
            ],
            &figures,
        ),
        table_of_shares(&names, &shares),
    ]
}

/// A table of Shapley's values of L1: the whole, each stage's share, and what is left with all of them exact.
pub fn table_of_shares(stages: &[String], lines: &[Vec<String>]) -> String {
    let mut head = vec!["scene".to_owned(), ">L1".to_owned()];
    head.extend(stages.iter().map(|name| format!(">{name}")));
    head.push(">all exact".to_owned());
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    table(&head, lines)
}

/// Pixels between the images of a picture.
const GAP: usize = 6;

/// Writes images of one size beside each other, row by row, into a file of `docs/`; `white` is the value that
/// is white.
pub fn save_picture(name: &str, [width, height]: [usize; 2], white: f64, rows: &[Vec<Vec<Rgb>>]) {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let along = |count: usize, size: usize| (count * (size + GAP)).saturating_sub(GAP) as u32;
    let mut picture = RgbImage::from_pixel(
        along(columns, width),
        along(rows.len(), height),
        Pixel([255, 255, 255]),
    );
    for (row, images) in rows.iter().enumerate() {
        for (column, values) in images.iter().enumerate() {
            for (texel, value) in values.iter().enumerate() {
                let (x, y) = (
                    texel % width + column * (width + GAP),
                    texel / width + row * (height + GAP),
                );
                // The curve of sRGB, near enough for a picture.
                let byte =
                    |it: f64| (255.0 * (it / white).clamp(0.0, 1.0).powf(1.0 / 2.2)).round() as u8;
                picture.put_pixel(x as u32, y as u32, Pixel(value.0.map(byte)));
            }
        }
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("docs")
        .join(name);
    picture.save(&file).expect("a file that can be written");
}
