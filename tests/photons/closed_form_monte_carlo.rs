//! The closed forms agree with plain Monte Carlo in three dimensions.
//!
//! The tracers here know nothing of the symmetries that the closed forms use: they follow random rays through
//! a sphere, a cylinder and half spaces. Every texel's estimate must lie within `BOUND` of its own standard
//! errors; the rays are the same on every run.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use nephroid::internals::generate::{BrilliantCut, round_brilliant};
use nephroid::internals::optics::{dielectric_reflectance, reflect, refract};
use nephroid::internals::reference::closed_form::{
    AxialLight, CupLight, FlatFacets, GlassBall, KnownPath, MirrorCup, ParallelLight,
    PlanoConvexLens, SineWater, SineWave, TexelGrid,
};

use crate::random::Random;

/// Some 2,000 texels are compared a test: a normal deviate exceeds 5 in none of them but once in 900 runs.
const BOUND: f64 = 5.0;

/// Texels with fewer deposits have no reliable standard error of their own: they are compared as one.
const FEWEST: u32 = 40;

/// A point of a disc about the origin.
fn in_disc(random: &mut Random, radius: f64) -> DVec2 {
    let r = radius * random.uniform().sqrt();
    DVec2::from_angle(TAU * random.uniform()) * r
}

/// Sums of deposits over a grid on the plane z = 0.
struct Tally {
    grid: TexelGrid,
    sum: Vec<f64>,
    sum_of_squares: Vec<f64>,
    count: Vec<u32>,
}

impl Tally {
    fn new(grid: TexelGrid) -> Self {
        let texels = grid.columns * grid.rows;
        Self {
            grid,
            sum: vec![0.0; texels],
            sum_of_squares: vec![0.0; texels],
            count: vec![0; texels],
        }
    }

    fn deposit(&mut self, origin: DVec3, direction: DVec3, flux: f64) {
        if direction.z >= 0.0 {
            return;
        }
        let point = (origin - direction * (origin.z / direction.z)).truncate();
        let place = (point - self.grid.bounds.min) / (self.grid.bounds.max - self.grid.bounds.min);
        if place.min_element() < 0.0 || place.max_element() >= 1.0 {
            return;
        }
        let column = (place.x * self.grid.columns as f64) as usize;
        let row = (place.y * self.grid.rows as f64) as usize;
        let i = row * self.grid.columns + column;
        self.sum[i] += flux;
        self.sum_of_squares[i] += flux * flux;
        self.count[i] += 1;
    }

    /// Asserts that the means over `rays` are the irradiances `exact`; returns how many texels had enough
    /// deposits.
    ///
    /// `ray_flux` is what one ray carries at most.
    fn assert_agrees(&self, what: &str, rays: u32, ray_flux: f64, exact: &[f64]) -> usize {
        let n = f64::from(rays);
        let area = self.grid.texel(0, 0).area();
        let assert_near = |name: &str, sum: f64, sum_of_squares: f64, exact: f64| {
            let mean = sum / n;
            let error = ((sum_of_squares / n - mean * mean) / n).sqrt();
            let deviation = (mean - exact * area).abs();
            assert!(
                deviation <= BOUND * error,
                "{what}, {name}: {mean} ± {error}, exact {}",
                exact * area
            );
        };
        let mut compared = 0;
        // The rest counts one deposit more than found, so that rare light cannot have an error of 0.
        let (mut rest, mut rest_squares, mut rest_exact) = (0.0, ray_flux * ray_flux, 0.0);
        for (i, &exact) in exact.iter().enumerate() {
            if self.count[i] >= FEWEST {
                assert_near(
                    &format!("texel {i}"),
                    self.sum[i],
                    self.sum_of_squares[i],
                    exact,
                );
                compared += 1;
            } else {
                rest += self.sum[i];
                rest_squares += self.sum_of_squares[i];
                rest_exact += exact;
            }
        }
        assert_near("the rest", rest, rest_squares, rest_exact);
        compared
    }
}

/// The distance to the sphere's surface, from outside the nearer one, from on it the farther one.
fn through_sphere(
    origin: DVec3,
    direction: DVec3,
    center: DVec3,
    radius: f64,
    far: bool,
) -> Option<f64> {
    let offset = origin - center;
    let b = offset.dot(direction);
    let root = (b * b - offset.length_squared() + radius * radius).sqrt();
    (root >= 0.0).then_some(if far { -b + root } else { -b - root })
}

