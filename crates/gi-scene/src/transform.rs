//! The operations of a `<transform>`, in document order.

use glam::{Affine3A, Mat3, Vec3};

use crate::value;

/// One operation's attributes, by name.
pub(crate) type Lookup<'a> = &'a dyn Fn(&str) -> Option<&'a str>;

/// The tags inside a `<transform>`.
pub(crate) const OPERATIONS: [&str; 5] = ["translate", "rotate", "scale", "lookat", "matrix"];

/// The matrix of one operation.
pub(crate) fn operation(tag: &str, attribute: Lookup<'_>) -> Result<Affine3A, String> {
    let xyz = |default: f32| -> Result<Vec3, String> {
        if let Some(text) = attribute("value") {
            return value::triple(text);
        }
        let axis = |name| attribute(name).map_or(Ok(default), value::number);
        Ok(Vec3::new(axis("x")?, axis("y")?, axis("z")?))
    };
    match tag {
        "translate" => Ok(Affine3A::from_translation(xyz(0.0)?)),
        "scale" => Ok(Affine3A::from_scale(xyz(1.0)?)),
        "rotate" => {
            let axis = xyz(0.0)?.try_normalize().ok_or("a rotation needs an axis")?;
            let angle = attribute("angle").ok_or("a rotation needs an `angle` in degrees")?;
            Ok(Affine3A::from_axis_angle(axis, value::number(angle)?.to_radians()))
        }
        "lookat" => {
            let point = |name: &str| {
                attribute(name).ok_or(format!("`lookat` needs `{name}`")).and_then(value::triple)
            };
            look_at(point("origin")?, point("target")?, attribute("up"))
        }
        "matrix" => matrix(&value::numbers(attribute("value").ok_or("a matrix needs `value`")?)?),
        _ => Err(format!("unknown operation `{tag}`")),
    }
}

fn look_at(origin: Vec3, target: Vec3, up: Option<&str>) -> Result<Affine3A, String> {
    let z = (target - origin).try_normalize().ok_or("origin and target are the same point")?;
    let up = up.map_or(Ok(Vec3::ZERO), value::triple)?;
    let x = match up.cross(z).try_normalize() {
        Some(x) => x,
        None if up == Vec3::ZERO => z.any_orthonormal_vector(),
        None => return Err("`up` is parallel to the view".into()),
    };
    Ok(Affine3A::from_mat3_translation(Mat3::from_cols(x, z.cross(x), z), origin))
}

/// A matrix of nine or sixteen numbers, row by row; a projective last row is refused.
fn matrix(m: &[f32]) -> Result<Affine3A, String> {
    let rows = match m.len() {
        9 => 3,
        16 if m[12..15] == [0.0; 3] && m[15] == 1.0 => 4,
        16 => return Err("the last row of the matrix is not 0 0 0 1".into()),
        n => return Err(format!("{n} numbers, but a matrix has 9 or 16")),
    };
    let column = |c: usize| Vec3::new(m[c], m[rows + c], m[2 * rows + c]);
    let translation = if rows == 4 { column(3) } else { Vec3::ZERO };
    Ok(Affine3A::from_cols(
        column(0).into(),
        column(1).into(),
        column(2).into(),
        translation.into(),
    ))
}

/// A vector's direction and length. Lengths within rounding of one become one, so that a normalised vector is not
/// changed.
pub(crate) fn unit(v: Vec3) -> (Vec3, f32) {
    const ROUNDING: f32 = 1e-6;
    let length = v.length();
    if (length - 1.0).abs() < ROUNDING { (v, 1.0) } else { (v / length, length) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apply(tag: &str, attributes: &[(&str, &'static str)]) -> Result<Affine3A, String> {
        operation(tag, &|name| attributes.iter().find(|(n, _)| *n == name).map(|(_, v)| *v))
    }

    #[test]
    fn a_matrix_is_read_row_by_row() {
        let m = apply("matrix", &[("value", "1 2 3 4  5 6 7 8  9 10 11 12  0 0 0 1")]).unwrap();
        assert_eq!(m.transform_point3(Vec3::ZERO), Vec3::new(4.0, 8.0, 12.0));
        assert_eq!(m.transform_vector3(Vec3::X), Vec3::new(1.0, 5.0, 9.0));
        assert!(apply("matrix", &[("value", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1")]).is_err());
    }

    #[test]
    fn look_at_looks_along_z_with_x_to_the_left() {
        let m = apply("lookat", &[("origin", "0 0 5"), ("target", "0 0 0"), ("up", "0 1 0")]);
        let m = m.unwrap();
        assert_eq!(m.transform_vector3(Vec3::Z), -Vec3::Z);
        assert_eq!(m.transform_vector3(Vec3::X), -Vec3::X, "left of a viewer who looks along -z");
        assert_eq!(m.transform_point3(Vec3::ZERO), Vec3::new(0.0, 0.0, 5.0));
        assert!(apply("lookat", &[("origin", "0 0 5"), ("target", "0 0 5")]).is_err());
    }

    #[test]
    fn rotations_are_in_degrees_and_right_handed() {
        let m = apply("rotate", &[("z", "1"), ("angle", "90")]).unwrap();
        assert!((m.transform_vector3(Vec3::X) - Vec3::Y).length() < 1e-6);
        assert!(apply("rotate", &[("angle", "90")]).is_err());
    }
}
