//! Warnings that are known before a frame: settings that do nothing together, and surfaces without texels.

use super::cuboid::Face;
use super::demands::{FLAT, Volume, specular_shapes};
use super::settings::Settings;
use super::variants::{Layers, March, Smooth, Splat, Sweep};
use crate::geometry::Shape;
use crate::scene::Scene;
use crate::setting::Values;

/// Names of shapes in a sentence at most.
const NAMED: usize = 4;

/// What |cos| of a normal and the volume's axis is at most, of surfaces along that.
const ALONG: f64 = 1e-9;

/// A sentence for each setting that was typed and does nothing beside another one.
pub fn idle(settings: &Settings, values: &Values) -> Vec<String> {
    let is_peeled = settings.layers == Layers::Peel;
    let is_traced = settings.layers == Layers::Exact;
    let is_beams = settings.splat == Splat::Exact;
    let typed = |key: &str| values.given().get(key).map(String::as_str);
    let is_exact = |key: &str| typed(key) == Some("exact");
    let rows = [
        (
            "buffers",
            is_peeled && is_exact("buffers"),
            "layers=peel, which has pictures of its own",
        ),
        (
            "march",
            is_peeled && is_exact("march"),
            "layers=peel, which is marched by texels",
        ),
        (
            "buffers",
            is_traced && !is_exact("buffers"),
            "layers=exact, which has no pictures",
        ),
        (
            "march",
            is_traced && !is_exact("march"),
            "layers=exact, which has no pictures",
        ),
        (
            "steps",
            settings.march != March::Steps,
            "a march other than march=steps",
        ),
        ("peels", !is_peeled, "layers other than layers=peel"),
        ("sigma", settings.smooth == Smooth::Exact, "smooth=exact"),
        ("border-levels", !is_beams, "a splat other than splat=exact"),
        ("tile", is_beams, "splat=exact"),
        ("splat-scale", is_beams, "splat=exact"),
        ("splat-min", is_beams, "splat=exact"),
        ("splat-max", is_beams, "splat=exact"),
        ("bias", is_beams, "splat=exact"),
        (
            "cull",
            settings.sweep == Sweep::Exact,
            "sweep=exact, which culls nothing",
        ),
    ];
    rows.into_iter()
        .filter(|(_, is_idle, _)| *is_idle)
        .filter_map(|(key, _, why)| {
            let text = typed(key)?;
            Some(format!("{key}={text} does nothing beside {why}"))
        })
        .collect()
}

/// Sentences on flat volumes, and on shapes that pictures have no texels of.
pub fn on_shapes(scene: &Scene, settings: &Settings, volume: &Volume) -> Vec<String> {
    let mut said = Vec::new();
    let axis = volume.cuboid.frame().n;
    let is_along = |shape: &u32| match &scene.world().shapes()[*shape as usize] {
        Shape::Sphere(_) => false,
        Shape::Rectangle(rectangle) => rectangle.normal().dot(axis).abs() < ALONG,
        Shape::Disk(disk) => disk.normal().dot(axis).abs() < ALONG,
        Shape::Cylinder(cylinder) => cylinder.axis().cross(axis).length() < ALONG,
        Shape::Mesh(mesh) => (0..mesh.triangle_count() as u32)
            .all(|face| mesh.face_normal(face).dot(axis).abs() < ALONG),
    };
    if settings.layers != Layers::Exact {
        let all: Vec<u32> = specular_shapes(scene)
            .into_iter()
            .filter(is_along)
            .collect();
        if !all.is_empty() {
            let names = all.iter().take(NAMED);
            let names = names.map(|shape| format!("\"{}\"", scene.objects()[*shape as usize].id));
            let more = match all.len().saturating_sub(NAMED) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            said.push(format!(
                "pictures have no texels of what is along the volume's axis, so that light does not meet {}{more}: \
                 layers=exact does",
                names.collect::<Vec<_>>().join(", ")
            ));
        }
    }
    let size = volume.cuboid.size();
    let thickness = [
        (size.z, Face::Entry, Face::Far),
        (2.0 * size.x, Face::FirstLow, Face::FirstHigh),
        (2.0 * size.y, Face::SecondLow, Face::SecondHigh),
    ];
    let largest = thickness.iter().fold(0.0, |most: f64, it| most.max(it.0));
    for (thick, low, high) in thickness {
        // A side that was not padded is larger, but for rounding.
        if thick <= FLAT * largest * (1.0 + 1e-9) {
            said.push(format!(
                "what mirrors or refracts is flat: the volume is padded to {thick:.3e} m from face {} to {}",
                volume.cuboid.name(low),
                volume.cuboid.name(high)
            ));
        }
    }
    said
}
