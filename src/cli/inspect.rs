//! `nephroid inspect`: contents and requirements of a scene.

use std::collections::BTreeMap;

use serde::Serialize;

use super::args::{InspectArgs, SettingArgs};
use super::outcome::Outcome;
use super::resident::Resident;
use super::scene::load;
use crate::geometry::{MeshDiagnostics, Shape};
use crate::method::Method;
use crate::method::sensors::{choose_camera, choose_sensor};
use crate::mitsuba::LoadError;
use crate::run::Cost;
use crate::scene::{Ignored, Requirement, Scene, Sensor, SensorKind, Warning, requirements};
use crate::setting::Given;

/// The output of `--json`.
#[derive(Serialize)]
struct Inspection<'a> {
    scene: String,
    content_hash: &'a str,
    shapes: Vec<ShapeLine<'a>>,
    emitters: Vec<EmitterLine>,
    sensors: Vec<SensorLine<'a>>,
    requirements: Vec<Requirement>,
    ignored: &'a [Ignored],
    warnings: &'a [Warning],
    memory_bytes: usize,
    /// Of the method that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    advice: Option<Advice>,
}

/// What a pilot says of a method's settings.
#[derive(Serialize)]
struct Advice {
    method: &'static str,
    sensor: String,
    cost: Cost,
    /// The memory of a run.
    memory: Memory,
    lines: Vec<String>,
}

/// The memory \[bytes\] that `nephroid render` is likely to have at most, all in all.
#[derive(Clone, Copy, Serialize)]
struct Memory {
    /// Of the program itself, as far as the system says.
    program: u64,
    /// Of the scene.
    scene: u64,
    /// Of the run, with the layers of light that a pilot finds.
    run: u64,
    /// All of it.
    bytes: u64,
}

impl Memory {
    /// That of a run; `before` is what the program had before it read anything.
    fn of(
        method: &Method,
        (scene, sensor): (&Scene, &Sensor),
        before: Option<Resident>,
    ) -> anyhow::Result<Self> {
        let run = method.pilot_bytes(scene, sensor)?;
        let scene = scene.world().memory_bytes() as u64;
        // By now all code has run that a run needs, but for that of its own loops.
        let program = match (before, Resident::now()) {
            (Some(before), Some(now)) => before.own + now.code,
            _ => 0,
        };
        Ok(Self {
            program,
            scene,
            run,
            bytes: program + scene + run,
        })
    }
}

impl Advice {
    /// The advice for the method and the sensor that are asked for.
    fn of(
        args: &InspectArgs,
        scene: &Scene,
        before: Option<Resident>,
    ) -> anyhow::Result<Option<Self>> {
        let Some(name) = args.method.as_deref() else {
            return Ok(None);
        };
        let method = Method::new(name, &SettingArgs::default().and(&args.set)?)?;
        let id = args.sensor.as_deref();
        let meter = choose_sensor(scene, id);
        let sensor = if id.is_some() {
            meter?
        } else {
            meter.or_else(|_| choose_camera(scene, None))?
        };
        let lines = method.advice(scene, sensor)?;
        Ok(Some(Self {
            method: method.name(),
            sensor: sensor.id.clone(),
            cost: method.cost(scene, sensor),
            memory: Memory::of(&method, (scene, sensor), before)?,
            lines,
        }))
    }

    fn print(&self) {
        say!(
            "\n{} on sensor {}: {}",
            self.method,
            self.sensor,
            told(&self.cost)
        );
        let megabytes = |bytes: u64| bytes.div_ceil(1_000_000);
        say!(
            "  the program is likely to take {} MB: {} of the run, with the light that a pilot finds; {} of the \
             scene; {} of its own",
            megabytes(self.memory.bytes),
            megabytes(self.memory.run),
            megabytes(self.memory.scene),
            megabytes(self.memory.program)
        );
        for line in &self.lines {
            say!("  {line}");
        }
        if self.lines.is_empty() {
            say!("  no pilot: this method gives no advice");
        }
    }
}

