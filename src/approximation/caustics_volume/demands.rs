//! Demands of a caustics volume on a scene: its box, its faces and its lights.

use glam::DVec3;

use super::cuboid::{Cuboid, Face};
use super::settings::Settings;
use super::variants::{Buffers, Emission, Entry, Fit, Layers, Splat, Sweep, Update};
use crate::approximation::sources::sources;
use crate::geometry::{Bounds, Frame, Shape};
use crate::run::Refusal;
use crate::scene::{Object, Scene};
use crate::transport::chain_limits;
use crate::transport::first_surface::Source;

/// The least extent of a volume's side, by the largest: flat mirrors have a volume, too.
pub(super) const FLAT: f64 = 1e-3;

/// The plural of the technique, in errors.
const VOLUMES: &str = "caustics volumes";

/// A volume with its faces and lights.
#[derive(Clone, Debug)]
pub struct Volume {
    /// The box.
    pub cuboid: Cuboid,
    /// Whether each face ends photons, by [`Face`].
    pub culls: [bool; 6],
    /// The lights.
    pub sources: Vec<Source>,
}

/// True if a shape mirrors or refracts.
pub fn is_specular(scene: &Scene, shape: u32) -> bool {
    scene.material_of(shape).is_specular(scene.materials())
}

/// The shapes that mirror or refract.
pub fn specular_shapes(scene: &Scene) -> Vec<u32> {
    let shapes = 0..scene.world().shapes().len() as u32;
    shapes.filter(|shape| is_specular(scene, *shape)).collect()
}

impl Volume {
    /// The volume of a scene.
    ///
    /// # Errors
    ///
    /// If nothing mirrors or refracts, a light has a size, is in the volume or behind its entry, if no face
    /// lets photons out, and if slabs are deeper than half floats reach.
    pub fn new(scene: &Scene, settings: &Settings) -> Result<Self, Refusal> {
        chain_limits::check_starts(scene).map_err(|error| Refusal::new(error.to_string()))?;
        let sources = sources(scene, VOLUMES)?;
        let shapes = specular_shapes(scene);
        if shapes.is_empty() {
            return Err(Refusal::new(
                "no shape mirrors or refracts: a caustics volume needs one of plugin dielectric, thindielectric or \
                 conductor",
            ));
        }
        let is_partly_passed = |object: &&Object| {
            scene
                .material(object.material)
                .is_partly_passed(scene.materials())
        };
        if let Some(object) = scene.objects().iter().find(is_partly_passed) {
            return Err(Refusal::new(format!(
                "shape \"{}\" has a mask that is partly open: caustics volumes follow light that meets a surface or \
                 passes it; allowed are opacities 0 and 1",
                object.id
            )));
        }
        let cuboid = cuboid(scene, settings, &shapes, &sources[0]);
        for source in &sources {
            check_light(settings, &cuboid, source)?;
        }
        check_depths(settings, &cuboid)?;
        let culls = culls(settings, &cuboid)?;
        Ok(Self {
            cuboid,
            culls,
            sources,
        })
    }

    /// The volume with another box, if that does as well: all that mirrors or refracts is in it, its entry
    /// has the same name, and lights are as it needs them.
    #[must_use]
    pub fn within(&self, scene: &Scene, settings: &Settings, cuboid: &Cuboid) -> Option<Self> {
        let shapes = scene.world().shapes();
        let is_in = |shape: &u32| cuboid.holds(&shapes[*shape as usize].bounds());
        let is_lit = |source: &Source| check_light(settings, cuboid, source).is_ok();
        let does = specular_shapes(scene).iter().all(is_in)
            && self.sources.iter().all(is_lit)
            && self.cuboid.name(Face::Entry) == cuboid.name(Face::Entry);
        does.then(|| {
            Some(Self {
                cuboid: *cuboid,
                culls: culls(settings, cuboid).ok()?,
                sources: self.sources.clone(),
            })
        })
        .flatten()
    }
}

/// Refuses settings that exclude one another.
///
/// # Errors
///
/// Names both.
pub fn check(settings: &Settings) -> Result<(), Refusal> {
    let several = [
        ("shares", settings.shares > 1),
        ("amortise", settings.amortise > 0),
        ("update=changed", settings.update == Update::Changed),
    ];
    let several: Vec<&str> = several.iter().filter(|it| it.1).map(|it| it.0).collect();
    if let [one, other, ..] = several.as_slice() {
        return Err(Refusal::new(format!(
            "{one} and {other}: each is another rule for what a frame makes anew; allowed is one of shares, \
             amortise and update=changed"
        )));
    }
    if let [one] = several.as_slice()
        && settings.splat == Splat::Exact
    {
        return Err(Refusal::new(format!(
            "{one} and splat=exact: beams are dealt out anew in each frame; allowed are splat=quads and \
             ellipses"
        )));
    }
    if settings.amortise > 0 && settings.sweep == Sweep::Exact {
        return Err(Refusal::new(
            "amortise and sweep=exact: without an order of slabs there are no passes to share out; allowed is \
             sweep=once",
        ));
    }
    Ok(())
}

/// The box, along some axes, of the points whose hull a shape is in.
fn bounds_along(axes: &Frame, shape: &Shape) -> Bounds {
    let of = |points: &[DVec3]| Bounds::from_points(points.iter().map(|it| axes.to_local(*it)));
    match shape {
        Shape::Mesh(mesh) => of(mesh.positions()),
        Shape::Sphere(_) | Shape::Rectangle(_) | Shape::Disk(_) | Shape::Cylinder(_) => {
            of(&shape.bounds().corners())
        }
    }
}

