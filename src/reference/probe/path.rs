//! From roots to paths: roots that the scene hides or that were found twice are left out, and flux is
//! computed for the rest.

use glam::{DMat2, DVec2, DVec3};

use super::found::{SpecularPath, Vertex};
use super::map::{LightMap, LightPlace, MapTracer};
use super::newton::Root;
use crate::geometry::{Hit, SurfacePoint, TraversalCounters};
use crate::transport::differentials::{ChainStep, Landing, signature};
use crate::transport::domain::DeltaEmission;
use crate::transport::scatter::Way;

/// Part of the patch in which a root is alone: a root of the same chain that lies nearer to it is the same.
const SAME: f64 = 1.0 / 16.0;

/// Largest miss of a ray traced through the scene as it is: the step in the root's patch that brings it to
/// the target. A ray that misses by more met something else than the chain (a facet beside the one that was
/// extended).
const VERIFIED: f64 = 1.0 / (1 << 12) as f64;

/// Step of the differences for the gradient of det J, as a part of the patch in which J varies by half at
/// most. Their error is about its square, 1e-8, and rounding adds 1e-15 / 1e-4.
const GRADIENT_STEP: f64 = 1e-4;

/// The roots that the scene does not hide, each once, as paths.
pub(super) fn specular_paths(
    map: &LightMap,
    roots: Vec<Root>,
    counters: &mut TraversalCounters,
) -> Vec<SpecularPath> {
    let mut tracer = map.tracer();
    let mut kept: Vec<(Root, DeltaEmission)> = Vec::new();
    let mut paths = Vec::new();
    for root in roots {
        let Some(emission) = map.emission(root.place) else {
            continue;
        };
        let again = |(other, found): &(Root, DeltaEmission)| {
            map.light.emitter_of(root.place.chart) == map.light.emitter_of(other.place.chart)
                && is_same_chain(&root.chain, &other.chain)
                && light_distance(&emission, found)
                    < SAME * reach(&emission, &root).min(reach(found, other))
        };
        if kept.iter().any(again) {
            continue;
        }
        if let Some(path) = verified(map, &mut tracer, &root, &emission) {
            paths.push(path);
            kept.push((root, emission));
        }
    }
    *counters += tracer.counters();
    paths
}

/// True if two chains are the same but for faces.
fn is_same_chain(a: &[ChainStep], b: &[ChainStep]) -> bool {
    a.len() == b.len()
        && a.iter()
            .zip(b)
            .all(|(a, b)| a.element.shape == b.element.shape && a.way == b.way)
}

/// Distance between two rays of one emitter: metres for parallel light, radians for a point's.
fn light_distance(a: &DeltaEmission, b: &DeltaEmission) -> f64 {
    a.ray.origin.distance(b.ray.origin) + a.ray.direction.distance(b.ray.direction)
}

/// Half the size of a root's patch, in the measure of [`light_distance`].
fn reach(emission: &DeltaEmission, root: &Root) -> f64 {
    let [x, y] = emission
        .derivatives
        .map(|by| by.position.length() + by.direction.length());
    (x * root.half.x).min(y * root.half.y)
}

/// The path of a root; `None` if the scene as it is does not have it.
fn verified(
    map: &LightMap,
    tracer: &mut MapTracer,
    root: &Root,
    emission: &DeltaEmission,
) -> Option<SpecularPath> {
    let (met, landing) = tracer.retrace(root.place, &root.chain)?;
    let image = map.target.image(&landing)?;
    let step = image.jacobian.inverse() * image.offset / root.half;
    // False for NaN.
    let is_there = step.abs().max_element() < VERIFIED;
    if !is_there {
        return None;
    }
    let mut path = light_path(map, root.place, emission, &landing, image.jacobian);
    path.signature = signature(&root.chain);
    path.vertices = vertices(&met, &root.chain);
    path.folded ^= reverses(&root.chain);
    path.residual = image.offset.length();
    path.fold_distance = fold_distance(tracer, root, image.jacobian);
    Some(path)
}

/// The effect of a place's light on the target, without the surfaces on its way.
pub(super) fn light_path(
    map: &LightMap,
    place: LightPlace,
    emission: &DeltaEmission,
    landing: &Landing,
    jacobian: DMat2,
) -> SpecularPath {
    let chart = &map.light.charts()[place.chart];
    let area = jacobian.determinant();
    let per_area = emission.falloff * emission.measure / area.abs();
    // Direct light sees the receiver's axes the other way round: they are right-handed with a normal that
    // points at it.
    let [a, b] = emission.derivatives;
    let cross = a.position.cross(b.position) + a.direction.cross(b.direction);
    let is_right_handed = cross.dot(emission.ray.direction) > 0.0;
    SpecularPath {
        signature: signature(&[]),
        emitter: map.light.emitter_of(place.chart),
        origin: emission.ray.origin,
        direction: emission.ray.direction,
        vertices: Vec::new(),
        throughput: landing.beam.throughput,
        jacobian: area.abs() / emission.measure,
        folded: (area > 0.0) == is_right_handed,
        irradiance: chart.strength() * landing.beam.throughput * per_area,
        fold_distance: None,
        residual: 0.0,
    }
}

/// True if a chain's mirrors turn a sheet of light over: it has an odd number of reflections.
fn reverses(chain: &[ChainStep]) -> bool {
    let is_mirror = |step: &&ChainStep| step.way == Way::Reflected;
    chain.iter().filter(is_mirror).count() % 2 == 1
}

fn vertices(met: &[(Hit, SurfacePoint)], chain: &[ChainStep]) -> Vec<Vertex> {
    met.iter()
        .zip(chain)
        .map(|((hit, point), step)| Vertex {
            shape: hit.shape,
            face: hit.face,
            way: step.way,
            position: point.position,
            normal: point.shading_normal,
        })
        .collect()
}

/// The distance that [`SpecularPath::fold_distance`] describes.
fn fold_distance(tracer: &mut MapTracer, root: &Root, jacobian: DMat2) -> Option<f64> {
    let mut by = |axis: DVec2| {
        let step = axis * root.half * GRADIENT_STEP;
        let mut at = |offset: DVec2| {
            let place = LightPlace {
                chart: root.place.chart,
                at: root.place.at + offset,
            };
            let image = tracer.image_along(place, &root.chain)?;
            Some(image.jacobian.determinant())
        };
        Some((at(step)? - at(-step)?) / (2.0 * step.length()))
    };
    let gradient = DVec2::new(by(DVec2::X)?, by(DVec2::Y)?);
    let on_receiver = jacobian.transpose().inverse() * gradient;
    let area = jacobian.determinant().abs();
    // Differences of a constant are its rounding over the step: folds that far away stay unknown.
    let rounding = 64.0 * f64::EPSILON * area / (GRADIENT_STEP * root.half.min_element());
    if gradient.length() <= rounding {
        return None;
    }
    let distance = 0.5 * area / on_receiver.length();
    distance.is_finite().then_some(distance)
}

/// True if a ray that was aimed from one point at another landed there, but for rounding: it landed `offset`
/// away.
pub(super) fn is_at_target(offset: DVec2, from: DVec3, to: DVec3) -> bool {
    // A dozen operations on coordinates and a distance are an ulp off each, at slopes of up to a hundred:
    // 1e-12 is some thousand ulps. Anything in the way is farther off, or cannot be told from the receiver.
    offset.length() <= 1e-12 * (from.distance(to) + from.length() + to.length())
}
