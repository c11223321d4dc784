//! The report as one page that needs nothing else: figures, films, plots and the scripts that show them.

use std::collections::BTreeSet;
use std::path::Path;

use rayon::prelude::*;
use serde::Serialize;

use super::super::StudyError;
use super::super::layers::add_specular;
use super::figures::{SensorFigures, StudyReport, Timings};
use super::planes::{Digits, EncodedPlane, reduced};
use crate::film::{Image, exr};
use crate::metric::compare_image::NOT_LIGHT;
use crate::metric::{CompareImage, Flip, ImageSide, Maps, Pairing, flip, texel_grid};
use crate::run::LayerName;

/// Largest size of the page's images \[bytes\]; larger films are averaged over squares of texels.
const LARGEST: usize = 14_000_000;

/// The data that the page's script reads.
#[derive(Serialize)]
struct Data<'a> {
    report: &'a StudyReport,
    timings: &'a Timings,
    /// In the order of the report's sensors.
    pictures: Vec<Pictures>,
}

/// The images of one sensor.
#[derive(Serialize)]
struct Pictures {
    /// Texels a row and rows of the images.
    size: [usize; 2],
    /// Side of the square of the film's texels whose mean is one texel here.
    step: usize,
    /// Width and height of a texel of the film \[m\], if that is known.
    spacing: Option<[f64; 2]>,
    planes: Vec<EncodedPlane>,
}

/// A film's images at full size.
struct PageFilm {
    file: String,
    /// Channels averaged.
    value: Vec<f32>,
    /// Red, green and blue, if they are not the same.
    colour: Option<[Vec<f32>; 3]>,
    /// One standard error, or half the distance of bounds; `None` if the film has neither.
    bar: Option<Vec<f32>>,
    z: Option<Vec<f32>>,
    /// HDR-FLIP of the light that the row is judged by.
    flip: Option<Vec<f32>>,
    /// Width and height of a texel \[m\], if that is known.
    spacing: Option<[f64; 2]>,
    /// True for a layer that no row is judged by.
    is_extra: bool,
}

/// The page of a report in a folder with its films.
///
/// # Errors
///
/// If a film cannot be read or compared.
pub fn page(folder: &Path, report: &StudyReport, timings: &Timings) -> Result<String, StudyError> {
    let mut films: Vec<Vec<PageFilm>> = report
        .sensors
        .iter()
        .map(|sensor| films(folder, sensor))
        .collect::<Result<_, _>>()?;
    let pictures = |films: &[Vec<PageFilm>]| -> Vec<Pictures> {
        let sensors = films.iter().zip(&report.sensors);
        sensors
            .map(|(films, sensor)| Pictures::new(films, sensor.size, 1))
            .collect()
    };
    let bytes = |pictures: &[Pictures]| pictures.iter().map(Pictures::bytes).sum::<usize>();
    let mut made = pictures(&films);
    // Single layers give way before texels do.
    if bytes(&made) > LARGEST {
        for films in &mut films {
            films.retain(|film| !film.is_extra);
        }
        made = pictures(&films);
    }
    let mut pictures = made;
    // The sensor that takes most room gives way, until all fit.
    while bytes(&pictures) > LARGEST {
        let sizes = pictures.iter().map(Pictures::bytes).enumerate();
        let Some((most, _)) = sizes.max_by_key(|(_, bytes)| *bytes) else {
            break;
        };
        let (size, step) = (report.sensors[most].size, 2 * pictures[most].step);
        if step > size[0].max(size[1]) {
            break;
        }
        pictures[most] = Pictures::new(&films[most], size, step);
    }
    let data = Data {
        report,
        timings,
        pictures,
    };
    // A text in the data must not end the script that it is in.
    let json = serde_json::to_string(&data)?.replace('<', "\\u003c");
    let title = format!("{} · nephroid validate", escaped(&report.study.scene));
    let scripts = [
        include_str!("format.js"),
        include_str!("viewer.js"),
        include_str!("export.js"),
        include_str!("plot.js"),
        include_str!("profile.js"),
        include_str!("scales.js"),
        include_str!("stages.js"),
        include_str!("flux.js"),
        include_str!("sensor.js"),
        include_str!("page.js"),
    ];
    Ok(include_str!("page.html")
        .replace("/*style*/", include_str!("style.css"))
        .replace("{{title}}", &title)
        .replace("/*script*/", &scripts.join("\n"))
        // Last: nothing is replaced inside the data.
        .replacen("{{data}}", &json, 1))
}

