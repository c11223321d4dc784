//! A scene in both programs: Mitsuba's image from a file, ours rendered now, and what tests say of the two.

use std::path::{Path, PathBuf};

use nephroid::internals::film::{Channel, Image, exr};
use nephroid::internals::metric::{
    CompareImage, CompareSettings, ImageSide, LayerComparison, Pairing, Verdict,
};
use nephroid::internals::mitsuba::load;
use nephroid::internals::reference::path::{PathSettings, run};
use nephroid::internals::run::Budget;
use nephroid::internals::run::{Layer, Progress};
use nephroid::internals::scene::{Crop, Scene, Sensor};

/// Replicates of our images. Mitsuba's have as many seeds: see `tests/mitsuba/parity/render.py`.
pub const REPLICATES: u32 = 32;

/// Result of the tests of two images of a scene.
#[derive(Debug)]
pub struct Outcome {
    /// The scene's name.
    pub name: String,
    /// Pixels a row and rows of what was compared.
    pub size: [usize; 2],
    /// Our mean less Mitsuba's, relative, and its standard error.
    pub bias: [f64; 2],
    /// Length of the difference that noise does not explain, relative: estimate and upper bound.
    pub unexplained: [f64; 2],
    /// Verdict on mean and pixels being the same within 1 %, by two one-sided tests of 95 % confidence.
    pub verdict: Verdict,
    /// Number of pixels and channels for which both programs have an error bar.
    pub tests: u64,
    /// Mean z²; some 1.03 for 62 degrees of freedom, where images agree.
    pub mean_square_z: f64,
    /// The probability of p-values so far from uniform; `None` with too few of them.
    pub uniformity: Option<f64>,
    /// The probability of a smallest p-value so small.
    pub extreme: f64,
}

/// Our image of a scene's first sensor, `samples` a pixel and replicate.
pub fn render(scene: &Scene, sensor: &Sensor, settings: PathSettings, samples: u64) -> Image {
    let settings = PathSettings {
        replicates: REPLICATES,
        ..settings
    };
    let budget = Budget {
        work: Some(samples * u64::from(REPLICATES)),
        ..Budget::default()
    };
    let (estimate, report) = run(scene, sensor, settings, &budget, &Progress::default())
        .unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(report.cut_off, 0);
    image_of(&estimate.total, estimate.width, estimate.height)
}

/// A layer as an image that `metric` reads.
pub fn image_of(layer: &Layer, width: usize, height: usize) -> Image {
    let triples = |values: &[nephroid::internals::radiometry::Rgb]| -> Vec<[f64; 3]> {
        values.iter().map(|value| value.0).collect()
    };
    let mut image = Image::new(width, height);
    image.add_rgb("L", &triples(&layer.values));
    image.add_rgb("L.stderr", &triples(&layer.standard_error));
    image.add_metadata("settings", format!("{{\"replicates\": {REPLICATES}}}"));
    image
}

/// Mitsuba's image, with standard errors that may be rounding set to zero, which says "not known".
///
/// Its film sums n samples in single precision, which may move the sum by n u of itself, u = 2⁻²⁴ (Higham
/// 2002, section 4.2), the same way in every seed where samples are much alike: a background, a lamp.
/// Standard errors below ten times that could be explained by it, to a tenth.
pub fn mitsuba_image(path: &Path) -> Image {
    let mut image = exr::read(path).unwrap_or_else(|error| panic!("{error}"));
    let rounding = 10.0 * samples_of(&image) as f64 * 2.0_f64.powi(-24);
    for component in ["R", "G", "B"] {
        let values = image.channel(component).unwrap().samples.clone();
        let name = format!("stderr.{component}");
        let errors = (image.channels.iter_mut())
            .find(|channel| channel.name == name)
            .unwrap();
        for (error, value) in errors.samples.iter_mut().zip(values) {
            if f64::from(*error) < rounding * f64::from(value) {
                *error = 0.0;
            }
        }
    }
    image
}

