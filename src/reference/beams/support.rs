//! The light and the surfaces that beams can follow.

use crate::run::Refusal;
use crate::scene::{Emitter, Scene};
use crate::transport::chain_limits;

/// Refuses scenes with light that beams cannot follow.
///
/// # Errors
///
/// Names the emitter or the surface.
pub fn supports(scene: &Scene) -> Result<(), Refusal> {
    chain_limits::check_starts(scene)?;
    for (index, emitter) in scene.emitters().iter().enumerate() {
        if let Emitter::Area { shape, .. } = emitter
            && !emitter.strength().is_black()
        {
            return Err(Refusal::new(format!(
                "emitter {index} is an area light on shape \"{}\": beams follow light from points and directions \
                 only; use photons",
                scene.objects()[shape.0 as usize].id
            )));
        }
    }
    for (index, object) in scene.objects().iter().enumerate() {
        if scene
            .material_of(index as u32)
            .is_partly_passed(scene.materials())
        {
            return Err(Refusal::new(format!(
                "beams cannot tell light past the half open mask \"{}\" from light by what it holds: use photons",
                object.id
            )));
        }
    }
    Ok(())
}
