//! Which method computes a run.

use super::args::{Method, RenderArgs};
use super::sensor::is_camera;
use crate::reference::beams;
use crate::scene::{Scene, Sensor};

/// A method, and what there is to say about how it came to be chosen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    /// The method.
    pub method: Method,
    /// Where it, or what an option does to it, is not what one would expect.
    pub notice: Option<String>,
}

/// The method asked for, or the best that a scene allows: beams, unless light has to be drawn
/// by lot, or an option says how photons are to be drawn.
///
/// # Errors
///
/// Where paths are asked for on a sensor that is no camera.
pub fn choose(args: &RenderArgs, scene: &Scene, sensor: &Sensor) -> anyhow::Result<Choice> {
    let draws_lots = !beams::is_deterministic(scene);
    let of_photons = args.of_photons_only();
    let of_chance = args.of_chance();
    let prefers_beams = beams::supports(scene).is_ok() && !draws_lots;
    let method = args.method.unwrap_or({
        if args.of_paths_only().is_some() {
            Method::Path
        } else if prefers_beams && of_photons.or(of_chance).is_none() {
            Method::Beams
        } else {
            Method::Photons
        }
    });
    if matches!(method, Method::Path | Method::Full) && !is_camera(sensor) {
        anyhow::bail!(
            "sensor \"{}\" ({}): paths start at cameras; an irradiancemeter is filled by --method beams or photons",
            sensor.id,
            sensor.plugin()
        );
    }
    let notice = match (method, args.method, of_chance) {
        // Who says how many photons knows that there will be photons.
        (Method::Photons, None, _) if prefers_beams => {
            let says_so = args.photons.is_some() || args.shard.is_some();
            of_photons.or(of_chance).filter(|_| !says_so).map(|name| {
                format!(
                    "{name} is about drawing by lot, so photons are used; without it, this scene's light \
                     is computed by beams, sooner and with bounds"
                )
            })
        }
        (Method::Beams, _, Some(name)) if !draws_lots => Some(format!(
            "{name} has no effect: beams draw nothing by lot where no light shines from a surface"
        )),
        _ => None,
    };
    Ok(Choice { method, notice })
}
