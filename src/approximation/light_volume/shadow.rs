//! Stages `shadow` and `shadow-cull`: the shadow map of what is above the water (section 3.4).

use glam::{DVec2, DVec3};

use super::beam::Beam;
use super::quadtree::{Node, Quadtree};
use super::slicing::{Slicing, join, overlap};
use super::water::mean_normal;
use super::work::Work;
use crate::approximation::{DepthMap, Extent, LightView, Precision, Receivers};
use crate::geometry::{Bounds, Shape};
use crate::scene::Scene;
use crate::transport::first_surface::Source;

/// What is above the water, as the light sees it.
pub struct ShadowMap {
    maps: Vec<DepthMap>,
    /// The boxes of occluders.
    occluders: Vec<Bounds>,
    /// Occluded pixels of the water's mean plane, map by map: in each row, the number before each column.
    counts: Vec<Vec<u32>>,
}

impl ShadowMap {
    /// Most views of one light's map over a shape of water; 0 if nothing reaches above the lowest place of
    /// its box.
    pub fn most_views(scene: &Scene, water: u32) -> u64 {
        let shapes = scene.world().shapes();
        let surface = &shapes[water as usize];
        let normal = mean_normal(surface);
        let height = |shape: &Shape, of: fn(f64, f64) -> f64, first: f64| {
            let corners = shape.bounds().corners().into_iter();
            corners.map(|corner| corner.dot(normal)).fold(first, of)
        };
        let lowest = height(surface, f64::min, f64::INFINITY);
        let mut others = (0_u32..).zip(shapes).filter(|(shape, _)| *shape != water);
        if !others.any(|(_, shape)| height(shape, f64::max, f64::NEG_INFINITY) > lowest) {
            return 0;
        }
        let views = |source: &Source| LightView::around(source, &[Extent::of(surface)], 1).len();
        Source::all(scene).iter().map(views).max().unwrap_or(0) as u64
    }

    /// The shadow map of the shapes that reach above the lowest of the water's vertices.
    ///
    /// - `plane`: a point and the normal of the plane in which nodes are compared.
    /// - `side`: texels a row, and rows.
    pub fn new(
        scene: &Scene,
        source: &Source,
        slicing: &Slicing,
        water: &[DVec3],
        plane: [DVec3; 2],
        side: u32,
        work: &mut Work,
    ) -> Self {
        let lowest = water
            .iter()
            .map(|place| slicing.local(*place).1)
            .fold(f64::NEG_INFINITY, f64::max);
        let reaches_above = |shape: &Shape| {
            let corners = shape.bounds().corners().into_iter();
            corners
                .map(|corner| slicing.local(corner).1)
                .fold(f64::INFINITY, f64::min)
                < lowest
        };
        let receivers = Receivers::chosen(scene, reaches_above);
        let occluders: Vec<Bounds> = receivers.shapes().iter().map(Shape::bounds).collect();
        if occluders.is_empty() {
            return Self {
                maps: Vec::new(),
                occluders,
                counts: Vec::new(),
            };
        }
        let all = scene.world().bounds();
        let maps: Vec<DepthMap> = LightView::around(source, &[Extent::Points(water)], side)
            .into_iter()
            .map(|view| {
                let view = view.before(&all);
                let windows = occluders.iter().map(|bounds| view.window(bounds));
                let window = windows.reduce(join);
                let window = window.unwrap_or([DVec2::ZERO; 2]);
                let (map, counters) = DepthMap::within(&receivers, view, Precision::F32, window);
                work.add_rays(counters);
                work.bytes += map.bytes();
                map
            })
            .collect();
        let counts = maps.iter().map(|map| occluded(map, plane)).collect();
        Self {
            maps,
            occluders,
            counts,
        }
    }

    /// True if the light sees a place, as far as the map tells.
    pub fn is_lit(&self, place: DVec3) -> bool {
        !self.maps.iter().any(|map| {
            let seen = map.view().project(place);
            seen.is_some_and(|seen| map.at(seen.at).is_some_and(|depth| seen.depth > depth))
        })
    }

    /// Marks the beams that are left when leaves in shadow are culled.
    ///
    /// - `s_min`: the share of a leaf in shadow beyond which it is culled.
    /// - `must_overlap`: ask only about nodes whose box an occluder's overlaps, as the light sees them.
    pub fn lit_leaves(
        &self,
        tree: &Quadtree,
        beams: &[Option<Beam>],
        s_min: f64,
        must_overlap: bool,
        work: &mut Work,
    ) -> Vec<bool> {
        let mut is_lit = vec![true; beams.len()];
        let mut open: Vec<Node> = tree.roots().collect();
        while let Some(node) = open.pop() {
            let places = tree.triangles(node);
            if beams[places.clone()].iter().flatten().next().is_none() {
                continue;
            }
            let corners = tree.corners(node);
            if must_overlap && !self.may_shade(corners) {
                continue;
            }
            work.queries += 1;
            let share = self.share(corners);
            match tree.children(node) {
                None if share > s_min => {
                    for place in places {
                        if beams[place].is_some() {
                            is_lit[place] = false;
                            work.culled += 1;
                        }
                    }
                }
                // All of the shadow may be on one leaf.
                Some(children) if share * f64::from(tree.leaves(node)) > s_min => {
                    open.extend(children);
                }
                None | Some(_) => {}
            }
        }
        is_lit
    }

