//! Meshes made on the spot, and repeatable random numbers.

use std::collections::HashMap;

use glam::DVec3;
use nephroid::internals::geometry::{Hit, Mesh, MeshParts, Ray, Shape, TraversalCounters, World};

/// Repeatable random numbers: Steele, Lea and Flood's SplitMix64 (OOPSLA 2014).
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in 0..1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * 2f64.powi(-53)
    }

    /// Uniform in -1..1.
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    pub fn in_cube(&mut self) -> DVec3 {
        DVec3::new(self.signed(), self.signed(), self.signed())
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.in_cube();
            let squared = v.length_squared();
            if squared > 1e-4 && squared <= 1.0 {
                return v / squared.sqrt();
            }
        }
    }
}

/// A closed sphere of 20 · 4ⁿ triangles: an icosahedron, each triangle cut in four n times.
pub fn icosphere(subdivisions: u32) -> MeshParts {
    let phi = 0.5 * (1.0 + 5f64.sqrt());
    let mut positions = Vec::new();
    for a in [-1.0, 1.0] {
        for b in [-phi, phi] {
            positions.push(DVec3::new(0.0, a, b));
            positions.push(DVec3::new(a, b, 0.0));
            positions.push(DVec3::new(b, 0.0, a));
        }
    }
    let mut triangles = Vec::new();
    for i in 0..12u32 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let [a, b, c] = [i, j, k].map(|v| positions[v as usize]);
                let side = |p: DVec3, q: DVec3| (p.distance(q) - 2.0).abs() < 1e-9;
                if side(a, b) && side(b, c) && side(c, a) {
                    let outward = (b - a).cross(c - a).dot(a) > 0.0;
                    triangles.push(if outward { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    for position in &mut positions {
        *position = position.normalize();
    }
    for _ in 0..subdivisions {
        let mut middles = HashMap::new();
        let mut finer = Vec::with_capacity(4 * triangles.len());
        for [a, b, c] in triangles {
            let mut middle = |p: u32, q: u32| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    positions.push((positions[p as usize] + positions[q as usize]).normalize());
                    positions.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    MeshParts {
        positions,
        triangles,
        ..MeshParts::default()
    }
}

/// A closed torus with bumps, of 2 · `around` · `across` triangles; not convex.
pub fn bumpy_torus(around: u32, across: u32) -> MeshParts {
    let turn = std::f64::consts::TAU;
    let mut positions = Vec::new();
    for i in 0..around {
        for j in 0..across {
            let (u, v) = (
                turn * f64::from(i) / f64::from(around),
                turn * f64::from(j) / f64::from(across),
            );
            let tube = 0.35 + 0.06 * (9.0 * u).sin() * (5.0 * v).cos() + 0.02 * (31.0 * u).cos();
            let reach = 1.0 + tube * v.cos();
            positions.push(DVec3::new(reach * u.cos(), reach * u.sin(), tube * v.sin()));
        }
    }
    let at = |i: u32, j: u32| (i % around) * across + j % across;
    let mut triangles = Vec::new();
    for i in 0..around {
        for j in 0..across {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    MeshParts {
        positions,
        triangles,
        ..MeshParts::default()
    }
}

/// The same mesh, scaled and moved.
pub fn placed(mut parts: MeshParts, scale: f64, offset: DVec3) -> MeshParts {
    for position in &mut parts.positions {
        *position = *position * scale + offset;
    }
    parts
}

pub fn mesh(parts: MeshParts) -> Mesh {
    Mesh::new(parts).expect("a generated mesh is valid")
}

pub fn world_of(parts: MeshParts) -> World {
    World::new(vec![Shape::Mesh(mesh(parts))])
}

/// The nearest hit; the shared way of asking.
pub fn closest(world: &World, ray: &Ray) -> Option<Hit> {
    world.closest_hit(ray, f64::INFINITY, &mut TraversalCounters::default())
}

/// A place well inside [`bumpy_torus`], from one of the cube [-1, 1]³: within 0.22 of the circle that is its
/// core, where its tube is at least 0.27 thick.
pub fn within_torus(place: DVec3) -> DVec3 {
    place.with_z(0.0).normalize_or(DVec3::X) + 0.125 * place
}

/// The same faces, each with three vertices of its own.
pub fn unshared(parts: &MeshParts) -> MeshParts {
    let corners = parts.triangles.iter().flatten();
    let positions: Vec<DVec3> = corners
        .map(|&vertex| parts.positions[vertex as usize])
        .collect();
    MeshParts {
        triangles: (0..parts.triangles.len() as u32)
            .map(|face| [3 * face, 3 * face + 1, 3 * face + 2])
            .collect(),
        positions,
        ..MeshParts::default()
    }
}

/// True if a search misses what a ray meets before `reach`: the search for the nearest hit, or the one for
/// any.
pub fn is_lost(world: &World, ray: &Ray, reach: f64) -> bool {
    let nearest = world.closest_hit(ray, reach, &mut TraversalCounters::default());
    let any = world.any_hit(ray, reach, |_| true, &mut TraversalCounters::default());
    nearest.is_none() || !any
}

/// A point on a vertex or an edge of a random face, at which a test that is not watertight leaks.
pub fn delicate_point(parts: &MeshParts, random: &mut Random) -> DVec3 {
    let triangle = parts.triangles[random.below(parts.triangles.len())];
    let first = random.below(3);
    let [a, b] = [first, (first + 1) % 3].map(|i| parts.positions[triangle[i] as usize]);
    match random.below(3) {
        0 => a,
        1 => a + (b - a) * 0.5,
        _ => a + (b - a) * random.unit(),
    }
}

/// Numbers of rays through delicate points of a closed mesh, by their fate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Leaks {
    /// Rays each way.
    pub rays: usize,
    /// From within, and met nothing.
    pub out: usize,
    /// From without, and met nothing before they were within.
    pub into: usize,
    /// From without, and the delicate point was what they met first.
    pub seen: usize,
}

/// Sends rays from places that `inside` gives (of the mesh as it was before it was placed) through delicate
/// points, and as many the other way.
///
/// A place outside and one inside have the surface between them, however concave it is and wherever its
/// silhouette: so a ray from without must meet it before it is within. It starts 3 to 3000 times `scale`
/// away, where solids of less than 1.5 have their outside, and passes its point and its place inside by some
/// u of that.
pub fn leaks(
    parts: &MeshParts,
    world: &World,
    (scale, middle): (f64, DVec3),
    rays: usize,
    inside: impl Fn(DVec3) -> DVec3,
) -> Leaks {
    let mut random = Random(7);
    let mut found = Leaks::default();
    while found.rays < rays {
        let start = middle + scale * inside(random.in_cube());
        let through = delicate_point(parts, &mut random) - start;
        let Some(direction) = through.try_normalize() else {
            continue;
        };
        found.rays += 1;
        let ray = Ray::new(start, direction);
        found.out += usize::from(is_lost(world, &ray, f64::INFINITY));
        let away = 3.0 * scale * 10f64.powf(3.0 * random.unit());
        let from = start + away * direction;
        let Some(back) = (start + through - from).try_normalize() else {
            continue;
        };
        let ray = Ray::new(from, back);
        found.into += usize::from(is_lost(world, &ray, away));
        // Some u of the way, of coordinates, and of what an edge seen at a low angle makes of both: far from
        // the next face.
        let to_it = away - through.length();
        found.seen += usize::from(
            closest(world, &ray).is_some_and(|hit| (hit.distance - to_it).abs() < 1e-6 * scale),
        );
    }
    found
}
