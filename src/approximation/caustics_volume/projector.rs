//! Stage `projector` (section 3.4): where photons that left the volume land.
//!
//! Each exit face has a picture of the surfaces outside that neither mirror nor refract. `cube` sees them
//! from the volume's middle through the face, as the faces of a cube map do; what leaves one picture goes on
//! in the next. `orthographic` sees them along the face's normal.

use glam::{DVec2, DVec3};

use super::cuboid::{Cuboid, Face};
use super::demands::Volume;
use super::ledger::Fate;
use super::photon::{Landing, Photon};
use super::raster::{Form, Fragment, Item, draw};
use super::settings::Settings;
use super::slab::facing;
use super::variants::Projector;
use super::work::Work;
use crate::geometry::{Hit, Ray, Shape, TraversalCounters};
use crate::scene::Scene;
use crate::transport::path_end::next_hit;

/// Bytes of a texel on a device: depth and normal.
const TEXEL_BYTES: u64 = 4 + 12;

/// A texel of a projector's picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Texel {
    /// The reciprocal of the depth along the face's normal, from the volume's middle on; 0 where nothing is.
    nearness: f32,
    shape: u32,
    face: u32,
}

/// The view of a face.
#[derive(Clone, Copy, Debug)]
struct View {
    /// The volume's middle, where depths begin, local.
    origin: DVec3,
    /// Across, and outwards, local.
    axes: [DVec3; 3],
    /// What the middle of the film's side is at depth 1; of orthographic pictures at any depth.
    half: DVec2,
    /// The depth of the face.
    near: f64,
    is_parallel: bool,
    side: usize,
}

impl View {
    fn new(cuboid: &Cuboid, face: Face, settings: &Settings) -> Self {
        let size = cuboid.size();
        let [(a, half_a), (b, half_b)] = Cuboid::face_axes(face, size);
        let outward = face.outward();
        let middle = DVec3::Z * (0.5 * size.z);
        let near = (cuboid.face_middle(face) - middle).dot(outward);
        let is_parallel = settings.projector == Projector::Orthographic;
        let across = DVec2::new(half_a, half_b);
        Self {
            origin: middle,
            axes: [a, b, outward],
            half: if is_parallel { across } else { across / near },
            near,
            is_parallel,
            side: settings.g_buffer as usize,
        }
    }

    /// Coordinates across and depth of a local point.
    fn place(&self, local: DVec3) -> DVec3 {
        let offset = local - self.origin;
        DVec3::from_array(self.axes.map(|axis| offset.dot(axis)))
    }

    /// The image of a place with positive depth, in texels.
    fn image(&self, place: DVec3) -> DVec2 {
        let across = if self.is_parallel {
            place.truncate()
        } else {
            place.truncate() / place.z
        };
        (across / self.half + 1.0) * (0.5 * self.side as f64)
    }

    /// The local ray of the picture through an image point, from the face on.
    fn ray(&self, at: DVec2) -> [DVec3; 2] {
        let across = (at * (2.0 / self.side as f64) - 1.0) * self.half;
        let [a, b, c] = self.axes;
        let plane = a * across.x + b * across.y;
        if self.is_parallel {
            [self.origin + plane + c * self.near, c]
        } else {
            let along = plane + c;
            [self.origin + along * self.near, along.normalize()]
        }
    }
}

/// A picture of what is outside a face.
#[derive(Debug)]
struct Picture {
    view: View,
    texels: Vec<Texel>,
}

/// The pictures of all exit faces.
#[derive(Debug, Default)]
pub struct Projectors {
    /// By [`Face`]; `None` of faces that cull.
    pictures: [Option<Picture>; 6],
}

impl Projectors {
    /// The pictures of a volume's exit faces; none if photons are traced.
    pub fn new(scene: &Scene, volume: &Volume, settings: &Settings, work: &mut Work) -> Self {
        let mut pictures: [Option<Picture>; 6] = Default::default();
        if settings.projector != Projector::Exact {
            for face in volume.exits() {
                let view = View::new(&volume.cuboid, face, settings);
                pictures[face as usize] = Some(picture(scene, &volume.cuboid, view, work));
            }
        }
        Self { pictures }
    }

