//! All shapes of a scene, and the search among them.

use std::fmt;

use glam::{DVec2, DVec3};

use super::{
    Bounds, Hit, Mesh, PlanePair, Ray, Segment, Shape, SurfacePoint,
    accel::{BoxTree, Lanes, LeafVisitor, LocalRay, Root},
    counters::TraversalCounters,
    face_tree::{FaceTree, sharing},
    nearest::Nearest,
};

/// All shapes of a scene, and trees over their primitives.
///
/// Meshes share a tree unless the faces of one are tiny in it: a search is unsure of places by a fraction of
/// the tree's extent, which stays small however large the floor that a mesh stands on.
pub struct World {
    shapes: Vec<Shape>,
    bounds: Bounds,
    trees: Vec<FaceTree>,
    /// Where each mesh's faces are, `None` for the other shapes; as long as `shapes`.
    places: Vec<Option<Place>>,
    /// What searches try.
    targets: Vec<Target>,
    /// A tree over the boxes of the targets, if there are too many to try one after the other.
    over_targets: Option<BoxTree>,
}

/// The faces of a mesh: a part of a tree.
#[derive(Clone, Copy)]
struct Place {
    tree: usize,
    part: usize,
}

/// One of the things to search for hits.
#[derive(Clone, Copy)]
enum Target {
    /// All meshes of this tree.
    Tree(usize),
    /// A shape that is not a mesh.
    Shape(u32),
}

/// Up to this number, trying all targets costs less than a walk down a tree (see `benches/traversal.rs`).
const LINEAR_SEARCH_LIMIT: usize = 8;

impl World {
    /// The world of these shapes, with its trees.
    pub fn new(shapes: Vec<Shape>) -> Self {
        let boxes: Vec<Bounds> = shapes.iter().map(Shape::bounds).collect();
        let meshes: Vec<(u32, &Mesh)> = (0..)
            .zip(&shapes)
            .filter_map(|(index, shape)| match shape {
                Shape::Mesh(mesh) => Some((index, mesh)),
                _ => None,
            })
            .collect();
        let mut places = vec![None; shapes.len()];
        let mut targets: Vec<(Target, Bounds)> = Vec::new();
        let mut trees = Vec::new();
        for members in sharing(&meshes.iter().map(|&(_, mesh)| mesh).collect::<Vec<_>>()) {
            let members: Vec<(u32, &Mesh)> = members.iter().map(|&member| meshes[member]).collect();
            let tree = FaceTree::new(&members);
            let around = members.iter().map(|&(shape, _)| boxes[shape as usize]);
            targets.push((
                Target::Tree(trees.len()),
                around.fold(Bounds::EMPTY, Bounds::union),
            ));
            for (part, &(shape, _)) in members.iter().enumerate() {
                places[shape as usize] = Some(Place {
                    tree: trees.len(),
                    part,
                });
            }
            trees.push(tree);
        }
        targets.extend(
            (0..)
                .zip(&shapes)
                .zip(&boxes)
                .filter(|((_, shape), _)| !matches!(shape, Shape::Mesh(_)))
                .map(|((index, _), &bounds)| (Target::Shape(index), bounds)),
        );
        let (targets, around): (Vec<Target>, Vec<Bounds>) = targets.into_iter().unzip();
        Self {
            bounds: boxes.iter().fold(Bounds::EMPTY, |all, &one| all.union(one)),
            over_targets: (targets.len() > LINEAR_SEARCH_LIMIT).then(|| BoxTree::new(&around)),
            trees,
            places,
            targets,
            shapes,
        }
    }

    /// The shapes, in the order given.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// The box around everything; empty if there are no shapes.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Memory held by shapes and trees, bytes.
    pub fn memory_bytes(&self) -> usize {
        let shapes = self.shapes.iter().map(|shape| match shape {
            Shape::Mesh(mesh) => size_of::<Shape>() + mesh.memory_bytes(),
            _ => size_of::<Shape>(),
        });
        let trees = self.trees.iter().map(FaceTree::memory_bytes);
        shapes.sum::<usize>()
            + trees.sum::<usize>()
            + size_of_val(&*self.places)
            + size_of_val(&*self.targets)
            + self.over_targets.as_ref().map_or(0, BoxTree::memory_bytes)
    }

    /// The nearest hit nearer than `max_distance` (exclusive); all hits have a distance > 0.
    ///
    /// Among hits at the same distance, the one with the lowest (shape, face) is the result, so it does not
    /// depend on the order of the search.
    #[inline]
    pub fn closest_hit(
        &self,
        ray: &Ray,
        max_distance: f64,
        counters: &mut TraversalCounters,
    ) -> Option<Hit> {
        counters.rays += 1;
        let mut nearest = Nearest::before(max_distance);
        if let Some(tree) = &self.over_targets {
            let mut search = TargetSearch {
                tree,
                visit: |target| {
                    self.search(self.targets[target], ray, &mut nearest, counters);
                    nearest.limit()
                },
                limit: max_distance,
            };
            counters.node_visits += tree.search(tree.whole(), ray, max_distance, &mut search);
        } else {
            for &target in &self.targets {
                self.search(target, ray, &mut nearest, counters);
            }
        }
        nearest.hit()
    }