/// Mitsuba's samples a pixel and seed.
pub fn samples_of(image: &Image) -> u64 {
    image.metadata("samples").unwrap().parse().unwrap()
}

/// Every `stride`-th pixel of every `stride`-th row.
///
/// A sample reaches pixels whose centres are nearer than the filter's radius r: pixels 2r apart share none,
/// and have independent errors, which all tests take for granted.
fn thinned(image: &Image, stride: usize) -> Image {
    let channels = image.channels.iter().map(|channel| Channel {
        name: channel.name.clone(),
        samples: (0..image.height)
            .step_by(stride)
            .flat_map(|y| (0..image.width).step_by(stride).map(move |x| (x, y)))
            .map(|(x, y)| channel.samples[y * image.width + x])
            .collect(),
    });
    Image {
        width: image.width.div_ceil(stride),
        height: image.height.div_ceil(stride),
        channels: channels.collect(),
        metadata: image.metadata.clone(),
    }
}

/// Tests of our image against Mitsuba's.
pub fn outcome(name: &str, ours: &Image, mitsuba: &Image, filter_radius: f64) -> Outcome {
    let stride = (2.0 * filter_radius).ceil() as usize;
    let [mitsuba, ours] = [("Mitsuba", mitsuba), ("ours", ours)]
        .map(|(name, image)| CompareImage::new(name, thinned(image, stride)));
    assert_eq!(mitsuba.samples, Some(u64::from(REPLICATES)));
    let pairing = Pairing::new(&mitsuba, &ours, ImageSide::A, &[]).unwrap();
    let settings = CompareSettings {
        margin: 0.01,
        level: 0.05,
        pixels_per_degree: None,
        ..CompareSettings::default()
    };
    let found = LayerComparison::of(&pairing.pairs[0], &settings);
    let significance = found.significance.unwrap();
    let equivalence = found.equivalence;
    let unknown = f64::NAN;
    Outcome {
        name: name.to_owned(),
        size: found.size,
        bias: [
            equivalence.bias.relative.unwrap_or(unknown),
            equivalence.bias.standard_error.unwrap_or(unknown),
        ],
        unexplained: [
            equivalence.texels.unexplained.unwrap_or(unknown),
            equivalence
                .texels
                .interval
                .map_or(unknown, |[_, high]| high),
        ],
        verdict: equivalence.verdict,
        tests: significance.tests,
        mean_square_z: significance.mean_square_z,
        uniformity: significance.uniformity.map(|test| test.p),
        extreme: significance.family.p,
    }
}

impl std::fmt::Display for Outcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let percent = |value: f64| 100.0 * value;
        write!(
            f,
            "{:<44} {} x {} bias {:+.3} ± {:.3} %, unexplained {:.2} (< {:.2}) %, {}; {} tests, z² {:.3}, uniform p ",
            self.name,
            self.size[0],
            self.size[1],
            percent(self.bias[0]),
            percent(self.bias[1]),
            percent(self.unexplained[0]),
            percent(self.unexplained[1]),
            self.verdict.name(),
            self.tests,
            self.mean_square_z,
        )?;
        match self.uniformity {
            Some(p) => write!(f, "{p:.4}")?,
            None => f.write_str("-")?,
        }
        write!(f, ", extreme p {:.4}", self.extreme)
    }
}

/// The sensor with a film of another size, without its crop.
pub fn scaled(sensor: &Sensor, width: usize, height: usize) -> Sensor {
    let mut sensor = sensor.clone();
    let [width, height] = [width, height].map(|size| u32::try_from(size).unwrap());
    sensor.film.width = width;
    sensor.film.height = height;
    sensor.film.crop = Crop {
        offset_x: 0,
        offset_y: 0,
        width,
        height,
    };
    sensor
}

/// The folder of the suite's scenes.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mitsuba/parity")
}

/// A scene of the suite, as it is on disk.
pub fn scene(name: &str) -> Scene {
    load(&folder().join(format!("{name}.xml")), &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// The names of all scenes of the suite, sorted.
pub fn names() -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|it| it == "xml"))
        .map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    names.sort();
    names
}
