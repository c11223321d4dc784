//! The light and the surfaces that beams can follow.

use crate::run::Refusal;
use crate::scene::{Emitter, Scene};
use crate::transport::chain_limits;
use crate::transport::domain::surface::{LightSurface, MAX_TRIANGLES};

/// The refusal of an area light, number `index` in the file's order from 0, whose surface light cannot start
/// from.
pub(super) fn refuse_area_light(scene: &Scene, index: usize, shape: usize) -> Refusal {
    let id = &scene.objects()[shape].id;
    Refusal::new(format!(
        "emitter {index} shines from shape \"{id}\": light can start from rectangles, discs, balls that shine \
         outward, and meshes of up to {MAX_TRIANGLES} triangles"
    ))
}

/// Refuses scenes with light that beams cannot follow.
///
/// # Errors
///
/// Names the emitter or the surface.
pub fn supports(scene: &Scene) -> Result<(), Refusal> {
    for (index, emitter) in scene.emitters().iter().enumerate() {
        if let Emitter::Area { shape, .. } = emitter
            && !emitter.strength().is_black()
            && LightSurface::new(&scene.world().shapes()[shape.0 as usize]).is_none()
        {
            return Err(refuse_area_light(scene, index, shape.0 as usize));
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
    chain_limits::check(scene)?;
    Ok(())
}

/// True if beams draw nothing at random: no light of the scene shines from a surface. Otherwise photons may
/// be sooner at the same error.
pub fn is_deterministic(scene: &Scene) -> bool {
    scene
        .emitters()
        .iter()
        .all(|emitter| !matches!(emitter, Emitter::Area { .. }) || emitter.strength().is_black())
}
