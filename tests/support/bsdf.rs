//! A bsdf at a point of a scene.

use std::path::Path;

use glam::{DVec2, DVec3};
use nephroid::internals::geometry::{Hit, Ray, SurfacePoint};
use nephroid::internals::mitsuba::load;
use nephroid::internals::numeric::quadrature::GaussLegendre;
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::bsdf::Bsdf;
use tempfile::TempDir;

/// The folder of the oracles' scripts, answers and images.
pub fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mitsuba")
}

/// A scene and a point in it.
pub struct Surface {
    pub scene: Scene,
    pub hit: Hit,
    pub point: SurfacePoint,
}

impl Surface {
    /// The square [-1, 1]² with normal +z at these surface parameters.
    pub fn square(bsdf: &str, uv: DVec2) -> Self {
        let origin = (uv * 2.0 - 1.0).extend(1.0);
        Self::of(
            &format!("<shape type=\"rectangle\">{bsdf}</shape>"),
            Ray::new(origin, -DVec3::Z),
        )
    }

    /// The point of a shape that a ray meets.
    pub fn of(shape: &str, ray: Ray) -> Self {
        let scene = scene(shape);
        let hit = scene
            .world()
            .closest_hit(&ray, f64::INFINITY, &mut Default::default())
            .expect("the ray meets the shape");
        let point = scene.world().surface_point(&ray, &hit);
        Self { scene, hit, point }
    }

    pub fn bsdf(&self) -> Bsdf<'_> {
        Bsdf::at(&self.scene, &self.hit, &self.point)
    }
}

/// A scene of these elements; images are looked for beside the oracles.
pub fn scene(elements: &str) -> Scene {
    let temporary = TempDir::new().unwrap();
    let path = temporary.path().join("scene.xml");
    let folder = folder();
    let xml = format!(
        "<scene version=\"3.0.0\"><path value=\"{}\"/>{elements}</scene>",
        folder.display()
    );
    std::fs::write(&path, xml).unwrap();
    load(&path, &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// The unit vector at angles in degrees from +z and, about it, from +x.
pub fn direction(theta: f64, phi: f64) -> DVec3 {
    let (theta, phi) = (theta.to_radians(), phi.to_radians());
    DVec3::new(
        theta.sin() * phi.cos(),
        theta.sin() * phi.sin(),
        theta.cos(),
    )
}

/// All bsdfs that were compared with Mitsuba, each once.
pub fn bsdfs() -> Vec<String> {
    let text = std::fs::read_to_string(folder().join("bsdf_oracle.txt")).unwrap();
    let mut cases: Vec<String> = text
        .lines()
        .filter_map(|line| line.strip_prefix("case "))
        .map(str::to_owned)
        .collect();
    cases.sort();
    cases.dedup();
    cases
}

/// Bins of the sphere, even in θ and φ.
pub struct Bins {
    pub rows: usize,
    pub columns: usize,
}

impl Bins {
    /// The bin of a direction.
    pub fn of(&self, w: DVec3) -> usize {
        let theta = w.x.hypot(w.y).atan2(w.z);
        let row = (theta * std::f64::consts::FRAC_1_PI * self.rows as f64) as usize;
        let turn = w.y.atan2(w.x) / std::f64::consts::TAU;
        let column = ((turn - turn.floor()) * self.columns as f64) as usize;
        row.min(self.rows - 1) * self.columns + column.min(self.columns - 1)
    }

    /// The integral of `f` over each bin, by rules of 4² nodes on squares in (θ, φ): 16 a bin, which are
    /// quartered until a square and its quarters agree, or 8 times.
    pub fn integrals(&self, f: impl Fn(DVec3) -> f64, tolerance: f64) -> Vec<f64> {
        let rule = GaussLegendre::new(4).unwrap();
        let on_square = |[theta, phi]: [f64; 2], [dtheta, dphi]: [f64; 2]| {
            let mut sum = 0.0;
            for (theta, weight_theta) in rule.on(theta, theta + dtheta) {
                let (sin, cos) = theta.sin_cos();
                for (phi, weight_phi) in rule.on(phi, phi + dphi) {
                    let w = DVec3::new(sin * phi.cos(), sin * phi.sin(), cos);
                    sum += weight_theta * weight_phi * sin * f(w);
                }
            }
            sum
        };
        let size = [
            std::f64::consts::PI / (4 * self.rows) as f64,
            std::f64::consts::TAU / (4 * self.columns) as f64,
        ];
        let bin = |index: usize| -> f64 {
            let (row, column) = (index / self.columns, index % self.columns);
            let squares = (0..4).flat_map(|i| (0..4).map(move |j| (4 * row + i, 4 * column + j)));
            squares
                .map(|(i, j)| {
                    let corner = [i as f64 * size[0], j as f64 * size[1]];
                    let coarse = on_square(corner, size);
                    refined(&on_square, corner, size, coarse, tolerance / 16.0, 8)
                })
                .sum()
        };
        (0..self.rows * self.columns).map(bin).collect()
    }
}

fn refined(
    on_square: &impl Fn([f64; 2], [f64; 2]) -> f64,
    corner: [f64; 2],
    size: [f64; 2],
    coarse: f64,
    tolerance: f64,
    depth: u32,
) -> f64 {
    let half = size.map(|side| 0.5 * side);
    let quarters = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)].map(|(x, y)| {
        let corner = [corner[0] + x * half[0], corner[1] + y * half[1]];
        (corner, on_square(corner, half))
    });
    let fine: f64 = quarters.iter().map(|(_, value)| value).sum();
    if depth == 0 || (fine - coarse).abs() <= tolerance {
        return fine;
    }
    quarters
        .into_iter()
        .map(|(corner, value)| refined(on_square, corner, half, value, 0.5 * tolerance, depth - 1))
        .sum()
}