    /// Where a photon outside the volume lands in the pictures.
    fn march(
        &self,
        scene: &Scene,
        cuboid: &Cuboid,
        photon: &Photon,
        work: &mut Work,
    ) -> Result<Landing, Fate> {
        let size = cuboid.size();
        let half = DVec3::new(size.x, size.y, 0.5 * size.z);
        let middle = DVec3::Z * half.z;
        let origin = cuboid.to_local(photon.ray.origin);
        let direction = cuboid.frame().to_local(photon.ray.direction);
        let face_at = |distance: f64| {
            let place = (origin + direction * distance - middle) / half;
            Face::along(place)
        };
        let mut face = face_at(0.0);
        let mut from = 0.0;
        // A straight way passes each face of a cube once.
        for _ in Face::ALL {
            let Some(picture) = &self.pictures[face as usize] else {
                return Err(Fate::BesidePictures);
            };
            let start = picture.view.place(origin);
            let axes = picture.view.axes;
            let along = DVec3::from_array(axes.map(|axis| direction.dot(axis)));
            match picture.march(start, along, from, work) {
                End::Met(distance, texel, at) => {
                    work.fetches += 1;
                    let position = photon.ray.at(distance);
                    let normal = picture
                        .normal(scene, cuboid, &texel, at)
                        .ok_or(Fate::NoReceiver)?;
                    return Ok(Landing {
                        photon: *photon,
                        position,
                        normal: facing(normal, photon.ray.direction),
                        hit: None,
                    });
                }
                End::Never => return Err(Fate::NoReceiver),
                End::Left(distance) => {
                    // A step over the border decides the next face.
                    let next = face_at(distance * (1.0 + 1e-9) + 1e-12 * half.length());
                    if next == face || picture.view.is_parallel {
                        return Err(Fate::BesidePictures);
                    }
                    (face, from) = (next, distance);
                }
            }
        }
        Err(Fate::BesidePictures)
    }

    /// Where a photon outside the volume lands.
    ///
    /// # Errors
    ///
    /// If it lands nowhere.
    pub fn land(
        &self,
        scene: &Scene,
        cuboid: &Cuboid,
        settings: &Settings,
        photon: &Photon,
        work: &mut Work,
    ) -> Result<Landing, Fate> {
        work.photons += 1;
        if settings.projector == Projector::Exact {
            trace(scene, photon, work)
        } else {
            self.march(scene, cuboid, photon, work)
        }
    }
}

/// Where a photon lands by a ray.
fn trace(scene: &Scene, photon: &Photon, work: &mut Work) -> Result<Landing, Fate> {
    let mut counters = TraversalCounters::default();
    let found = next_hit(scene, photon.ray, &mut counters);
    work.add_rays(counters);
    let (ray, hit) = found.ok_or(Fate::NoReceiver)?;
    if scene.material_of(hit.shape).is_specular(scene.materials()) {
        return Err(Fate::Specular);
    }
    let point = scene.world().bounce_point(&ray, &hit);
    let passed = ray.origin.distance(photon.ray.origin);
    Ok(Landing {
        photon: *photon,
        position: point.position,
        normal: facing(point.geometric_normal, ray.direction),
        hit: Some(Hit {
            distance: hit.distance + passed,
            ..hit
        }),
    })
}

/// The end of a way through a picture.
enum End {
    /// At a distance, on a texel's surface.
    Met(f64, Texel, DVec2),
    /// It leaves the picture at a distance.
    Left(f64),
    /// It goes on for ever.
    Never,
}

