//! What a scene file says of the paths that are to be followed.

/// How long paths are, and what the camera is not to see, as the file's integrator says.
///
/// Which method computes is not the scene's to say; but a file that asks for direct light only means another
/// image than one that asks for all of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Integrator {
    /// The name of Mitsuba's plugin.
    pub plugin: String,
    /// Whether the camera does not see emitters, neither directly nor through what lets light pass.
    pub hide_emitters: bool,
    /// The most legs of a path from light to camera (1: emitters seen directly; 2: direct light);
    /// `None` for any number.
    pub max_depth: Option<u32>,
    /// The leg from which on Russian roulette may end paths.
    pub rr_depth: u32,
}

impl Integrator {
    /// Mitsuba's `rr_depth` where a file does not say.
    pub const DEFAULT_RR_DEPTH: u32 = 5;
}
