//! Stage `buffers` (section 3.2): the surfaces of a slab as its entry sees them, texel by texel.
//!
//! A picture is orthographic across the volume's depth. `near` has the surface that is nearest to the entry
//! within the slab, `far` the farthest. Depths are from the slab's own entry on, so that floats have few
//! digits to lose.

use glam::{DVec2, DVec3};
use half::f16;
use rayon::prelude::*;

use super::cuboid::Cuboid;
use super::raster::{Form, Fragment, Item, draw, has_centre};
use super::settings::Settings;
use super::variants::{Buffers, Layers};
use super::work::Work;
use crate::geometry::{Hit, Ray, Shape, SurfacePoint, TraversalCounters};
use crate::scene::Scene;

/// Bytes of a texel on a device: depth, normal and material.
const TEXEL_BYTES: [u64; 2] = [2 + 6 + 4, 4 + 12 + 4];

/// A texel of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texel {
    /// From the slab's entry \[m\]; infinite where nothing is.
    pub depth: f32,
    /// The shape.
    pub shape: u32,
    /// The face of a mesh; 0 of other shapes.
    pub face: u32,
}

impl Texel {
    /// One in which nothing is.
    pub const EMPTY: Self = Self {
        depth: f32::INFINITY,
        shape: 0,
        face: 0,
    };
}

impl Default for Texel {
    fn default() -> Self {
        Self::EMPTY
    }
}

/// A surface of a slab.
#[derive(Clone, Copy, Debug)]
pub struct Met {
    /// Where it is along the slab's depth, from its entry \[m\].
    pub depth: f64,
    /// The shape, and the face of a mesh.
    pub hit: Hit,
    /// The surface; its position is the texel's own.
    pub point: SurfacePoint,
}

/// A slab of a volume, with texels across it.
#[derive(Clone, Copy, Debug)]
pub struct Slab<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The volume.
    pub cuboid: &'a Cuboid,
    /// The depths \[m\] between which it is.
    pub depths: [f64; 2],
    /// Texels a row, and rows.
    pub side: usize,
}

