//! The tasks that the light of some signatures is followed in: their order is the same on any machine.

use std::borrow::Cow;
use std::ops::Range;

use super::light::BeamLight;
use crate::transport::facets::table::Facets;
use crate::transport::first_surface::SurfacePatch;

/// Least number of patches of one task: of a surface with few patches it makes some hundred tasks.
const LEAST_OF_TASK: usize = 16;
/// Least number of facets: their polygons share no paths.
const LEAST_OF_FACETS: usize = 1;
/// Most patches of one task: it is so large that most neighbours, which share paths, are in one task.
const MOST_OF_TASK: usize = 512;
/// Number of tasks between the two.
const TASKS: usize = 128;

/// Number of patches of one task, of so many in all.
fn size(all: usize, least: usize) -> usize {
    (all / TASKS).clamp(least, MOST_OF_TASK)
}

/// The light of one source, by the way that it is followed.
pub(super) struct LightParts<'l> {
    light: &'l BeamLight,
    /// Followed as polygons.
    facets: Vec<u32>,
    /// Divided into cells.
    patches: Cow<'l, [SurfacePatch]>,
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

/// A part of one source's light. One thread begins it; light that it leaves is followed by any.
pub(super) struct Task<'p> {
    pub light: &'p BeamLight,
    /// The signatures, by their order in a batch.
    pub signatures: Range<usize>,
    pub towards: Towards<'p>,
}

/// Where a task's light sets out to.
#[derive(Clone, Copy)]
pub(super) enum Towards<'p> {
    /// Patches of first surfaces.
    Patches(&'p [SurfacePatch]),
    /// Flat facets.
    Facets(&'p [u32]),
}

/// The tasks of so many signatures: one for each of them and some patches, and one for all of them together
/// and some facets, since these share polygons.
pub(super) fn tasks<'p>(parts: &'p [LightParts<'p>], signatures: usize) -> Vec<Task<'p>> {
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
                towards: Towards::Patches(patches),
            }));
        }
        tasks.extend(
            facets
                .chunks(size(facets.len(), LEAST_OF_FACETS))
                .map(|facets| Task {
                    light,
                    signatures: 0..signatures,
                    towards: Towards::Facets(facets),
                }),
        );
    }
    tasks
}

/// How many tasks there are, whatever the signatures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::reference) struct TaskCount {
    for_each_signature: usize,
    for_all_together: usize,
}

impl TaskCount {
    /// That of some lights.
    pub fn new(lights: &[BeamLight], facets: &Facets) -> Self {
        let mut count = Self {
            for_each_signature: 0,
            for_all_together: 0,
        };
        for light in lights {
            let (flat, patches) = light.parts(facets);
            let tasks = |all: usize, least| all.div_ceil(size(all, least));
            count.for_each_signature += tasks(patches.len(), LEAST_OF_TASK);
            count.for_all_together += tasks(flat.len(), LEAST_OF_FACETS);
        }
        count
    }

    /// That of so many signatures.
    pub fn of(&self, signatures: usize) -> usize {
        signatures * self.for_each_signature + self.for_all_together
    }
}
