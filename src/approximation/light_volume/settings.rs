//! The settings of a light volume.

use super::variants::{
    Accumulate, BeamFlux, Clamp, Cosine, Density, DepthTest, Inside, NodeHull, Occlusion, Queries,
    ShadowCull, SliceAxis, TexelPoints, Transmittance, WaterShadow, WaterSurface,
};
use crate::approximation::table::settings;
use crate::setting::{Kind, NamedValues, Values, words_of};

/// The rows of the paper's Table 2.
const PRESETS: &[NamedValues] = &[
    NamedValues {
        word: "reference",
        meaning: "Table 2, Reference: clamping and culling beam by beam",
        values: &[("clamp", "beams"), ("shadow-cull", "exact")],
    },
    NamedValues {
        word: "hierarchical",
        meaning: "Table 2, Hierarchical: clamping and culling by nodes",
        values: &[("shadow-cull", "exact")],
    },
    NamedValues {
        word: "shadow-culling",
        meaning: "Table 2, Shadow Culling: also beams in shadow are culled",
        values: &[],
    },
    NamedValues {
        word: "vector",
        meaning: "Table 2, Vector Accum: also scaled light vectors are summed",
        values: &[("cosine", "vector")],
    },
];

settings! {
    /// The settings of a light volume, with their types. By default, the technique of Table 2's third row.
    Settings;
    /// Row of Table 2; it has done its work when values are read.
    preset: String = "preset", Kind::Presets(PRESETS), Value "shadow-culling", "",
        "Row of the paper's Table 2; other settings override it",
        |values: &Values, key| values.text(key).map(str::to_owned);
    /// The shape that is the water's surface; empty leaves it to the scene.
    surface_shape: String = "surface-shape", Kind::Name, Rule "the only one that refracts", "",
        "Id of the shape that is the water's surface",
        |values: &Values, key| Some(values.text(key).unwrap_or_default().to_owned());
    /// Vertices a row of the grid that samples the water, and rows: W. 0: the mesh's own.
    grid: u32 = "grid", Kind::Whole(0, 4097), Value "0", "vertices",
        "Vertices a row of a grid that samples the water, and rows: W; 0 takes the mesh's own", Values::whole;
    /// Largest error of a beam of the adaptive grid, in texels; 0: none.
    lod: f64 = "lod", Kind::Number(0.0, 1024.0), Value "0", "texels",
        "Error up to which cells of a grid are joined, the smallest of 2^k by buckets; 0 joins none", Values::number;
    /// Stage `surface`.
    surface: WaterSurface = "surface", Kind::Choice(words_of::<WaterSurface>), Value "triangles", "",
        "Stage: rays that bound a beam", Values::word;
    /// Times that exact triangles are quartered.
    levels: u32 = "levels", Kind::Whole(0, 6), Value "1", "",
        "Times that triangles are quartered (exact surface or look-ups)", Values::whole;
    /// Times that a cell is quartered further, if its corners meet different surfaces (exact look-ups).
    border_levels: u32 = "border-levels", Kind::Whole(0, 8), Value "3", "",
        "Further times where corners of a cell meet different surfaces (exact look-ups)", Values::whole;
    /// Stage `flux`.
    flux: BeamFlux = "flux", Kind::Choice(words_of::<BeamFlux>), Value "exact", "",
        "Stage: light that a beam begins with", Values::word;
    /// Stage `fresnel`.
    fresnel: Transmittance = "fresnel", Kind::Choice(words_of::<Transmittance>), Value "vertex", "",
        "Stage: light that the water's surface lets through", Values::word;
    /// Stage `shadow`.
    shadow: WaterShadow = "shadow", Kind::Choice(words_of::<WaterShadow>), Value "vertex", "",
        "Stage: shadows on the water's surface", Values::word;
    /// Texels a row of the shadow map, and rows; 0: a ray for each vertex.
    shadow_map: u32 = "shadow-map", Kind::Whole(0, 16384), Value "1024", "texels",
        "Texels a row of the shadow map, and rows; 0 traces a ray to each vertex instead", Values::whole;
    /// Stage `shadow-cull`.
    shadow_cull: ShadowCull = "shadow-cull", Kind::Choice(words_of::<ShadowCull>), Value "hierarchy", "",
        "Stage: beams that are not drawn since they are dark", Values::word;
    /// Share of a leaf in shadow from which on its beams are culled: `S_min`.
    s_min: f64 = "s-min", Kind::Number(0.0, 1.0), Value "0.65", "",
        "Share of a leaf in shadow beyond which its beams are culled: S_min", Values::number;
    /// Nodes for which shadow culling asks the shadow map.
    queries: Queries = "queries", Kind::Choice(words_of::<Queries>), Value "all", "",
        "Nodes for which shadow culling asks the shadow map", Values::word;
    /// Stage `clamp`.
    clamp: Clamp = "clamp", Kind::Choice(words_of::<Clamp>), Value "hierarchy", "",
        "Stage: parts of beams that are drawn", Values::word;
    /// Root nodes along each side of the water.
    buckets: u32 = "buckets", Kind::Whole(1, 1024), Value "4", "", "Root nodes along each side of the water",
        Values::whole;
    /// Times that a root is quartered.
    splits: u32 = "splits", Kind::Whole(0, 12), Value "3", "", "Times that a root is quartered", Values::whole;
    /// Hulls of nodes.
    hull: NodeHull = "hull", Kind::Choice(words_of::<NodeHull>), Value "padded", "", "Hulls of nodes",
        Values::word;
    /// Share of the flux on its way that may be lost with the faintest beams.
    least_flux: f64 = "least-flux", Kind::Number(0.0, 1.0), Value "0", "",
        "Share of the light that may be lost with the faintest beams", Values::number;
    /// Stage `density`.
    density: Density = "density", Kind::Choice(words_of::<Density>), Value "slices", "",
        "Stage: light by area along a beam", Values::word;
    /// Slices between planes.
    slices: u32 = "slices", Kind::Whole(1, 4096), Value "16", "",
        "Slices from the water's top to the lowest receiver", Values::whole;
    /// Axis across which planes are.
    axis: SliceAxis = "axis", Kind::Choice(words_of::<SliceAxis>), Value "water", "",
        "Axis across which planes are", Values::word;
    /// Stage `inside`.
    inside: Inside = "inside", Kind::Choice(words_of::<Inside>), Value "stencil", "",
        "Stage: points in a beam", Values::word;
    /// Faces that the stencil buffer counts.
    depth_test: DepthTest = "depth-test", Kind::Choice(words_of::<DepthTest>), Value "fail", "",
        "Faces of beams that a stencil buffer counts", Values::word;
    /// Stage `occlusion`.
    occlusion: Occlusion = "occlusion", Kind::Choice(words_of::<Occlusion>), Value "none", "",
        "Stage: shadows under water", Values::word;
    /// Stage `cosine`.
    cosine: Cosine = "cosine", Kind::Choice(words_of::<Cosine>), Value "flat", "",
        "Stage: angles at which light falls on surfaces", Values::word;
    /// Stage `accumulate`.
    accumulate: Accumulate = "accumulate", Kind::Choice(words_of::<Accumulate>), Value "auto", "",
        "Stage: format in which beams are summed", Values::word;
    /// Irradiance that 8 bits hold, in irradiances of a horizontal floor below flat water.
    white: f64 = "white", Kind::Number(1e-6, 1e6), Value "4", "irradiances in flat water",
        "Irradiance that 255 of 8 bits stands for", Values::number;
    /// Stage `lookup`.
    lookup: TexelPoints = "lookup", Kind::Choice(words_of::<TexelPoints>), Value "center", "",
        "Stage: points of a texel", Values::word;
}
