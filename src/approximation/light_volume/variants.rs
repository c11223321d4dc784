//! Stages and their variants, by name.

use crate::approximation::stage::{Stage, stages};
use crate::setting::Words;
use crate::setting::words::words;

words! {
    /// The stages in the order in which they run.
    Step {
        /// Rays that bound a beam
        Surface = "surface",
        /// Light that a beam begins with
        Flux = "flux",
        /// Light that the water's surface lets through
        Fresnel = "fresnel",
        /// Shadows on the water's surface
        Shadow = "shadow",
        /// Beams that are not drawn since they are dark
        ShadowCull = "shadow-cull",
        /// Parts of beams that are drawn
        Clamp = "clamp",
        /// Light by area along a beam
        Density = "density",
        /// Points in a beam
        Inside = "inside",
        /// Shadows under water
        Occlusion = "occlusion",
        /// Angles at which light falls on surfaces
        Cosine = "cosine",
        /// Sums over beams
        Accumulate = "accumulate",
        /// Points of a texel
        Lookup = "lookup",
    }
}

/// One of something for each [`Step`].
pub type BySteps<T> = [T; Step::WORDS.len()];

/// The stages, as techniques list them.
pub(super) static STAGES: BySteps<Stage> = stages(Step::WORDS);

words! {
    /// The rays that bound a beam.
    WaterSurface {
        /// Refracted at the vertices of the water's triangles, linear between
        Triangles = "triangles",
        /// Each triangle is quartered `levels` times, with corners on the scene's own surface
        Exact = "exact",
    }
}

words! {
    /// The light that a beam begins with.
    BeamFlux {
        /// Irradiance across the light by area: without the cosine of incidence, as section 3.1 is printed
        Literal = "literal",
        /// Irradiance by |cos θ| by area: all that falls on the triangle
        Exact = "exact",
    }
}

words! {
    /// The light that the water's surface lets through.
    Transmittance {
        /// Fresnel's equations at vertices, linear between
        Vertex = "vertex",
        /// Schlick's approximation at vertices, linear between
        Schlick = "schlick",
        /// All of it
        None = "none",
        /// Fresnel's equations
        Exact = "exact",
    }
}

words! {
    /// The shadows on the water's surface.
    WaterShadow {
        /// Vertices that a shadow map hides are dark; linear between
        Vertex = "vertex",
        /// None
        None = "none",
        /// A ray from the light to each point
        Exact = "exact",
    }
}

words! {
    /// The beams that are not drawn since they are dark.
    ShadowCull {
        /// Leaves of the hierarchy of which more than `s-min` is in shadow (section 3.4)
        Hierarchy = "hierarchy",
        /// Beams of which all three vertices are dark: no light is lost
        Dark = "dark",
        /// None
        Exact = "exact",
    }
}

words! {
    /// The nodes for which shadow culling asks the shadow map.
    Queries {
        /// All from the roots on (section 3.4)
        All = "all",
        /// Those whose rectangle overlaps an occluder's box as the light sees them (section 5)
        Overlap = "overlap",
    }
}

words! {
    /// The parts of beams that are drawn.
    Clamp {
        /// Those in the view and in boxes of receivers, by nodes first (section 3.3)
        Hierarchy = "hierarchy",
        /// Those in the view and in boxes of receivers, beam by beam (section 4)
        Beams = "beams",
        /// All beams between all planes
        Exact = "exact",
    }
}

words! {
    /// The hulls of the hierarchy's nodes.
    NodeHull {
        /// The box of all rays in the highest and in the lowest plane: conservative
        Padded = "padded",
        /// From the node's rectangle of water to the square of rays in the lowest plane (section 3.3)
        Paper = "paper",
    }
}

words! {
    /// The axis across which planes are.
    SliceAxis {
        /// The mean normal of the water; a coordinate axis if one is near
        Water = "water",
        /// Light refracted by flat water
        Refracted = "refracted",
    }
}

words! {
    /// Light by area along a beam.
    Density {
        /// By the beam's area in each plane, linear between (section 3.2)
        Slices = "slices",
        /// By its area across the light in each plane, linear between
        Perpendicular = "perpendicular",
        /// By its area across the light at the point; of a stencil buffer, in each plane
        Exact = "exact",
    }
}

words! {
    /// The points in a beam.
    Inside {
        /// Pixels by a stencil buffer, with the value of the first face (section 3.2); cameras only
        Stencil = "stencil",
        /// Points in the beam's cross-section, with the value at the point
        Exact = "exact",
    }
}

words! {
    /// The faces that a stencil buffer counts.
    DepthTest {
        /// Those behind surfaces: right wherever the eye is
        Fail = "fail",
        /// Those before surfaces, as in Heidmann 1991: wrong with the eye in a beam that is drawn
        Pass = "pass",
    }
}

words! {
    /// The shadows under water.
    Occlusion {
        /// None
        None = "none",
        /// A ray from the water's surface to the point
        Exact = "exact",
    }
}

words! {
    /// The angles at which light falls on surfaces.
    Cosine {
        /// That of light in flat water, for all beams
        Flat = "flat",
        /// That of the sum of scaled light vectors (section 3.2)
        Vector = "vector",
        /// Each beam's own
        Exact = "exact",
    }
}

words! {
    /// The format in which beams are summed.
    Accumulate {
        /// u8; f16 for vectors
        Auto = "auto",
        /// 8 bits, with 255 for `white`
        U8 = "u8",
        /// Half floats
        F16 = "f16",
        /// Floats
        F32 = "f32",
        /// As computed
        Exact = "exact",
    }
}

words! {
    /// The points of a texel.
    TexelPoints {
        /// Its centre
        Center = "center",
        /// All of it
        Exact = "exact",
    }
}