/// The films of a sensor: the truth, each row, and the truth's layers that rows are judged by.
fn films(folder: &Path, sensor: &SensorFigures) -> Result<Vec<PageFilm>, StudyError> {
    let read = |file: &str| exr::read(&folder.join(file));
    let mut truth = CompareImage::new(sensor.truth.file.clone(), read(&sensor.truth.file)?);
    let specular = LayerName::Specular.to_string();
    if sensor.rows.iter().any(|row| row.layer == specular) {
        add_specular(&mut truth.image);
    }
    let total = sensor.quantity.symbol();
    let mut films = vec![PageFilm::of(&truth.image, &sensor.truth.file, total)];
    let brightest = brightest(&truth.image, total);
    let extra = |image: &Image, file: &str, layer: &str| PageFilm {
        is_extra: true,
        bar: None,
        colour: None,
        ..PageFilm::of(image, &format!("{file}#{layer}"), layer)
    };
    for row in &sensor.rows {
        let other = CompareImage::new(row.file.clone(), read(&row.file)?);
        if row.layer == total {
            let known = brightest
                .iter()
                .filter(|layer| mean(&other.image, layer, "").is_some());
            films.extend(known.map(|layer| extra(&other.image, &row.file, layer)));
        }
        let mut film = PageFilm::of(&other.image, &row.file, &row.layer);
        let pairing = Pairing::new(
            &truth,
            &other,
            ImageSide::A,
            std::slice::from_ref(&row.layer),
        )?;
        film.flip = pairing
            .pairs
            .first()
            .and_then(|pair| Flip::map(pair, flip::PIXELS_PER_DEGREE));
        let z = pairing.pairs.first().and_then(|pair| Maps::of(pair).z);
        film.z = z.map(|grid| grid.iter().copied().collect());
        films.push(film);
    }
    // Rows that are judged by one layer are shown beside that layer of the truth.
    let layers = sensor
        .rows
        .iter()
        .map(|row| row.layer.as_str())
        .filter(|layer| *layer != total);
    let judged: BTreeSet<&str> = layers.collect();
    let others = brightest
        .iter()
        .filter(|layer| !judged.contains(layer.as_str()));
    films.extend(others.map(|layer| extra(&truth.image, &sensor.truth.file, layer)));
    for layer in judged {
        films.push(PageFilm::of(
            &truth.image,
            &format!("{}#{layer}", sensor.truth.file),
            layer,
        ));
    }
    Ok(films)
}

/// The brightest layers of a truth, if they have a hundredth of all light or more.
fn brightest(truth: &Image, total: &str) -> Vec<String> {
    const MOST: usize = 3;
    const LEAST: f64 = 0.01;
    let sum = |layer: &str| -> f64 {
        let values = mean(truth, layer, "").unwrap_or_default();
        values.iter().map(|value| f64::from(*value)).sum()
    };
    let is_light =
        |layer: &&str| *layer != total && !NOT_LIGHT.contains(layer) && !layer.contains('.');
    let names = truth.channels.iter();
    let names = names.filter_map(|channel| channel.name.rsplit_once('.').map(|(layer, _)| layer));
    let names: BTreeSet<&str> = names.filter(is_light).collect();
    let all = sum(total);
    let mut layers: Vec<(f64, &str)> = names.into_iter().map(|name| (sum(name), name)).collect();
    layers.retain(|(sum, _)| *sum >= LEAST * all);
    layers.sort_by(|a, b| b.0.total_cmp(&a.0));
    layers.truncate(MOST);
    layers
        .into_iter()
        .map(|(_, name)| name.to_owned())
        .collect()
}

impl Pictures {
    fn new(films: &[PageFilm], size: [usize; 2], step: usize) -> Self {
        let mut images = Vec::new();
        for (i, film) in films.iter().enumerate() {
            let digits = if i == 0 { Digits::Five } else { Digits::Four };
            images.push((film, "value", &film.value, digits));
            images.extend(film.bar.as_ref().map(|bar| (film, "bar", bar, Digits::Two)));
            let flip = film.flip.as_ref();
            images.extend(flip.map(|flip| (film, "flip", flip, Digits::Two)));
            images.extend(film.z.as_ref().map(|z| (film, "z", z, Digits::Two)));
            let names = ["red", "green", "blue"].into_iter();
            let channels = names.zip(film.colour.iter().flatten());
            // A screen has 8 bits: its darkest step is 0.8 %, and all others are more.
            images.extend(channels.map(|(name, values)| (film, name, values, Digits::Two)));
        }
        let planes = images
            .into_par_iter()
            .map(|(film, kind, values, digits)| {
                EncodedPlane::new(&film.file, kind, &reduced(values, size, step), digits)
            })
            .collect();
        Self {
            size: size.map(|n| n.div_ceil(step)),
            step,
            // The truth's is the first.
            spacing: films.first().and_then(|film| film.spacing),
            planes,
        }
    }

    fn bytes(&self) -> usize {
        self.planes.iter().map(|plane| plane.data.len()).sum()
    }
}

impl PageFilm {
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
        let names = ["E", "L", ""];
        let colour = if names.contains(&layer) {
            names.iter().find_map(|name| colour(image, name))
        } else {
            colour(image, layer)
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
            colour,
            bar,
            z: None,
            flip: None,
            spacing: texel_grid::spacing(image),
            is_extra: false,
        }
    }
}

/// The mean of the channels of a layer, or of one of its error bars; `None` if it has none.
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

/// The channels of a layer; `None` if they are the same.
fn colour(image: &Image, layer: &str) -> Option<[Vec<f32>; 3]> {
    let dot = if layer.is_empty() { "" } else { "." };
    let channel = |component: &str| {
        let channel = image.channel(&format!("{layer}{dot}{component}"))?;
        Some(channel.samples.clone())
    };
    let channels = [channel("R")?, channel("G")?, channel("B")?];
    let bits = |values: &[f32]| values.iter().map(|it| it.to_bits()).collect::<Vec<_>>();
    let red = bits(&channels[0]);
    let is_grey = channels[1..].iter().all(|other| bits(other) == red);
    (!is_grey).then_some(channels)
}

/// Text for HTML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