/// Memory and work in a line.
fn told(cost: &Cost) -> String {
    let work = cost.work.iter();
    let work = work.map(|one| format!(", {} {}", one.count, one.name));
    format!(
        "up to {} MB of memory{}",
        cost.bytes.div_ceil(1_000_000),
        work.collect::<String>()
    )
}

#[derive(Serialize)]
struct ShapeLine<'a> {
    id: &'a str,
    plugin: &'static str,
    material: &'static str,
    triangles: Option<usize>,
    mesh: Option<MeshLine>,
}

#[derive(Serialize)]
struct MeshLine {
    closed: bool,
    components: usize,
    open_edges: usize,
    non_manifold_edges: usize,
    clashing_edges: usize,
    zero_area_faces: usize,
    duplicate_faces: usize,
    signed_volume: f64,
}

impl From<MeshDiagnostics> for MeshLine {
    fn from(found: MeshDiagnostics) -> Self {
        Self {
            closed: found.is_closed(),
            components: found.components,
            open_edges: found.open_edges.count,
            non_manifold_edges: found.non_manifold_edges.count,
            clashing_edges: found.clashing_edges.count,
            zero_area_faces: found.zero_area_faces.count,
            duplicate_faces: found.duplicate_faces.count,
            signed_volume: found.signed_volume,
        }
    }
}

#[derive(Serialize)]
struct EmitterLine {
    plugin: &'static str,
    strength: [f64; 3],
    unit: &'static str,
}

#[derive(Serialize)]
struct SensorLine<'a> {
    id: &'a str,
    plugin: &'static str,
    on: Option<&'a str>,
    size: [u32; 2],
    /// The cost of a run at most, by method, with its default settings.
    costs: BTreeMap<&'static str, Cost>,
    /// The method that suits it, and why.
    suits: Option<[String; 2]>,
}

/// Runs the command.
///
/// # Errors
///
/// If the scene cannot be read, or the method that is asked for cannot work on it.
pub fn inspect(args: &InspectArgs) -> anyhow::Result<Outcome> {
    let before = Resident::now();
    let scene = load(&args.scene).map_err(|error| anyhow::anyhow!(obstacles(&error)))?;
    let mut inspection = Inspection::of(&scene);
    inspection.advice = Advice::of(args, &scene, before)?;
    if args.json {
        say!("{}", serde_json::to_string_pretty(&inspection)?);
    } else {
        inspection.print();
    }
    Ok(Outcome::Complete)
}

/// All problems of a scene, those with one message together.
fn obstacles(error: &LoadError) -> String {
    if error.others.is_empty() {
        return error.to_string();
    }
    let mut places: Vec<(&str, Vec<String>)> = Vec::new();
    for one in error.all() {
        let at = one.at.to_string();
        match places
            .iter_mut()
            .find(|(message, _)| *message == one.message)
        {
            Some((_, all)) => all.push(at),
            None => places.push((&one.message, vec![at])),
        }
    }
    let lines = places.iter().map(|(message, all)| match all.as_slice() {
        [one] => format!("\n  {one}: {message}"),
        [first, others @ ..] => {
            format!("\n  {first} and {} more: {message}", others.len())
        }
        [] => String::new(),
    });
    format!(
        "{} problems keep this file from being a scene:{}",
        error.all().count(),
        lines.collect::<String>()
    )
}

/// The cost of each method that can fill a sensor, with its default settings.
fn costs(scene: &Scene, sensor: &Sensor) -> BTreeMap<&'static str, Cost> {
    let methods = Method::names().into_iter();
    let methods = methods.filter_map(|name| Method::new(name, &Given::new()).ok());
    methods
        .filter(|method| method.supports(scene, sensor).is_ok())
        .map(|method| (method.name(), method.cost(scene, sensor)))
        .collect()
}

