//! The result of a run: an estimate with everything that is known beside it.

use std::time::Duration;

use serde_json::{Map, Value};

use super::{Counter, Estimate, FluxEntry, Light, StageWork};
use crate::radiometry::Rgb;

/// The result of a run: an estimate with everything that is known beside it.
///
/// # Example: everything beside the values
///
/// ```
/// # use nephroid::{Budget, Context, Method};
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let method = Method::new("photons", &Default::default())?;
/// # let rendering = method.run(&scene, sensor, &Budget::work(4096), &Context::default())?;
/// for warning in &rendering.warnings {
///     eprintln!("warning: {warning}");
/// }
/// println!("{} {}", rendering.estimate.paths, rendering.unit);
/// assert_eq!(rendering.replicates, Some(32));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Rendering {
    /// Values with error bars, layer by layer.
    pub estimate: Estimate,
    /// The light that the method measures; it is judged by this light alone.
    pub light: Light,
    /// Independent replicates behind the standard errors; `None` for methods that draw nothing at random.
    pub replicates: Option<u32>,
    /// The unit of [`Estimate::paths`], in the plural.
    pub unit: &'static str,
    /// Work, counted: noise-free, in the order of importance.
    pub counters: Vec<Counter>,
    /// Work and time by stage; empty for references.
    pub stages: Vec<StageWork>,
    /// Work and time of preparations that later frames do not repeat, by stage; empty for references.
    pub preparation: Vec<StageWork>,
    /// Flux \[W\] from the light to the image, by stage and reason; empty for references, and for techniques
    /// that do not account for it.
    pub flux: Vec<FluxEntry>,
    /// Time of one frame by the method's own clock, if it prepares anything that a frame does not repeat.
    pub frame_time: Option<Duration>,
    /// Method, sensor, settings and the method's own report, by name: written into files as attributes.
    pub report: Map<String, Value>,
    /// The method's own lines of a summary for people.
    pub summary: Vec<String>,
    /// Further maps in the estimate's unit, by channel name.
    pub maps: Vec<(String, Vec<Rgb>)>,
    /// Further numbers of texels, by channel name.
    pub scalars: Vec<(String, Vec<f64>)>,
    /// Oddities of the scene or the run.
    pub warnings: Vec<String>,
}

impl Rendering {
    /// An estimate of all light without a report.
    pub(crate) fn new(estimate: Estimate) -> Self {
        Self {
            estimate,
            light: Light::All,
            replicates: None,
            unit: "paths",
            counters: Vec::new(),
            stages: Vec::new(),
            preparation: Vec::new(),
            flux: Vec::new(),
            frame_time: None,
            report: Map::new(),
            summary: Vec::new(),
            maps: Vec::new(),
            scalars: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// Adds the work of a frame's stages.
    #[must_use]
    pub(crate) fn with_stages(mut self, stages: Vec<StageWork>) -> Self {
        self.stages = stages;
        self
    }

    /// Adds the flux of a frame, to the report, too; nothing if there is none.
    #[must_use]
    pub(crate) fn with_flux(mut self, flux: Vec<FluxEntry>) -> Self {
        if !flux.is_empty() {
            self = self.reporting("flux", &flux);
        }
        self.flux = flux;
        self
    }

    /// Adds an attribute to the report.
    #[must_use]
    pub(crate) fn reporting(mut self, name: &str, value: impl serde::Serialize) -> Self {
        // What a report is made of are numbers, texts and lists: none of them fails to be JSON.
        let value = serde_json::to_value(value).unwrap_or_default();
        self.report.insert(name.to_owned(), value);
        self
    }
}