impl Slab<'_> {
    /// Its depth \[m\].
    pub fn depth(&self) -> f64 {
        self.depths[1] - self.depths[0]
    }

    /// Texels by metre along both directions across.
    pub fn scale(&self) -> DVec2 {
        self.side as f64 / (2.0 * self.cuboid.size().truncate())
    }

    /// The texels of a local point, and its depth from the slab's entry.
    #[inline]
    pub fn place(&self, local: DVec3) -> DVec3 {
        let at = (local.truncate() + self.cuboid.size().truncate()) * self.scale();
        at.extend(local.z - self.depths[0])
    }

    /// The point with some texel coordinates and depth.
    pub fn point(&self, place: DVec3) -> DVec3 {
        let across = place.truncate() / self.scale() - self.cuboid.size().truncate();
        self.cuboid
            .to_world(across.extend(place.z + self.depths[0]))
    }

    /// What depths may be off the slab's borders: surfaces on them belong to both sides.
    fn slack(&self) -> f64 {
        1e-9 * self.depth()
    }

    /// The axis ray through texel coordinates from just before the slab, or, backwards, from just behind.
    fn axis_ray(&self, at: DVec2, is_backward: bool) -> Ray {
        let n = self.cuboid.frame().n;
        if is_backward {
            Ray::new(self.point(at.extend(self.depth() + self.slack())), -n)
        } else {
            Ray::new(self.point(at.extend(-self.slack())), n)
        }
    }

    /// A hit of an axis ray, if it is in the slab.
    fn met(&self, ray: &Ray, hit: Hit, is_backward: bool) -> Option<Met> {
        let along = hit.distance - self.slack();
        let depth = if is_backward {
            self.depth() - along
        } else {
            along
        };
        (along <= self.depth() + self.slack()).then(|| Met {
            depth,
            hit,
            point: self.scene.world().bounce_point(ray, &hit),
        })
    }

    /// The nearest or farthest surface of one shape.
    fn met_on(&self, shape: u32, at: DVec2, is_backward: bool, work: &mut Work) -> Option<Met> {
        let ray = self.axis_ray(at, is_backward);
        let mut counters = TraversalCounters::default();
        work.rays += 1;
        let hit = self.scene.world().hit_on(shape, &ray, &mut counters)?;
        self.met(&ray, hit, is_backward)
    }

    /// The nearest or farthest surface, by a ray.
    pub fn asked(&self, at: DVec2, is_backward: bool, work: &mut Work) -> Option<Met> {
        let (scene, mut start) = (self.scene, self.axis_ray(at, is_backward));
        let mut counters = TraversalCounters::default();
        let mut left = self.depth() + 2.0 * self.slack();
        let whole = start;
        loop {
            let hit = scene.world().closest_hit(&start, left, &mut counters);
            let Some(hit) = hit else {
                work.add_rays(counters);
                return None;
            };
            if !scene.material_of(hit.shape).is_passed(scene.materials()) {
                work.add_rays(counters);
                let point = scene.world().bounce_point(&start, &hit);
                let distance = (point.position - whole.origin).dot(whole.direction);
                return self
                    .met(&whole, Hit { distance, ..hit }, is_backward)
                    .map(|met| Met { point, ..met });
            }
            let next = scene
                .world()
                .bounce_point(&start, &hit)
                .spawn(start.direction);
            left -= next.origin.distance(start.origin);
            start = next;
        }
    }

    /// What is drawn: every surface in the slab that light does not pass; and the number of triangles and
    /// shapes, with triangles that are between the centres of texels. Those are left out.
    fn items(&self) -> (Vec<Item>, u64) {
        /// Faces that a thread looks at together.
        const FACES: usize = 4096;
        let shapes = (0_u32..).zip(self.scene.world().shapes());
        let (mut items, mut count) = (Vec::new(), 0);
        for (shape, form) in shapes {
            if self
                .scene
                .material_of(shape)
                .is_passed(self.scene.materials())
            {
                continue;
            }
            let low = DVec3::new(0.0, 0.0, -self.slack());
            let side = self.side as f64;
            let high = DVec3::new(side, side, self.depth() + self.slack());
            let overlaps = |places: &[DVec3]| {
                let least = places.iter().fold(DVec3::INFINITY, |a, b| a.min(*b));
                let most = places.iter().fold(DVec3::NEG_INFINITY, |a, b| a.max(*b));
                least.cmple(high).all() && most.cmpge(low).all()
            };
            let place = |point: DVec3| self.place(self.cuboid.to_local(point));
            let corners = form.bounds().corners().map(place);
            if !overlaps(&corners) {
                continue;
            }
            let triangle = |face: u32, corners: [DVec3; 3]| {
                let form = Form::Triangle {
                    face,
                    corners: corners.map(DVec3::truncate),
                    values: corners.map(|corner| corner.z),
                };
                overlaps(&corners).then_some(Item { shape, form })
            };
            let is_drawn = |item: &Item| match &item.form {
                Form::Triangle { corners, .. } => has_centre(self.side, corners),
                Form::Sampled { .. } => true,
            };
            match form {
                Shape::Mesh(mesh) => {
                    let places: Vec<DVec3> =
                        mesh.positions().par_iter().map(|it| place(*it)).collect();
                    let faces = mesh.triangles().par_chunks(FACES).enumerate();
                    let found: Vec<(Vec<Item>, u64)> = faces
                        .map(|(chunk, faces)| {
                            let (mut drawn, mut count) = (Vec::new(), 0);
                            for (face, corners) in (chunk * FACES..).zip(faces) {
                                let corners = corners.map(|corner| places[corner as usize]);
                                if let Some(item) = triangle(face as u32, corners) {
                                    count += 1;
                                    drawn.extend(Some(item).filter(is_drawn));
                                }
                            }
                            (drawn, count)
                        })
                        .collect();
                    for (drawn, more) in found {
                        items.extend(drawn);
                        count += more;
                    }
                }
                Shape::Rectangle(rectangle) => {
                    let [a, b, c, d] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
                        .map(|uv| place(rectangle.point(DVec2::from_array(uv))));
                    for item in [triangle(0, [a, b, c]), triangle(0, [a, c, d])] {
                        count += u64::from(item.is_some());
                        items.extend(item.filter(is_drawn));
                    }
                }
                Shape::Sphere(_) | Shape::Disk(_) | Shape::Cylinder(_) => {
                    let across = corners.map(DVec3::truncate);
                    let form = Form::Sampled {
                        low: across.iter().fold(DVec2::INFINITY, |a, b| a.min(*b)),
                        high: across.iter().fold(DVec2::NEG_INFINITY, |a, b| a.max(*b)),
                    };
                    items.push(Item { shape, form });
                    count += 1;
                }
            }
        }
        (items, count)
    }

    /// A fragment's depth as a picture keeps it; `None` beside the slab.
    fn kept(&self, fragment: &Fragment, is_far: bool, format: Buffers) -> Option<f32> {
        let depth = if let Some(depth) = fragment.value {
            depth
        } else {
            let mut work = Work::default();
            self.met_on(fragment.shape, fragment.at, is_far, &mut work)?
                .depth
        };
        let is_there = depth >= -self.slack() && depth <= self.depth() + self.slack();
        is_there.then_some(match format {
            Buffers::F16 => f16::from_f64(depth).to_f32(),
            Buffers::F32 | Buffers::Exact => depth as f32,
        })
    }
}

