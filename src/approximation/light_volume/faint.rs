//! Contribution culling (section 5): the faintest beams are not drawn.

use super::beam::Beam;
use super::cull::Draw;
use super::slicing::Slicing;

/// The draws that are left without the faintest beams, which together have at most a `share` of the flux
/// drawn.
///
/// A beam is as faint as its greatest irradiance in the planes that it is drawn between. Of two that are
/// equally faint the earlier one is left out first.
///
/// - `draws`: those of a beam follow one another.
pub fn without_faintest(
    slicing: &Slicing,
    beams: &[Option<Beam>],
    mut draws: Vec<Draw>,
    share: f64,
) -> Vec<Draw> {
    /// A beam that is drawn.
    struct Drawn {
        beam: u32,
        flux: f64,
        brightest: f64,
    }
    let mut drawn: Vec<Drawn> = draws
        .chunk_by(|a, b| a.beam == b.beam)
        .filter_map(|ranges| {
            let number = ranges[0].beam;
            let beam = beams[number as usize].as_ref()?;
            let flux = beam.light.iter().sum::<f64>() / 3.0;
            let planes = ranges
                .iter()
                .flat_map(|draw| draw.planes[0]..=draw.planes[1]);
            let areas = planes.map(|plane| beam.section(slicing.plane(plane)).area());
            let irradiance = flux / areas.fold(f64::INFINITY, f64::min);
            Some(Drawn {
                beam: number,
                flux,
                // Without light and in a focus: 0/0 is no light.
                brightest: if irradiance.is_nan() { 0.0 } else { irradiance },
            })
        })
        .collect();
    let mut left = share * drawn.iter().map(|one| one.flux).sum::<f64>();
    drawn.sort_by(|a, b| a.brightest.total_cmp(&b.brightest));
    let mut is_faint = vec![false; beams.len()];
    for one in &drawn {
        left -= one.flux;
        if left < 0.0 {
            break;
        }
        is_faint[one.beam as usize] = true;
    }
    draws.retain(|draw| !is_faint[draw.beam as usize]);
    draws
}
