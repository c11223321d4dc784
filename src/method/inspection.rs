//! What can be said of a scene before anything is run: its contents, what it requires, and what each method
//! costs.

use std::collections::BTreeMap;

use serde::Serialize;

use super::Method;
use super::sensors::{choose_camera, choose_sensor};
use crate::geometry::{Mesh, MeshDiagnostics, Shape};
use crate::run::{Cost, Error};
use crate::scene::{Ignored, Requirement, Scene, Sensor, SensorKind, Warning, requirements};
use crate::setting::Given;

/// Contents and requirements of a scene.
#[derive(Clone, Debug, Serialize)]
pub struct Inspection<'a> {
    /// Its file.
    pub scene: String,
    /// A hash of all contents and parameters.
    pub content_hash: &'a str,
    /// Its shapes, in the file's order.
    pub shapes: Vec<ShapeLine<'a>>,
    /// Its emitters.
    pub emitters: Vec<EmitterLine>,
    /// Its sensors, with the methods that can fill them.
    pub sensors: Vec<SensorLine<'a>>,
    /// Features of light transport, and whether the scene needs them.
    pub requirements: Vec<Requirement>,
    /// What the file has and no measurement heeds.
    pub ignored: &'a [Ignored],
    /// Oddities.
    pub warnings: &'a [Warning],
    /// The memory of its shapes \[bytes\].
    pub memory_bytes: usize,
    /// Of the method that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub advice: Option<Advice>,
}

/// What a pilot says of a method's settings.
#[derive(Clone, Debug, Serialize)]
pub struct Advice {
    /// The method.
    pub method: &'static str,
    /// The sensor's id.
    pub sensor: String,
    /// The cost of a run at most.
    pub cost: Cost,
    /// The memory of a run.
    pub memory: Memory,
    /// What the pilot says, a line each; empty for methods without one.
    pub lines: Vec<String>,
}

/// The memory \[bytes\] that `nephroid render` is likely to have at most, all in all.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Memory {
    /// Of the program itself, as far as the system says.
    pub program: u64,
    /// Of the scene.
    pub scene: u64,
    /// Of the run, with the layers of light that a pilot finds.
    pub run: u64,
    /// All of it.
    pub bytes: u64,
}

impl Memory {
    /// That of a run. `program` is asked last, when all code has run that a run needs, but for that of its
    /// own loops.
    fn of(
        method: &Method,
        (scene, sensor): (&Scene, &Sensor),
        program: impl FnOnce() -> u64,
    ) -> Result<Self, Error> {
        let run = method.pilot_bytes(scene, sensor)?;
        let scene = scene.world().memory_bytes() as u64;
        let program = program();
        Ok(Self {
            program,
            scene,
            run,
            bytes: program + scene + run,
        })
    }
}

impl Advice {
    /// The advice for a method, on the sensor with this id: else on the first irradiance meter, else on the
    /// first camera. `program` tells the memory \[bytes\] of the program itself, 0 if that is not known.
    ///
    /// # Errors
    ///
    /// For a sensor that does not exist, and if the method cannot work on it.
    pub fn of(
        method: &Method,
        scene: &Scene,
        id: Option<&str>,
        program: impl FnOnce() -> u64,
    ) -> Result<Self, Error> {
        let meter = choose_sensor(scene, id);
        let sensor = if id.is_some() {
            meter?
        } else {
            meter.or_else(|_| choose_camera(scene, None))?
        };
        let lines = method.advice(scene, sensor)?;
        Ok(Self {
            method: method.name(),
            sensor: sensor.id.clone(),
            cost: method.cost(scene, sensor),
            memory: Memory::of(method, (scene, sensor), program)?,
            lines,
        })
    }
}

/// A shape.
#[derive(Clone, Debug, Serialize)]
pub struct ShapeLine<'a> {
    /// Its id.
    pub id: &'a str,
    /// Its plugin.
    pub plugin: &'static str,
    /// The plugin of its material.
    pub material: &'static str,
    /// Triangles of a mesh.
    pub triangles: Option<usize>,
    /// Facts of a mesh.
    pub mesh: Option<MeshLine>,
}

/// Facts of a mesh.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct MeshLine {
    /// True if it has no open edges and no edges of three faces.
    pub closed: bool,
    /// Parts that no edge connects.
    pub components: usize,
    /// Edges of one face.
    pub open_edges: usize,
    /// Edges of more than two faces.
    pub non_manifold_edges: usize,
    /// Edges whose faces have opposite orientations.
    pub clashing_edges: usize,
    /// Faces without area.
    pub zero_area_faces: usize,
    /// Faces that are there twice.
    pub duplicate_faces: usize,
    /// Volume \[m³\]; negative if normals point inwards.
    pub signed_volume: f64,
}

impl From<&MeshDiagnostics> for MeshLine {
    fn from(found: &MeshDiagnostics) -> Self {
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

/// An emitter.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct EmitterLine {
    /// Its plugin.
    pub plugin: &'static str,
    /// Its strength.
    pub strength: [f64; 3],
    /// The strength's unit.
    pub unit: &'static str,
}

/// A sensor.
#[derive(Clone, Debug, Serialize)]
pub struct SensorLine<'a> {
    /// Its id.
    pub id: &'a str,
    /// Its plugin.
    pub plugin: &'static str,
    /// The shape that it measures.
    pub on: Option<&'a str>,
    /// Texels a row, and rows.
    pub size: [u32; 2],
    /// The cost of a run at most, by method, with its default settings.
    pub costs: BTreeMap<&'static str, Cost>,
    /// The method that suits it, and why.
    pub suits: Option<[String; 2]>,
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
    /// Of a scene, without advice.
    pub fn of(scene: &'a Scene) -> Self {
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
                        triangles: mesh.map(Mesh::triangle_count),
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
                        "directional" | "projector" => "W/m²",
                        "area" | "constant" | "envmap" | "sunsky" => "W/m²/sr",
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
}
