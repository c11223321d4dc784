//! The steps inside a `<transform>`.

use glam::{DMat3, DMat4, DVec3, DVec4};

use super::numbers;
use crate::numeric::math;

/// The attributes of an element, parameters replaced.
pub type Attributes = [(String, String)];

/// The tags of all steps.
pub const STEPS: [&str; 5] = ["translate", "rotate", "scale", "lookat", "matrix"];

/// The matrix of one step.
///
/// # Errors
///
/// The problem with the attributes, without the place.
pub fn step(tag: &str, attributes: &Attributes) -> Result<DMat4, String> {
    match tag {
        "translate" => {
            allow(attributes, &["x", "y", "z", "value"])?;
            Ok(DMat4::from_translation(components(attributes, 0.0)?))
        }
        "scale" => {
            allow(attributes, &["x", "y", "z", "value"])?;
            Ok(DMat4::from_scale(components(attributes, 1.0)?))
        }
        "rotate" => {
            allow(attributes, &["x", "y", "z", "value", "angle"])?;
            let axis = components(attributes, 0.0)?;
            if axis == DVec3::ZERO {
                return Err("the axis of a rotation must not be zero".to_owned());
            }
            let angle = numbers::float(required(attributes, "angle")?)?;
            Ok(if is_unit(axis) {
                rotation(axis.normalize(), angle)
            } else {
                rotation(axis, angle)
            })
        }
        "lookat" => {
            allow(attributes, &["origin", "target", "up"])?;
            let vector = |name| -> Result<DVec3, String> {
                numbers::vector(required(attributes, name)?)
                    .map_err(|message| format!("{name}: {message}"))
            };
            let up = match attribute(attributes, "up") {
                Some(_) => vector("up")?,
                None => DVec3::ZERO,
            };
            look_at(vector("origin")?, vector("target")?, up)
        }
        "matrix" => {
            allow(attributes, &["value"])?;
            matrix(required(attributes, "value")?)
        }
        _ => Err(format!("a transform is made of {}", STEPS.join(", "))),
    }
}

/// The value of an attribute.
pub fn attribute<'a>(attributes: &'a Attributes, name: &str) -> Option<&'a str> {
    attributes
        .iter()
        .find(|(known, _)| known == name)
        .map(|(_, value)| value.as_str())
}

/// The value of an attribute that must be there.
pub fn required<'a>(attributes: &'a Attributes, name: &str) -> Result<&'a str, String> {
    attribute(attributes, name).ok_or_else(|| format!("the attribute \"{name}\" is missing"))
}

/// Fails if there are attributes other than these.
pub fn allow(attributes: &Attributes, allowed: &[&str]) -> Result<(), String> {
    match attributes
        .iter()
        .find(|(name, _)| !allowed.contains(&name.as_str()))
    {
        None => Ok(()),
        Some((name, _)) => Err(format!(
            "the attribute \"{}\" is not known here; allowed are {}",
            numbers::shortened(name),
            allowed.join(", ")
        )),
    }
}

/// The components `x`, `y`, `z`, or `value` with one or three numbers.
pub fn components(attributes: &Attributes, missing: f64) -> Result<DVec3, String> {
    let of_axis = |axis: &str| match attribute(attributes, axis) {
        Some(text) => numbers::float(text).map(Some),
        None => Ok(None),
    };
    let axes = [of_axis("x")?, of_axis("y")?, of_axis("z")?];
    let Some(value) = attribute(attributes, "value") else {
        return Ok(DVec3::from_array(
            axes.map(|number| number.unwrap_or(missing)),
        ));
    };
    if axes.iter().any(Option::is_some) {
        return Err("\"value\" and \"x\", \"y\", \"z\" exclude each other".to_owned());
    }
    match numbers::floats(value)?[..] {
        [single] => Ok(DVec3::splat(single)),
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        ref other => Err(format!(
            "\"value\" must hold 1 or 3 numbers, not {}",
            other.len()
        )),
    }
}

/// The oddity of a step that is otherwise fine, if there is one.
///
/// Mitsuba 3.9 does not normalise the axis of a `<rotate>` (0.6 did): about (0, 1, 1) the step not only turns
/// but also stretches. The same file must mean the same thing here, so the step stretches here, too.
pub fn oddity(tag: &str, attributes: &Attributes) -> Option<String> {
    let axis = components(attributes, 0.0)
        .ok()
        .filter(|axis| tag == "rotate" && !is_unit(*axis))?;
    Some(format!(
        "the axis of this rotation has length {:.6}, not 1: the transform also stretches, as in Mitsuba 3.9",
        axis.length()
    ))
}

