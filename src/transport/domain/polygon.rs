//! Convex polygons in a plane.

use glam::DVec2;

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

/// The triangles from the first corner of a convex polygon to all edges that do not meet it.
pub fn fan(polygon: &[DVec2]) -> impl Iterator<Item = [DVec2; 3]> {
    let edges = polygon.get(1..).unwrap_or_default().windows(2);
    edges.map(|edge| [polygon[0], edge[0], edge[1]])
}

#[cfg(test)]
mod tests {
    use super::*;

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
