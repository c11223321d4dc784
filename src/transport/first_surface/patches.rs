//! Triangles of chart coordinates that hold all light that may meet a specular surface first.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec2, DVec3};

use super::chart::SurfaceChart;
use super::cone::Cone;
use super::fan::Fan;
use super::source::Source;
use super::triangle::{middles, quarters};
use crate::geometry::{Cylinder, Mesh, Ray, Shape, TraversalCounters, World};
use crate::numeric::math;
use crate::numeric::rotation;
use crate::scene::Scene;

/// A triangle of chart coordinates.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePatch {
    /// The chart whose coordinates they are.
    pub chart: SurfaceChart,
    /// The corners.
    pub corners: [DVec2; 3],
}

impl SurfacePatch {
    /// Its area in chart coordinates.
    pub fn area(&self) -> f64 {
        let [a, b, c] = self.corners;
        0.5 * (b - a).perp_dot(c - a).abs()
    }
}

/// Bands of incidence and sectors of azimuth that a ball's cap is divided into. A small number suffices, as
/// all of it is smooth, and a few hundred tasks keep threads busy.
const CAP_BANDS: u32 = 8;
const CAP_SECTORS: u32 = 16;

/// Part of an angle before grazing at which round surfaces end: at grazing, light would neither enter nor
/// miss. The light left out is (1e-9)² of the surface's.
const HAIR: f64 = 1e-9;

/// Largest angle of incidence on a ball.
const CAP_END: f64 = FRAC_PI_2 * (1.0 - HAIR);

/// Number of strips, each way, that analytic parameters are divided into.
const PARAMETER_STRIPS: u32 = 16;

/// Largest patch of a spot's light, in units of the cone's opening.
const LARGEST_IN_CONE: f64 = 0.25;

/// All light of `source` that may meet a specular surface before anything else. Obstacles on its way are not
/// looked for here.
pub fn patches(scene: &Scene, source: &Source) -> Vec<SurfacePatch> {
    let mut patches = Vec::new();
    for (index, shape) in scene.world().shapes().iter().enumerate() {
        let index = index as u32;
        if !scene.material_of(index).is_specular(scene.materials()) {
            continue;
        }
        let parameters = SurfaceChart::Parameters { shape: index };
        let unit = [DVec2::ZERO, DVec2::ONE];
        match shape {
            Shape::Sphere(ball) => {
                if let Some(cap) = SurfaceChart::cap(index, ball, source) {
                    let all = [DVec2::ZERO, DVec2::new(CAP_END, TAU)];
                    add_grid(&mut patches, cap, all, [CAP_BANDS, CAP_SECTORS]);
                } else {
                    add_grid(&mut patches, parameters, unit, [PARAMETER_STRIPS; 2]);
                }
            }
            Shape::Rectangle(_) | Shape::Disk(_) => {
                add_grid(&mut patches, parameters, unit, [PARAMETER_STRIPS; 2]);
            }
            Shape::Cylinder(cylinder) => {
                for [from, to] in lit_ranges(cylinder, source) {
                    let range = [DVec2::new(from, 0.0), DVec2::new(to, 1.0)];
                    add_grid(&mut patches, parameters, range, [PARAMETER_STRIPS; 2]);
                }
            }
            Shape::Mesh(mesh) => add_faces(&mut patches, scene, index, mesh, source),
        }
    }
    match source.origin() {
        Some(origin) => parted(scene, origin, Cone::of(source).as_ref(), patches),
        None => patches,
    }
}

/// The patches, divided until their corners tell how much light falls on them. Patches that are seen at a
/// wide angle are halved. Those that a spot's cone may reach are quartered to a quarter of the cone, so that
/// no cone passes between the nodes of any. Those that it cannot reach are left out.
fn parted(
    scene: &Scene,
    origin: DVec3,
    cone: Option<&Cone>,
    mut pending: Vec<SurfacePatch>,
) -> Vec<SurfacePatch> {
    let world = scene.world();
    let mut done = Vec::with_capacity(pending.len());
    pending.reverse();
    while let Some(SurfacePatch { chart, corners }) = pending.pop() {
        let fan = Fan::of_triangle(origin, world, &chart, corners);
        let overlap = cone.map(|cone| cone.overlap_of(&fan));
        if overlap.is_some_and(|overlap| !overlap.is_possible) {
            continue;
        }
        let patch = |corners| SurfacePatch { chart, corners };
        if overlap.is_some_and(|one| one.relative_size > LARGEST_IN_CONE) {
            pending.extend(quarters(corners, middles(corners)).map(patch));
        } else if fan.is_too_wide()
            && let Some(halves) = halves(world, origin, &chart, corners)
        {
            pending.extend(halves.map(patch));
        } else {
            done.push(patch(corners));
        }
    }
    done
}

/// A triangle's halves, through the middle of the edge that is seen at the widest angle. If coordinates are
/// stretched, as about a pole, only wide edges are divided. `None` if rounding leaves nothing to divide.
fn halves(
    world: &World,
    origin: DVec3,
    chart: &SurfaceChart,
    corners: [DVec2; 3],
) -> Option<[[DVec2; 3]; 2]> {
    let middles = middles(corners);
    let direction = |at: DVec2| {
        let place = chart.place(world, at);
        place.map_or(DVec3::ZERO, |it| {
            (it.point.position - origin).normalize_or_zero()
        })
    };
    let ends = corners.map(direction);
    let width = |edge: usize| {
        let middle = direction(middles[edge]);
        rotation::angle_between(ends[(edge + 1) % 3], middle)
            + rotation::angle_between(middle, ends[(edge + 2) % 3])
    };
    let widest = (0..3).max_by(|&a, &b| width(a).total_cmp(&width(b)))?;
    let [a, b, c] = [widest, widest + 1, widest + 2].map(|index| corners[index % 3]);
    let middle = middles[widest];
    (middle != b && middle != c).then_some([[a, b, middle], [a, middle, c]])
}

