//! The method: a scene in, an estimate out.

use super::ball::BallOnAxis;
use super::cup::MirroringCup;
use super::known_layer::KnownLight;
use super::open::OpenLight;
use super::pane::Pane;
use super::parts::{Body, OneLight, SceneContents, contents};
use super::plane::ReceiverPlane;
use super::solid::SolidInParallelLight;
use crate::geometry::{Shape, TraversalCounters};
use crate::run::Refusal;
use crate::run::{Estimate, Layer, LayerName, Progress, Quantity};
use crate::scene::{Scene, Sensor};
use crate::transport::chain_limits::check_clear;
use crate::transport::ledger::Ledger;

/// Settings of the method of closed forms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClosedFormSettings {
    /// Largest number of specular events of a path; up to [`Self::MOST_EVENTS`].
    pub max_depth: u32,
}

impl ClosedFormSettings {
    /// The most specular events that may be asked for.
    ///
    /// A radial map is searched for its folds in 2048 cells, of which each reflection inside takes its share.
    pub const MOST_EVENTS: u32 = 32;
}

impl Default for ClosedFormSettings {
    fn default() -> Self {
        Self { max_depth: 16 }
    }
}

/// The irradiance of every texel of a sensor by the scene's closed form, a layer for each path that brings
/// light.
///
/// Bounds are those of the formula's quadrature and rounding: for a ball or a pane 1e-10 of a texel's value
/// and 4e-12 of the flux of the circles that meet it, for a cup 1e-7 of the irradiance without it, for a
/// solid with flat facets 1e-9 of the light's irradiance and what comes from corners off their facets'
/// planes. Nothing is traced: there are no paths, no counts, and no ledger.
///
/// # Errors
///
/// If the scene is none that a closed form solves.
pub fn solve(
    scene: &Scene,
    sensor: &Sensor,
    settings: ClosedFormSettings,
    progress: &Progress,
) -> Result<Estimate, Refusal> {
    if settings.max_depth > ClosedFormSettings::MOST_EVENTS {
        return Err(Refusal::new(format!(
            "max_depth is {}; 0 to {} specular events are allowed with closed forms",
            settings.max_depth,
            ClosedFormSettings::MOST_EVENTS
        )));
    }
    let (plane, light) = recognised(scene, sensor)?;
    let crop = sensor.film.crop;
    let (width, height) = (crop.width as usize, crop.height as usize);
    let mut total = Layer::bounded(LayerName::Total, width * height);
    let mut specular = total.clone();
    let mut layers = Vec::new();
    let mut is_first = true;
    progress.count_texels();
    progress.expect((width * height) as u64 * u64::from(settings.max_depth + 1));
    light.layers(&plane, settings.max_depth, &mut |known| {
        // Direct light, the first, is a layer even if there is none.
        if is_first || !known.is_dark() {
            let layer = known.into_layer();
            total.add(&layer);
            if !is_first {
                specular.add(&layer);
            }
            layers.push(layer);
        }
        is_first = false;
        progress.add((width * height) as u64);
        !progress.is_stopped()
    })?;
    let incomplete = progress.is_stopped();
    if incomplete {
        total.make_unknown();
    }
    Ok(Estimate {
        quantity: Quantity::Irradiance,
        width,
        height,
        total,
        layers,
        counts: vec![0; width * height],
        ledger: Ledger::default(),
        paths: 0,
        counters: TraversalCounters::default(),
        relative_error: specular.relative_error(),
        incomplete,
    })
}

/// Reports if [`solve`] knows the scene.
///
/// # Errors
///
/// One sentence about the first thing that no closed form takes.
pub fn supports(scene: &Scene, sensor: &Sensor) -> Result<(), Refusal> {
    recognised(scene, sensor).map(drop)
}

fn recognised(
    scene: &Scene,
    sensor: &Sensor,
) -> Result<(ReceiverPlane, Box<dyn KnownLight>), Refusal> {
    let SceneContents {
        plane,
        light,
        bodies,
    } = contents(scene, sensor)?;
    check_clear(scene).map_err(|error| Refusal::new(error.to_string()))?;
    let known = configuration(&plane, &light, &bodies)?;
    Ok((plane, known))
}

fn configuration(
    plane: &ReceiverPlane,
    light: &OneLight,
    bodies: &[Body],
) -> Result<Box<dyn KnownLight>, Refusal> {
    match bodies {
        [] => Ok(Box::new(OpenLight::new(plane, light)?)),
        [body] => match body.shape {
            Shape::Sphere(sphere) => Ok(Box::new(BallOnAxis::new(plane, light, body, sphere)?)),
            Shape::Cylinder(cylinder) => {
                Ok(Box::new(MirroringCup::new(plane, light, body, cylinder)?))
            }
            Shape::Mesh(mesh) => Ok(Box::new(SolidInParallelLight::new(
                plane, light, body, mesh,
            )?)),
            Shape::Rectangle(_) | Shape::Disk(_) => Err(Refusal::new(format!(
                "{} is a single flat surface beside the receiver: closed forms know a ball, a cylinder that mirrors \
                 inside, a solid with flat facets, or two faces of a pane",
                body.name
            ))),
        },
        [
            first @ Body {
                shape: Shape::Rectangle(one),
                ..
            },
            second @ Body {
                shape: Shape::Rectangle(two),
                ..
            },
        ] => Ok(Box::new(Pane::new(
            plane,
            light,
            [(first, one), (second, two)],
        )?)),
        [first, second, rest @ ..] => Err(Refusal::new(format!(
            "{} and {}{} are in the scene beside the receiver: closed forms know one body, or the two faces of a pane",
            first.name,
            second.name,
            if rest.is_empty() {
                String::new()
            } else {
                format!(" and {} more shapes", rest.len())
            }
        ))),
    }
}
