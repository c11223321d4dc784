//! The limits that a scene file sets on the paths to be followed.

/// The path lengths, and the visibility of emitters to the camera, that the file's integrator asks for.
///
/// A scene does not choose the method that computes its image. But a file that asks for direct light only
/// means another image than one that asks for all of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Integrator {
    /// The name of Mitsuba's plugin.
    pub plugin: String,
    /// True if the camera does not see emitters, neither directly nor through what lets light pass.
    pub hide_emitters: bool,
    /// Largest number of legs of a path from light to camera (1: emitters seen directly; 2: direct light).
    /// `None` for any number.
    pub max_depth: Option<u32>,
    /// The leg from which Russian roulette may end paths.
    pub rr_depth: u32,
}

impl Integrator {
    /// Mitsuba's `rr_depth` for a file that gives none.
    pub const DEFAULT_RR_DEPTH: u32 = 5;
}