impl Picture {
    /// Goes along a way from a distance on, texel by texel, until it is as deep as what the picture has.
    fn march(&self, start: DVec3, along: DVec3, mut from: f64, work: &mut Work) -> End {
        let view = &self.view;
        let side = view.side as f64;
        let perspective = if view.is_parallel { 0.0 } else { 1.0 };
        // Coordinates across by depth: (s + t a) / (w + t c), with w = 1 and c = 0 in parallel pictures.
        let w = 1.0 + perspective * (start.z - 1.0);
        let c = perspective * along.z;
        // The sign of their change is the same all the way.
        let trend = along.truncate() * w - start.truncate() * c;
        let place = start + along * from;
        let image = view.image(place).clamp(DVec2::ZERO, DVec2::splat(side));
        let first = |at: f64, trend: f64| {
            let texel = if trend < 0.0 {
                at.ceil() - 1.0
            } else {
                at.floor()
            };
            texel.clamp(0.0, side - 1.0)
        };
        let mut texel = DVec2::new(first(image.x, trend.x), first(image.y, trend.y));
        // The distance at which a coordinate reaches the next border.
        let border = |texel: f64, axis: usize, from: f64| {
            let trend = trend[axis];
            if trend == 0.0 {
                return f64::INFINITY;
            }
            let edge = if trend > 0.0 { texel + 1.0 } else { texel };
            let across = (edge * (2.0 / side) - 1.0) * view.half[axis];
            let distance = (across * w - start[axis]) / (along[axis] - across * c);
            // Behind the last place by rounding, or never.
            if distance.is_nan() || distance < from {
                let is_ahead = distance.is_finite() && from - distance < 1e-9 * (1.0 + from);
                return if is_ahead { from } else { f64::INFINITY };
            }
            distance
        };
        loop {
            work.steps += 1;
            work.fetches += 1;
            let next = [border(texel.x, 0, from), border(texel.y, 1, from)];
            let to = next[0].min(next[1]);
            let found = self.texels[texel.y as usize * view.side + texel.x as usize];
            if found.nearness > 0.0 {
                let depth = 1.0 / f64::from(found.nearness);
                let ends = [from, to].map(|distance| start.z + along.z * distance);
                let deepest = if ends[1].is_nan() {
                    ends[0]
                } else {
                    ends[0].max(ends[1])
                };
                if deepest >= depth {
                    let distance = (depth - start.z) / along.z;
                    let distance = if distance.is_finite() {
                        distance.clamp(from, to)
                    } else {
                        from
                    };
                    return End::Met(distance, found, texel + 0.5);
                }
            }
            if to.is_infinite() {
                return End::Never;
            }
            let axis = usize::from(next[1] < next[0]);
            texel[axis] += trend[axis].signum();
            from = to;
            if texel[axis] < 0.0 || texel[axis] >= side {
                return End::Left(from);
            }
        }
    }

    /// The unit normal of a texel's surface at its centre.
    fn normal(&self, scene: &Scene, cuboid: &Cuboid, texel: &Texel, at: DVec2) -> Option<DVec3> {
        let world = scene.world();
        match &world.shapes()[texel.shape as usize] {
            Shape::Mesh(mesh) => Some(mesh.face_normal(texel.face)),
            Shape::Rectangle(rectangle) => Some(rectangle.normal()),
            Shape::Disk(disk) => Some(disk.normal()),
            Shape::Sphere(_) | Shape::Cylinder(_) => {
                let ray = world_ray(cuboid, self.view.ray(at));
                let mut counters = TraversalCounters::default();
                let hit = world.hit_on(texel.shape, &ray, &mut counters)?;
                Some(world.bounce_point(&ray, &hit).geometric_normal)
            }
        }
    }
}

fn world_ray(cuboid: &Cuboid, [origin, direction]: [DVec3; 2]) -> Ray {
    Ray::new(
        cuboid.to_world(origin),
        cuboid.frame().to_world(direction).normalize(),
    )
}