/// True if a vector has length 1, up to single precision or six digits of a file.
fn is_unit(vector: DVec3) -> bool {
    (vector.length_squared() - 1.0).abs() < 1e-5
}

/// A turn about a unit axis by an angle in degrees, counter-clockwise seen against the axis.
///
/// Quarter turns are exact, so that an object turned by 90° stays parallel to the axes.
fn rotation(axis: DVec3, degrees: f64) -> DMat4 {
    let (sin, cos) = match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => math::sin_cos(degrees.to_radians()),
    };
    // Rodrigues: R = cos I + sin [a]× + (1 - cos) a aᵀ.
    let column =
        |unit: DVec3| unit * cos + axis.cross(unit) * sin + axis * (axis.dot(unit) * (1.0 - cos));
    DMat4::from_mat3(DMat3::from_cols(
        column(DVec3::X),
        column(DVec3::Y),
        column(DVec3::Z),
    ))
}

/// The frame at `origin` whose +z points to `target` and whose +y leans towards `up`.
fn look_at(origin: DVec3, target: DVec3, up: DVec3) -> Result<DMat4, String> {
    let forward = (target - origin)
        .try_normalize()
        .ok_or("origin and target of a lookat must differ")?;
    let up = if up == DVec3::ZERO {
        some_perpendicular(forward)
    } else {
        up
    };
    let left = up
        .cross(forward)
        .try_normalize()
        .ok_or("up of a lookat must not be parallel to its line of sight")?;
    let up = forward.cross(left);
    Ok(DMat4::from_cols(
        left.extend(0.0),
        up.extend(0.0),
        forward.extend(0.0),
        origin.extend(1.0),
    ))
}

/// The first of the two unit vectors that complete `n` to a frame.
///
/// It is chosen as in Mitsuba: Duff et al., *Building an Orthonormal Basis, Revisited*, JCGT 6(1), 2017,
/// listing 3.
pub fn some_perpendicular(n: DVec3) -> DVec3 {
    let sign = 1.0_f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    DVec3::new(
        1.0 + sign * n.x * n.x * a,
        sign * n.x * n.y * a,
        -sign * n.x,
    )
}