impl<'a> Inspection<'a> {
    fn of(scene: &'a Scene) -> Self {
        let shapes = scene.world().shapes().iter().zip(scene.objects());
        Self {
            scene: scene.path().display().to_string(),
            content_hash: scene.content_hash(),
            shapes: shapes
                .map(|(shape, object)| {
                    let mesh = match shape {
                        Shape::Mesh(mesh) => Some(mesh),
                        _ => None,
                    };
                    ShapeLine {
                        id: &object.id,
                        plugin: object.plugin,
                        material: scene.material(object.material).plugin(),
                        triangles: mesh.map(crate::geometry::Mesh::triangle_count),
                        mesh: mesh.map(|mesh| mesh.diagnose().into()),
                    }
                })
                .collect(),
            emitters: scene
                .emitters()
                .iter()
                .map(|emitter| EmitterLine {
                    plugin: emitter.plugin(),
                    strength: emitter.strength().0,
                    unit: match emitter.plugin() {
                        "directional" => "W/m²",
                        "area" | "constant" | "envmap" => "W/m²/sr",
                        _ => "W/sr",
                    },
                })
                .collect(),
            sensors: scene
                .sensors()
                .iter()
                .map(|sensor| SensorLine {
                    id: &sensor.id,
                    plugin: sensor.plugin(),
                    on: match sensor.kind {
                        SensorKind::IrradianceMeter { shape } => {
                            Some(&scene.objects()[shape.0 as usize].id)
                        }
                        _ => None,
                    },
                    size: [sensor.film.crop.width, sensor.film.crop.height],
                    costs: costs(scene, sensor),
                    suits: Method::choose(scene, sensor)
                        .ok()
                        .map(|choice| [choice.method.name().to_owned(), choice.reason]),
                })
                .collect(),
            requirements: requirements(scene),
            ignored: scene.ignored(),
            warnings: scene.warnings(),
            memory_bytes: scene.world().memory_bytes(),
            advice: None,
        }
    }

    fn print(&self) {
        say!("{}", self.scene);
        say!(
            "\nshapes ({} kB in memory)",
            self.memory_bytes.div_ceil(1000)
        );
        for shape in &self.shapes {
            let mesh = shape.mesh.as_ref().map_or_else(String::new, |mesh| {
                format!(
                    ", {} triangles, {}, {} part(s)",
                    shape.triangles.unwrap_or(0),
                    if mesh.closed { "closed" } else { "not closed" },
                    mesh.components
                )
            });
            say!(
                "  {} ({}): {}{mesh}",
                shape.id,
                shape.plugin,
                shape.material
            );
        }
        say!("\nemitters");
        for emitter in &self.emitters {
            let [r, g, b] = emitter.strength;
            say!("  {}: {r} {g} {b} {}", emitter.plugin, emitter.unit);
        }
        say!("\nsensors");
        for sensor in &self.sensors {
            let on = sensor.on.map_or_else(String::new, |on| format!(" on {on}"));
            let [width, height] = sensor.size;
            say!(
                "  {} ({}){on}: {width} x {height}",
                sensor.id,
                sensor.plugin
            );
            if let Some([method, reason]) = &sensor.suits {
                say!("    suited by {method}: {reason}");
            }
            for (method, cost) in &sensor.costs {
                say!("    {method}: {}", told(cost));
            }
        }
        say!("\nrequires modelled");
        for requirement in &self.requirements {
            let needed = if requirement.needed { "yes" } else { "no " };
            say!(
                "  {needed}  {}: {}",
                requirement.feature,
                requirement.reason
            );
        }
        if !self.ignored.is_empty() {
            say!("\nignored");
            for ignored in self.ignored {
                say!("  {}: {}: {}", ignored.at, ignored.what, ignored.why);
            }
        }
        if !self.warnings.is_empty() {
            say!("\nwarnings");
            for warning in self.warnings {
                say!("  {warning}");
            }
        }
        if let Some(advice) = &self.advice {
            advice.print();
        }
    }
}