/// Draws what is outside a face.
fn picture(scene: &Scene, cuboid: &Cuboid, view: View, work: &mut Work) -> Picture {
    let items = items(scene, cuboid, &view);
    work.triangles += items.len() as u64;
    let texels = (view.side * view.side) as u64;
    work.texels += texels;
    work.bytes += texels * TEXEL_BYTES;
    let nearness = |fragment: &Fragment| match fragment.value {
        Some(value) if view.is_parallel => Some(1.0 / value),
        Some(value) => Some(value),
        None => {
            let ray = world_ray(cuboid, view.ray(fragment.at));
            let mut counters = TraversalCounters::default();
            let hit = scene.world().hit_on(fragment.shape, &ray, &mut counters)?;
            Some(1.0 / view.place(cuboid.to_local(ray.at(hit.distance))).z)
        }
    };
    let texels = draw(view.side, &items, |kept: &mut Texel, fragment| {
        if let Some(nearness) = nearness(fragment).map(|it| it as f32)
            && nearness > kept.nearness
        {
            *kept = Texel {
                nearness,
                shape: fragment.shape,
                face: fragment.face,
            };
        }
    });
    Picture { view, texels }
}

/// What is drawn: surfaces beyond a face that neither mirror nor refract, cut at the face's plane.
fn items(scene: &Scene, cuboid: &Cuboid, view: &View) -> Vec<Item> {
    let mut items = Vec::new();
    for (shape, form) in (0_u32..).zip(scene.world().shapes()) {
        let material = scene.material_of(shape);
        if material.is_passed(scene.materials()) || material.is_specular(scene.materials()) {
            continue;
        }
        let place = |point: DVec3| view.place(cuboid.to_local(point));
        let corners = form.bounds().corners().map(place);
        if corners.iter().all(|corner| corner.z < view.near) {
            continue;
        }
        let mut triangle = |face: u32, corners: [DVec3; 3]| {
            for corners in cut(corners, view.near) {
                let values = corners.map(|corner| {
                    if view.is_parallel {
                        corner.z
                    } else {
                        1.0 / corner.z
                    }
                });
                let form = Form::Triangle {
                    face,
                    corners: corners.map(|corner| view.image(corner)),
                    values,
                };
                items.push(Item { shape, form });
            }
        };
        match form {
            Shape::Mesh(mesh) => {
                for face in 0..mesh.triangle_count() as u32 {
                    triangle(face, mesh.corners(face).map(place));
                }
            }
            Shape::Rectangle(rectangle) => {
                let [a, b, c, d] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
                    .map(|uv| place(rectangle.point(DVec2::from_array(uv))));
                triangle(0, [a, b, c]);
                triangle(0, [a, c, d]);
            }
            Shape::Sphere(_) | Shape::Disk(_) | Shape::Cylinder(_) => {
                let is_ahead = corners.iter().all(|corner| corner.z >= view.near);
                let (mut low, mut high) = (DVec2::ZERO, DVec2::splat(view.side as f64));
                if is_ahead {
                    let images = corners.map(|corner| view.image(corner));
                    low = images.iter().fold(DVec2::INFINITY, |a, b| a.min(*b));
                    high = images.iter().fold(DVec2::NEG_INFINITY, |a, b| a.max(*b));
                }
                let form = Form::Sampled { low, high };
                items.push(Item { shape, form });
            }
        }
    }
    items
}

/// The part of a triangle beyond a depth, as up to two triangles.
fn cut(corners: [DVec3; 3], near: f64) -> Vec<[DVec3; 3]> {
    let mut kept: Vec<DVec3> = Vec::with_capacity(4);
    for index in 0..3 {
        let (a, b) = (corners[index], corners[(index + 1) % 3]);
        if a.z >= near {
            kept.push(a);
        }
        if (a.z >= near) != (b.z >= near) {
            kept.push(a + (b - a) * ((near - a.z) / (b.z - a.z)));
        }
    }
    match kept.as_slice() {
        [a, b, c] => vec![[*a, *b, *c]],
        [a, b, c, d] => vec![[*a, *b, *c], [*a, *c, *d]],
        _ => Vec::new(),
    }
}
