//! Stages and their variants, by name.

use crate::approximation::stage::{Stage, stages};
use crate::setting::Words;
use crate::setting::words::words;

words! {
    /// The stages in the order in which they run.
    Step {
        /// Photons that enter the volume
        Emission = "emission",
        /// Pictures of the surfaces in a slab
        Buffers = "buffers",
        /// Crossings of photons with pictures
        March = "march",
        /// Surfaces of a slab that photons may meet
        Layers = "layers",
        /// Ways on from a surface, and the flux on them
        Interface = "interface",
        /// Order of slabs
        Sweep = "sweep",
        /// Places where photons land
        Projector = "projector",
        /// Light of photons on surfaces
        Splat = "splat",
        /// Filter of the film
        Smooth = "smooth",
    }
}

/// One of something for each [`Step`].
pub type BySteps<T> = [T; Step::WORDS.len()];

/// The stages, as techniques list them.
pub(super) static STAGES: BySteps<Stage> = stages(Step::WORDS);

words! {
    /// The photons that enter the volume.
    Emission {
        /// Evenly over the entry face, all along the light's direction at its middle, with equal flux
        Parallel = "parallel",
        /// Evenly over the entry face, along their own directions, with equal flux
        Towards = "towards",
        /// By all faces that light reaches, with their own directions and flux, in shadow or not
        Exact = "exact",
    }
}

words! {
    /// The pictures of a slab.
    Buffers {
        /// Half floats
        F16 = "f16",
        /// Floats
        F32 = "f32",
        /// Asked by rays along the axis at each photon's own place
        Exact = "exact",
    }
}

words! {
    /// The march of a photon through a slab's pictures.
    March {
        /// All texels on its way, each with its interval of depth
        Texels = "texels",
        /// Points at equal steps
        Steps = "steps",
        /// The very crossing with the space between the near and the far picture
        Exact = "exact",
    }
}

words! {
    /// The surfaces of a slab that photons may meet.
    Layers {
        /// The nearest and the farthest, one event on each
        NearFar = "near-far",
        /// The first few from the entry on, any number of events (beyond the paper)
        Peel = "peel",
        /// All, by rays
        Exact = "exact",
    }
}

words! {
    /// The ways on from a surface, and the flux on them.
    Interface {
        /// All flux is refracted, or mirrored by mirrors; total reflection ends it
        Refract = "refract",
        /// As `refract`, and total reflection mirrors
        MirrorTotal = "mirror-total",
        /// As `mirror-total`, with Schlick's share of the way that is taken
        Schlick = "schlick",
        /// As `mirror-total`, with the share by Fresnel's equations
        Fresnel = "fresnel",
        /// All ways by their shares
        Exact = "exact",
    }
}

words! {
    /// The order of slabs.
    Sweep {
        /// Once, forwards; what goes back ends
        Once = "once",
        /// Any, and by all faces
        Exact = "exact",
    }
}

words! {
    /// The places where photons land.
    Projector {
        /// By pictures of the scene from the volume's middle, one by each exit face
        Cube = "cube",
        /// By pictures across each exit face
        Orthographic = "orthographic",
        /// By rays
        Exact = "exact",
    }
}

words! {
    /// The light of photons on surfaces.
    Splat {
        /// Discs whose size is set by density and length of way
        Quads = "quads",
        /// Ellipses as large as neighbouring photons land apart (beyond the paper)
        Ellipses = "ellipses",
        /// Beams between photons, dealt out to texels by area
        Exact = "exact",
    }
}

words! {
    /// The filter of the film.
    Smooth {
        /// A Gaussian
        Gaussian = "gaussian",
        /// None
        Exact = "exact",
    }
}

words! {
    /// The box that the volume is.
    Fit {
        /// Along the axes of the world
        World = "world",
        /// Along the light
        Light = "light",
    }
}

words! {
    /// The face through which photons enter.
    Entry {
        /// The one that faces the light most
        Auto = "auto",
        /// Towards -x
        XLow = "x-",
        /// Towards +x
        XHigh = "x+",
        /// Towards -y
        YLow = "y-",
        /// Towards +y
        YHigh = "y+",
        /// Towards -z
        ZLow = "z-",
        /// Towards +z
        ZHigh = "z+",
    }
}

words! {
    /// What a frame makes anew.
    Update {
        /// Everything
        Full = "full",
        /// Pictures of slabs in which something changed, and photons from the first of these on
        Changed = "changed",
    }
}