/// The pictures of a slab.
#[derive(Debug)]
pub enum Pictures {
    /// None: surfaces are traced.
    None,
    /// Asked by rays, where these depths allow a photon to be at a surface: see [`Pictures::is_before`].
    Asked(Vec<[f32; 2]>),
    /// By texel: nearest and farthest surface.
    NearFar(Vec<[Texel; 2]>),
    /// Layer by layer, from the entry on.
    Peeled(Vec<Vec<Texel>>),
}

/// A layer of a slab: 0 is the nearest; of near and far, 1 is the farthest.
pub type Layer = usize;

impl Pictures {
    /// The pictures of a slab that settings ask for; none if the slab's surfaces are traced.
    pub fn new(slab: &Slab, settings: &Settings, work: &mut Work) -> Self {
        if settings.layers == Layers::Exact {
            return Self::None;
        }
        if settings.layers == Layers::NearFar && settings.buffers == Buffers::Exact {
            return Self::asked(slab);
        }
        let (items, triangles) = slab.items();
        work.triangles += triangles;
        let layers = match settings.layers {
            Layers::NearFar | Layers::Exact => 2,
            Layers::Peel => u64::from(settings.peels),
        };
        let texels = (slab.side * slab.side) as u64 * layers;
        work.texels += texels;
        work.bytes += texels * TEXEL_BYTES[usize::from(settings.buffers != Buffers::F16)];
        if settings.layers == Layers::Peel {
            return Self::peeled(slab, &items, settings);
        }
        Self::NearFar(Self::near_and_far(slab, &items, settings.buffers))
    }

    /// By texel the nearest and the farthest surface.
    fn near_and_far(slab: &Slab, items: &[Item], format: Buffers) -> Vec<[Texel; 2]> {
        let texel = |fragment: &Fragment, depth: f32| Texel {
            depth,
            shape: fragment.shape,
            face: fragment.face,
        };
        draw(slab.side, items, |kept: &mut [Texel; 2], fragment| {
            if let Some(depth) = slab.kept(fragment, false, format)
                && depth < kept[0].depth
            {
                kept[0] = texel(fragment, depth);
            }
            if let Some(depth) = slab.kept(fragment, true, format)
                && (depth > kept[1].depth || kept[1].depth == f32::INFINITY)
            {
                kept[1] = texel(fragment, depth);
            }
        })
    }

    /// Where rays need not ask: by texel, depths [m] before which neither surface is. Pictures say so, of the
    /// texel and its neighbours: the least depth among them, less how much they differ, and less a texel.
    fn asked(slab: &Slab) -> Self {
        let texels = Self::near_and_far(slab, &slab.items().0, Buffers::F32);
        let side = slab.side;
        let texel = (1.0 / slab.scale().min_element()) as f32;
        let bound = |index: usize, layer: Layer| {
            let (column, row) = (index % side, index / side);
            let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
            for y in row.saturating_sub(1)..(row + 2).min(side) {
                for x in column.saturating_sub(1)..(column + 2).min(side) {
                    let depth = texels[y * side + x][layer].depth;
                    if depth < f32::INFINITY {
                        (least, most) = (least.min(depth), most.max(depth));
                    }
                }
            }
            if least < f32::INFINITY {
                2.0 * least - most - texel
            } else {
                f32::INFINITY
            }
        };
        let bounds = (0..side * side).into_par_iter();
        Self::Asked(
            bounds
                .map(|index| [bound(index, 0), bound(index, 1)])
                .collect(),
        )
    }

    /// True if a photon at texel coordinates is surely before the surface of a layer that rays would find.
    #[inline]
    pub fn is_before(&self, slab: &Slab, layer: Layer, place: DVec3) -> bool {
        let Self::Asked(bounds) = self else {
            return false;
        };
        let last = slab.side - 1;
        let (column, row) = (
            (place.x.max(0.0) as usize).min(last),
            (place.y.max(0.0) as usize).min(last),
        );
        place.z < f64::from(bounds[row * slab.side + column][layer])
    }

    /// Layers one behind the other: each pass keeps the nearest fragment behind that of the pass before
    /// (Everitt 2001). Shapes that rays sample have two layers.
    fn peeled(slab: &Slab, items: &[Item], settings: &Settings) -> Self {
        let mut layers: Vec<Vec<Texel>> = Vec::new();
        for _ in 0..settings.peels {
            let last = layers.last();
            let layer = draw(slab.side, items, |kept: &mut Texel, fragment| {
                let at = fragment.at;
                let index = at.y as usize * slab.side + at.x as usize;
                let before = last.map_or(f32::NEG_INFINITY, |layer| layer[index].depth);
                let ends: &[bool] = match fragment.value {
                    Some(_) => &[false],
                    None => &[false, true],
                };
                for is_far in ends {
                    if let Some(depth) = slab.kept(fragment, *is_far, settings.buffers)
                        && depth > before
                        && depth < kept.depth
                    {
                        *kept = Texel {
                            depth,
                            shape: fragment.shape,
                            face: fragment.face,
                        };
                    }
                }
            });
            layers.push(layer);
        }
        Self::Peeled(layers)
    }

