//! Legs that start or end on tubes.

use glam::DVec3;

use super::legs::Leg;
use crate::geometry::{Cylinder, longest, range};

/// The crossings of a leg's lines with a tube that is taken as endless.
struct Crossings {
    /// Vectors across the axis, from the axis to: the leg's starts, its ends, and the points of its lines
    /// nearest to the axis.
    start: [DVec3; 6],
    end: [DVec3; 6],
    feet: [DVec3; 6],
    along: [DVec3; 6],
    /// Heights over the base where the lines enter and leave; NaN if they miss.
    enters: [f64; 6],
    leaves: [f64; 6],
}

impl Crossings {
    fn new(leg: &Leg, tube: &Cylinder) -> Self {
        let (start, heights) = across(&leg.start.map(|point| point - tube.base()), tube.axis());
        let (end, _) = across(&leg.end.map(|point| point - tube.base()), tube.axis());
        let (along, climbs) = across(&leg.along(), tube.axis());
        let nearest: [f64; 6] =
            std::array::from_fn(|i| -start[i].dot(along[i]) / along[i].length_squared());
        let feet: [DVec3; 6] = std::array::from_fn(|i| start[i] + along[i] * nearest[i]);
        let half_chord: [f64; 6] = std::array::from_fn(|i| {
            let squared = tube.radius() * tube.radius() - feet[i].length_squared();
            (squared / along[i].length_squared()).sqrt()
        });
        let height = |side: f64| {
            std::array::from_fn(|i| heights[i] + climbs[i] * (nearest[i] + side * half_chord[i]))
        };
        Self {
            start,
            end,
            feet,
            along,
            enters: height(-1.0),
            leaves: height(1.0),
        }
    }
}

/// True if all heights are on a tube.
fn is_on(heights: &[f64; 6], tube: &Cylinder) -> bool {
    let [low, high] = range(heights);
    0.0 < low && high < tube.length()
}

/// True if all heights are above a tube, or all are below it.
fn is_off(heights: &[f64; 6], tube: &Cylinder) -> bool {
    let [low, high] = range(heights);
    low > tube.length() || high < 0.0
}

/// True if a tube catches all light of a leg that ends on it.
pub(super) fn tube_catches(leg: &Leg, tube: &Cylinder, starts_on_it: bool) -> bool {
    let lines = Crossings::new(leg, tube);
    if starts_on_it || is_within(&lines.start, tube.radius()) {
        return is_on(&lines.leaves, tube);
    }
    is_within(&lines.feet, tube.radius())
        && (is_on(&lines.enters, tube) || is_off(&lines.enters, tube) && is_on(&lines.leaves, tube))
}

/// True if a leg that starts or ends on a tube meets it nowhere else. Across its axis a tube is a circle,
/// which a line crosses twice.
pub(super) fn tube_is_met_once(leg: &Leg, tube: &Cylinder, starts: bool, ends: bool) -> bool {
    let lines = Crossings::new(leg, tube);
    let product = |at: &[DVec3; 6]| std::array::from_fn(|i| at[i].dot(lines.along[i]));
    if starts {
        let [low, high] = range(&product(&lines.start));
        // Outward for good; or inward, and then to the other side, or out by an open end, or not so far.
        return low > 0.0
            || high < 0.0
                && (ends || is_off(&lines.leaves, tube) || is_within(&lines.end, tube.radius()));
    }
    // Onto the side that faces the light, or through an open end, or from inside.
    let facing: [f64; 6] = product(&lines.end);
    let size = tube.radius()
        * lines
            .along
            .iter()
            .map(|along| along.length())
            .fold(0.0, f64::max);
    facing
        .iter()
        .all(|facing| *facing <= 64.0 * f64::EPSILON * size)
        || is_off(&lines.enters, tube)
        || is_within(&lines.start, tube.radius())
}

/// The parts of vectors across an axis, and their heights along it.
fn across(vectors: &[DVec3; 6], axis: DVec3) -> ([DVec3; 6], [f64; 6]) {
    let heights = vectors.map(|vector| vector.dot(axis));
    (
        std::array::from_fn(|i| vectors[i] - axis * heights[i]),
        heights,
    )
}

/// True if all points of a bundle are nearer to an axis than `radius`.
fn is_within(across: &[DVec3; 6], radius: f64) -> bool {
    longest(across) < radius
}
