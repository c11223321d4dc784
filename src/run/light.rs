//! The set of light paths that a method measures.

use serde::{Deserialize, Serialize};

use crate::transport::signature::Signature;

/// The set of light paths that a method measures; a truth for it is made of the same light.
///
/// # Example: the light that a technique models
///
/// ```
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let map = nephroid::Method::new("caustic-map", &Default::default())?;
/// # let map = map.with("photons", "16")?.with("map", "16")?;
/// # let rendering = map.run(&scene, sensor, &Default::default(), &Default::default())?;
/// use nephroid::Light;
///
/// assert_eq!(rendering.light, Light::Path("LTTD".parse()?));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Light {
    /// All light that the sensor's quantity is made of.
    All,
    /// The paths of one signature.
    Path(Signature),
    /// All paths by way of mirrors or glass, L S+ D, of up to so many specular events.
    Specular {
        /// The most specular events of a path.
        max_depth: u32,
    },
}

impl Light {
    /// The most specular events of a path; `None` for all light, which has no bound of its own.
    pub(crate) fn max_depth(self) -> Option<u32> {
        match self {
            Self::All => None,
            Self::Path(signature) => Some(signature.len() as u32),
            Self::Specular { max_depth } => Some(max_depth),
        }
    }

    /// True if the paths of a signature are in the set.
    ///
    /// # Example: paths of at most two specular events
    ///
    /// ```
    /// let light = nephroid::Light::Specular { max_depth: 2 };
    /// assert!(light.includes("LTTD".parse()?));
    /// assert!(!light.includes("LD".parse()?), "direct light");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn includes(self, signature: Signature) -> bool {
        match self {
            Self::All => true,
            Self::Path(one) => one == signature,
            Self::Specular { max_depth } => {
                signature != Signature::DIRECT && signature.len() as u32 <= max_depth
            }
        }
    }
}