#[test]
fn a_glass_balls_layers_agree_with_random_rays() {
    let ball = GlassBall::SHIPPED;
    let grid = TexelGrid::square(2.0, 32);
    let fine = TexelGrid::square(0.4, 32);
    let rays = 1_000_000;
    let paths = [
        KnownPath::Reflected(1),
        KnownPath::Through(0),
        KnownPath::Through(1),
        KnownPath::Through(2),
    ];
    let mut tallies: Vec<(KnownPath, Tally)> =
        paths.iter().map(|&path| (path, Tally::new(grid))).collect();
    tallies.push((KnownPath::Through(0), Tally::new(fine)));
    let mut random = Random(1);
    let (lamp, center) = (DVec3::new(0.0, 0.0, 4.0), DVec3::new(0.0, 0.0, 1.4));
    let lowest_cos = (1.0 - 1.0 / 2.6_f64.powi(2)).sqrt();
    for _ in 0..rays {
        let cos = 1.0 - random.uniform() * (1.0 - lowest_cos);
        let side = DVec2::from_angle(TAU * random.uniform()) * ((1.0 - cos) * (1.0 + cos)).sqrt();
        let direction = side.extend(-cos);
        let flux = 100.0 * TAU * (1.0 - lowest_cos);
        let Some(distance) = through_sphere(lamp, direction, center, 1.0, false) else {
            continue;
        };
        let mut point = lamp + direction * distance;
        let mut deposit = |path: KnownPath, point: DVec3, direction: DVec3, flux: f64| {
            for (_, tally) in tallies.iter_mut().filter(|(of, _)| *of == path) {
                tally.deposit(point, direction, flux);
            }
        };
        let normal = point - center;
        let reflectance = dielectric_reflectance(-direction.dot(normal), 1.5);
        deposit(
            KnownPath::Reflected(1),
            point,
            reflect(direction, normal),
            flux * reflectance,
        );
        let mut inside = refract(direction, normal, 1.5).unwrap();
        let mut flux = flux * (1.0 - reflectance);
        for k in 0..3 {
            point += inside * through_sphere(point, inside, center, 1.0, true).unwrap();
            let normal = point - center;
            let reflectance = dielectric_reflectance(inside.dot(normal), 1.0 / 1.5);
            if let Some(outside) = refract(inside, -normal, 1.0 / 1.5) {
                deposit(
                    KnownPath::Through(k),
                    point,
                    outside,
                    flux * (1.0 - reflectance),
                );
            }
            inside = reflect(inside, normal);
            flux *= reflectance;
        }
    }
    let mut compared = 0;
    for (path, tally) in &tallies {
        compared += tally.assert_agrees(
            &path.signature(),
            rays,
            ball.intercepted_flux(),
            &ball.sheet(*path).map(&tally.grid),
        );
    }
    assert!(compared > 1500, "{compared}");
}

/// A random ray through a cup's opening: where it crosses it, its direction and its flux.
///
/// Uniform over the opening, or over the directions of a lamp so near that it would light the opening
/// unevenly.
fn into_the_cup(cup: &MirrorCup, random: &mut Random) -> Option<(DVec3, DVec3, f64)> {
    let crossing = in_disc(random, cup.radius).extend(cup.height);
    let area = PI * cup.radius * cup.radius;
    match cup.light {
        CupLight::Parallel {
            tan_angle,
            irradiance,
        } => {
            let direction = DVec3::new(tan_angle, 0.0, -1.0).normalize();
            Some((crossing, direction, irradiance * -direction.z * area))
        }
        CupLight::Point {
            distance,
            height,
            intensity,
        } if distance > cup.radius => {
            let way = crossing - DVec3::new(-distance, 0.0, height);
            let direction = way.normalize();
            Some((
                crossing,
                direction,
                intensity * -direction.z / way.length_squared() * area,
            ))
        }
        CupLight::Point {
            distance,
            height,
            intensity,
        } => {
            let cos = random.uniform();
            let side =
                DVec2::from_angle(TAU * random.uniform()) * ((1.0 - cos) * (1.0 + cos)).sqrt();
            let direction = side.extend(-cos);
            let crossing =
                DVec3::new(-distance, 0.0, height) + direction * ((height - cup.height) / cos);
            let enters = crossing.truncate().length() < cup.radius;
            enters.then_some((crossing, direction, TAU * intensity))
        }
    }
}

