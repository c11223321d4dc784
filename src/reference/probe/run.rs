//! Probe runs: all light that reaches a point.

use glam::DVec2;

use super::direct::direct_paths;
use super::error::ProbeError;
use super::found::Probed;
use super::map::LightMap;
use super::path::specular_paths;
use super::search::search;
use super::settings::ProbeSettings;
use super::target::ProbeTarget;
use crate::scene::{Scene, Sensor};
use crate::transport::chain_limits;
use crate::transport::domain::{LightSpace, LightSpaceError};
use crate::transport::receiver::Receiver;
use crate::transport::signature::MAX_EVENTS;

/// Finds every specular path from the scene's emitters to the point at `uv` of the shape that `sensor`
/// measures, and direct light.
///
/// # Errors
///
/// As [`probe_until`].
pub fn probe(
    scene: &Scene,
    sensor: &Sensor,
    uv: DVec2,
    settings: &ProbeSettings,
) -> Result<Probed, ProbeError> {
    probe_until(scene, sensor, uv, settings, &|| false)
}

/// Finds the same as [`probe`], until `stop` returns true; then the result is what was found by that time.
///
/// The crop of the sensor's film does not matter. Results of runs that nothing stopped are the same bits on
/// any number of threads.
///
/// # Errors
///
/// If the sensor is no irradiance meter on a shape with (u, v), if `uv` is outside, or if an emitter has a
/// surface.
pub fn probe_until(
    scene: &Scene,
    sensor: &Sensor,
    uv: DVec2,
    settings: &ProbeSettings,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Probed, ProbeError> {
    if settings.max_depth as usize > MAX_EVENTS {
        return Err(ProbeError::Depth(settings.max_depth));
    }
    if let Some(one) = scene.dispersion().first() {
        return Err(ProbeError::Dispersion(one.id.clone()));
    }
    let receiver = Receiver::new(scene, sensor)?;
    let target = ProbeTarget::new(scene, &receiver, uv).ok_or(ProbeError::OffReceiver(uv))?;
    chain_limits::check_starts(scene).map_err(LightSpaceError::from)?;
    let area = scene
        .emitters()
        .iter()
        .position(|emitter| !emitter.is_delta());
    if let Some(index) = area {
        return Err(ProbeError::AreaEmitter { emitter: index + 1 });
    }
    let light = LightSpace::new(scene)?;
    let map = LightMap::new(scene, &light, &target, settings);
    let found = search(&map, stop);
    let mut counters = found.counters;
    let mut paths = direct_paths(&map, &mut counters);
    paths.extend(specular_paths(&map, found.roots, &mut counters));
    paths.sort_by(|a, b| {
        let brighter = b.irradiance.mean().total_cmp(&a.irradiance.mean());
        a.signature.cmp(&b.signature).then(brighter)
    });
    Ok(Probed {
        point: target.point(),
        paths,
        unresolved: found.unresolved,
        end: found.end,
        level: found.level,
        patches: found.patches,
        counters,
    })
}
