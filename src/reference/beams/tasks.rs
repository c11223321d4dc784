//! The tasks that the light of some signatures is followed in: their order is the same on any machine.

use std::ops::Range;

use super::light::BeamLight;
use crate::transport::facets::table::Facets;
use crate::transport::first_surface::SurfacePatch;

/// Least number of patches of one task: of a surface with few patches it makes some hundred tasks. Polygons
/// of facets share no paths: of these, one is enough.
const LEAST_OF_TASK: usize = 16;
/// Most patches of one task: it is so large that most neighbours, which share paths, are in one task.
const MOST_OF_TASK: usize = 512;
/// Number of tasks between the two.
const TASKS: usize = 128;

/// The light of one source, by the way that it is followed.
pub(super) struct LightParts<'l> {
    light: &'l BeamLight,
    /// Followed as polygons.
    facets: Vec<u32>,
    /// Divided into cells.
    patches: Vec<SurfacePatch>,
}

impl<'l> LightParts<'l> {
    /// The parts of a light.
    pub fn new(light: &'l BeamLight, facets: &Facets) -> Self {
        let (facets, patches) = light.parts(facets);
        Self {
            light,
            facets,
            patches,
        }
    }
}

/// A part of one source's light that one thread follows.
pub(super) struct Task<'p> {
    pub light: &'p BeamLight,
    /// The signatures, by their order in a batch.
    pub signatures: Range<usize>,
    pub share: Share<'p>,
}

/// Where a task's light sets out to.
#[derive(Clone, Copy)]
pub(super) enum Share<'p> {
    /// Patches of first surfaces.
    Patches(&'p [SurfacePatch]),
    /// Flat facets.
    Facets(&'p [u32]),
}

/// Number of the tasks of so many signatures.
pub(in crate::reference) fn task_count(
    lights: &[BeamLight],
    facets: &Facets,
    signatures: usize,
) -> usize {
    let parts: Vec<LightParts> = lights
        .iter()
        .map(|light| LightParts::new(light, facets))
        .collect();
    tasks(&parts, signatures).len()
}

/// The tasks of so many signatures: one for each of them and some patches, and one for all of them together
/// and some facets, since these share polygons.
pub(super) fn tasks<'p>(parts: &'p [LightParts<'p>], signatures: usize) -> Vec<Task<'p>> {
    let size = |all: usize, least: usize| (all / TASKS).clamp(least, MOST_OF_TASK);
    let mut tasks = Vec::new();
    for LightParts {
        light,
        facets,
        patches,
    } in parts
    {
        for signature in 0..signatures {
            let chunks = patches.chunks(size(patches.len(), LEAST_OF_TASK));
            tasks.extend(chunks.map(|patches| Task {
                light,
                signatures: signature..signature + 1,
                share: Share::Patches(patches),
            }));
        }
        tasks.extend(facets.chunks(size(facets.len(), 1)).map(|facets| Task {
            light,
            signatures: 0..signatures,
            share: Share::Facets(facets),
        }));
    }
    tasks
}
