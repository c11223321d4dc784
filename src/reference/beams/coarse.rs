//! Faint signatures that may have coarse cells, because the discovery's paths bound their light.
//!
//! Cells tell what they misplace only if a signature has some hundreds of them, however faint it is. So a
//! signature with 2·10⁻⁴ of a lens' light took 60 % of a run's time, for a hundredth of the error asked for.
//! Coarser cells do for the value. Their bars are then those of light that is [left out](super::selection):
//! any of it may be elsewhere, and texels may get what the densest bins of paths about them tell.
//!
//! Such bars are wide. So only as many signatures have coarse cells as leave the mean of all these bounds
//! within a part of the error asked for. Those come first that save most: faint ones of many events.

use std::collections::BTreeSet;

use super::selection::{Found, MARGIN, bound};
use crate::transport::signature::Signature;

/// Mean of the bounds of all coarse signatures over the error asked for. Bars of the others are five to ten
/// times that error.
const MOST: f64 = 2.0;

/// The signatures that may have coarse cells, of those that are followed, if the likely error may be a flux
/// of `error` \[W\], all texels together.
pub(super) fn coarse<'a>(
    followed: impl Iterator<Item = &'a Found>,
    film: [usize; 2],
    error: f64,
) -> BTreeSet<Signature> {
    let mut found: Vec<&Found> = followed.collect();
    // Cells of light beside the film must show that none of it is on it.
    found.retain(|(_, light)| !light.is_beside());
    let dear = |(signature, light): &Found| light.on_film / signature.len() as f64;
    found.sort_by(|a, b| dear(a).total_cmp(&dear(b)).then(a.0.cmp(&b.0)));
    let mut left = MOST * error;
    let mut coarse = BTreeSet::new();
    for (signature, light) in found {
        // The bound of evenly spread light: no other is less.
        if MARGIN * light.on_film > left {
            continue;
        }
        let own: f64 = bound(&light.landings, film).iter().sum();
        if own <= left {
            left -= own;
            coarse.insert(*signature);
        }
    }
    coarse
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::beams::discovery::{Landing, SignatureLight};
    use glam::DVec2;

    const FILM: [usize; 2] = [64, 64];

    /// A signature of so much flux, by a path in each of 64 x 64 texels.
    fn light(name: &str, flux: f64) -> Found {
        let landings = (0..4096).map(|texel| Landing {
            at: DVec2::new(f64::from(texel % 64) + 0.5, f64::from(texel / 64) + 0.5),
            flux: flux / 4096.0,
        });
        let found = SignatureLight {
            flux,
            on_film: flux,
            peak: 1.0,
            landings: landings.collect(),
        };
        (name.parse().unwrap(), found)
    }

    fn names(found: &[Found], error: f64) -> Vec<String> {
        let coarse = coarse(found.iter(), FILM, error);
        coarse.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn faint_light_of_many_events_is_coarse_while_its_bounds_are_within_the_error() {
        // Each is bounded by four times its flux, and twice the error may go to bounds.
        let found = [
            light("LTTD", 1.0),
            light("LRD", 2e-3),
            light("LTRRRRTD", 2e-3),
        ];
        assert_eq!(names(&found, 1e-3), [""; 0]);
        assert_eq!(names(&found, 4.1e-3), ["LTRRRRTD"]);
        assert_eq!(names(&found, 8.2e-3), ["LRD", "LTRRRRTD"]);
    }

    #[test]
    fn focused_light_has_wide_bounds_and_is_not_coarse() {
        let mut focused = light("LTRTD", 1e-3);
        for landing in &mut focused.1.landings {
            landing.at = DVec2::splat(32.5);
        }
        // All in one bin of 64 x 64: nine bins have 4 x 1e-3, and coarser bins four times as many less.
        assert_eq!(names(&[light("LTTD", 1.0), focused.clone()], 3e-3), [""; 0]);
        assert_eq!(names(&[light("LTTD", 1.0), focused], 0.1), ["LTRTD"]);
    }

    #[test]
    fn light_beside_the_film_has_no_coarse_cells() {
        let (name, found) = light("LTRTD", 1e-9);
        let beside = SignatureLight {
            on_film: 0.0,
            landings: Vec::new(),
            ..found
        };
        assert_eq!(names(&[light("LTTD", 1.0), (name, beside)], 0.1), [""; 0]);
    }
}
