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
const PLACES: usize = 1 << 12;

/// Flux below this part of what set out is not followed any further.
const LEAST_THROUGHPUT: f64 = 1e-7;

/// What a survey saw of one signature.
#[derive(Clone, Copy, Debug, Default)]
pub struct Found {
    /// About how much flux it brings \[W\], mean of channels.
    pub flux: f64,
    /// The most that a path delivers of what sets out.
    pub peak: f64,
}

/// What a survey saw.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// What each signature brings to the sensor's surface.
    pub signatures: BTreeMap<Signature, Found>,
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
        let found: Vec<Vec<Sight>> = roots
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
        for sight in found.into_iter().flatten() {
            let scale = stride as f64;
            let one = all.signatures.entry(sight.signature).or_default();
            one.flux += sight.flux * scale;
            one.peak = one.peak.max(sight.throughput / strength);
        }
    }
    all
}

/// A path that landed.
struct Sight {
    signature: Signature,
    /// What it brings for its part of the root \[W\].
    flux: f64,
    /// Times the source's strength.
    throughput: f64,
}

/// Adds the signatures of one place.
fn look_at(
    follower: &mut PathFollower<3>,
    root: &Root,
    index: usize,
    count: usize,
    max_depth: u32,
    found: &mut Vec<Sight>,
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
    follower.follow_all(
        &root.chart,
        at,
        max_depth,
        LEAST_THROUGHPUT,
        &mut |signature, path| {
            if matches!(path.end, End::Landed(_)) {
                let throughput = path.throughput.rgb().mean();
                found.push(Sight {
                    signature,
                    flux: throughput * path.emitted * area,
                    throughput,
                });
            }
        },
    );
}
