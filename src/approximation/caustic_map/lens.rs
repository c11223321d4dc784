//! How wide a photon's beam is when it meets the receiver, by lens equations (section 4.2).

/// A specular object as a photon meets it: two spherical interfaces, or one mirror, and distances.
///
/// Curvatures are those of the surface with its normal outward, positive where the object is convex: the
/// report's radii are `r_front` = 1/`front` and `r_back` = −1/`back`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// `1/d_front`, the light's distance [1/m]: 0 for parallel light.
    pub vergence: f64,
    /// Mean curvature where light enters [1/m].
    pub front: f64,
    /// Mean curvature where it leaves [1/m].
    pub back: f64,
    /// `n_in` / `n_out`.
    pub eta: f64,
    /// The distance between the two places \[m\].
    pub thickness: f64,
}

impl Lens {
    /// 1/f [1/m], of a thin lens: eq. 2, (`n_in` − `n_out)(1/r_front` − `1/r_back`) in units of `n_out`.
    pub fn power(&self) -> f64 {
        (self.eta - 1.0) * (self.front + self.back)
    }

    /// `D_new` / D₀ of a thin lens `background` (`d_bg`, \[m\]) before the receiver: eq. 7.
    ///
    /// With `1/d_image` = 1/f − `1/d_front` (eq. 1), the quotient (`d_bg` − `d_image`) / `d_image` is `d_bg`
    /// (1/f − `1/d_front`) − 1: written so, neither an image at infinity nor parallel light is special. The
    /// sign, which says whether the image is in between, is dropped.
    pub fn thin(&self, background: f64) -> f64 {
        let spread = background * (self.power() - self.vergence) - 1.0;
        spread.abs() / (1.0 + background * self.vergence)
    }

    /// `D_new` / D₀ of a thick lens: paraxial rays refracted at the two interfaces one after the other
    /// (Born and Wolf, *Principles of Optics*, 7th edition, 4.4).
    ///
    /// A ray at height 1 with slope `1/d_front` has the slope u₁ = (`1/d_front` − (η−1) front) / η inside,
    /// height y = 1 + thickness · u₁ at the back, and leaves with the slope η u₁ − (η−1) back · y.
    pub fn thick(&self, background: f64) -> f64 {
        let bend = self.eta - 1.0;
        let inside = (self.vergence - bend * self.front) / self.eta;
        let height = 1.0 + self.thickness * inside;
        let outside = self.eta * inside - bend * self.back * height;
        let unrefracted = 1.0 + (self.thickness + background) * self.vergence;
        (height + background * outside).abs() / unrefracted
    }

    /// `D_new` / D₀ beyond one interface, in whose medium the receiver is: a ray at height 1 goes on with the
    /// slope (`1/d_front` − (η−1) front) / η. The report has two interfaces; this is its equation for one.
    pub fn surface(&self, background: f64) -> f64 {
        let inside = (self.vergence - (self.eta - 1.0) * self.front) / self.eta;
        (1.0 + background * inside).abs() / (1.0 + background * self.vergence)
    }

    /// `D_new` / D₀ of a spherical mirror: eq. 7 with 1/f = −2 · curvature, positive curvature being convex.
    pub fn mirror(&self, background: f64) -> f64 {
        let spread = background * (-2.0 * self.front - self.vergence) - 1.0;
        spread.abs() / (1.0 + background * self.vergence)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equation_seven_in_its_printed_form() {
        // d_front = 3, r_front = 2, r_back = -4, n = 1.5: 1/f = 0.375, 1/d_image = 1/24.
        let lens = Lens {
            vergence: 1.0 / 3.0,
            front: 0.5,
            back: 0.25,
            eta: 1.5,
            thickness: 0.0,
        };
        let (front, image, background) = (3.0, 24.0_f64, 5.0);
        let printed: f64 = front / (front + background) * (background - image) / image;
        // A handful of roundings.
        assert!((lens.thin(background) - printed.abs()).abs() < 8.0 * f64::EPSILON);
        assert!((lens.thick(background) - printed.abs()).abs() < 8.0 * f64::EPSILON);
    }

    #[test]
    fn light_focused_on_the_receiver_has_no_width() {
        let lens = Lens {
            vergence: 0.0,
            front: 1.0,
            back: 1.0,
            eta: 1.5,
            thickness: 0.0,
        };
        assert!(lens.thin(1.0) < 4.0 * f64::EPSILON);
        // A ball focuses parallel light n R / (2 (n − 1)) from its centre: R/2 behind its back.
        let ball = Lens {
            thickness: 2.0,
            ..lens
        };
        assert!(ball.thick(0.5) < 4.0 * f64::EPSILON);
    }
}