    /// [`Self::closest_hit`] of many rays, each before its segment's end: `found` becomes one entry a
    /// segment.
    ///
    /// Hits are the same as one by one. With at most eight trees and other shapes it is sooner if rays go
    /// about the same way: they then go down a tree together, and counters have fewer visits of nodes. It is
    /// sooner, too, if rays are apart and meshes are large: their searches then wait for memory together,
    /// with the same counters.
    pub fn closest_hits(
        &self,
        segments: &[Segment],
        found: &mut Vec<Option<Hit>>,
        counters: &mut TraversalCounters,
    ) {
        found.clear();
        if self.over_targets.is_some() {
            let hits = segments.iter();
            found.extend(hits.map(|it| self.closest_hit(&it.ray, it.length, counters)));
            return;
        }
        counters.rays += segments.len() as u64;
        let mut nearest: Vec<Nearest> = segments
            .iter()
            .map(|segment| Nearest::before(segment.length))
            .collect();
        for &target in &self.targets {
            match target {
                Target::Tree(tree) => {
                    self.trees[tree].closest_hits(segments, &mut nearest, counters);
                }
                Target::Shape(shape) => {
                    for (segment, nearest) in segments.iter().zip(&mut nearest) {
                        self.try_shape(shape, &segment.ray, nearest, counters);
                    }
                }
            }
        }
        found.extend(nearest.into_iter().map(Nearest::hit));
    }

    /// True if [`Self::closest_hits`] may be sooner than one ray after the other.
    pub fn gains_by_many(&self) -> bool {
        self.over_targets.is_none() && self.trees.iter().any(FaceTree::gains_by_many)
    }

    #[inline]
    fn search(
        &self,
        target: Target,
        ray: &Ray,
        nearest: &mut Nearest,
        counters: &mut TraversalCounters,
    ) {
        match target {
            Target::Tree(tree) => {
                let tree = &self.trees[tree];
                tree.closest_hit(tree.whole(), ray, nearest, counters);
            }
            Target::Shape(shape) => self.try_shape(shape, ray, nearest, counters),
        }
    }

    /// Tries a shape that is not a mesh.
    #[inline]
    fn try_shape(
        &self,
        shape: u32,
        ray: &Ray,
        nearest: &mut Nearest,
        counters: &mut TraversalCounters,
    ) {
        counters.primitive_tests += 1;
        if let Some(hit) = self.analytic_hit(shape, ray) {
            nearest.offer(hit);
        }
    }

    /// Where a mesh's faces are; `None` for other shapes.
    #[inline]
    fn faces_of(&self, shape: u32) -> Option<(&FaceTree, Root)> {
        let Place { tree, part } = self.places[shape as usize]?;
        let tree = &self.trees[tree];
        Some((tree, tree.part(part)))
    }

    /// The nearest hit on one shape, whatever is in the way.
    pub fn hit_on(&self, shape: u32, ray: &Ray, counters: &mut TraversalCounters) -> Option<Hit> {
        let mut nearest = Nearest::before(f64::INFINITY);
        if let Some((tree, root)) = self.faces_of(shape) {
            tree.closest_hit(root, ray, &mut nearest, counters);
        } else {
            self.try_shape(shape, ray, &mut nearest, counters);
        }
        nearest.hit()
    }

    /// The first hit on a shape that is not a mesh.
    #[inline]
    fn analytic_hit(&self, shape: u32, ray: &Ray) -> Option<Hit> {
        let distance = match &self.shapes[shape as usize] {
            Shape::Sphere(sphere) => sphere.distance(ray),
            Shape::Rectangle(rectangle) => rectangle.distance(ray),
            Shape::Disk(disk) => disk.distance(ray),
            Shape::Cylinder(cylinder) => cylinder.distance(ray),
            Shape::Mesh(_) => None,
        }?;
        Some(Hit {
            distance,
            shape,
            face: 0,
            barycentric: DVec2::ZERO,
        })
    }

    /// True if any hit nearer than `max_distance` satisfies `blocks`, which is asked in no particular order.
    ///
    /// For a sphere or cylinder only the nearest hit is asked about.
    pub fn any_hit(
        &self,
        ray: &Ray,
        max_distance: f64,
        mut blocks: impl FnMut(&Hit) -> bool,
        counters: &mut TraversalCounters,
    ) -> bool {
        counters.rays += 1;
        let mut blocked_by = |target: Target| match target {
            Target::Tree(tree) => {
                self.trees[tree].any_hit(ray, max_distance, &mut blocks, counters)
            }
            Target::Shape(shape) => {
                counters.primitive_tests += 1;
                self.analytic_hit(shape, ray)
                    .is_some_and(|hit| hit.distance < max_distance && blocks(&hit))
            }
        };
        if let Some(tree) = &self.over_targets {
            let mut blocked = false;
            let mut search = TargetSearch {
                tree,
                visit: |target| {
                    blocked = blocked || blocked_by(self.targets[target]);
                    // Nothing is nearer than −∞: the search ends.
                    if blocked {
                        f64::NEG_INFINITY
                    } else {
                        max_distance
                    }
                },
                limit: max_distance,
            };
            counters.node_visits += tree.search(tree.whole(), ray, max_distance, &mut search);
            blocked
        } else {
            self.targets.iter().copied().any(blocked_by)
        }
    }