/// The box around some shapes, with the entry face that settings ask for.
fn cuboid(scene: &Scene, settings: &Settings, shapes: &[u32], light: &Source) -> Cuboid {
    let all = scene.world().shapes();
    let whole = shapes.iter().fold(Bounds::EMPTY, |sum, shape| {
        sum.union(all[*shape as usize].bounds())
    });
    let travel = -light
        .towards(whole.center())
        .try_normalize()
        .unwrap_or(DVec3::Z);
    let axes = match settings.volume {
        Fit::World => Frame {
            s: DVec3::X,
            t: DVec3::Y,
            n: DVec3::Z,
        },
        Fit::Light => Frame::around(-travel),
    };
    let bounds = shapes.iter().fold(Bounds::EMPTY, |sum, shape| {
        sum.union(bounds_along(&axes, &all[*shape as usize]))
    });
    let largest = bounds.extent().max_element();
    let half = (0.5 * bounds.extent()).max(DVec3::splat(0.5 * FLAT * largest))
        * (1.0 + 2.0 * settings.margin);
    let middle = axes.to_world(bounds.center());
    let outward = match settings.entry {
        Entry::Auto => return facing(middle, &axes, half, light, travel),
        Entry::XLow => -axes.s,
        Entry::XHigh => axes.s,
        Entry::YLow => -axes.t,
        Entry::YHigh => axes.t,
        Entry::ZLow => -axes.n,
        Entry::ZHigh => axes.n,
    };
    Cuboid::new(middle, &axes, half, outward)
}

/// The box with the entry face before which the light is that faces its travel most.
fn facing(middle: DVec3, axes: &Frame, half: DVec3, light: &Source, travel: DVec3) -> Cuboid {
    let mut best: Option<(f64, Cuboid)> = None;
    for axis in [axes.n, axes.s, axes.t] {
        for outward in [axis, -axis] {
            let one = Cuboid::new(middle, axes, half, outward);
            let is_before = light
                .towards(one.to_world(DVec3::ZERO))
                .dot(outward)
                .is_sign_positive();
            // A light behind all of the face does not enter by it, however it faces.
            let score = -travel.dot(outward) - if is_before { 0.0 } else { 2.0 };
            if best.as_ref().is_none_or(|(most, _)| score > *most + 1e-9) {
                best = Some((score, one));
            }
        }
    }
    best.map_or_else(
        || Cuboid::new(middle, axes, half, axes.n),
        |(_, cuboid)| cuboid,
    )
}

/// Whether each face ends photons.
fn culls(settings: &Settings, cuboid: &Cuboid) -> Result<[bool; 6], Refusal> {
    let mut culls = [false; 6];
    if settings.cull != "none" {
        for word in settings.cull.split(',').map(str::trim) {
            let face = Face::ALL.into_iter().find(|face| {
                (word == "entry" && *face == Face::Entry) || cuboid.name(*face) == word
            });
            let Some(face) = face else {
                return Err(Refusal::new(format!(
                    "cull has the face \"{word}\"; allowed are none, or some of entry, x-, x+, y-, y+, z-, z+ with \
                     commas between"
                )));
            };
            culls[face as usize] = true;
        }
    }
    if culls == [true; 6] {
        return Err(Refusal::new(
            "cull has all six faces: no photon would leave the volume; allowed are up to five",
        ));
    }
    Ok(culls)
}

/// Refuses slabs whose depths half floats do not have.
fn check_depths(settings: &Settings, cuboid: &Cuboid) -> Result<(), Refusal> {
    let deepest = half::f16::MAX.to_f64();
    let deep = cuboid.size().z / f64::from(settings.slabs);
    if settings.buffers == Buffers::F16 && settings.layers != Layers::Exact && deep > deepest {
        return Err(Refusal::new(format!(
            "slabs are {deep:.3e} m deep, and half floats end at {deepest} m: allowed are buffers=f32, and {:.0} slabs \
             or more",
            (cuboid.size().z / deepest).ceil()
        )));
    }
    Ok(())
}

/// Refuses lights in the volume, and, if photons start on the entry face, lights behind it.
fn check_light(settings: &Settings, cuboid: &Cuboid, source: &Source) -> Result<(), Refusal> {
    if let Source::Point { origin, .. } = *source
        && cuboid.holds(&Bounds::from_points([origin]))
    {
        return Err(Refusal::new(format!(
            "the emitter at ({}, {}, {}) is in the volume: photons enter it from outside",
            origin.x, origin.y, origin.z
        )));
    }
    let is_before = |face: Face| {
        let middle = cuboid.to_world(cuboid.face_middle(face));
        source.towards(middle).dot(cuboid.outward(face)) > 0.0
    };
    if settings.emission == Emission::Exact || is_before(Face::Entry) {
        return Ok(());
    }
    let other = Face::ALL.into_iter().find(|face| is_before(*face));
    let other = other.map_or("none", |face| cuboid.name(face));
    Err(Refusal::new(format!(
        "a light is behind the entry face ({}): entry={other} is before it, and emission=exact takes all faces",
        cuboid.name(Face::Entry)
    )))
}
