//! Patches of light space, and the images of one under chains of surfaces.

use glam::{DMat2, DVec2};

use super::map::LightPlace;
use super::target::TargetImage;
use crate::transport::differentials::ChainStep;
use crate::transport::domain::patch::ChartPatch;

/// Level up to which a patch whose nodes see different chains is divided if *any* of them may hide the
/// target. An unseen chain may be between them. Beyond, it is divided only if a chain that is seen may.
pub(super) const MIXED_LEVELS: u32 = 3;

/// A patch of light space to be searched.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightPiece {
    pub chart: usize,
    pub patch: ChartPatch,
    pub level: u32,
}

/// The image of a piece's light under one chain.
pub(super) struct Sheet {
    pub chain: Vec<ChainStep>,
    /// Images at the nodes, in the piece's coordinates (−1..=1).
    pub nodes: [Option<TargetImage>; NODES],
    /// True if the scene as it is lets the chain's light through at every node.
    pub is_visible: bool,
}

/// Number of nodes: 3 x 3.
pub(super) const NODES: usize = 9;
const CENTER: usize = 4;

/// A node in the piece's coordinates, row by row.
pub(super) fn node(index: usize) -> DVec2 {
    DVec2::new((index % 3) as f64 - 1.0, (index / 3) as f64 - 1.0)
}

impl LightPiece {
    /// Half its size, in chart coordinates.
    pub fn half(&self) -> DVec2 {
        0.5 * (self.patch.to - self.patch.from)
    }

    /// The place at −1..=1 across it, or a little beyond.
    pub fn place(&self, at: DVec2) -> LightPlace {
        LightPlace {
            chart: self.chart,
            at: 0.5 * (self.patch.from + self.patch.to) + self.half() * at,
        }
    }

    /// An image whose derivatives are by the piece's own coordinates.
    pub fn scaled(&self, image: &TargetImage) -> TargetImage {
        let half = self.half();
        let [x, y] = image.miss_derivatives;
        TargetImage {
            jacobian: image.jacobian * DMat2::from_diagonal(half),
            miss_derivatives: [x * half.x, y * half.y],
            ..*image
        }
    }

    pub fn quarters(&self) -> [Self; 4] {
        self.patch.quarters().map(|patch| Self {
            chart: self.chart,
            patch,
            level: self.level + 1,
        })
    }
}

/// Largest variation of J over a piece: ‖J(center)⁻¹ J(node) − 1‖ (Frobenius) at all nodes.
///
/// If such a bound held everywhere and were below 1, the sheet would meet a point once at most. The reason:
/// for x ≠ y in a convex set, J(center)⁻¹ (f(x) − f(y)) would differ from x − y by less than |x − y|. A bound
/// of 1/2 leaves the rest for the sheet between the nodes.
const MOST_VARIATION: f64 = 0.5;

impl Sheet {
    /// Newton's first step from the center, if J varies so little that there is one root at most.
    pub fn regular_start(&self) -> Option<DVec2> {
        let center = self.nodes[CENTER]?;
        let inverse = center.jacobian.inverse();
        for image in &self.nodes {
            let variation = inverse * (*image)?.jacobian - DMat2::IDENTITY;
            let squares = variation.x_axis.length_squared() + variation.y_axis.length_squared();
            // False for NaN, of a singular J.
            let is_steady = squares <= MOST_VARIATION * MOST_VARIATION;
            if !is_steady {
                return None;
            }
        }
        Some(-(inverse * center.offset))
    }

    /// True if light of the piece may meet the target. Around each node, a linear map tells by how much light
    /// misses. The margin is the error of the nodes' linear maps at each other.
    ///
    /// A piece's nodes stand 1 apart. If all see the chain, each speaks for half of that. The margin is the
    /// error at its neighbours: four times the error of a quadratic map after half that step. If some do not
    /// see the chain, the nearest that do speak for them. Sheets of meshes may jump (at creases), and no
    /// margin would ever allow for that. Past [`MIXED_LEVELS`] it is at most the linear map's own reach.
    pub fn may_hold_target(&self, level: u32) -> bool {
        let seen: Vec<(DVec2, f64, TargetImage)> = self
            .nodes
            .iter()
            .enumerate()
            .filter_map(|(index, image)| Some((node(index), self.reach(index), (*image)?)))
            .collect();
        let extent = |reach: f64, image: &TargetImage| {
            let [x, y] = image.miss_derivatives;
            (x.abs() + y.abs()) * reach
        };
        let largest = seen
            .iter()
            .map(|(_, reach, image)| extent(*reach, image).max_element())
            .fold(0.0, f64::max);
        let neighbourhood = if seen.len() == NODES { 1.0 } else { 2.0 };
        let mut error: f64 = 0.0;
        for (from, _, image) in &seen {
            for (to, _, other) in &seen {
                let step = *to - *from;
                if step.abs().max_element() <= neighbourhood {
                    let [x, y] = image.miss_derivatives;
                    let predicted = image.miss + x * step.x + y * step.y;
                    error = error.max((other.miss - predicted).abs().max_element());
                }
            }
        }
        let margin = if seen.len() == 1 {
            largest
        } else if level < MIXED_LEVELS {
            error
        } else {
            error.min(largest)
        };
        seen.iter().any(|(_, reach, image)| {
            let room = extent(*reach, image) + margin;
            image.miss.abs().cmple(room).all()
        })
    }

    /// Distance, in the piece's coordinates, up to which a node speaks for the piece. Of 5 x 5 points, it
    /// counts those without a nearer node that sees the chain: the farthest one's distance, and half their
    /// spacing more.
    fn reach(&self, index: usize) -> f64 {
        const SPACING: f64 = 0.5;
        let distance = |index: usize, point: DVec2| (point - node(index)).abs().max_element();
        let mut reach: f64 = 0.0;
        for i in 0..25 {
            let point = DVec2::new((i % 5) as f64, (i / 5) as f64) * SPACING - 1.0;
            let own = distance(index, point);
            let is_nearest = (0..NODES)
                .filter(|other| self.nodes[*other].is_some())
                .all(|other| distance(other, point) >= own);
            if is_nearest {
                reach = reach.max(own);
            }
        }
        reach + 0.5 * SPACING
    }
}
