//! Convex polygons in the plane.

use glam::DVec2;

use super::TexelRect;

/// Area, positive where the corners run counter-clockwise.
pub(super) fn area(polygon: &[DVec2]) -> f64 {
    let Some(&first) = polygon.first() else {
        return 0.0;
    };
    // From the first corner: far from the origin nothing cancels.
    polygon
        .windows(2)
        .map(|pair| 0.5 * (pair[0] - first).perp_dot(pair[1] - first))
        .sum()
}

/// The part of a convex polygon where `side(point)` ≥ 0, for an affine `side` (Sutherland and Hodgman 1974).
pub(super) fn clipped(polygon: &[DVec2], side: impl Fn(DVec2) -> f64) -> Vec<DVec2> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    let Some(&last) = polygon.last() else {
        return kept;
    };
    let (mut before, mut side_before) = (last, side(last));
    for &corner in polygon {
        let side_here = side(corner);
        if (side_before < 0.0) != (side_here < 0.0) {
            kept.push(before + (corner - before) * (side_before / (side_before - side_here)));
        }
        if side_here >= 0.0 {
            kept.push(corner);
        }
        (before, side_before) = (corner, side_here);
    }
    kept
}

/// The part of a convex polygon inside a convex polygon whose corners run counter-clockwise.
pub(super) fn intersection(polygon: &[DVec2], window: &[DVec2]) -> Vec<DVec2> {
    let mut kept = polygon.to_vec();
    for (i, &from) in window.iter().enumerate() {
        let to = window[(i + 1) % window.len()];
        kept = clipped(&kept, |point| (to - from).perp_dot(point - from));
        if kept.len() < 3 {
            return Vec::new();
        }
    }
    kept
}

/// A convex polygon that holds all points within `by` of a convex polygon.
pub(super) fn grown(polygon: &[DVec2], by: f64) -> Vec<DVec2> {
    let offsets = [(-by, -by), (by, -by), (by, by), (-by, by)];
    convex_hull(
        polygon
            .iter()
            .flat_map(|corner| offsets.map(|(x, y)| *corner + DVec2::new(x, y)))
            .collect(),
    )
}

/// The part of a convex polygon whose points are all `by` and more from its border.
pub(super) fn shrunk(polygon: &[DVec2], by: f64) -> Vec<DVec2> {
    let turn = if area(polygon) < 0.0 { -1.0 } else { 1.0 };
    let mut kept = polygon.to_vec();
    for (i, &from) in polygon.iter().enumerate() {
        let side = polygon[(i + 1) % polygon.len()] - from;
        let length = side.length();
        if length > 0.0 {
            kept = clipped(&kept, |point| {
                turn * side.perp_dot(point - from) / length - by
            });
        }
    }
    kept
}

/// The convex hull of points, counter-clockwise, without points on its sides (Andrew 1979).
pub(super) fn convex_hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut hull: Vec<DVec2> = Vec::new();
        for point in points {
            while let [.., a, b] = hull[..] {
                if (b - a).perp_dot(point - b) > 0.0 {
                    break;
                }
                hull.pop();
            }
            hull.push(point);
        }
        hull.pop();
        hull
    };
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    hull
}

/// The area of a convex polygon's part inside a texel.
pub(super) fn area_in_texel(polygon: &[DVec2], texel: &TexelRect) -> f64 {
    let (min, max) = (texel.min, texel.max);
    let window = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
    area(&intersection(polygon, &window)).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_cut_by_a_grid_keeps_its_area() {
        let triangle = [
            DVec2::new(-0.9, -0.8),
            DVec2::new(0.7, -0.1),
            DVec2::new(-0.2, 0.95),
        ];
        let grid = super::super::TexelGrid::square(1.0, 13);
        let sum: f64 = grid
            .map(|texel| area_in_texel(&triangle, texel))
            .iter()
            .sum();
        // 169 areas, each a few roundings of numbers below 1.
        assert!((sum - area(&triangle)).abs() < 1e-14);
    }

    #[test]
    fn polygons_apart_have_nothing_in_common() {
        let square = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        let far: Vec<DVec2> = square
            .iter()
            .map(|&corner| corner + DVec2::new(5.0, 0.5))
            .collect();
        assert!(intersection(&square, &far).is_empty());
    }
}
