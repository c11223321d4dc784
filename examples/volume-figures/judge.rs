//! Renderings of meters against the truth by beams, and tables.

use std::collections::BTreeMap;

use nephroid::internals::film::Image;
use nephroid::internals::method::Method;
use nephroid::internals::metric::fidelity::{self, Fidelity};
use nephroid::internals::metric::{CompareImage, Figure};
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::format::three_digits;
use nephroid::internals::run::{Budget, Context, Light, Rendering, texels};
use nephroid::internals::scene::{Scene, Sensor};
use nephroid::internals::study::attribution::{Truth, truth_by_beams};

use crate::support::approximation::bundled;
use crate::support::pool::{line, metered, rendered, sensor};

/// Texels a row of meters, and rows.
pub const SIDE: usize = 128;

/// Likely error of the truth.
pub const TRUTH: f64 = 0.003;

/// Meters with their truths, made once.
#[derive(Default)]
pub struct Judge {
    known: BTreeMap<String, Case>,
}

/// A meter and its truth.
pub struct Case {
    pub scene: Scene,
    pub meter: &'static str,
    pub truth: Truth,
}

impl Judge {
    /// The floor of `water`.
    pub fn water(&mut self) -> &Case {
        self.case("water", "floor", || bundled("water", SIDE))
    }

    /// A meter of the pool.
    pub fn pool(&mut self, occluder: &str, meter: &'static str) -> &Case {
        self.case(&format!("pool {occluder}"), meter, || {
            metered(occluder, SIDE)
        })
    }

    fn case(&mut self, name: &str, meter: &'static str, scene: impl FnOnce() -> Scene) -> &Case {
        self.known
            .entry(format!("{name} {meter}"))
            .or_insert_with(|| {
                let scene = scene();
                let light = Light::Path("LTD".parse().expect("a signature"));
                let budget = Budget::error(TRUTH);
                let context = Context::default();
                let truth = truth_by_beams(&scene, sensor(&scene, meter), light, &budget, &context);
                Case {
                    truth: truth.expect("a truth by beams"),
                    scene,
                    meter,
                }
            })
    }
}

impl Case {
    pub fn sensor(&self) -> &Sensor {
        sensor(&self.scene, self.meter)
    }

    /// What a light volume makes of it, and its figures.
    pub fn judged(&self, volume: &Method) -> (Rendering, Fidelity) {
        let rendering = rendered(&self.scene, self.meter, volume);
        let found = figures(
            &self.scene,
            self.sensor(),
            &self.truth.modelled,
            &rendering.estimate.total.values,
        );
        (rendering, found)
    }

    /// A figure in percent, or in texels.
    pub fn figure(&self, volume: &Method, figure: Figure) -> String {
        shown(&self.judged(volume).1, figure)
    }
}

/// The figures of some values against others.
pub fn figures(scene: &Scene, sensor: &Sensor, truth: &[Rgb], values: &[Rgb]) -> Fidelity {
    let image = |name: &str, values: &[Rgb]| {
        let [width, height] = sensor.size();
        let mut image = Image::new(width, height);
        let triples: Vec<[f64; 3]> = values.iter().map(|value| value.0).collect();
        image.add_rgb("E", &triples);
        texels::describe(&mut image, scene, sensor);
        CompareImage::new(name, image)
    };
    fidelity::of(&image("the truth", truth), &image("the volume", values)).expect("two alike films")
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
