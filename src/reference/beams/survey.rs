//! Which path signatures bring light to the sensor.

use std::collections::BTreeMap;

use glam::DVec2;
use rayon::prelude::*;

use super::pass::Light;
use crate::scene::Scene;
use crate::transport::first_surface::Root;
use crate::transport::prescribed::{End, PathFollower};
use crate::transport::scatter::ShadingNormals;
use crate::transport::screen::Screen;
use crate::transport::signature::Signature;

/// About how many places of the first surfaces are looked at.
const PLACES: usize = 1 << 14;

/// Flux below this part of what set out is not followed any further.
const LEAST_THROUGHPUT: f64 = 1e-9;

/// What a survey saw.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// About how much flux each signature brings to the sensor's film \[W\] and beside it, mean of channels.
    pub flux: BTreeMap<Signature, f64>,
    /// About how much set out towards first surfaces \[W\], mean of channels.
    pub emitted: f64,
}

/// Follows all branches of some thousand paths spread over all first surfaces.
pub fn survey(
    scene: &Scene,
    lights: &[Light],
    screen: &Screen,
    max_depth: u32,
    shading_normals: ShadingNormals,
) -> Survey {
    let places = PLACES.div_ceil(lights.len().max(1));
    let mut all = Survey::default();
    for light in lights {
        let source = &light.source;
        let roots = light.roots(scene);
        let a_root = places.div_ceil(roots.len().max(1));
        // Where there are many roots, every so many-th will do.
        let stride = (roots.len() / places).max(1);
        let found: Vec<Vec<(Signature, f64, f64)>> = roots
            .par_iter()
            .step_by(stride)
            .enumerate()
            .map(|(index, root)| {
                let mut follower = PathFollower::<3>::new(
                    scene,
                    source,
                    screen,
                    Signature::DIRECT,
                    shading_normals,
                );
                let mut found = Vec::new();
                for place in 0..a_root {
                    look_at(
                        &mut follower,
                        root,
                        index + place,
                        a_root,
                        max_depth,
                        &mut found,
                    );
                }
                found
            })
            .collect();
        let strength = source.strength().mean();
        // Sums of few values in a fixed order: the same on any threads.
        for (signature, arrived, set_out) in found.into_iter().flatten() {
            let scale = stride as f64;
            if signature.is_empty() {
                all.emitted += set_out * strength * scale;
            } else {
                *all.flux.entry(signature).or_default() += arrived * scale;
            }
        }
    }
    all
}

/// Adds the signatures of one place.
fn look_at(
    follower: &mut PathFollower<3>,
    root: &Root,
    index: usize,
    count: usize,
    max_depth: u32,
    found: &mut Vec<(Signature, f64, f64)>,
) {
    let [a, b, c] = root.corners;
    let area = 0.5 * (b - a).perp_dot(c - a).abs() / count as f64;
    // Roberts' R2 sequence, folded into the triangle.
    let mut at = DVec2::new(
        (0.5 + 0.754_877_666_246_692_8 * index as f64).fract(),
        (0.5 + 0.569_840_290_998_053_3 * index as f64).fract(),
    );
    if at.x + at.y > 1.0 {
        at = DVec2::ONE - at;
    }
    let at = a + (b - a) * at.x + (c - a) * at.y;
    let set_out = follower.emitted(&root.chart, at) * area;
    found.push((Signature::DIRECT, 0.0, set_out));
    follower.follow_all(
        &root.chart,
        at,
        max_depth,
        LEAST_THROUGHPUT,
        &mut |signature, path| {
            if matches!(path.end, End::Landed(_)) {
                let arrived = path.throughput.rgb().mean() * path.emitted * area;
                found.push((signature, arrived, 0.0));
            }
        },
    );
}
