//! How wide a photon is drawn: what the variants of stage `splat` with a kernel of their own differ in.

use glam::{DMat2, DVec2};

use super::hit::Place;
use super::refraction::Exit;
use super::resolve::DIAMETERS;
use super::settings::Settings;
use super::splat::Spread;
use super::variants::{Mode, Splat};
use crate::approximation::LightView;
use crate::approximation::bands::DEVIATIONS;
use crate::numeric::math;

/// Texels of the map along a pixel of the photon buffer: M/N, if both have the same frustum.
pub fn texels_by_pixel(view: &LightView, map: &LightView) -> f64 {
    view.half() / view.side() as f64 * map.side() as f64 / map.half()
}

/// How wide a photon is drawn, in texels of the map.
pub fn spread(
    settings: &Settings,
    mode: Mode,
    view: &LightView,
    map: &LightView,
    exit: &Exit,
    place: &Place,
) -> Spread {
    let unbent = settings.base_size * texels_by_pixel(view, map);
    let background = place.position.distance(exit.ray.origin);
    let lens = &exit.lens;
    let bounded = |factor: f64| {
        let diameter = factor * unbent;
        // At least a texel, as points on a device are.
        Spread::Round(
            if diameter.is_nan() { unbent } else { diameter }
                .clamp(1.0, settings.largest_splat.max(1.0)),
        )
    };
    match (settings.splat, mode) {
        (Splat::ThinLens | Splat::ThickLens, Mode::Reflection) => bounded(lens.mirror(background)),
        (Splat::ThinLens | Splat::ThickLens, Mode::SingleRefraction) => {
            bounded(lens.surface(background))
        }
        (Splat::ThinLens, Mode::Refraction) => bounded(lens.thin(background)),
        (Splat::ThickLens, Mode::Refraction) => bounded(lens.thick(background)),
        (Splat::TwoCurvatures, _) => ellipse(settings, map, exit, place),
        // The finest of its four.
        (Splat::MultiResolution, _) => Spread::Round(DIAMETERS[0]),
        // Chains of maps have sizes of their own, and beams have none.
        (Splat::Fixed | Splat::Mip | Splat::MipSplat | Splat::Exact, _) => {
            Spread::Round(settings.splat_size)
        }
    }
}

/// The Gaussian of a photon's pixel, σ = `base_size` / 6 pixels, carried to the map by the beam's exact
/// derivatives; never narrower than a third of a texel, nor larger than the largest splat.
fn ellipse(settings: &Settings, map: &LightView, exit: &Exit, place: &Place) -> Spread {
    const NARROWEST: f64 = 1.0 / 3.0;
    let distance = place.position.distance(exit.ray.origin);
    let [a, b] = exit.derivatives.map(|derivative| {
        let on_receiver = derivative.transferred(exit.ray.direction, distance, place.normal);
        map.project_derivative(place.position, on_receiver.position)
            * (settings.base_size / DEVIATIONS)
    });
    let floor = DMat2::from_diagonal(DVec2::splat(NARROWEST * NARROWEST));
    let covariance = DMat2::from_cols(
        DVec2::new(a.x * a.x + b.x * b.x, a.x * a.y + b.x * b.y),
        DVec2::new(a.x * a.y + b.x * b.y, a.y * a.y + b.y * b.y),
    );
    let trace = covariance.x_axis.x + covariance.y_axis.y;
    let largest = math::powi(settings.largest_splat / DEVIATIONS, 2);
    if !trace.is_finite() {
        return Spread::Ellipse(DMat2::from_diagonal(DVec2::splat(largest)));
    }
    // The larger variance is between half the trace and the trace.
    let shrink = (largest / trace.max(f64::MIN_POSITIVE)).min(1.0);
    Spread::Ellipse(covariance * shrink + floor)
}
