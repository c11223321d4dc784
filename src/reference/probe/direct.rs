//! Light that comes straight from an emitter.

use super::found::SpecularPath;
use super::map::{LightMap, LightPlace};
use super::path::{is_at_target, light_path};
use crate::geometry::TraversalCounters;

/// The paths without a specular event, at most one an emitter: their places on the charts are known.
///
/// A mask that stands in the way takes its share of the light.
pub(super) fn direct_paths(map: &LightMap, counters: &mut TraversalCounters) -> Vec<SpecularPath> {
    let target = map.target.point().position;
    let mut paths: Vec<SpecularPath> = Vec::new();
    let mut tracer = map.tracer_to(0);
    for (index, chart) in map.light.charts().iter().enumerate() {
        let emitter = map.light.emitter_of(index);
        // A direction on the edge between two faces is on both.
        if paths.iter().any(|path| path.emitter == emitter) {
            continue;
        }
        let Some(at) = chart.place_towards(target) else {
            continue;
        };
        let place = LightPlace { chart: index, at };
        let Some(emission) = map.emission(place) else {
            continue;
        };
        let mut found = None;
        tracer.images(place, |_, image, landing| {
            if is_at_target(image.offset, emission.ray.origin, target) {
                let mut path = light_path(map, place, &emission, landing, image.jacobian);
                path.residual = image.offset.length();
                found = Some(path);
            }
        });
        paths.extend(found);
    }
    *counters += tracer.counters();
    paths
}