    /// True if the box of an occluder overlaps a rectangle of the water in a picture.
    fn may_shade(&self, corners: [DVec3; 4]) -> bool {
        let bounds = Bounds::from_points(corners);
        self.maps.iter().any(|map| {
            let ours = map.view().window(&bounds);
            self.occluders.iter().any(|occluder| {
                let theirs = map.view().window(occluder);
                overlap(ours, theirs)
            })
        })
    }

    /// The share of a rectangle's pixels that are occluded, 0 to 1.
    fn share(&self, places: [DVec3; 4]) -> f64 {
        let (mut count, mut area) = (0, 0.0);
        for (map, counts) in self.maps.iter().zip(&self.counts) {
            let Some(image) = seen(map.view(), places) else {
                continue;
            };
            area += seen_area(image, map.view().side() as f64);
            count += count_in(image, map.view().side(), counts);
        }
        if area > 0.0 {
            // The area is an estimate of what is counted: all of it may be a little more than it.
            (f64::from(count) / area).min(1.0)
        } else {
            0.0
        }
    }
}

/// Where places are in an image; `None` if one is behind the light.
fn seen(view: &LightView, places: [DVec3; 4]) -> Option<[DVec2; 4]> {
    let [a, b, c, d] = places.map(|place| view.project(place).map(|seen| seen.at));
    Some([a?, b?, c?, d?])
}

/// The pixels at whose centres the water's mean plane is behind an occluder: in each row, how many there are
/// before each column.
fn occluded(map: &DepthMap, [place, normal]: [DVec3; 2]) -> Vec<u32> {
    let (view, side) = (map.view(), map.view().side());
    let mut counts = Vec::with_capacity(side * (side + 1));
    for row in 0..side {
        let mut count = 0;
        counts.push(0);
        for column in 0..side {
            let at = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
            let depth = map.at(at).unwrap_or(f64::INFINITY);
            if depth.is_finite() {
                let ray = view.ray(at);
                let distance = (place - ray.origin).dot(normal) / ray.direction.dot(normal);
                let own = view.project(ray.at(distance)).map(|seen| seen.depth);
                count += u32::from(own.is_some_and(|own| own > depth));
            }
            counts.push(count);
        }
    }
    counts
}

/// The number of occluded pixels with their centres in a convex quadrilateral.
fn count_in(image: [DVec2; 4], side: usize, counts: &[u32]) -> u32 {
    let low = image.iter().map(|it| it.y).fold(f64::INFINITY, f64::min);
    let high = image
        .iter()
        .map(|it| it.y)
        .fold(f64::NEG_INFINITY, f64::max);
    let last = side as f64;
    let rows =
        (low - 0.5).ceil().clamp(0.0, last) as usize..(high - 0.5).ceil().clamp(0.0, last) as usize;
    let mut count = 0;
    for row in rows {
        let y = row as f64 + 0.5;
        let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
        for i in 0..4 {
            let (a, b) = (image[i], image[(i + 1) % 4]);
            if (a.y <= y) != (b.y <= y) {
                let x = a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y));
                from = from.min(x);
                to = to.max(x);
            }
        }
        if from < to {
            let column = |x: f64| (x - 0.5).ceil().clamp(0.0, last) as usize;
            let line = &counts[row * (side + 1)..][..=side];
            count += line[column(to)] - line[column(from)];
        }
    }
    count
}

/// The area of the part of a convex quadrilateral that is in an image of `side` x `side` pixels.
fn seen_area(image: [DVec2; 4], side: f64) -> f64 {
    let mut polygon = image.to_vec();
    // Inside is where out · place is at most the offset.
    let sides = [
        (DVec2::NEG_X, 0.0),
        (DVec2::NEG_Y, 0.0),
        (DVec2::X, side),
        (DVec2::Y, side),
    ];
    for (out, offset) in sides {
        let mut cut = Vec::with_capacity(8);
        for (i, from) in polygon.iter().enumerate() {
            let to = polygon[(i + 1) % polygon.len()];
            let (a, b) = (out.dot(*from) - offset, out.dot(to) - offset);
            if a <= 0.0 {
                cut.push(*from);
            }
            if (a <= 0.0) != (b <= 0.0) {
                cut.push(*from + (to - *from) * (a / (a - b)));
            }
        }
        polygon = cut;
    }
    let corners = polygon.len();
    let twice: f64 = (0..corners)
        .map(|i| polygon[i].perp_dot(polygon[(i + 1) % corners]))
        .sum();
    0.5 * twice.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_part_of_a_rectangle_that_is_in_the_image_counts() {
        let at = |x: f64, y: f64| DVec2::new(x, y);
        let around = |low: DVec2, high: DVec2| [low, at(high.x, low.y), high, at(low.x, high.y)];
        assert_eq!(seen_area(around(at(1.0, 2.0), at(4.0, 4.0)), 8.0), 6.0);
        assert_eq!(seen_area(around(at(-5.0, 2.0), at(4.0, 4.0)), 8.0), 8.0);
        assert_eq!(seen_area(around(at(6.0, -9.0), at(40.0, 90.0)), 8.0), 16.0);
        assert_eq!(seen_area(around(at(9.0, 1.0), at(12.0, 2.0)), 8.0), 0.0);
    }
}
