//! Light by way of flat facets: polygons of it are cut where they meet the facets' edges.
//!
//! On flat faces every (entry facet, next facet, ...) chain is a topology of light of its own, and cells that
//! are divided blindly drown in the topologies' borders. But these borders are known: light changes
//! topologies where it passes an edge of a facet. So a polygon of the light that meets a facet
//! first is followed leg by leg (`refine/`): a ray through its middle finds a facet, the facet's
//! edges cut out the part of the polygon that goes there, and what is left over is asked again.
//! Each cut parts a polygon in two, so that nothing is lost or counted twice. What has made all
//! its events lands (`land.rs`) as a fan of triangles.
//!
//! One ray does not see what is beside it. So a polygon goes on only where nothing else may be in
//! the space that its leg sweeps (`leg/`): a facet that is there is cut out, too; next to what is
//! not flat, polygons are halved down to the tolerance, and cells find the border, or all light
//! of what is left is uncertain.
//!
//! Parallel light goes along a chain of flat facets by an affine map: then all of this is exact.
//! Light from a point does not: the lines where polygons are cut are bent a little, and so are the
//! images. Where the tolerance does not allow that, polygons are halved.

mod land;
mod leg;
mod polygon;
mod refine;

pub use refine::FacetRefiner;

use glam::DVec2;

use crate::transport::facets::table::Facets;
use crate::transport::first_surface::{SurfaceChart, SurfacePatch};

/// Parts the patches that are facets, by the facets' numbers, from the others.
pub fn part_patches(facets: &Facets, patches: &[SurfacePatch]) -> (Vec<u32>, Vec<SurfacePatch>) {
    let mut seen = vec![false; facets.len()];
    let mut flat = Vec::new();
    let mut others = Vec::new();
    for patch in patches {
        let facet = match patch.chart {
            SurfaceChart::Face { shape, face } => facets.of(shape, face),
            SurfaceChart::Parameters { shape } => facets.of(shape, 0),
            SurfaceChart::Cap { .. } => None,
        };
        match facet {
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

/// The chart whose coordinates a facet's are.
fn chart_of(facets: &Facets, facet: u32, is_mesh: bool) -> SurfaceChart {
    let facet = facets.get(facet);
    if is_mesh {
        SurfaceChart::Face {
            shape: facet.shape,
            face: facet.face,
        }
    } else {
        SurfaceChart::Parameters { shape: facet.shape }
    }
}

/// Area and middle of a convex polygon.
fn area_and_middle(corners: impl Iterator<Item = DVec2> + Clone) -> (f64, DVec2) {
    let mut rest = corners.clone();
    let Some(first) = rest.next() else {
        return (0.0, DVec2::ZERO);
    };
    let (mut area, mut moment, mut sum, mut count) = (0.0, DVec2::ZERO, DVec2::ZERO, 0.0);
    for (a, b) in rest.clone().zip(rest.skip(1)) {
        let (a, b) = (a - first, b - first);
        let part = 0.5 * a.perp_dot(b);
        area += part;
        moment += (a + b) * (part / 3.0);
    }
    for corner in corners {
        sum += corner;
        count += 1.0;
    }
    let middle = first + moment / area;
    // A needle has no centroid to speak of.
    let middle = if middle.is_finite() {
        middle
    } else {
        sum / count
    };
    (area.abs(), middle)
}
