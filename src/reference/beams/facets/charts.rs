//! Facets and the charts of their coordinates.

use crate::transport::facets::table::Facets;
use crate::transport::first_surface::SurfacePatch;

/// Parts the patches that are facets, as the facets' numbers, from the others.
pub fn part_patches(facets: &Facets, patches: &[SurfacePatch]) -> (Vec<u32>, Vec<SurfacePatch>) {
    let mut seen = vec![false; facets.len()];
    let mut flat = Vec::new();
    let mut others = Vec::new();
    for patch in patches {
        match facet_of(facets, patch) {
            // A facet of many faces has as many patches.
            Some(facet) if seen[facet as usize] => {}
            Some(facet) => {
                seen[facet as usize] = true;
                flat.push(facet);
            }
            None => others.push(*patch),
        }
    }
    (flat, others)
}

/// The facet that a patch is a part of; `None` if it is not flat.
pub fn facet_of(facets: &Facets, patch: &SurfacePatch) -> Option<u32> {
    facets.of(patch.chart.shape(), patch.chart.face())
}
