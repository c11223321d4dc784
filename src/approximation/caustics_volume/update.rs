//! Differential updates (section 3.5): what of a frame the next one can use.
//!
//! A slab's pictures show what is in it. The photons before a slab depend on the slabs before it. So after a
//! change, pictures of slabs that it is in are drawn anew, and photons are marched anew from the first of
//! these slabs on. The paper says that only that slab is updated: this holds for the last one.

use super::buffers::Pictures;
use super::demands::Volume;
use super::projector::Projectors;
use super::settings::Settings;
use super::sweep::Queue;
use super::variants::{Emission, Sweep};
use crate::geometry::{Bounds, Shape};
use crate::scene::{Material, MaterialId, Scene};
use crate::transport::first_surface::Source;

/// What is left of a frame.
#[derive(Debug, Default)]
pub struct Last {
    shapes: Vec<Shape>,
    materials: Vec<Material>,
    /// The material of each shape.
    chosen: Vec<MaterialId>,
    sources: Vec<Source>,
    pictures: Vec<Pictures>,
    projectors: Option<Projectors>,
    /// The photons before each slab, and after all.
    queues: Vec<Queue>,
}

/// What a frame can use of the last one.
#[derive(Debug)]
pub struct Usable {
    /// The pictures of each slab that still hold.
    pub pictures: Vec<Option<Pictures>>,
    /// The projectors' pictures, if they hold.
    pub projectors: Option<Projectors>,
    /// The slab from which photons are marched, and the photons before it; the number of slabs if only the
    /// projectors are to do.
    pub queue: Option<(usize, Queue)>,
    /// The photons before earlier slabs.
    pub queues: Vec<Queue>,
}

impl Last {
    /// What is left of a frame: `queues` are before each slab, and after all.
    pub fn new(
        scene: &Scene,
        volume: &Volume,
        pictures: Vec<Pictures>,
        projectors: Projectors,
        queues: Vec<Queue>,
    ) -> Self {
        Self {
            shapes: scene.world().shapes().to_vec(),
            materials: scene.materials().to_vec(),
            chosen: chosen(scene),
            sources: volume.sources.clone(),
            pictures,
            projectors: Some(projectors),
            queues,
        }
    }

    /// What a frame of a scene can use.
    pub fn against(
        self,
        scene: &Scene,
        volume: &Volume,
        settings: &Settings,
        slabs: usize,
    ) -> Usable {
        let nothing = Usable {
            pictures: (0..slabs).map(|_| None).collect(),
            projectors: None,
            queue: None,
            queues: Vec::new(),
        };
        let shapes = scene.world().shapes();
        let is_same_scene = self.pictures.len() == slabs
            && self.shapes.len() == shapes.len()
            && self.materials == scene.materials()
            && self.chosen == chosen(scene)
            && self.sources == volume.sources;
        // Shadows, and what is outside, have no slab.
        if !is_same_scene
            || settings.sweep == Sweep::Exact
            || settings.emission == Emission::Exact && self.shapes != shapes
        {
            return nothing;
        }
        let mut is_dirty = vec![false; slabs];
        let mut are_receivers_dirty = false;
        for (shape, (before, now)) in (0_u32..).zip(self.shapes.iter().zip(shapes)) {
            if before == now {
                continue;
            }
            let material = scene.material_of(shape);
            are_receivers_dirty |= !material.is_specular(scene.materials());
            for bounds in [before.bounds(), now.bounds()] {
                for (slab, flag) in is_dirty.iter_mut().enumerate() {
                    *flag |= is_in(volume, slab, slabs, &bounds);
                }
            }
        }
        let first = is_dirty.iter().position(|flag| *flag).unwrap_or(slabs);
        let mut queues = self.queues;
        queues.truncate(first + 1);
        let queue = queues.pop();
        let pictures = self.pictures.into_iter().zip(is_dirty);
        Usable {
            pictures: pictures
                .map(|(picture, is_dirty)| (!is_dirty).then_some(picture))
                .collect(),
            projectors: self.projectors.filter(|_| !are_receivers_dirty),
            queue: queue.map(|queue| (first, queue)),
            queues,
        }
    }
}

/// The material of each shape.
fn chosen(scene: &Scene) -> Vec<MaterialId> {
    let objects = scene.objects().iter();
    objects.map(|object| object.material).collect()
}

/// True if a box may have points in a slab, or on its border.
fn is_in(volume: &Volume, slab: usize, slabs: usize, bounds: &Bounds) -> bool {
    let cuboid = &volume.cuboid;
    let size = cuboid.size();
    let [from, to] = cuboid.slab(slab, slabs);
    let slack = 1e-6 * cuboid.diagonal();
    let local = Bounds::from_points(bounds.corners().map(|corner| cuboid.to_local(corner)));
    local.min.x <= size.x + slack
        && local.max.x >= -size.x - slack
        && local.min.y <= size.y + slack
        && local.max.y >= -size.y - slack
        && local.min.z <= to + slack
        && local.max.z >= from - slack
}