    /// The surface at a hit.
    #[inline]
    pub fn surface_point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.with_uv(self.bounce_point(ray, hit), hit)
    }

    /// The [`surface_point`](Self::surface_point) that a hit's [`bounce_point`](Self::bounce_point) belongs
    /// to.
    #[inline]
    pub fn with_uv(&self, mut point: SurfacePoint, hit: &Hit) -> SurfacePoint {
        match &self.shapes[hit.shape as usize] {
            Shape::Sphere(sphere) => point.uv = sphere.uv(&point),
            Shape::Disk(_) => point.uv = super::Disk::uv(&point),
            Shape::Cylinder(cylinder) => point.uv = cylinder.uv(&point),
            Shape::Rectangle(_) | Shape::Mesh(_) => {}
        }
        point
    }

    /// The surface at a hit without `uv`, which is left unspecified on round shapes.
    ///
    /// For bounces, which do not use `uv`: the angles it takes would cost more than the search.
    #[inline]
    pub fn bounce_point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        match &self.shapes[hit.shape as usize] {
            Shape::Sphere(sphere) => sphere.surface_point(ray, hit.distance),
            Shape::Rectangle(rectangle) => rectangle.surface_point(ray, hit.distance),
            Shape::Disk(disk) => disk.surface_point(ray, hit.distance),
            Shape::Cylinder(cylinder) => cylinder.surface_point(ray, hit.distance),
            Shape::Mesh(mesh) => mesh.surface_point(ray, hit),
        }
    }

    /// The point of a mesh's face with these barycentric weights of its second and third vertex; `None` if
    /// the shape is no mesh. `uv` is as for a hit there.
    pub fn face_point(&self, shape: u32, face: u32, barycentric: DVec2) -> Option<SurfacePoint> {
        let Shape::Mesh(mesh) = &self.shapes[shape as usize] else {
            return None;
        };
        let hit = Hit {
            distance: 0.0,
            shape,
            face,
            barycentric,
        };
        // The ray matters only to faces without area.
        let ray = Ray::new(DVec3::ZERO, DVec3::Z);
        Some(mesh.surface_point(&ray, &hit))
    }

    /// True if `overlaps` may hold for a primitive of the chosen shapes. Descends the tree while
    /// `overlaps(box)` is true; at a leaf asks `overlaps` of each chosen primitive's own box.
    ///
    /// `overlaps` must be monotone: true for every box that holds a box for which it is true.
    pub fn any_primitive_box(
        &self,
        choose: impl Fn(u32) -> bool,
        mut overlaps: impl FnMut(&Bounds) -> bool,
    ) -> bool {
        (0..self.shapes.len() as u32)
            .filter(|&shape| choose(shape))
            .any(|shape| match self.faces_of(shape) {
                Some((tree, root)) => tree.any_box(root, &mut overlaps),
                None => overlaps(&self.shapes[shape as usize].bounds()),
            })
    }
}

impl World {
    /// True if `test(face, corners)` holds for any face of a mesh that is between all pairs of planes, and
    /// perhaps for others near them; false if the shape is no mesh. Among faces at the same place only one is
    /// asked about.
    pub fn any_face(
        &self,
        shape: u32,
        pairs: impl Iterator<Item = PlanePair>,
        test: impl FnMut(u32, &[DVec3; 3]) -> bool,
    ) -> bool {
        self.faces_of(shape)
            .is_some_and(|(tree, root)| tree.any_face(root, pairs, test))
    }
}

/// A search of the targets of the leaves visited.
struct TargetSearch<'a, F> {
    tree: &'a BoxTree,
    /// The visit of one target; returns the new limit.
    visit: F,
    limit: f64,
}

impl<F: FnMut(usize) -> f64> LeafVisitor for TargetSearch<'_, F> {
    #[inline]
    fn candidates(&self, _lanes: impl Lanes, leaf: usize, _ray: &LocalRay) -> u32 {
        (1 << self.tree.leaf(leaf).len()) - 1
    }

    #[inline]
    fn test(&mut self, leaf: usize, _candidates: u32) -> f64 {
        for &target in self.tree.leaf(leaf) {
            self.limit = (self.visit)(target as usize);
        }
        self.limit
    }
}

impl fmt::Debug for World {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("World")
            .field("shapes", &self.shapes.len())
            .field("bounds", &self.bounds)
            .finish_non_exhaustive()
    }
}
