//! Exact twins that are known only as well as the figures need.
//!
//! Some twins take samples, or halve cells, until the image is known. An attribution runs them in half of its
//! runs or so. Their noise must not look like a stage's error, and nothing more is decided by less noise.

use crate::approximation::Twins;
use crate::method::Method;
use crate::radiometry::Rgb;
use crate::setting::SettingError;

/// The noise that twins may leave, by the error that is attributed, both as L2: a stage that makes a
/// twentieth of the error stands out of it.
pub const TWINS: f64 = 0.05;

/// A technique whose twins are known to an error.
#[derive(Debug)]
pub(super) struct Known {
    pub technique: Method,
    /// Relative standard error over the sensor; `None` if no twin leaves one.
    pub error: Option<f64>,
}

/// The technique with twins no better known than to `error`, relative, over the sensor. A setting that is
/// given, or coarser, stays.
///
/// Halvings have an error that no formula tells. `exact` runs the technique with all stages exact, and
/// `difference` is the L2 of one image beside a finer one. There are as few halvings as leave a difference of
/// at most `error` to one more: that is about what they leave of the error.
pub(super) fn known_to<E: From<SettingError>>(
    error: f64,
    technique: &Method,
    mut exact: impl FnMut(&Method) -> Result<Vec<Rgb>, E>,
    difference: impl Fn(&[Rgb], &[Rgb]) -> Result<f64, E>,
) -> Result<Known, E> {
    let as_it_is = |error| Known {
        technique: technique.clone(),
        error,
    };
    let Some((twins, set)) = technique.twins() else {
        return Ok(as_it_is(None));
    };
    let is_given = technique.given().contains_key(twins.key());
    match twins {
        Twins::Error(_) if is_given || error.is_nan() || error <= set => Ok(as_it_is(Some(set))),
        Twins::Error(key) => {
            let error = error.min(1.0);
            Ok(Known {
                technique: technique.with(key, &error.to_string())?,
                error: Some(error),
            })
        }
        Twins::Halvings(_) if is_given => Ok(as_it_is(None)),
        Twins::Halvings(key) => {
            let with = |halvings: u32| technique.with(key, &halvings.to_string());
            let mut coarse = with(0)?;
            let mut values = exact(&coarse)?;
            let mut left = None;
            for halvings in 1..=set as u32 {
                let fine = with(halvings)?;
                let finer = exact(&fine)?;
                let found = difference(&finer, &values)?;
                left = Some(found);
                if found <= error {
                    break;
                }
                (coarse, values) = (fine, finer);
            }
            Ok(Known {
                technique: coarse,
                error: left,
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::math;

    fn method(name: &str, given: &[(&str, &str)]) -> Method {
        let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
        Method::new(name, &given.iter().map(owned).collect()).unwrap()
    }

    /// Twins of a method whose exact image is 1 + 8⁻ⁿ after n halvings.
    fn twins(method: &Method, error: f64) -> (Known, u32) {
        let mut runs = 0;
        let exact = |technique: &Method| {
            runs += 1;
            let halvings = technique.twins().unwrap().1;
            Ok(vec![Rgb::grey(1.0 + math::powf(0.125, halvings))])
        };
        let difference = |a: &[Rgb], b: &[Rgb]| Ok((a[0].mean() - b[0].mean()).abs());
        let known = known_to::<SettingError>(error, method, exact, difference).unwrap();
        (known, runs)
    }

    #[test]
    fn twins_that_sample_are_known_as_well_as_is_asked_unless_they_are_set() {
        let default = method("local-irradiance", &[]);
        let (_, set) = default.twins().unwrap();
        let (loose, _) = twins(&default, 0.05);
        assert_eq!(loose.error, Some(0.05));
        assert_eq!(loose.technique.given()["noise-error"], "0.05");
        // No better than the default, and no worse than nothing.
        let (same, _) = twins(&default, 0.1 * set);
        assert_eq!(same.error, Some(set));
        assert_eq!(same.technique.given(), default.given());
        assert_eq!(twins(&default, 7.0).0.error, Some(1.0));
        let given = method("local-irradiance", &[("noise-error", "0.01")]);
        assert_eq!(twins(&given, 0.05).0.error, Some(0.01));
        for others in ["caustic-map", "beams"] {
            let (known, runs) = twins(&method(others, &[]), 0.05);
            assert_eq!((known.error, runs), (None, 0));
        }
    }

    #[test]
    fn cells_are_halved_until_one_more_halving_makes_no_difference_unless_they_are_set() {
        let default = method("caustics-volume", &[]);
        // 7/8, 7/64, 7/512 are the differences of the first four images.
        for (error, halvings, left) in [
            (0.9, "0", 0.875),
            (0.2, "1", 7.0 / 64.0),
            (0.02, "2", 7.0 / 512.0),
        ] {
            let (known, runs) = twins(&default, error);
            assert_eq!(known.technique.given()["border-levels"], halvings);
            assert!((known.error.unwrap() - left).abs() < 1e-12, "{known:?}");
            assert_eq!(runs, halvings.parse::<u32>().unwrap() + 2);
        }
        // The default is the finest, and its error is at most what the last halving changed.
        let (finest, _) = twins(&default, 1e-9);
        assert_eq!(finest.technique.given()["border-levels"], "3");
        assert!((finest.error.unwrap() - 7.0 / 512.0).abs() < 1e-12);
        let given = method("caustics-volume", &[("border-levels", "2")]);
        let (known, runs) = twins(&given, 0.9);
        assert_eq!((known.technique, known.error, runs), (given, None, 0));
    }
}
