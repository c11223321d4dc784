//! The settings of local precomputed irradiance.

use super::variants::{
    Axis, Deposit, Directions, Interpolation, Light, Noise, Normal, Radii, Region, SampleAt, Space,
    Storage, Surroundings, Symmetry, Tables, Tree,
};
use crate::approximation::table::settings;
use crate::setting::{Kind, Values, words_of};

settings! {
    /// The settings of local precomputed irradiance, with their types.
    Settings;
    /// Stage `light`.
    light: Light = "light", Kind::Choice(words_of::<Light>), Value "directional", "",
        "Stage: light that tables are made for", Values::word;
    /// Stage `scene`.
    scene: Surroundings = "scene", Kind::Choice(words_of::<Surroundings>), Value "alone", "",
        "Stage: what is around the object", Values::word;
    /// Stage `directions`.
    directions: Directions = "directions", Kind::Choice(words_of::<Directions>), Value "aligned", "",
        "Stage: samples of light directions that a frame reads", Values::word;
    /// Parts of an icosahedron's edge, between which light directions are sampled.
    frequency: u32 = "frequency", Kind::Whole(1, 64), Value "4", "",
        "Parts of an icosahedron's edge: 10 f² + 2 light directions", Values::whole;
    /// Where light directions are sampled.
    sample_at: SampleAt = "sample-at", Kind::Choice(words_of::<SampleAt>), Value "vertices", "",
        "Where light directions are sampled", Values::word;
    /// A symmetry of the object.
    symmetry: Symmetry = "symmetry", Kind::Choice(words_of::<Symmetry>), Value "none", "",
        "Symmetry of the object that spares light directions", Values::word;
    /// The axis of that symmetry.
    axis: Axis = "axis", Kind::Choice(words_of::<Axis>), Value "z", "",
        "Axis of the symmetry, in the object's own space", Values::word;
    /// Samples along half a turn about it.
    axis_samples: u32 = "axis-samples", Kind::Whole(2, 4096), Value "64", "samples",
        "Light directions from one end of the axis to the other", Values::whole;
    /// Stage `noise`.
    noise: Noise = "noise", Kind::Choice(words_of::<Noise>), Value "photons", "",
        "Stage: number of photons of a light direction", Values::word;
    /// Photons of a sample.
    photons: u64 = "photons", Kind::Whole(1, 1 << 30), Value "262144", "photons",
        "Photons of a light direction", Values::whole;
    /// Relative standard error at which `noise=exact` ends.
    noise_error: f64 = "noise-error", Kind::Number(1e-4, 1.0), Value "0.003", "",
        "Relative standard error of what the sensor reads, at which noise=exact ends", Values::number;
    /// Specular events of a photon.
    max_depth: u32 = "max-depth", Kind::Whole(1, 16), Value "16", "events",
        "Specular events after which a photon ends", Values::whole;
    /// Seed of the photons.
    seed: u64 = "seed", Kind::Whole(0, u32::MAX as u64), Value "0", "", "Seed of the photons", Values::whole;
    /// Stage `deposit`.
    deposit: Deposit = "deposit", Kind::Choice(words_of::<Deposit>), Value "crossing", "",
        "Stage: light of a photon's leg in a cell", Values::word;
    /// Stage `space`.
    space: Space = "space", Kind::Choice(words_of::<Space>), Value "grid", "",
        "Stage: cells of space", Values::word;
    /// Radius of the region by the object's.
    reach: f64 = "reach", Kind::Number(1.0, 1000.0), Value "3", "radii",
        "Radius of the region that has cells, by the object's", Values::number;
    /// Cubes along each side of a grid.
    cells: u32 = "cells", Kind::Whole(1, 512), Value "64", "cells",
        "Cubes along each side of a grid", Values::whole;
    /// Shells.
    shells: u32 = "shells", Kind::Whole(1, 256), Value "6", "shells", "Shells", Values::whole;
    /// Each shell has 20·4^level triangles.
    shell_level: u32 = "shell-level", Kind::Whole(0, 8), Value "4", "",
        "Level of a shell: it has 20·4^level triangles", Values::whole;
    /// The radii of shells.
    radii: Radii = "radii", Kind::Choice(words_of::<Radii>), Value "adapted", "",
        "Radii of shells", Values::word;
    /// The cells that a tree merges.
    tree: Tree = "tree", Kind::Choice(words_of::<Tree>), Value "shells", "",
        "Cells that space=multi-resolution merges", Values::word;
    /// Largest difference of a cell from the mean of those it is merged with.
    tolerance: f64 = "tolerance", Kind::Number(0.0, 1000.0), Value "0.05", "",
        "Largest difference of a merged cell from the mean, by the light's own irradiance", Values::number;
    /// How a value between cells is found.
    interpolation: Interpolation = "interpolation", Kind::Choice(words_of::<Interpolation>), Value "linear", "",
        "How a value between cells is found", Values::word;
    /// Order of spherical harmonics.
    order: u32 = "order", Kind::Whole(1, 32), Value "5", "",
        "Order n of spherical harmonics: n² coefficients", Values::whole;
    /// Stage `region`.
    region: Region = "region", Kind::Choice(words_of::<Region>), Value "clamp", "",
        "Stage: light beyond the cells", Values::word;
    /// Stage `normal`.
    normal: Normal = "normal", Kind::Choice(words_of::<Normal>), Value "fixed", "",
        "Stage: normal of surfaces", Values::word;
    /// Stage `storage`.
    storage: Storage = "storage", Kind::Choice(words_of::<Storage>), Value "u8", "",
        "Stage: numbers of a table", Values::word;
    /// Largest number of a table of bytes.
    range: f64 = "range", Kind::Number(1e-3, 1e6), Value "3", "",
        "Largest number of a table of bytes, by the light's own irradiance", Values::number;
    /// The tables that are made before the first frame.
    tables: Tables = "tables", Kind::Choice(words_of::<Tables>), Value "needed", "",
        "Tables that are made before the first frame", Values::word;
    /// Look-ups along each side of a sensor's texel.
    samples: u32 = "samples", Kind::Whole(1, 64), Value "2", "",
        "Look-ups along each side of a sensor's texel", Values::whole;
}

impl Settings {
    /// All that tables depend on which outlive a frame, in words.
    pub fn of_tables(&self) -> String {
        let radii = (self.shells, self.shell_level, self.radii);
        format!(
            "{:?}",
            (
                (
                    self.frequency,
                    self.sample_at,
                    self.symmetry,
                    self.axis,
                    self.axis_samples
                ),
                (self.photons, self.max_depth, self.seed, self.deposit),
                (
                    self.space,
                    self.reach,
                    self.cells,
                    radii,
                    self.tree,
                    self.tolerance,
                    self.order
                ),
                (
                    self.storage,
                    self.range,
                    self.directions == Directions::Harmonics,
                    self.normal == Normal::Vector
                ),
            )
        )
    }
}
