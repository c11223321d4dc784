//! The order of boxes along the Morton curve.

use glam::Vec3A;
use obvhs::aabb::Aabb;
use rayon::prelude::*;

use crate::numeric::fine_morton_code;

/// The boxes' numbers along the Morton curve through their middles. Of boxes in one cell of the curve, those
/// of less `weight`, which is not negative, come first, and then those of lower numbers.
pub(super) fn along_the_curve(boxes: &[Aabb], weight: impl Fn(&Aabb) -> f32 + Sync) -> Vec<u32> {
    let all = boxes.iter().fold(Aabb::empty(), |all, one| all.union(one));
    // A side without length would divide 0 by 0.
    let extent = all.diagonal().max(Vec3A::splat(f32::MIN_POSITIVE));
    let key = |number: u32| {
        let one = &boxes[number as usize];
        let place = (one.center() - all.min) / extent;
        // Bits of numbers that are not negative are in their order.
        let code = fine_morton_code(place.as_dvec3());
        (code, weight(one).to_bits(), number)
    };
    let mut order: Vec<(u64, u32, u32)> =
        (0..boxes.len() as u32).into_par_iter().map(key).collect();
    order.par_sort_unstable();
    order.into_iter().map(|(.., number)| number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_lie_along_the_curve_by_weight_and_number() {
        // Along z, with no extent along x and y.
        let at = |z: f32, size: f32| Aabb::new(Vec3A::Z * (z - size), Vec3A::Z * (z + size));
        let boxes = [
            at(3.0, 0.5),
            at(1.0, 0.5),
            at(3.0, 0.25),
            at(2.0, 0.1),
            at(3.0, 0.5),
        ];
        assert_eq!(along_the_curve(&boxes, |_| 0.0), [1, 3, 0, 2, 4]);
        assert_eq!(
            along_the_curve(&boxes, |it| it.diagonal().z),
            [1, 3, 2, 0, 4]
        );
        assert!(along_the_curve(&[], |_| 0.0).is_empty());
    }

    #[test]
    fn what_is_small_in_a_large_world_is_still_in_order() {
        // 2²¹ cells in an extent of 20,000: each is 0.01 wide.
        let at = |x: f32| Aabb::new(Vec3A::X * x, Vec3A::X * (x + 1e-3));
        let small = (0..50).map(|n| at(0.02 * ((n * 17) % 50) as f32));
        let boxes: Vec<Aabb> = small.chain([at(1e4), at(-1e4)]).collect();
        let order = along_the_curve(&boxes, |_| 0.0);
        let at = |number: &u32| boxes[*number as usize].min.x;
        assert!(order.is_sorted_by(|a, b| at(a) <= at(b)));
    }
}
