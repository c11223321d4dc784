//! Derivatives of rays by the coordinates of the light: the geometry of a thin beam.

use glam::DVec3;

use super::dielectric::eta_cos_squared;

/// The derivative of a ray by one coordinate of the light it belongs to: metres (of `position`) and radians
/// (of `direction`) per unit of that coordinate.
///
/// Two of them describe a thin beam: its cross section, and how fast that spreads. The rules below carry them
/// along a path: exact derivatives of transfer, reflection and refraction after Igehy, *Tracing ray
/// differentials*, SIGGRAPH 1999, with the surface's curvature given as the derivative of its normal. The
/// curvature of the beam's wavefronts is implied (Mitchell and Hanrahan, *Illumination from curved
/// reflectors*, SIGGRAPH 1992). Nothing here is an approximation except for rounding.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayDerivative {
    /// ∂P: derivative of the point the ray starts at.
    pub position: DVec3,
    /// ∂D: derivative of the unit direction of travel, so at a right angle to it.
    pub direction: DVec3,
}

impl RayDerivative {
    /// The derivative carried along the ray to a surface: ∂P of the point at which it meets the surface.
    ///
    /// ∂P′ = ∂P + t ∂D + ∂t D, with ∂t = −(∂P + t ∂D)·N / (D·N) so that ∂P′ lies in the surface (Igehy, 10 to
    /// 12).
    ///
    /// - `direction`: D, the unit direction of travel.
    /// - `distance`: t from the ray's start to the surface.
    /// - `normal`: N, the surface's *true* unit normal there; its sign does not matter. For a ray along the
    ///   surface (D·N = 0) the result is not finite.
    #[inline]
    #[must_use]
    pub fn transferred(self, direction: DVec3, distance: f64, normal: DVec3) -> Self {
        let moved = self.position + self.direction * distance;
        let further = -moved.dot(normal) / direction.dot(normal);
        Self {
            position: moved + direction * further,
            direction: self.direction,
        }
    }

    /// The derivative after a mirror reflection, D′ = D − 2 (D·n) n.
    ///
    /// ∂D′ = ∂D − 2 (∂D·n + D·∂n) n − 2 (D·n) ∂n (Igehy, 15).
    ///
    /// - `normal`: n, the unit normal that reflects; only the sign of n and ∂n together is free.
    /// - `normal_derivative`: ∂n, as the point moves by `position`.
    #[inline]
    #[must_use]
    pub fn reflected(self, direction: DVec3, normal: DVec3, normal_derivative: DVec3) -> Self {
        let cos = direction.dot(normal);
        let cos_derivative = self.direction.dot(normal) + direction.dot(normal_derivative);
        Self {
            position: self.position,
            direction: self.direction - (normal * cos_derivative + normal_derivative * cos) * 2.0,
        }
    }

    /// The derivative after refraction, D′ = (D + (c − s) n) / η with c = −D·n and s = √((η−1)(η+1) + c²);
    /// `None` at and beyond the critical angle.
    ///
    /// ∂D′ = (∂D + (c − s) ∂n + (1 − c/s) ∂c n) / η, with ∂c = −∂D·n − D·∂n (Igehy, 17 to 19, for the formula
    /// of [`refract`](super::refract)). Unbounded towards the critical angle, at which s is 0.
    ///
    /// - `normal`: n, the unit normal that refracts, on the side light arrives from.
    /// - `normal_derivative`: ∂n, as the point moves by `position`.
    /// - `eta`: η = `n_transmitted / n_incident`.
    #[inline]
    pub fn refracted(
        self,
        direction: DVec3,
        normal: DVec3,
        normal_derivative: DVec3,
        eta: f64,
    ) -> Option<Self> {
        let cos = -direction.dot(normal);
        let squared = eta_cos_squared(cos, eta);
        if squared <= 0.0 {
            return None;
        }
        let root = squared.sqrt();
        let cos_derivative = -self.direction.dot(normal) - direction.dot(normal_derivative);
        // 1 − c/s is written so that nothing cancels for η near 1.
        let change = (eta - 1.0) * (eta + 1.0) / (root * (root + cos));
        Some(Self {
            position: self.position,
            direction: (self.direction
                - normal_derivative * ((eta - 1.0) * (eta + 1.0) / (root + cos))
                + normal * (change * cos_derivative))
                / eta,
        })
    }
}