    /// How many layers there are.
    pub fn layers(&self) -> usize {
        match self {
            Self::None => 0,
            Self::Asked(_) | Self::NearFar(_) => 2,
            Self::Peeled(layers) => layers.len(),
        }
    }

    /// The texel of a layer at texel coordinates; `None` beside the picture, and where nothing is.
    #[inline]
    fn texel(&self, slab: &Slab, layer: Layer, at: DVec2) -> Option<Texel> {
        let side = slab.side as f64;
        if !(at.x >= 0.0 && at.y >= 0.0 && at.x <= side && at.y <= side) {
            return None;
        }
        let last = slab.side - 1;
        let index = (at.y as usize).min(last) * slab.side + (at.x as usize).min(last);
        let texel = match self {
            Self::None | Self::Asked(_) => return None,
            Self::NearFar(texels) => texels[index][layer],
            Self::Peeled(layers) => layers[layer][index],
        };
        (texel.depth < f32::INFINITY).then_some(texel)
    }

    /// The depth of a layer at texel coordinates \[m\].
    #[inline]
    pub fn depth(&self, slab: &Slab, layer: Layer, at: DVec2, work: &mut Work) -> Option<f64> {
        if matches!(self, Self::Asked(_)) {
            return slab.asked(at, layer == 1, work).map(|met| met.depth);
        }
        work.fetches += 1;
        self.texel(slab, layer, at)
            .map(|texel| f64::from(texel.depth))
    }

    /// The unit normal of a mesh's face in a texel; `None` of other shapes.
    #[inline]
    pub fn face_normal(&self, slab: &Slab, layer: Layer, at: DVec2) -> Option<(u32, DVec3)> {
        let texel = self.texel(slab, layer, at)?;
        let Shape::Mesh(mesh) = &slab.scene.world().shapes()[texel.shape as usize] else {
            return None;
        };
        Some((texel.shape, mesh.face_normal(texel.face)))
    }

    /// The surface of a layer at texel coordinates: of a picture that at the texel's centre.
    pub fn surface(
        &self,
        slab: &Slab,
        settings: &Settings,
        layer: Layer,
        at: DVec2,
        work: &mut Work,
    ) -> Option<Met> {
        if matches!(self, Self::Asked(_)) {
            return slab.asked(at, layer == 1, work);
        }
        let texel = self.texel(slab, layer, at)?;
        let last = DVec2::splat(slab.side as f64 - 1.0);
        let centre = at.floor().min(last) + 0.5;
        let met = texel_surface(slab, &texel, centre)?;
        let mut point = met.point;
        if settings.buffers == Buffers::F16 {
            let stored = |v: DVec3| {
                v.map(|x| f16::from_f64(x).to_f64())
                    .try_normalize()
                    .unwrap_or(v)
            };
            point.geometric_normal = stored(point.geometric_normal);
            point.shading_normal = stored(point.shading_normal);
        }
        Some(Met {
            depth: f64::from(texel.depth),
            point,
            ..met
        })
    }
}

/// The surface in a texel, at its centre: what a fragment shader would write beside its depth.
fn texel_surface(slab: &Slab, texel: &Texel, centre: DVec2) -> Option<Met> {
    let world = slab.scene.world();
    let Shape::Mesh(mesh) = &world.shapes()[texel.shape as usize] else {
        // Of two surfaces of a shape the one at the texel's depth.
        let mut work = Work::default();
        let ends = [false, true].map(|is_far| slab.met_on(texel.shape, centre, is_far, &mut work));
        let off = |met: &Met| (met.depth - f64::from(texel.depth)).abs();
        return ends
            .into_iter()
            .flatten()
            .min_by(|a, b| off(a).total_cmp(&off(b)));
    };
    let corners = mesh
        .corners(texel.face)
        .map(|corner| slab.place(slab.cuboid.to_local(corner)).truncate());
    let [a, b, c] = corners;
    let area = (b - a).perp_dot(c - a);
    let barycentric = DVec2::new(
        (centre - a).perp_dot(c - a) / area,
        (b - a).perp_dot(centre - a) / area,
    );
    let hit = Hit {
        distance: 0.0,
        shape: texel.shape,
        face: texel.face,
        barycentric,
    };
    let point = world.face_point(texel.shape, texel.face, barycentric)?;
    point.geometric_normal.is_finite().then_some(Met {
        depth: f64::from(texel.depth),
        hit,
        point,
    })
}