/// A rectangle of coordinates, cut into triangles.
fn add_grid(
    patches: &mut Vec<SurfacePatch>,
    chart: SurfaceChart,
    [from, to]: [DVec2; 2],
    [columns, rows]: [u32; 2],
) {
    let step = (to - from) / DVec2::new(f64::from(columns), f64::from(rows));
    let at = |column: u32, row: u32| {
        let place = |index: u32, count: u32, from: f64, to: f64, step: f64| {
            if index == count {
                to
            } else {
                from + f64::from(index) * step
            }
        };
        DVec2::new(
            place(column, columns, from.x, to.x, step.x),
            place(row, rows, from.y, to.y, step.y),
        )
    };
    for row in 0..rows {
        for column in 0..columns {
            let [a, b, c, d] = [
                at(column, row),
                at(column + 1, row),
                at(column + 1, row + 1),
                at(column, row + 1),
            ];
            for corners in [[a, b, c], [a, c, d]] {
                patches.push(SurfacePatch { chart, corners });
            }
        }
    }
}

/// The ranges of u = φ/2π in which the outside of a cylinder faces the source, and in which the inside does.
///
/// Across the axis, light from the distance d meets a circle of radius r. It meets the outside within
/// ±arccos(r/d) of the source's azimuth, the far inside beyond. If the source is within (d < r), all is
/// inside.
fn lit_ranges(cylinder: &Cylinder, source: &Source) -> Vec<[f64; 2]> {
    let towards = source.towards(cylinder.base());
    let across = towards - cylinder.axis() * towards.dot(cylinder.axis());
    let radial = |u: f64| {
        let axial = cylinder.base() + cylinder.axis() * (0.5 * cylinder.length());
        (cylinder.at_uv(DVec2::new(u, 0.5)).position - axial) / cylinder.radius()
    };
    let (x, y): (DVec3, DVec3) = (radial(0.0), radial(0.25));
    let radius_over_distance = if source.is_parallel() {
        0.0
    } else {
        cylinder.radius() / across.length()
    };
    // NaN: parallel light along the axis, or light from a point of it.
    if radius_over_distance >= 1.0 || across.length_squared() == 0.0 {
        return vec![[0.0, 1.0]];
    }
    let azimuth = math::atan2(across.dot(y), across.dot(x)) / TAU;
    let half = math::acos(radius_over_distance) / TAU;
    // As for a ball's cap: at grazing itself the last digit would tell inside from outside.
    let (outside, inside) = (half * (1.0 - HAIR), half * (1.0 + HAIR));
    vec![
        [azimuth - outside, azimuth + outside],
        [azimuth + inside, azimuth - inside + 1.0],
    ]
}

/// The patches of a mesh's faces, in an order that keeps near ones together: they share edges, and the
/// contents of caches. If a closed mesh is seen from outside, faces turned away are behind others and are
/// left out.
fn add_faces(
    patches: &mut Vec<SurfacePatch>,
    scene: &Scene,
    shape: u32,
    mesh: &Mesh,
    source: &Source,
) {
    let only_front = is_outside_closed(scene, shape, mesh, source);
    let corners = [DVec2::ZERO, DVec2::X, DVec2::Y];
    for face in mesh.faces_by_place() {
        let normal = mesh.face_normal(face);
        let facing = source.towards(mesh.corners(face)[0]).dot(normal);
        if facing > 0.0 || facing < 0.0 && !only_front {
            patches.push(SurfacePatch {
                chart: SurfaceChart::Face { shape, face },
                corners,
            });
        }
    }
}

/// True if the mesh is closed, its faces turned outward, and the source outside. Then each ray of the source
/// meets a face turned towards it first.
fn is_outside_closed(scene: &Scene, shape: u32, mesh: &Mesh, source: &Source) -> bool {
    let found = mesh.diagnose();
    if !found.is_closed() {
        return false;
    }
    let mut counters = TraversalCounters::default();
    // Any face in front of a surface that shines will do.
    let arrival = (0..mesh.triangle_count() as u32).find_map(|face| {
        let [a, b, c] = mesh.corners(face);
        source.arrive((a + b + c) / 3.0)
    });
    let Some(arrival) = arrival else {
        return false;
    };
    // The parity of crossings between the source and infinity: the first hit decides.
    let mut ray: Ray = arrival.ray;
    loop {
        let world = scene.world();
        let Some(hit) = world.closest_hit(&ray, f64::INFINITY, &mut counters) else {
            return false;
        };
        if hit.shape == shape {
            let cosine = mesh.face_normal(hit.face).dot(ray.direction);
            // A source on the mesh shines to both sides; rounding decides on which one a ray starts.
            let is_on = hit.distance * cosine.abs() <= mesh.position_error(hit.face).max_element();
            return cosine < 0.0 && !is_on;
        }
        let point = world.bounce_point(&ray, &hit);
        ray = point.spawn(ray.direction);
    }
}
