//! Convex polygons in a plane.

use glam::DVec2;

use crate::numeric::math;

/// The part of a convex polygon where `side`, affine in places, is not below zero.
pub fn cut(polygon: &[DVec2], side: impl Fn(&DVec2) -> f64) -> Vec<DVec2> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    let Some(mut before) = polygon.last() else {
        return kept;
    };
    let mut side_before = side(before);
    for place in polygon {
        let side_here = side(place);
        if (side_before < 0.0) != (side_here < 0.0) {
            kept.push(*before + (*place - *before) * (side_before / (side_before - side_here)));
        }
        if side_here >= 0.0 {
            kept.push(*place);
        }
        (before, side_before) = (place, side_here);
    }
    kept
}

/// Area of a convex polygon, by the triangles of its fan.
pub fn area(polygon: &[DVec2]) -> f64 {
    let twice = |[a, b, c]: [DVec2; 3]| (b - a).perp_dot(c - a);
    0.5 * fan(polygon).map(twice).sum::<f64>().abs()
}

/// The area that a polygon, convex or not, has in common with the disc of radius 1 about the origin.
///
/// It is the sum over edges of signed areas between the edge and the origin: of a triangle where the edge is
/// in the disc, of a sector where it is not.
pub fn disk_area(polygon: &[DVec2]) -> f64 {
    let sector = |a: DVec2, b: DVec2| 0.5 * math::atan2(a.perp_dot(b), a.dot(b));
    let mut sum = 0.0;
    for (index, a) in polygon.iter().enumerate() {
        let (a, b) = (*a, polygon[(index + 1) % polygon.len()]);
        let along = b - a;
        // |a + t along|² = 1.
        let (square, half) = (along.length_squared(), a.dot(along));
        let root = half * half - square * (a.length_squared() - 1.0);
        if !(root > 0.0 && square > 0.0) {
            sum += sector(a, b);
            continue;
        }
        let [enter, leave] =
            [-1.0, 1.0].map(|sign| ((sign * root.sqrt() - half) / square).clamp(0.0, 1.0));
        let [p, q] = [enter, leave].map(|t| a + along * t);
        sum += sector(a, p) + 0.5 * p.perp_dot(q) + sector(q, b);
    }
    sum.abs()
}

/// The triangles from the first corner of a convex polygon to all edges that do not meet it.
pub fn fan(polygon: &[DVec2]) -> impl Iterator<Item = [DVec2; 3]> {
    let edges = polygon.get(1..).unwrap_or_default().windows(2);
    edges.map(|edge| [polygon[0], edge[0], edge[1]])
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn discs_and_polygons_have_the_area_in_common_that_geometry_tells() {
        let square = |from: DVec2, size: f64| {
            [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y].map(|it| from + it * size)
        };
        // A segment of height 1/2 is cut off at x = 1/2: acos(1/2) - 1/2 √(1 - 1/4).
        let segment = PI / 3.0 - 0.5 * 0.75_f64.sqrt();
        for (from, size, expected) in [
            (DVec2::splat(-0.1), 0.2, 0.04),
            (DVec2::splat(-2.0), 4.0, PI),
            (DVec2::ZERO, 2.0, 0.25 * PI),
            (DVec2::new(0.5, -2.0), 4.0, segment),
            (DVec2::new(-3.5, -2.0), 4.0, PI - segment),
            (DVec2::new(1.5, 1.5), 1.0, 0.0),
            (DVec2::new(0.8, 0.8), 1.0, 0.0),
        ] {
            let found = disk_area(&square(from, size));
            assert!((found - expected).abs() < 1e-13, "{found} for {expected}");
        }
    }

    #[test]
    fn the_parts_on_both_sides_of_a_cut_make_the_whole() {
        let square = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        for (normal, offset, below) in [
            (DVec2::X, 0.25, 0.25),
            (DVec2::new(1.0, 1.0), 1.0, 0.5),
            (DVec2::new(1.0, 1.0), 0.5, 0.125),
            (DVec2::Y, 2.0, 1.0),
            (DVec2::Y, -1.0, 0.0),
        ] {
            let low = cut(&square, |place| offset - normal.dot(*place));
            let high = cut(&square, |place| normal.dot(*place) - offset);
            assert_eq!(area(&low), below);
            assert_eq!(area(&high), 1.0 - below);
        }
    }
}
