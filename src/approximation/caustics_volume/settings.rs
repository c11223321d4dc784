//! The settings of a caustics volume.

use super::variants::{
    Buffers, Emission, Entry, Fit, Interface, Layers, March, Projector, Smooth, Splat, Sweep,
    Update,
};
use crate::approximation::table::settings;
use crate::setting::{Kind, NamedValues, Values, words_of};

/// The settings of the paper's Tables 4 to 6.
const PRESETS: &[NamedValues] = &[
    NamedValues {
        word: "best",
        meaning: "the paper's best: pictures of 500 x 500 texels, 50,000 photons",
        values: &[],
    },
    NamedValues {
        word: "middle",
        meaning: "the paper's middle: pictures of 200 x 200 texels, 20,000 photons",
        values: &[("g-buffer", "200"), ("photons", "20000")],
    },
    NamedValues {
        word: "lowest",
        meaning: "the paper's lowest: pictures of 100 x 100 texels, 10,000 photons",
        values: &[("g-buffer", "100"), ("photons", "10000")],
    },
];

settings! {
    /// The settings of a caustics volume, with their types. By default, the paper's best.
    Settings;
    /// Rows of Tables 4 to 6; it has done its work when values are read.
    preset: String = "preset", Kind::Presets(PRESETS), Value "best", "",
        "Texels and photons of the paper's Tables 4 to 6; other settings override it",
        |values: &Values, key| values.text(key).map(str::to_owned);
    /// Photons of all lights together.
    photons: u32 = "photons", Kind::Whole(1, 1 << 24), Value "50000", "photons",
        "Photons that enter the volume, of all lights together", Values::whole;
    /// Texels a row of each picture, and rows.
    g_buffer: u32 = "g-buffer", Kind::Whole(1, 4096), Value "500", "texels",
        "Texels a row of each picture, and rows: G", Values::whole;
    /// Slabs of the volume.
    slabs: u32 = "slabs", Kind::Whole(1, 64), Value "3", "slabs", "Slabs of the volume: S", Values::whole;
    /// The box.
    volume: Fit = "volume", Kind::Choice(words_of::<Fit>), Value "world", "",
        "Axes of the box around what mirrors or refracts", Values::word;
    /// Share of its extent by which the box is larger on every side.
    margin: f64 = "margin", Kind::Number(0.0, 10.0), Value "0.01", "",
        "Share of its extent by which the box is larger on every side", Values::number;
    /// The entry face.
    entry: Entry = "entry", Kind::Choice(words_of::<Entry>), Value "auto", "",
        "Face through which photons enter, by the volume's axes", Values::word;
    /// Faces that end photons.
    cull: String = "cull", Kind::Name, Value "entry", "",
        "Faces that end photons: none, or some of entry,x-,x+,y-,y+,z-,z+",
        |values: &Values, key| values.text(key).map(str::to_owned);
    /// Stage `emission`.
    emission: Emission = "emission", Kind::Choice(words_of::<Emission>), Value "parallel", "",
        "Stage: photons that enter the volume", Values::word;
    /// Stage `buffers`.
    buffers: Buffers = "buffers", Kind::Choice(words_of::<Buffers>), Value "f32", "",
        "Stage: pictures of the surfaces in a slab", Values::word;
    /// Stage `march`.
    march: March = "march", Kind::Choice(words_of::<March>), Value "texels", "",
        "Stage: crossings of photons with pictures", Values::word;
    /// Steps of `march=steps` through a slab.
    steps: u32 = "steps", Kind::Whole(1, 65536), Value "128", "steps",
        "Steps along the way through a slab, if these are equal (march=steps)", Values::whole;
    /// Stage `layers`.
    layers: Layers = "layers", Kind::Choice(words_of::<Layers>), Value "near-far", "",
        "Stage: surfaces of a slab that photons may meet", Values::word;
    /// Surfaces of `layers=peel`.
    peels: u32 = "peels", Kind::Whole(1, 16), Value "4", "surfaces",
        "Surfaces by texel, from the entry on (layers=peel)", Values::whole;
    /// Stage `interface`.
    interface: Interface = "interface", Kind::Choice(words_of::<Interface>), Value "refract", "",
        "Stage: ways on from a surface, and the flux on them", Values::word;
    /// Most specular events of a photon.
    max_depth: u32 = "max-depth", Kind::Whole(1, 64), Value "16", "events",
        "Most specular events of a photon, and of the light that it is judged by", Values::whole;
    /// Stage `sweep`.
    sweep: Sweep = "sweep", Kind::Choice(words_of::<Sweep>), Value "once", "", "Stage: order of slabs",
        Values::word;
    /// Stage `projector`.
    projector: Projector = "projector", Kind::Choice(words_of::<Projector>), Value "cube", "",
        "Stage: places where photons land", Values::word;
    /// Stage `splat`.
    splat: Splat = "splat", Kind::Choice(words_of::<Splat>), Value "quads", "",
        "Stage: light of photons on surfaces", Values::word;
    /// Texels of a projector's picture along a tile in which density is counted.
    tile: u32 = "tile", Kind::Whole(1, 4096), Value "16", "texels",
        "Texels of a projector's picture along a tile in which photons are counted", Values::whole;
    /// Factor of a splat's radius.
    splat_scale: f64 = "splat-scale", Kind::Number(1e-3, 1e3), Value "1", "",
        "Factor of a splat's radius by density", Values::number;
    /// Least radius of a splat.
    splat_min: f64 = "splat-min", Kind::Number(0.0, 1e12), Value "0", "m",
        "Least radius of a splat by density, before its length of way", Values::number;
    /// Largest radius of a splat, by the volume's diagonal.
    splat_max: f64 = "splat-max", Kind::Number(1e-6, 1e3), Value "0.05", "diagonals",
        "Largest radius of a splat by density, in diagonals of the volume", Values::number;
    /// Half the height of a splat, in radii.
    bias: f64 = "bias", Kind::Number(0.0, 1e6), Value "2", "radii",
        "Distance from a splat's plane up to which surfaces are lit, in radii", Values::number;
    /// Times that a cell between photons is quartered at borders (exact splats).
    border_levels: u32 = "border-levels", Kind::Whole(0, 8), Value "3", "",
        "Times that a cell between photons is quartered where they part (exact splats)", Values::whole;
    /// Stage `smooth`.
    smooth: Smooth = "smooth", Kind::Choice(words_of::<Smooth>), Value "gaussian", "",
        "Stage: filter of the film", Values::word;
    /// Standard deviation of the filter.
    sigma: f64 = "sigma", Kind::Number(1e-3, 64.0), Value "1", "texels",
        "Standard deviation of the film's filter", Values::number;
    /// Distance from the camera up to which all slabs are used; 0: at any.
    lod_distance: f64 = "lod-distance", Kind::Number(0.0, 1e12), Value "0", "m",
        "Distance of a camera up to which all slabs are used; 0 is any", Values::number;
    /// Whether a volume out of the camera's view has no photons.
    frustum: bool = "frustum", Kind::Flag, Value "false", "",
        "Leaves out a volume that is out of the camera's view",
        Values::flag;
    /// What a frame makes anew.
    update: Update = "update", Kind::Choice(words_of::<Update>), Value "full", "",
        "Parts that each frame of an animation makes anew", Values::word;
    /// Frames among which the photons are shared out.
    shares: u32 = "shares", Kind::Whole(1, 1000), Value "1", "frames",
        "Frames of an animation among which the photons are shared out", Values::whole;
    /// Passes of a frame; 0: all.
    amortise: u32 = "amortise", Kind::Whole(0, 65), Value "0", "passes",
        "Passes that each frame of an animation makes; 0 is all", Values::whole;
}

impl Settings {
    /// True if a frame shows light of the frames before it.
    pub fn trails(&self) -> bool {
        self.shares > 1 || self.amortise > 0
    }
}