#[test]
fn mirror_cups_agree_with_random_rays() {
    let coffee = MirrorCup {
        radius: 0.04,
        height: 0.08,
        reflectance: 0.9,
        light: CupLight::Parallel {
            tan_angle: 0.6,
            irradiance: 1000.0,
        },
    };
    let point = |distance| CupLight::Point {
        distance,
        height: 0.01,
        intensity: 0.001,
    };
    let ring = |distance| MirrorCup {
        radius: 0.01,
        height: 0.006,
        reflectance: 0.9,
        light: point(distance),
    };
    for cup in [coffee, ring(0.01), ring(0.004), ring(0.03)] {
        let grid = TexelGrid::square(cup.radius, 24);
        let rays = 600_000;
        let mut tallies: Vec<Tally> = (1..4).map(|_| Tally::new(grid)).collect();
        let mut random = Random(2);
        for _ in 0..rays {
            let Some((mut origin, mut direction, mut flux)) = into_the_cup(&cup, &mut random)
            else {
                continue;
            };
            for reflections in 0..4 {
                // To the wall, seen from above.
                let (a, b) = (
                    direction.truncate().length_squared(),
                    origin.truncate().dot(direction.truncate()),
                );
                let c = origin.truncate().length_squared() - cup.radius * cup.radius;
                let to_wall = (-b + (b * b - a * c).max(0.0).sqrt()) / a;
                if origin.z + to_wall * direction.z <= 0.0 {
                    if reflections > 0 {
                        tallies[reflections - 1].deposit(origin, direction, flux);
                    }
                    break;
                }
                origin += direction * to_wall;
                direction = reflect(direction, origin.with_z(0.0).normalize());
                flux *= cup.reflectance;
            }
        }
        for (tally, k) in tallies.iter().zip(1..) {
            tally.assert_agrees(
                &format!("{cup:?} {k}"),
                rays,
                4.0 * cup.entering_flux(),
                &cup.map(KnownPath::Reflected(k), &grid),
            );
        }
    }
}

#[test]
fn a_lens_agrees_with_random_rays() {
    let lens = PlanoConvexLens {
        curvature: 0.06,
        aperture: 0.05,
        flat_height: 0.06,
        ior: 1.5,
        light: AxialLight::Point {
            height: 0.56,
            intensity: 10.0,
        },
    };
    let grid = TexelGrid::square(0.024, 32);
    let rays = 1_000_000;
    let mut tally = Tally::new(grid);
    let mut random = Random(4);
    let lamp = DVec3::new(0.0, 0.0, 0.56);
    let center = DVec3::new(
        0.0,
        0.0,
        0.06 - (0.06_f64.powi(2) - 0.05_f64.powi(2)).sqrt(),
    );
    let widest = 0.5 / 0.5_f64.hypot(0.05);
    let flux = 10.0 * TAU * (1.0 - widest);
    for _ in 0..rays {
        let cos = 1.0 - random.uniform() * (1.0 - widest);
        let side = DVec2::from_angle(TAU * random.uniform()) * ((1.0 - cos) * (1.0 + cos)).sqrt();
        let direction = side.extend(-cos);
        let Some(distance) = through_sphere(lamp, direction, center, 0.06, false) else {
            continue;
        };
        let top = lamp + direction * distance;
        let normal = (top - center) / 0.06;
        let enter = 1.0 - dielectric_reflectance(-direction.dot(normal), 1.5);
        let inside = refract(direction, normal, 1.5).unwrap();
        let bottom = top + inside * ((0.06 - top.z) / inside.z);
        let leave = 1.0 - dielectric_reflectance(-inside.z, 1.0 / 1.5);
        if let Some(outside) = refract(inside, DVec3::Z, 1.0 / 1.5) {
            tally.deposit(bottom, outside, flux * enter * leave);
        }
    }
    let compared = tally.assert_agrees("LTTD", rays, flux, &lens.sheet().map(&grid));
    assert!(compared > 300, "{compared}");
}

