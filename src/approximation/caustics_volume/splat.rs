//! Stage `splat` (section 3.4): photons as discs on the surfaces where they land.
//!
//! A photon of a tile with n photons and the area A, whose way is `length` long, is a disc of the radius
//!
//! ```text
//! s = scale · clamp(√(A / (π n)), min, max) · clamp(length / longest, 0.1, 1)
//! ```
//!
//! stretched by min(1 / cos θ, 5) along the projection of its direction (Haines and Akenine-Möller, *Ray
//! Tracing Gems*, 2019, chapter 24, to which the paper refers). Its irradiance is Φ / (π s² stretch). Tiles
//! are squares of the projectors' pictures: of directions from the volume's middle.

use glam::{DVec2, DVec3};

use super::cuboid::{Cuboid, Face};
use super::photon::Landing;
use super::settings::Settings;
use crate::numeric::math;
use crate::radiometry::Rgb;

/// A photon as a disc or an ellipse on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Its middle.
    pub center: DVec3,
    /// Its unit normal.
    pub normal: DVec3,
    /// The reciprocals of its half axes, along them.
    across: [DVec3; 2],
    /// Half its height \[m\].
    height: f64,
    /// Its longer half axis \[m\].
    pub reach: f64,
    /// Irradiance of a point in it [W/m²].
    pub irradiance: Rgb,
}

/// The largest stretch along a grazing photon's direction.
const LONGEST_STRETCH: f64 = 5.0;

/// The least share of a splat's radius for photons with short ways.
const SHORTEST: f64 = 0.1;

impl Disc {
    /// A disc of some radius \[m\] at a landing.
    pub fn new(landing: &Landing, radius: f64, bias: f64) -> Self {
        let direction = landing.photon.ray.direction;
        let normal = landing.normal;
        let along = direction - normal * direction.dot(normal);
        let first = along
            .try_normalize()
            .unwrap_or_else(|| normal.any_orthonormal_vector());
        let second = normal.cross(first);
        let stretch = (1.0 / direction.dot(normal).abs()).min(LONGEST_STRETCH);
        Self {
            center: landing.position,
            normal,
            across: [first / (radius * stretch), second / radius],
            height: bias * radius,
            reach: radius * stretch,
            irradiance: landing.photon.flux / (std::f64::consts::PI * radius * radius * stretch),
        }
    }

    /// An ellipse at a landing: `first` is the unit direction of its first half axis, in the surface's plane;
    /// `half` are the lengths of both \[m\].
    pub fn elliptic(landing: &Landing, first: DVec3, [a, b]: [f64; 2], bias: f64) -> Self {
        let normal = landing.normal;
        Self {
            center: landing.position,
            normal,
            across: [first / a, normal.cross(first) / b],
            height: bias * a.min(b),
            reach: a.max(b),
            irradiance: landing.photon.flux / (std::f64::consts::PI * a * b),
        }
    }

    /// True if a point of a surface with this unit normal is in the disc.
    #[inline]
    pub fn holds(&self, point: DVec3, normal: DVec3) -> bool {
        let offset = point - self.center;
        let place = DVec2::new(offset.dot(self.across[0]), offset.dot(self.across[1]));
        place.length_squared() <= 1.0
            && offset.dot(self.normal).abs() <= self.height
            && normal.dot(self.normal) > 0.0
    }

    /// Half the sides of the box around it.
    pub fn half(&self) -> DVec3 {
        DVec3::splat(math::hypot(self.reach, self.height))
    }
}

/// The tile of a place, by its direction from the volume's middle; and a side of it there \[m\].
fn tile(cuboid: &Cuboid, settings: &Settings, position: DVec3) -> ([u32; 3], f64) {
    let size = cuboid.size();
    let half = DVec3::new(size.x, size.y, 0.5 * size.z);
    let local = cuboid.to_local(position) - DVec3::Z * half.z;
    let face = Face::along(local / half);
    let [(a, half_a), (b, half_b)] = Cuboid::face_axes(face, size);
    let near = (half * face.outward()).element_sum().abs();
    let depth = local.dot(face.outward()).max(f64::MIN_POSITIVE);
    let across = DVec2::new(local.dot(a) / half_a, local.dot(b) / half_b) * (near / depth);
    let texels = f64::from(settings.g_buffer);
    let index = |at: f64| {
        let texel = ((at + 1.0) * 0.5 * texels).clamp(0.0, texels - 1.0);
        (texel / f64::from(settings.tile)) as u32
    };
    let texel = 2.0 * (half_a * half_b).sqrt() / texels * (depth / near);
    (
        [face as u32, index(across.x), index(across.y)],
        texel * f64::from(settings.tile),
    )
}

/// The discs of photons that landed; `least` is the radius \[m\] below which points of the film would miss
/// them.
pub fn discs(cuboid: &Cuboid, settings: &Settings, landed: &[Landing], least: f64) -> Vec<Disc> {
    let side = settings.g_buffer.div_ceil(settings.tile) as usize;
    let mut counts = vec![0_u32; 6 * side * side];
    let places: Vec<(usize, f64)> = landed
        .iter()
        .map(|landing| {
            let ([face, x, y], length) = tile(cuboid, settings, landing.position);
            let index = (face as usize * side + y as usize) * side + x as usize;
            counts[index] += 1;
            (index, length)
        })
        .collect();
    let longest = landed.iter().map(Landing::length).fold(0.0, f64::max);
    let most = settings.splat_max * cuboid.diagonal();
    landed
        .iter()
        .zip(places)
        .map(|(landing, (index, side))| {
            let photons = f64::from(counts[index]);
            let by_density = side / (std::f64::consts::PI * photons).sqrt();
            let by_length = (landing.length() / longest).clamp(SHORTEST, 1.0);
            let bounded = by_density.max(settings.splat_min).min(most);
            let radius = (settings.splat_scale * bounded * by_length).max(least);
            Disc::new(landing, radius, settings.bias)
        })
        .collect()
}
