//! Stages and their variants, by name.

use crate::approximation::stage::{Stage, stages};
use crate::setting::Words;
use crate::setting::words::words;

words! {
    /// The stages in the order in which they run.
    Step {
        /// The light that tables are made for
        Light = "light",
        /// What is around the object
        Scene = "scene",
        /// The samples of light directions that a frame reads
        Directions = "directions",
        /// The number of photons of a sample
        Noise = "noise",
        /// The light of a photon's leg in a cell
        Deposit = "deposit",
        /// The cells of space
        Space = "space",
        /// Light beyond the cells
        Region = "region",
        /// The normal of surfaces
        Normal = "normal",
        /// The numbers of a table
        Storage = "storage",
    }
}

/// One of something for each [`Step`].
pub type BySteps<T> = [T; Step::WORDS.len()];

/// The stages, as techniques list them.
pub(super) static STAGES: BySteps<Stage> = stages(Step::WORDS);

words! {
    /// The light that tables are made for.
    Light {
        /// Parallel light with the irradiance at the object's centre
        Directional = "directional",
        /// The emitter itself, turned about the object for other directions
        Exact = "exact",
    }
}

words! {
    /// What is around the object.
    Surroundings {
        /// Nothing: neither shadows nor other objects, and receivers stop no light
        Alone = "alone",
        /// The whole scene
        Exact = "exact",
    }
}

words! {
    /// The samples of light directions that a frame reads.
    Directions {
        /// The three around the light, each turned by the least rotation that takes the light to it
        Aligned = "aligned",
        /// The three around the light
        Barycentric = "barycentric",
        /// The nearest one
        Nearest = "nearest",
        /// All, as spherical harmonics of the light's direction fitted in each cell
        Harmonics = "harmonics",
        /// One, at the light's direction
        Exact = "exact",
    }
}

words! {
    /// The number of photons of a sample.
    Noise {
        /// As set
        Photons = "photons",
        /// Doubled until what the sensor reads is known
        Exact = "exact",
    }
}

words! {
    /// The light of a photon's leg in a cell.
    Deposit {
        /// Flux by the cell's area across the leg, as if it met a surface at the cell's middle
        Crossing = "crossing",
        /// The mean over the cell, of legs outside of glass
        Exact = "exact",
    }
}

words! {
    /// The cells of space.
    Space {
        /// Cubes
        Grid = "grid",
        /// Triangles of a geodesic on concentric shells
        Shells = "shells",
        /// Cells that are merged where the caustic is even
        MultiResolution = "multi-resolution",
        /// Spherical harmonics on each shell
        ShellHarmonics = "shell-harmonics",
        /// None: legs count where they cross the sensor's surface
        Exact = "exact",
    }
}

words! {
    /// Light beyond the cells.
    Region {
        /// That at the border, along the line to the object's centre
        Clamp = "clamp",
        /// Fades out in the last tenth of the radius
        Fade = "fade",
        /// More cells, up to all that the sensor sees
        Exact = "exact",
    }
}

words! {
    /// The normal of surfaces.
    Normal {
        /// As if all light came from the object's centre
        Fixed = "fixed",
        /// Any, by the light's mean direction in each cell: vector irradiance
        Vector = "vector",
        /// The sensor's own
        Exact = "exact",
    }
}

words! {
    /// The numbers of a table.
    Storage {
        /// Bytes: 256 steps from 0 to the range
        U8 = "u8",
        /// Four bytes: mantissas of nine bits with one exponent of five
        Rgb9e5 = "rgb9e5",
        /// Half floats
        F16 = "f16",
        /// Floats
        F32 = "f32",
        /// As computed
        Exact = "exact",
    }
}

words! {
    /// Where light directions are sampled.
    SampleAt {
        /// The vertices of a geodesic
        Vertices = "vertices",
        /// The middles of its triangles
        Centres = "centres",
    }
}

words! {
    /// A symmetry of the object that spares light directions.
    Symmetry {
        /// None
        None = "none",
        /// Every turn about its centre: one sample
        Sphere = "sphere",
        /// Every turn about an axis of its own space: samples by the angle to it
        Axis = "axis",
    }
}

words! {
    /// An axis of the object's own space.
    Axis {
        /// x
        X = "x",
        /// y
        Y = "y",
        /// z
        Z = "z",
    }
}

words! {
    /// The radii of shells.
    Radii {
        /// Closer where a pilot's caustic changes
        Adapted = "adapted",
        /// Equally far apart
        Uniform = "uniform",
    }
}

words! {
    /// Cells that a tree merges.
    Tree {
        /// Triangles on shells, four by four
        Shells = "shells",
        /// Cubes, eight by eight
        Grid = "grid",
    }
}

words! {
    /// How a value between cells is found.
    Interpolation {
        /// Linearly
        Linear = "linear",
        /// The cell's own
        Nearest = "nearest",
    }
}

words! {
    /// The tables that are made before the first frame.
    Tables {
        /// Those that the frame reads
        Needed = "needed",
        /// All
        All = "all",
    }
}
