//! The light of one source, as beams follow it.

use std::borrow::Cow;

use super::facets::part_patches;
use crate::scene::Scene;
use crate::transport::facets::table::Facets;
use crate::transport::first_surface::{Cone, Source, SurfacePatch, patches};

/// A source and the light space over its first surfaces.
#[derive(Clone, Debug)]
pub struct BeamLight {
    /// The origin of the light.
    pub source: Source,
    /// The patches that its light may reach.
    pub patches: Vec<SurfacePatch>,
}

impl BeamLight {
    /// The light of all delta emitters of a scene.
    pub fn all(scene: &Scene) -> Vec<Self> {
        let light = |source| Self {
            patches: patches(scene, &source),
            source,
        };
        Source::all(scene).into_iter().map(light).collect()
    }

    /// The facets that its light is followed by as polygons, and the patches that are divided into cells.
    pub fn parts(&self, facets: &Facets) -> (Vec<u32>, Cow<'_, [SurfacePatch]>) {
        // A cone's patches are parts of facets only, and its border is none of the facets' edges.
        if facets.is_empty() || Cone::of(&self.source).is_some() {
            return (Vec::new(), Cow::Borrowed(&self.patches));
        }
        let (flat, others) = part_patches(facets, &self.patches);
        (flat, Cow::Owned(others))
    }
}
