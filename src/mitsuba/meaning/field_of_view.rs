//! The frames and fields of view of cameras and projectors.

use glam::DMat3;

use super::plugin::Plugin;
use crate::geometry::Transform;
use crate::mitsuba::error::LoadError;
use crate::mitsuba::syntax::shortened;
use crate::numeric::math;

/// Largest deviation of the products of a camera's axes from 0 and 1: Mitsuba's own limit
/// (`AffineTransform::has_scale`).
const RIGID_TOLERANCE: f64 = 1e-3;

/// Fails for a camera that stretches space, as Mitsuba does.
pub fn must_be_rigid(plugin: &Plugin, to_world: &Transform) -> Result<(), LoadError> {
    let linear = DMat3::from_mat4(to_world.matrix());
    if (linear * linear.transpose()).abs_diff_eq(DMat3::IDENTITY, RIGID_TOLERANCE) {
        Ok(())
    } else {
        Err(plugin.error("must not scale or shear in its to_world"))
    }
}

/// The full horizontal field of view of an uncropped film, or of a projector's image, of `width` x `height`
/// pixels \[rad\].
///
/// `fov` is in degrees along `fov_axis`. Without it, `focal_length` ("50mm" by default) is that of a 35 mm
/// still camera. Its film measures 36 mm x 24 mm, and its diagonal is the image's.
pub fn horizontal_fov(plugin: &Plugin, [width, height]: [f64; 2]) -> Result<f64, LoadError> {
    let aspect = width / height;
    let Some((degrees, at)) = plugin.float_at("fov")? else {
        let length = focal_length(plugin)?;
        let diagonal = 2.0 * math::atan(0.5 * math::hypot(36.0_f64, 24.0) / length);
        return Ok(from_axis("diagonal", diagonal, aspect));
    };
    if let Some(found) = plugin.find("focal_length") {
        return Err(plugin.parameter_error(
            found.property.at,
            "focal_length",
            "and \"fov\" exclude each other",
        ));
    }
    let axis = plugin.choice_or(
        "fov_axis",
        &["x", "y", "diagonal", "smaller", "larger"],
        "x",
    )?;
    let horizontal = from_axis(axis, degrees.to_radians(), aspect);
    if degrees > 0.0 && degrees < 180.0 && horizontal > 0.0 && horizontal < std::f64::consts::PI {
        return Ok(horizontal);
    }
    Err(plugin.parameter_error(
        at,
        "fov",
        format!("must be above 0 and below 180 degrees, not {degrees}"),
    ))
}

fn focal_length(plugin: &Plugin) -> Result<f64, LoadError> {
    const DEFAULT: f64 = 50.0;
    let Some(found) = plugin.find("focal_length") else {
        return Ok(DEFAULT);
    };
    let text = plugin.string("focal_length")?.unwrap_or_default();
    let number = text.trim().trim_end_matches("mm").trim_end().parse::<f64>();
    match number {
        Ok(length) if length > 0.0 && length.is_finite() => Ok(length),
        _ => {
            let message = format!(
                "must be a length in millimetres such as \"50mm\", not \"{}\"",
                shortened(text)
            );
            Err(plugin.parameter_error(found.property.at, "focal_length", message))
        }
    }
}

/// The horizontal angle, from the angle along an axis. All in radians.
fn from_axis(axis: &str, angle: f64, aspect: f64) -> f64 {
    let half = math::tan(0.5 * angle);
    let half_width = match axis {
        "y" => half * aspect,
        "diagonal" => half * aspect / math::hypot(aspect, 1.0),
        "smaller" if aspect > 1.0 => half * aspect,
        "larger" if aspect < 1.0 => half * aspect,
        _ => half,
    };
    2.0 * math::atan(half_width)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers are `x_fov` as Mitsuba 3.9.1 prints it, six digits.
    #[test]
    fn fields_of_view_are_mitsubas() {
        let aspect = 768.0 / 576.0;
        let degrees = |axis, angle: f64| from_axis(axis, angle.to_radians(), aspect).to_degrees();
        assert!((degrees("y", 40.0) - 51.774).abs() < 5e-4);
        assert!((degrees("smaller", 40.0) - 51.774).abs() < 5e-4);
        assert!((degrees("x", 40.0) - 40.0).abs() < 1e-12);
        assert!((degrees("larger", 40.0) - 40.0).abs() < 1e-12);
        let of_lens =
            |length: f64| 2.0 * math::atan(0.5 * math::hypot(36.0_f64, 24.0) / length).to_degrees();
        assert!((degrees("diagonal", of_lens(35.0)) - 52.6225).abs() < 5e-5);
        assert!((degrees("diagonal", of_lens(50.0)) - 38.1848).abs() < 5e-5);
    }
}
