//! Scenes and settings that beams cannot handle.

use crate::reference::TargetError;
use crate::scene::{Emitter, Scene};
use crate::transport::chain_limits::{self, NotFollowed};
use crate::transport::domain::surface::{LightSurface, MAX_TRIANGLES};

/// The reason why beams cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum BeamError {
    /// The sensor cannot be filled.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// An area light whose surface light cannot start from.
    #[error(
        "emitter {index} shines from shape \"{id}\": light can start from rectangles, discs, balls \
         that shine outward, and meshes of up to {MAX_TRIANGLES} triangles"
    )]
    LampShape {
        /// The light, in the file's order, from 0.
        index: usize,
        /// The shape's id.
        id: String,
    },
    /// A surface that light both passes and meets.
    #[error(
        "beams cannot tell light past the half open mask \"{id}\" from light by what it holds: use photons"
    )]
    Mask {
        /// The shape's id.
        id: String,
    },
    /// Chains cannot be followed in the scene.
    #[error(transparent)]
    NotFollowed(#[from] NotFollowed),
    /// A setting outside its range.
    #[error("{name} is {value}; {allowed} are allowed")]
    Setting {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: String,
        /// The values that it may have.
        allowed: String,
    },
    /// A deposit or a sum is too large for its integer.
    #[error("a texel's flux is not representable: NaN, infinite, or far beyond the emitters' flux")]
    NotRepresentable,
}

/// Succeeds if beams can follow all light of a scene.
///
/// # Errors
///
/// An error that names the light or material that they cannot follow.
pub fn supports(scene: &Scene) -> Result<(), BeamError> {
    for (index, emitter) in scene.emitters().iter().enumerate() {
        if let Emitter::Area { shape, .. } = emitter
            && !emitter.strength().is_black()
            && LightSurface::new(&scene.world().shapes()[shape.0 as usize]).is_none()
        {
            return Err(BeamError::LampShape {
                index,
                id: scene.objects()[shape.0 as usize].id.clone(),
            });
        }
    }
    for (index, object) in scene.objects().iter().enumerate() {
        if scene
            .material_of(index as u32)
            .is_partly_passed(scene.materials())
        {
            return Err(BeamError::Mask {
                id: object.id.clone(),
            });
        }
    }
    chain_limits::check(scene)?;
    Ok(())
}

/// True if beams draw nothing at random for a scene: no light shines from a surface. Otherwise photons may be
/// sooner at the same error.
pub fn is_deterministic(scene: &Scene) -> bool {
    scene
        .emitters()
        .iter()
        .all(|emitter| !matches!(emitter, Emitter::Area { .. }) || emitter.strength().is_black())
}
