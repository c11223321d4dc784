//! Whether light meets the surface at an end of its leg only there.

use glam::DVec3;

use super::Clearance;
use super::caught::{across, is_within};
use super::legs::Leg;
use crate::geometry::{Cylinder, Hull, Mesh, Shape, range};

impl Clearance<'_> {
    /// Whether a leg meets the surface at its start, or at its end, nowhere else.
    pub(super) fn meets_own_surface_once(&self, leg: &Leg, hull: &Hull, shape: u32) -> bool {
        match &self.scene.world().shapes()[shape as usize] {
            // A line meets a plane once; a ball it leaves it does not meet again, and one it
            // enters it meets at the other side, where the leg ends.
            Shape::Sphere(_) | Shape::Rectangle(_) | Shape::Disk(_) => true,
            Shape::Cylinder(tube) => {
                tube_is_met_once(leg, tube, leg.starts_on(shape), leg.ends_on(shape))
            }
            Shape::Mesh(mesh) => self.mesh_is_met_once(leg, hull, shape, mesh),
        }
    }

    /// What light meets of a mesh changes from one path to the next only where there is a
    /// silhouette or a border between. So light leaves a mesh for good, or meets it first where
    /// the leg ends, if all faces in the hull face the same way as those at that end, and there is
    /// no border among them. If the leg starts and ends on the same mesh, the first half of the
    /// hull may have faces as those at its start only, the second as those at its end.
    fn mesh_is_met_once(&self, leg: &Leg, hull: &Hull, shape: u32, mesh: &Mesh) -> bool {
        let along = leg.along();
        let sign = |face: u32| facing(&along, mesh.corners(face));
        let alone = |faces: &[u32; 6]| {
            faces
                .iter()
                .all(|face| *face == faces[0])
                .then_some(faces[0])
        };
        let start = leg.starts_on(shape).then(|| Allowed {
            facing: sign(leg.from_faces[0]),
            // A flat face's edges are not in the way of light that leaves it.
            own: alone(&leg.from_faces),
        });
        let end = leg.ends_on(shape).then(|| Allowed {
            facing: sign(leg.to_faces[0]),
            // The chart's own face needs no catching.
            own: (leg.from == super::Met::Source)
                .then(|| alone(&leg.to_faces))
                .flatten(),
        });
        match (start, end) {
            (Some(start), Some(end)) => {
                let [first, second] = hull.halves();
                self.has_only(&along, &first, shape, &start)
                    && self.has_only(&along, &second, shape, &end)
            }
            (Some(only), None) | (None, Some(only)) => self.has_only(&along, hull, shape, &only),
            (None, None) => false,
        }
    }

    /// Whether all faces of a mesh in a hull face the allowed way and are away from any border.
    fn has_only(&self, along: &[DVec3; 6], hull: &Hull, shape: u32, allowed: &Allowed) -> bool {
        let Some(wanted) = allowed.facing else {
            return false;
        };
        let border = self.surfaces[shape as usize].border.as_ref();
        let is_bad = |face: u32, corners: &[DVec3; 3]| {
            let [a, b, c] = *corners;
            let normal = (b - a).cross(c - a);
            if normal == DVec3::ZERO || !hull.may_overlap_points(corners, &[normal]) {
                return false;
            }
            facing(along, *corners) != Some(wanted)
                || allowed.own != Some(face)
                    && (0..3).any(|edge| {
                        let [from, to] = [corners[edge], corners[(edge + 1) % 3]];
                        border.is_none_or(|border| border.is_at(face, edge))
                            && hull.may_overlap_points(&[from, to], &[])
                    })
        };
        let world = self.scene.world();
        !world.any_face(shape, |bounds| hull.may_overlap_box(bounds), is_bad)
    }
}

/// The faces that may be in a part of a leg's hull.
struct Allowed {
    /// Whether light goes the way of their normals; `None` where it grazes them.
    facing: Option<bool>,
    /// Its edges may be a border.
    own: Option<u32>,
}

/// Whether all light goes the way of a face's normal (by its winding), or all against it.
fn facing(along: &[DVec3; 6], [a, b, c]: [DVec3; 3]) -> Option<bool> {
    let normal = (b - a).cross(c - a);
    let [low, high] = range(&along.map(|along| along.dot(normal)));
    if low > 0.0 {
        Some(true)
    } else if high < 0.0 {
        Some(false)
    } else {
        None
    }
}

/// Where the lines of a leg go through a tube that is taken as endless.
struct Crossings {
    /// Across the axis, where the leg starts and ends and where its line is nearest to the axis.
    start: [DVec3; 6],
    end: [DVec3; 6],
    feet: [DVec3; 6],
    along: [DVec3; 6],
    /// Heights over the base where the line enters and leaves; not numbers where it misses.
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

/// Whether all heights are on a tube.
fn is_on(heights: &[f64; 6], tube: &Cylinder) -> bool {
    let [low, high] = range(heights);
    0.0 < low && high < tube.length()
}

/// Whether all heights are above a tube, or all below it.
fn is_off(heights: &[f64; 6], tube: &Cylinder) -> bool {
    let [low, high] = range(heights);
    low > tube.length() || high < 0.0
}

/// Whether a tube catches all light of a leg that ends on it.
pub(super) fn tube_catches(leg: &Leg, tube: &Cylinder, starts_on_it: bool) -> bool {
    let lines = Crossings::new(leg, tube);
    if starts_on_it || is_within(&lines.start, tube.radius()) {
        return is_on(&lines.leaves, tube);
    }
    is_within(&lines.feet, tube.radius())
        && (is_on(&lines.enters, tube) || is_off(&lines.enters, tube) && is_on(&lines.leaves, tube))
}

/// Whether a leg that starts or ends on a tube meets it nowhere else: across its axis a tube is a
/// circle, which a line crosses twice.
fn tube_is_met_once(leg: &Leg, tube: &Cylinder, starts: bool, ends: bool) -> bool {
    let lines = Crossings::new(leg, tube);
    let product = |at: &[DVec3; 6]| std::array::from_fn(|i| at[i].dot(lines.along[i]));
    if starts {
        let [low, high] = range(&product(&lines.start));
        // Outward for good; or inward, and then to the other side, or out by an open end, or not
        // so far.
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
