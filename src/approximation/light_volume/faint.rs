//! Contribution culling (section 5): the faintest beams are not drawn.

use super::beam::Beam;
use super::cull::Draw;
use super::slicing::Slicing;

/// The draws that are left without the faintest, which together have at most a `share` of the flux drawn.
///
/// A draw is as faint as its greatest irradiance in the planes that it is drawn between. Of two that are
/// equally faint the earlier one is left out first.
pub fn without_faintest(
    slicing: &Slicing,
    beams: &[Option<Beam>],
    draws: Vec<Draw>,
    share: f64,
) -> Vec<Draw> {
    let flux = |draw: &Draw| {
        let beam = beams[draw.beam as usize].as_ref();
        beam.map_or(0.0, |beam| beam.light.iter().sum::<f64>() / 3.0)
    };
    let brightness = |draw: &Draw| {
        let beam = beams[draw.beam as usize].as_ref();
        let areas = beam.map(|beam| {
            let planes = draw.planes[0]..=draw.planes[1];
            planes
                .map(|plane| beam.section(slicing.plane(plane)).area())
                .fold(f64::INFINITY, f64::min)
        });
        // Without light and in a focus: 0/0 is no light.
        let irradiance = flux(draw) / areas.unwrap_or(f64::INFINITY);
        if irradiance.is_nan() { 0.0 } else { irradiance }
    };
    let mut order: Vec<usize> = (0..draws.len()).collect();
    let bright: Vec<f64> = draws.iter().map(brightness).collect();
    order.sort_by(|&a, &b| bright[a].total_cmp(&bright[b]));
    let mut left = share * draws.iter().map(flux).sum::<f64>();
    let mut is_kept = vec![true; draws.len()];
    for index in order {
        left -= flux(&draws[index]);
        if left < 0.0 {
            break;
        }
        is_kept[index] = false;
    }
    let mut kept = is_kept.into_iter();
    let mut draws = draws;
    draws.retain(|_| kept.next().unwrap_or(true));
    draws
}
