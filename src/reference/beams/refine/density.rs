//! How dense a cell's light may be, by its mean.
//!
//! Light is dense where the map f of its cell stretches little: E = w / |det ∂f|. The determinant of the
//! quadratic map through a cell's six nodes is of second degree. Its mean over the triangle is that of the
//! edges' middles. The least of its six Bézier ordinates bounds it from below everywhere in the triangle:
//! those of the corners are its values there. That of an edge is 2 m − (a + b)/2, with m its middle's value
//! and a, b those of its ends (Farin 2002, *Curves and Surfaces for CAGD*, chapter 17).
//!
//! If the least is far below the mean, a fold or a focus is in the cell or near it: the determinant is zero
//! there, and light may be anywhere on a line.

use glam::DVec2;

use crate::reference::beams::cell::{BeamCell, BeamNode};

/// Density of the quadratic map, by its mean, from which light may be focused near the cell. A determinant
/// that is linear falls by three quarters of its mean from the centroid to its least corner then. It is zero
/// a third of that way farther.
const FOCUSED: f64 = 4.0;

/// The largest density of a cell's light, by its mean; infinite if it may be focused.
pub(super) fn most_density<const N: usize>(cell: &BeamCell<N>, middles: &[BeamNode<N>; 3]) -> f64 {
    let landing = |node: &BeamNode<N>| node.landing.unwrap_or(DVec2::NAN);
    let map = QuadraticMap {
        corners: cell.corners.each_ref().map(landing),
        middles: middles.each_ref().map(landing),
    };
    let [a, b, c] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|at| map.determinant(at));
    let [bc, ca, ab] = [[0.5, 0.5], [0.0, 0.5], [0.5, 0.0]].map(|at| map.determinant(at));
    let mean = (bc + ca + ab) / 3.0;
    let edge = |middle: f64, ends: f64| 2.0 * middle - 0.5 * ends;
    let ordinates = [a, b, c, edge(bc, b + c), edge(ca, c + a), edge(ab, a + b)];
    let density = ordinates.iter().fold(1.0_f64, |most, one| {
        let density = mean / one;
        // Turned over, or nothing that is a number: no bound.
        if density > 0.0 {
            most.max(density)
        } else {
            f64::INFINITY
        }
    });
    if density < FOCUSED {
        density
    } else {
        f64::INFINITY
    }
}

/// The quadratic map through the landings of six nodes, over the coordinates (s, t) of its triangle: its
/// corners are at (0, 0), (1, 0) and (0, 1).
struct QuadraticMap {
    corners: [DVec2; 3],
    /// Those of the edges' middles, each opposite to the corner of the same index.
    middles: [DVec2; 3],
}

impl QuadraticMap {
    /// det ∂f at (s, t), by the derivatives of the six shape functions.
    fn determinant(&self, [s, t]: [f64; 2]) -> f64 {
        let ([a, b, c], [bc, ca, ab]) = (self.corners, self.middles);
        let r = 1.0 - s - t;
        let from_a = a * (1.0 - 4.0 * r);
        let by_s = from_a + b * (4.0 * s - 1.0) + ((bc - ca) * t + ab * (r - s)) * 4.0;
        let by_t = from_a + c * (4.0 * t - 1.0) + ((bc - ab) * s + ca * (r - t)) * 4.0;
        by_s.perp_dot(by_t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::flux::Flux;

    /// The density by the nodes of a map f(s, t).
    fn density(f: impl Fn(f64, f64) -> DVec2) -> f64 {
        let node = |[s, t]: [f64; 2]| BeamNode::<1> {
            at: DVec2::new(s, t),
            landing: Some(f(s, t)),
            turned_back: false,
            weight: Flux([1.0]),
            emitted: 1.0,
            topology: 0,
            faces: 0,
        };
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(node);
        let middles = [[0.5, 0.5], [0.0, 0.5], [0.5, 0.0]].map(node);
        most_density(&BeamCell::of_patch(corners), &middles)
    }

    #[test]
    fn an_affine_map_spreads_light_evenly() {
        let affine = |s: f64, t: f64| DVec2::new(3.0 + 2.0 * s - t, 1.0 - 4.0 * s + 5.0 * t);
        assert!((density(affine) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn light_is_dense_where_a_map_is_stretched_least() {
        // det = 1 + s: its mean is 4/3, its least value 1.
        let stretched = |s: f64, t: f64| DVec2::new(s + 0.5 * s * s, t);
        assert!((density(stretched) - 4.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn light_at_a_fold_or_close_to_it_may_be_focused() {
        // det = s − x: the fold is at s = x.
        let folded = |x: f64| density(move |s, t| DVec2::new(0.5 * s * s - x * s, t));
        for x in [-0.1, 0.0, 0.3, 1.0, 1.1] {
            assert_eq!(folded(x), f64::INFINITY, "{x}");
        }
        assert!(folded(-0.5).is_finite() && folded(-0.5) > 1.6);
        // All light on one point.
        assert_eq!(density(|_, _| DVec2::ONE), f64::INFINITY);
    }

    #[test]
    fn light_may_be_focused_between_nodes_that_are_stretched_alike() {
        // The complex square about the centroid of an equilateral triangle: det = 4 |z|² is zero there, and
        // between 1/4 and 1 of its largest value at all nodes.
        let square = |s: f64, t: f64| {
            let z = DVec2::new(s + 0.5 * t - 0.5, 0.75_f64.sqrt() * (t - 1.0 / 3.0));
            DVec2::new(z.x * z.x - z.y * z.y, 2.0 * z.x * z.y)
        };
        assert_eq!(density(square), f64::INFINITY);
    }
}