/// A matrix: 16 numbers, row by row, or 9 for the linear part.
fn matrix(text: &str) -> Result<DMat4, String> {
    let numbers = numbers::floats(text)?;
    let rows = match numbers.len() {
        16 => [0, 1, 2, 3].map(|row| DVec4::from_slice(&numbers[4 * row..])),
        9 => [
            DVec3::from_slice(&numbers).extend(0.0),
            DVec3::from_slice(&numbers[3..]).extend(0.0),
            DVec3::from_slice(&numbers[6..]).extend(0.0),
            DVec4::W,
        ],
        count => return Err(format!("a matrix has 16 or 9 numbers, not {count}")),
    };
    Ok(DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(tag: &str, attributes: &[(&str, &str)]) -> Result<DMat4, String> {
        let attributes: Vec<_> = attributes
            .iter()
            .map(|(a, b)| ((*a).to_owned(), (*b).to_owned()))
            .collect();
        step(tag, &attributes)
    }

    #[test]
    fn a_quarter_turn_is_exact() {
        let turn = of("rotate", &[("y", "1"), ("angle", "90")]).unwrap();
        assert_eq!(turn.transform_vector3(DVec3::Z), DVec3::X);
        assert_eq!(turn.transform_vector3(DVec3::X), DVec3::NEG_Z);
        let back = of("rotate", &[("y", "1"), ("angle", "-90")]).unwrap();
        assert_eq!(back * turn, DMat4::IDENTITY);
    }

    #[test]
    fn an_axis_of_another_length_stretches_as_in_mitsuba_and_is_told() {
        let attributes = [("y", "1"), ("z", "1"), ("angle", "15")];
        // np.array(mi.ScalarTransform4f().rotate([0, 1, 1], 15).matrix), Mitsuba 3.9.1, f32.
        let mitsuba = [
            [0.9659258, -0.25881904, 0.25881904],
            [0.25881904, 1.0, 0.03407419],
            [-0.25881904, 0.03407419, 1.0],
        ];
        let matrix = of("rotate", &attributes).unwrap();
        for (row, expected) in mitsuba.into_iter().enumerate() {
            let row = matrix.row(row).truncate();
            assert!(
                row.abs_diff_eq(expected.into(), 1e-7),
                "{row} is not {expected:?}"
            );
        }
        let told = |attributes: &[(&str, &str)]| {
            let attributes: Vec<_> = attributes
                .iter()
                .map(|(a, b)| ((*a).to_owned(), (*b).to_owned()))
                .collect();
            oddity("rotate", &attributes)
        };
        assert!(told(&attributes).unwrap().contains("1.414214"));
        assert_eq!(
            told(&[("value", "0.6 0.8 0.000001"), ("angle", "15")]),
            None
        );
        assert_eq!(told(&[("x", "-1"), ("angle", "15")]), None);
    }

    #[test]
    fn missing_components_are_zero_but_one_for_a_scale() {
        let moved = of("translate", &[("y", "2")])
            .unwrap()
            .transform_point3(DVec3::ONE);
        assert_eq!(moved, DVec3::new(1.0, 3.0, 1.0));
        let scaled = of("scale", &[("y", "2")])
            .unwrap()
            .transform_point3(DVec3::ONE);
        assert_eq!(scaled, DVec3::new(1.0, 2.0, 1.0));
        assert_eq!(
            of("scale", &[("value", "3")])
                .unwrap()
                .transform_point3(DVec3::ONE),
            DVec3::splat(3.0)
        );
    }

    #[test]
    fn look_at_sees_its_target_on_positive_z_with_up_on_y() {
        let frame = of(
            "lookat",
            &[("origin", "1 2 3"), ("target", "1, 2, 8"), ("up", "0,1,0")],
        )
        .unwrap();
        assert_eq!(
            frame.transform_point3(DVec3::ZERO),
            DVec3::new(1.0, 2.0, 3.0)
        );
        assert_eq!(frame.transform_vector3(DVec3::Z), DVec3::Z);
        assert_eq!(frame.transform_vector3(DVec3::Y), DVec3::Y);
        // Mitsuba's camera has +x to the left, which is +x here for z forward and y up.
        assert_eq!(frame.transform_vector3(DVec3::X), DVec3::X);
    }

    #[test]
    fn look_at_needs_no_up_and_says_what_it_cannot_use() {
        let down = of("lookat", &[("origin", "0 0 1"), ("target", "0 0 -1")]).unwrap();
        assert_eq!(down.transform_vector3(DVec3::Z), DVec3::NEG_Z);
        assert!((down.determinant() - 1.0).abs() < 1e-15);
        assert!(of("lookat", &[("origin", "0 0 1"), ("target", "0 0 1")]).is_err());
        let parallel = of(
            "lookat",
            &[("origin", "0 0 1"), ("target", "0 0 2"), ("up", "0 0 3")],
        );
        assert!(parallel.unwrap_err().contains("parallel"));
    }

    #[test]
    fn a_matrix_is_given_row_by_row() {
        let text = "1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1";
        assert_eq!(
            of("matrix", &[("value", text)]).unwrap().w_axis.truncate(),
            DVec3::new(5.0, 6.0, 7.0)
        );
        let swap = of("matrix", &[("value", "0 1 0 1 0 0 0 0 1")]).unwrap();
        assert_eq!(
            swap.transform_vector3(DVec3::new(1.0, 2.0, 3.0)),
            DVec3::new(2.0, 1.0, 3.0)
        );
        assert!(
            of("matrix", &[("value", "1 2 3")])
                .unwrap_err()
                .contains("not 3")
        );
    }

    #[test]
    fn wrong_attributes_are_named() {
        assert!(
            of("rotate", &[("x", "1")])
                .unwrap_err()
                .contains("\"angle\" is missing")
        );
        assert!(
            of("rotate", &[("angle", "1")])
                .unwrap_err()
                .contains("axis")
        );
        assert!(of("scale", &[("w", "1")]).unwrap_err().contains("\"w\""));
        assert!(
            of("scale", &[("x", "1"), ("value", "1")])
                .unwrap_err()
                .contains("exclude")
        );
    }
}
