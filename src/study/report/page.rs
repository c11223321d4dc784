//! The report as one page that needs nothing else: figures, films, plots and what shows them.

use std::path::Path;

use rayon::prelude::*;
use serde::Serialize;

use super::super::StudyError;
use super::figures::{Report, Timings};
use super::planes::{Digits, Plane, reduced};
use crate::film::{Image, exr};
use crate::metric::{Maps, Pairing, Side, Source};

/// The page may be so large \[bytes\]; where films at full size are more, they are averaged over squares of texels.
const LARGEST: usize = 14_000_000;

/// What the page's script reads.
#[derive(Serialize)]
struct Data<'a> {
    report: &'a Report,
    timings: &'a Timings,
    /// Texels a row and rows of the images.
    size: [usize; 2],
    /// Texels of the films that one of theirs is the mean of, each way.
    step: usize,
    planes: Vec<Plane>,
}

/// A film's images at full size, channels averaged.
struct Film {
    file: String,
    value: Vec<f32>,
    /// One standard error, or half the distance of bounds; `None` where the film has neither.
    bar: Option<Vec<f32>>,
    z: Option<Vec<f32>>,
}

/// The page of a report in a folder with its films.
///
/// # Errors
///
/// Where a film cannot be read or compared.
pub fn page(folder: &Path, report: &Report, timings: &Timings) -> Result<String, StudyError> {
    let read = |file: &str| exr::read(&folder.join(file));
    let truth = Source::new(report.truth.file.clone(), read(&report.truth.file)?);
    let total = report.study.quantity.symbol();
    let mut films = vec![Film::of(&truth.image, &report.truth.file, total)];
    for row in &report.rows {
        let other = Source::new(row.file.clone(), read(&row.file)?);
        let mut film = Film::of(&other.image, &row.file, &row.layer);
        let pairing = Pairing::new(&truth, &other, Side::A, std::slice::from_ref(&row.layer))?;
        let z = pairing.pairs.first().and_then(|pair| Maps::of(pair).z);
        film.z = z.map(|grid| grid.iter().copied().collect());
        films.push(film);
    }
    // Rows that are judged by one layer are shown beside that layer of the truth.
    let layers = report
        .rows
        .iter()
        .map(|row| row.layer.as_str())
        .filter(|layer| *layer != total);
    for layer in layers.collect::<std::collections::BTreeSet<_>>() {
        films.push(Film::of(
            &truth.image,
            &format!("{}#{layer}", report.truth.file),
            layer,
        ));
    }
    let size = report.study.size;
    let mut step = 1;
    let planes = loop {
        let planes = encoded(&films, size, step);
        let bytes: usize = planes.iter().map(|plane| plane.data.len()).sum();
        if bytes <= LARGEST || step >= size[0].max(size[1]) {
            break planes;
        }
        step *= 2;
    };
    let data = Data {
        report,
        timings,
        size: size.map(|n| n.div_ceil(step)),
        step,
        planes,
    };
    // A text in the data must not end the script that it is in.
    let json = serde_json::to_string(&data)?.replace('<', "\\u003c");
    let title = format!("{} · nephroid validate", escaped(&report.study.scene));
    let scripts = [
        include_str!("format.js"),
        include_str!("viewer.js"),
        include_str!("plot.js"),
        include_str!("stages.js"),
        include_str!("page.js"),
    ];
    Ok(include_str!("page.html")
        .replace("/*style*/", include_str!("style.css"))
        .replace("{{title}}", &title)
        .replace("/*script*/", &scripts.join("\n"))
        // Last: nothing is looked for in what the data hold.
        .replacen("{{data}}", &json, 1))
}

fn encoded(films: &[Film], size: [usize; 2], step: usize) -> Vec<Plane> {
    let images: Vec<_> = films
        .iter()
        .enumerate()
        .flat_map(|(i, film)| {
            let digits = if i == 0 { Digits::Five } else { Digits::Four };
            [
                Some((film, "value", &film.value, digits)),
                film.bar.as_ref().map(|bar| (film, "bar", bar, Digits::Two)),
                film.z.as_ref().map(|z| (film, "z", z, Digits::Two)),
            ]
        })
        .flatten()
        .collect();
    images
        .into_par_iter()
        .map(|(film, kind, values, digits)| {
            Plane::new(&film.file, kind, &reduced(values, size, step), digits)
        })
        .collect()
}

impl Film {
    fn of(image: &Image, file: &str, layer: &str) -> Self {
        let mean = |end: &str| {
            let names = ["E", "L", ""];
            let names = if names.contains(&layer) {
                &names[..]
            } else {
                &[layer]
            };
            names.iter().find_map(|name| mean(image, name, end))
        };
        let bar = match (mean("lo"), mean("hi")) {
            (Some(low), Some(high)) => {
                let pairs = low.iter().zip(&high);
                Some(pairs.map(|(low, high)| 0.5 * (high - low)).collect())
            }
            _ => mean("stderr"),
        };
        Self {
            file: file.to_owned(),
            value: mean("").unwrap_or_default(),
            bar,
            z: None,
        }
    }
}

/// The mean of the channels of a layer, or of one of its error bars; `None` where it has none.
fn mean(image: &Image, layer: &str, end: &str) -> Option<Vec<f32>> {
    let channel = |component: &str| {
        let parts = [layer, end, component];
        let parts: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        image.channel(&parts.join("."))
    };
    let colour: Option<Vec<_>> = ["R", "G", "B"].iter().map(|it| channel(it)).collect();
    let channels = colour.or_else(|| Some(vec![channel("Y")?]))?;
    let share = 1.0 / channels.len() as f64;
    let mean = |i: usize| -> f64 {
        channels
            .iter()
            .map(|one| share * f64::from(one.samples[i]))
            .sum()
    };
    Some(
        (0..image.width * image.height)
            .map(|i| mean(i) as f32)
            .collect(),
    )
}

/// Text for HTML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