#[test]
fn waves_agree_with_random_rays() {
    let wave = SineWave {
        depth: 0.8,
        amplitude: 0.04,
        wave_number: 12.0,
        phase: 0.4,
        ior: 1.33,
        irradiance: 1000.0,
        half_width: 1.0,
    };
    let grid = TexelGrid {
        bounds: nephroid::internals::reference::closed_form::TexelRect::new(-1.0, -0.5, 1.0, 0.5),
        columns: 400,
        rows: 1,
    };
    let rays = 1_000_000;
    let mut tally = Tally::new(grid);
    let mut random = Random(5);
    for _ in 0..rays {
        let (x, y) = (2.0 * random.uniform() - 1.0, random.uniform() - 0.5);
        let angle = wave.wave_number * x + wave.phase;
        let point = DVec3::new(x, y, wave.depth + wave.amplitude * angle.sin());
        let normal =
            DVec3::new(-wave.amplitude * wave.wave_number * angle.cos(), 0.0, 1.0).normalize();
        let transmitted = 1.0 - dielectric_reflectance(normal.z, wave.ior);
        let direction = refract(DVec3::NEG_Z, normal, wave.ior).unwrap();
        tally.deposit(point, direction, 1000.0 * 2.0 * transmitted);
    }
    let compared = tally.assert_agrees("LTD", rays, 2000.0, &SineWater::new(wave).map(&grid));
    assert!(compared > 380, "{compared}");
}

#[test]
fn a_cut_stone_agrees_with_random_rays() {
    let mut mesh = round_brilliant(1.0, BrilliantCut::TOLKOWSKY);
    // The pavilion up, tilted.
    let (sin, cos) = 2.9_f64.sin_cos();
    for position in &mut mesh.positions {
        let (x, z) = (position.x, position.z);
        *position = DVec3::new(cos * x + sin * z, position.y, cos * z - sin * x + 1.2);
    }
    let planes: Vec<(DVec3, f64)> = mesh
        .triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            let normal = (b - a).cross(c - a).normalize();
            (normal, normal.dot(a))
        })
        .collect();
    let light = ParallelLight {
        direction: DVec3::new(0.3, 0.1, -1.0).normalize(),
        irradiance: 1000.0,
    };
    let exact = FlatFacets::new(&mesh, 2.418, light, 3).unwrap();
    let grid = TexelGrid::square(2.0, 16);
    let rays = 2_000_000;
    let mut reflected = Tally::new(grid);
    let mut through: Vec<Tally> = (0..4).map(|_| Tally::new(grid)).collect();
    let mut random = Random(3);
    let (across, along) = light.direction.any_orthonormal_pair();
    let center = DVec3::new(0.0, 0.0, 1.2);
    let flux = 1000.0 * PI * 1.3 * 1.3;
    for _ in 0..rays {
        let start = in_disc(&mut random, 1.3);
        let origin = center + across * start.x + along * start.y - light.direction * 3.0;
        // Into the solid: the last plane entered before the first one left.
        let (mut enter, mut leave) = ((f64::NEG_INFINITY, DVec3::ZERO), f64::INFINITY);
        for &(normal, offset) in &planes {
            let slope = normal.dot(light.direction);
            let distance = (offset - normal.dot(origin)) / slope;
            if slope < 0.0 && distance > enter.0 {
                enter = (distance, normal);
            } else if slope > 0.0 {
                leave = leave.min(distance);
            }
        }
        if enter.0 >= leave {
            continue;
        }
        let mut point = origin + light.direction * enter.0;
        let reflectance = dielectric_reflectance(-light.direction.dot(enter.1), 2.418);
        if random.uniform() < reflectance {
            reflected.deposit(point, reflect(light.direction, enter.1), flux);
            continue;
        }
        let mut inside = refract(light.direction, enter.1, 2.418).unwrap();
        for tally in &mut through {
            let exits = planes.iter().filter(|(normal, _)| normal.dot(inside) > 0.0);
            let (distance, normal) = exits
                .map(|&(normal, offset)| {
                    ((offset - normal.dot(point)) / normal.dot(inside), normal)
                })
                .filter(|(distance, _)| *distance > 1e-9)
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .unwrap();
            point += inside * distance;
            let reflectance = dielectric_reflectance(inside.dot(normal), 1.0 / 2.418);
            if random.uniform() >= reflectance {
                tally.deposit(point, refract(inside, -normal, 1.0 / 2.418).unwrap(), flux);
                break;
            }
            inside = reflect(inside, normal);
        }
    }
    let mut compared = reflected.assert_agrees(
        "LRD",
        rays,
        flux,
        &exact.map(KnownPath::Reflected(1), &grid),
    );
    for (tally, k) in through.iter().zip(0..) {
        let path = KnownPath::Through(k);
        compared += tally.assert_agrees(&path.signature(), rays, flux, &exact.map(path, &grid));
    }
    assert!(compared > 100, "{compared}");
}
