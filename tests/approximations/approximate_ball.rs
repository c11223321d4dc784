//! A glass ball on the axis of a light, as image-space refraction sees it: in closed form, from the papers.
//!
//! All is in a plane through the axis: x away from it, y along it from the lamp on. Nothing here is taken from
//! the library.

use std::f64::consts::PI;

use glam::DVec2;

/// A ball of radius 1 about (0, `distance`), and a floor at y = `floor`; the lamp is at (0, 0).
#[derive(Clone, Copy, Debug)]
pub struct ApproximateBall {
    pub distance: f64,
    pub floor: f64,
    /// Index of the glass.
    pub eta: f64,
    /// Whether d̃ is `d_V` alone.
    pub by_view: bool,
}

/// A ray through the ball.
#[derive(Clone, Copy, Debug)]
pub struct Through {
    /// Angle of incidence at the front.
    pub incidence: f64,
    /// Cosine of the angle of incidence at the approximate exit, inside.
    pub cos_exit: f64,
    /// How far from the axis it meets the floor; `None` where the exit reflects it totally.
    pub radius: Option<f64>,
}

/// The scene of the tests: a lamp 4 above the floor, the ball's centre 1.4 above it.
pub const BALL: ApproximateBall = ApproximateBall {
    distance: 2.6,
    floor: 4.0,
    eta: 1.5,
    by_view: false,
};

impl ApproximateBall {
    /// The slope of the ray that touches the ball.
    pub fn edge(&self) -> f64 {
        (1.0 / self.distance).asin().tan()
    }

    /// Where the lamp's ray of a slope leaves the ball: the back face of its pixel.
    fn back(&self, slope: f64) -> Option<DVec2> {
        let ray = DVec2::new(slope, 1.0).normalize();
        let closest = self.distance * ray.y;
        let inside = 1.0 - (self.distance * ray.x).powi(2);
        (inside >= 0.0).then(|| ray * (closest + inside.sqrt()))
    }

    /// The ray that leaves the lamp with a slope (the tangent of its angle). The normal at the approximate exit
    /// is that of the back face at the slope `pixel(slope of the exit)`. `None` beside the ball, and where the
    /// picture has no back face.
    pub fn trace(&self, slope: f64, pixel: impl Fn(f64) -> f64) -> Option<Through> {
        let center = DVec2::new(0.0, self.distance);
        let view = DVec2::new(slope, 1.0).normalize();
        let exit_by_view = self.back(slope)?;
        let across = self.distance * view.x;
        let incidence = across.asin();
        let front = view * (self.distance * view.y - (1.0 - across * across).sqrt());
        let normal = front - center;
        // Snell's law, with the tangent on the side of the ray.
        let refracted = (incidence.sin() / self.eta).asin();
        let tangent = (view - normal * view.dot(normal)).normalize_or_zero();
        let inside = tangent * refracted.sin() - normal * refracted.cos();
        let along_view = exit_by_view.distance(front);
        // The diameter.
        let along_normal = 2.0;
        let share = if incidence > 0.0 {
            refracted / incidence
        } else {
            1.0 / self.eta
        };
        let thickness = if self.by_view {
            along_view
        } else {
            share * along_view + (1.0 - share) * along_normal
        };
        let exit = front + inside * thickness;
        let outward = self.back(pixel(exit.x / exit.y))? - center;
        let cos_exit = inside.dot(outward);
        let sine = self.eta * (1.0 - cos_exit * cos_exit).sqrt();
        let radius = (sine < 1.0).then(|| {
            let tangent = (inside - outward * cos_exit).normalize_or_zero();
            let outside = tangent * sine + outward * (1.0 - sine * sine).sqrt();
            exit.x + outside.x / outside.y * (self.floor - exit.y)
        });
        Some(Through {
            incidence,
            cos_exit,
            radius,
        })
    }

    /// The slope from which on the approximate exit reflects totally, by bisection; a real ball never does.
    pub fn false_total_reflection(&self) -> f64 {
        let is_total = |slope| {
            self.trace(slope, |seen| seen)
                .is_some_and(|ray| ray.radius.is_none())
        };
        let (mut low, mut high) = (0.0, self.edge() * (1.0 - 1e-9));
        assert!(is_total(high) && !is_total(low));
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if is_total(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    }

    /// ∫ 2π u w(u) du over slopes u from 0 to `last`, w being a flux by area of the plane at distance 1: by
    /// the midpoint rule.
    pub fn integral(&self, last: f64, by_area: impl Fn(f64, &Through) -> f64) -> f64 {
        const PARTS: u32 = 200_000;
        let step = last / f64::from(PARTS);
        (0..PARTS)
            .filter_map(|index| {
                let slope = (f64::from(index) + 0.5) * step;
                let ray = self.trace(slope, |seen| seen)?;
                Some(2.0 * PI * slope * step * by_area(slope, &ray))
            })
            .sum()
    }
}

/// Solid angle by area of the plane at distance 1, at a slope.
pub fn solid_angle(slope: f64) -> f64 {
    (1.0 + slope * slope).powf(-1.5)
}

/// Fresnel's reflectance of unpolarised light; `eta` is n_transmitted / n_incident.
pub fn fresnel(cos_i: f64, eta: f64) -> f64 {
    let sin_t = (1.0 - cos_i * cos_i).sqrt() / eta;
    if sin_t >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin_t * sin_t).sqrt();
    let s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    let p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    0.5 * (s * s + p * p)
}

/// Schlick's reflectance (1994), with the angle on the less dense side.
pub fn schlick(cos_i: f64, eta: f64) -> f64 {
    let normal = ((eta - 1.0) / (eta + 1.0)).powi(2);
    let cos = if eta < 1.0 {
        let sin_t = (1.0 - cos_i * cos_i).sqrt() / eta;
        (1.0 - sin_t * sin_t).max(0.0).sqrt()
    } else {
        cos_i
    };
    let x = 1.0 - cos;
    normal + (1.0 - normal) * x * x * x * x * x
}
