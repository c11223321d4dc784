//! Parts of Disney's principled materials, thick and thin.
//!
//! B. Burley, "Physically-Based Shading at Disney" (SIGGRAPH 2012 course) and "Extending the Disney BRDF to a
//! BSDF with Integrated Subsurface Scattering" (2015), with the choices of Mitsuba 3.9.1.

use crate::radiometry::Rgb;
use crate::scene::luminance;

/// The roughness α of an interface along both tangents (Burley 2012, 5.4).
pub(super) fn alphas(roughness: f64, anisotropic: f64) -> [f64; 2] {
    let aspect = (1.0 - 0.9 * anisotropic).sqrt();
    let alpha = roughness * roughness;
    [alpha / aspect, alpha * aspect].map(|alpha| alpha.max(0.001))
}

/// A colour with luminance 1; white for black.
pub(super) fn hue(color: Rgb) -> Rgb {
    let luminance = luminance(color);
    if luminance > 0.0 {
        color / luminance
    } else {
        Rgb::WHITE
    }
}

/// (1 − cos θ)⁵.
pub(super) fn schlick_weight(cos: f64) -> f64 {
    let m = (1.0 - cos).clamp(0.0, 1.0);
    m * m * m * m * m
}

/// Schlick's reflectance of an interface seen from the front: by the angle inside if that is the larger one.
pub(super) fn schlick(r0: f64, cos: f64, eta: f64) -> f64 {
    let weight = if eta > 1.0 {
        schlick_weight(cos)
    } else {
        let squared = 1.0 - (1.0 - cos * cos) / (eta * eta);
        schlick_weight(squared.max(0.0).sqrt())
    };
    r0 + (1.0 - r0) * weight
}

/// Schlick's reflectance with the hue of a base, from that of the index at normal incidence.
pub(super) fn tinted(base_color: Rgb, cos: f64, eta: f64) -> Rgb {
    let amplitude = (eta - 1.0) / (eta + 1.0);
    let normal = amplitude * amplitude;
    hue(base_color).map(|hue| schlick(hue * normal, cos, eta))
}

/// The matt part's f by that of a Lambertian one: its edge, light sent back, and the flat look of light that
/// entered.
///
/// `cos_d` is that between a direction and the half vector.
pub(super) fn matt_shape(
    [cos_i, cos_o]: [f64; 2],
    cos_d: f64,
    roughness: f64,
    flatness: f64,
) -> f64 {
    let [fi, fo] = [cos_i, cos_o].map(schlick_weight);
    let diffuse = (1.0 - 0.5 * fi) * (1.0 - 0.5 * fo);
    let rr = 2.0 * roughness * cos_d * cos_d;
    let retro = rr * (fo + fi + fo * fi * (rr - 1.0));
    let ss90 = 0.5 * rr;
    let ss = (1.0 + (ss90 - 1.0) * fo) * (1.0 + (ss90 - 1.0) * fi);
    let flat = 1.25 * (ss * (1.0 / (cos_o + cos_i) - 0.5) + 0.5);
    diffuse + retro + (flat - diffuse - retro) * flatness
}

/// The glow at grazing angles: its f, from white to the base's hue.
pub(super) fn sheen(base_color: Rgb, tint: f64, strength: f64, cos_d: f64) -> Rgb {
    let tint = Rgb::WHITE + (hue(base_color) - Rgb::WHITE) * tint;
    tint * (strength * schlick_weight(cos_d.abs()))
}
