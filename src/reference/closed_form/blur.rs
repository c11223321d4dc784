//! Uncertainty of beams in a solid whose corners are not quite in their facets' planes.

/// First-order uncertainty of a beam in a solid whose facets are flat but for a `bulge` (m) and a `tilt`
/// (rad).
///
/// A file's `f32` coordinates put the four or more corners of a facet beside one plane. Each of its triangles
/// then has a plane of its own. The beam of the whole facet is that of its triangles but for this blur.
/// Slivers of beams no wider than the shift, which a neighbouring facet gets instead where it had nothing,
/// are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Blur {
    /// Distance (m) by which the corners may be off.
    pub(super) shift: f64,
    /// Angle (rad) by which the direction may be off.
    turn: f64,
    /// Relative error of the irradiance.
    pub(super) relative: f64,
}

/// One way of light at a facet.
pub(super) struct FacetEvent<'a> {
    /// Cosine of the incident light to the normal.
    pub(super) cos: f64,
    /// Angle (rad) of the facet's triangles to its plane.
    pub(super) tilt: f64,
    /// Irradiance afterwards over that before, by the cosine of incidence.
    pub(super) part: &'a dyn Fn(f64) -> f64,
}

impl Blur {
    /// Blur on a facet or plane that the beam meets after `distance` (m), at the cosine `cos` to its normal.
    pub(super) fn landed(self, distance: f64, bulge: f64, cos: f64) -> Self {
        Self {
            shift: (self.shift + self.turn * distance + bulge) / cos,
            ..self
        }
    }

    /// Blur after a reflection: a mirror turned by the tilt turns light by twice that.
    pub(super) fn reflected(self, event: &FacetEvent) -> Self {
        Self {
            turn: self.turn + 2.0 * event.tilt,
            relative: self.relative + self.change(event),
            ..self
        }
    }

    /// Blur after a refraction d' = η d + (η c − c') n with c' = √(1 − η² (1 − c²)).
    ///
    /// In the plane of incidence a turn of d grows by η c/c', across it by η. A turn ε of n adds
    /// ε (|η c − c'| + η s + η² c s/c').
    pub(super) fn refracted(self, event: &FacetEvent, ratio: f64, cos_out: f64) -> Self {
        let FacetEvent { cos, tilt, .. } = *event;
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let gain = ratio * (cos / cos_out).max(1.0);
        let by_tilt =
            (ratio * cos - cos_out).abs() + ratio * sin + ratio * ratio * cos * sin / cos_out;
        Self {
            turn: gain * self.turn + by_tilt * tilt,
            relative: self.relative + self.change(event),
            ..self
        }
    }

    /// Relative change of the part that goes one way as the incidence changes by all that is uncertain of it.
    fn change(&self, event: &FacetEvent) -> f64 {
        let at = (event.part)(event.cos);
        let angle = self.turn + event.tilt;
        if at == 0.0 || angle == 0.0 {
            return 0.0;
        }
        let sin = (1.0 - event.cos * event.cos).max(0.0).sqrt();
        let delta = angle * (sin + angle);
        [event.cos - delta, event.cos + delta]
            .map(|cos| ((event.part)(cos.clamp(1e-12, 1.0)) / at - 1.0).abs())
            .into_iter()
            .fold(0.0, f64::max)
    }
}
