//! The order of boxes along the Morton curve.

use glam::Vec3A;
use obvhs::aabb::Aabb;
use rayon::prelude::*;

use crate::numeric::morton_code;

/// The boxes' numbers along the Morton curve through their middles; of those in one place the smaller first.
pub(super) fn along_the_curve(boxes: &[Aabb]) -> Vec<u32> {
    let all = boxes.iter().fold(Aabb::empty(), |all, one| all.union(one));
    // A side without length would divide 0 by 0.
    let size = all.diagonal().max(Vec3A::splat(f32::MIN_POSITIVE));
    let place = |number: u32| {
        let place = (boxes[number as usize].center() - all.min) / size;
        (morton_code(place.as_dvec3()), number)
    };
    let mut order: Vec<(u64, u32)> = (0..boxes.len() as u32).into_par_iter().map(place).collect();
    let size = |number: u32| boxes[number as usize].half_area();
    order.par_sort_unstable_by(|a, b| {
        let of_one_place = || size(a.1).total_cmp(&size(b.1)).then(a.1.cmp(&b.1));
        a.0.cmp(&b.0).then_with(of_one_place)
    });
    order.into_iter().map(|(_, number)| number).collect()
}
