//! Stages and their variants, by name.

use crate::approximation::stage::{Stage, stages};
use crate::setting::Words;
use crate::setting::words::words;

words! {
    /// The stages in the order in which they run.
    Step {
        /// What the light sees
        View = "view",
        /// How light leaves the specular object
        Refraction = "refraction",
        /// Where it meets the receiver
        Hit = "hit",
        /// What a photon stands for
        Flux = "flux",
        /// What interfaces let through
        Fresnel = "fresnel",
        /// How a photon's light is spread
        Splat = "splat",
        /// How irradiance is read
        Lookup = "lookup",
    }
}

/// One of something for each [`Step`].
pub type BySteps<T> = [T; Step::WORDS.len()];

/// The stages, as techniques list them.
pub(super) static STAGES: BySteps<Stage> = stages(Step::WORDS);

words! {
    /// The light that is modelled.
    Mode {
        /// Through two interfaces of a refractor: `LTTD`
        Refraction = "refraction",
        /// Through one interface, as of water without a bottom side: `LTD`
        SingleRefraction = "single-refraction",
        /// By one mirror reflection: `LRD`
        Reflection = "reflection",
    }
}

words! {
    /// The way in which light leaves the specular object.
    Refraction {
        /// Wyman 2005: the exit point at an approximate distance, its normal from a picture of back faces
        ImageSpace = "image-space",
        /// The ray is traced through the object
        Exact = "exact",
    }
}

words! {
    /// The distance between entry and exit, by image-space refraction.
    Thickness {
        /// Between the object's thickness along the light and along the normal (Wyman 2005)
        Interpolated = "interpolated",
        /// The object's thickness along the light (Wyman's demo of 2008)
        View = "view",
    }
}

words! {
    /// The back faces in the picture that image-space refraction reads.
    BackFaces {
        /// The farthest of each pixel (Wyman 2005)
        Farthest = "farthest",
        /// The nearest of each pixel (Wyman's demo of 2008)
        Nearest = "nearest",
    }
}

words! {
    /// What image-space refraction does at an exit point where the picture has no back face.
    NoBackFace {
        /// The normal is across the axis of the light's view, as on an object's side (Wyman's demo of 2008)
        Side = "side",
        /// The photon is dropped
        Drop = "drop",
    }
}

words! {
    /// What image-space refraction does where the approximate exit would reflect all light.
    TotalReflection {
        /// The photon leaves along the surface: the cosine is clamped to 0 (Wyman's shader of 2005)
        Clamp = "clamp",
        /// The photon is dropped (Wyman's demo of 2008)
        Drop = "drop",
    }
}

words! {
    /// The way in which a photon meets the receiver.
    Hit {
        /// A march through the receivers' depth map, then bisection
        DepthMap = "depth-map",
        /// Two guesses, then ten steps each to the depth found by the last (Wyman's demo of 2008)
        FixedPoint = "fixed-point",
        /// The ray is traced
        Exact = "exact",
    }
}

words! {
    /// The light that a photon stands for.
    Flux {
        /// As much as makes photons per texel direct light where nothing bends them (Wyman 2006, 2008)
        DensityRatio = "density-ratio",
        /// All pixels of the light view alike
        Uniform = "uniform",
        /// By the solid angle of its pixel
        Exact = "exact",
    }
}

words! {
    /// The spread of a photon's light.
    Splat {
        /// One size for all (Wyman and Davis 2006)
        Fixed = "fixed",
        /// Into one texel; looked up in a chain of box-filtered maps
        Mip = "mip",
        /// Into every level of a chain of maps
        MipSplat = "mip-splat",
        /// Four Gaussians and counts (section 4.1)
        MultiResolution = "multi-resolution",
        /// As wide as a thin lens makes the beam (section 4.2)
        ThinLens = "thin-lens",
        /// As wide as a thick lens makes the beam
        ThickLens = "thick-lens",
        /// An ellipse from the beam's exact derivatives
        TwoCurvatures = "two-curvatures",
        /// No photons: beams between the pixels' corners
        Exact = "exact",
    }
}

words! {
    /// The form of round splats.
    Kernel {
        /// A Gaussian of a sixth of the diameter, its weights divided by their sum
        Gaussian = "gaussian",
        /// The filter of Wyman's demo of 2008 in the circle: 1.35 times as wide, weights as they are
        Wyman2008 = "wyman-2008",
    }
}

words! {
    /// The way in which irradiance is read.
    Lookup {
        /// The texel
        Nearest = "nearest",
        /// Four texels, interpolated
        Bilinear = "bilinear",
        /// Light is dealt out to the sensor's own texels, by area
        Exact = "exact",
    }
}

words! {
    /// The contents of the photon buffer's image.
    Frustum {
        /// Specular objects and receivers, as the caustic map's does
        Scene = "scene",
        /// Specular objects only
        Object = "object",
    }
}
