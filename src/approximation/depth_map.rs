//! Depth maps of receivers, as a shadow map has them.

use glam::DVec2;
use rayon::prelude::*;

use super::light_view::LightView;
use super::precision::Precision;
use super::receivers::Receivers;
use crate::geometry::TraversalCounters;

/// The nearest receiver in each pixel: its depth, or infinity.
#[derive(Clone, Debug)]
pub struct DepthMap {
    view: LightView,
    depths: Vec<f64>,
}

impl DepthMap {
    /// Depths of receivers at pixel centres, as if nothing specular were there.
    ///
    /// Returns the map with the work of its rays.
    pub fn new(
        receivers: &Receivers,
        view: LightView,
        precision: Precision,
    ) -> (Self, TraversalCounters) {
        let all = [DVec2::ZERO, DVec2::splat(view.side() as f64)];
        Self::within(receivers, view, precision, all)
    }

    /// The same, where receivers are known to be between two corners of the image only.
    pub fn within(
        receivers: &Receivers,
        view: LightView,
        precision: Precision,
        window: [DVec2; 2],
    ) -> (Self, TraversalCounters) {
        let side = view.side();
        let last = DVec2::splat(side as f64);
        let [first, end] =
            [window[0].floor(), window[1].ceil()].map(|at| at.clamp(DVec2::ZERO, last));
        let mut depths = vec![f64::INFINITY; side * side];
        let counters = depths
            .par_chunks_mut(side)
            .enumerate()
            .filter(|(row, _)| (first.y as usize..end.y as usize).contains(row))
            .map(|(row, depths)| {
                let mut counters = TraversalCounters::default();
                let columns = first.x as usize..(end.x as usize).max(first.x as usize);
                for (column, depth) in columns.clone().zip(&mut depths[columns]) {
                    let at = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
                    let found = receivers.first(&view.ray(at), &mut counters);
                    if let Some(seen) = found.and_then(|(_, point)| view.project(point.position)) {
                        *depth = precision.of_depth(seen.depth, &view);
                    }
                }
                counters
            })
            .reduce(TraversalCounters::default, |mut a, b| {
                a += b;
                a
            });
        (Self { view, depths }, counters)
    }

    /// Bytes of the map on a device: four a pixel.
    pub fn bytes(&self) -> u64 {
        4 * self.depths.len() as u64
    }

    /// The view that it is of.
    pub fn view(&self) -> &LightView {
        &self.view
    }

    /// The depth in the pixel of an image point; `None` outside.
    #[inline]
    pub fn at(&self, at: DVec2) -> Option<f64> {
        let side = self.view.side();
        self.view
            .holds(at)
            .then(|| self.depths[at.y as usize * side + at.x as usize])
    }
}
