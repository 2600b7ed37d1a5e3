//! The operations of a `<transform>`, in document order. They are in double precision: a scene may be far from the
//! origin of its coordinates.

use glam::{DAffine3, DMat3, DVec3, Vec3};

use crate::value;

/// One operation's attributes, by name.
pub(crate) type Lookup<'a> = &'a dyn Fn(&str) -> Option<&'a str>;

/// The tags inside a `<transform>`.
pub(crate) const OPERATIONS: [&str; 5] = ["translate", "rotate", "scale", "lookat", "matrix"];

/// The matrix of one operation.
pub(crate) fn operation(tag: &str, attribute: Lookup<'_>) -> Result<DAffine3, String> {
    let xyz = |default: f64| -> Result<DVec3, String> {
        if let Some(text) = attribute("value") {
            return value::triple64(text);
        }
        let axis = |name| attribute(name).map_or(Ok(default), value::number64);
        Ok(DVec3::new(axis("x")?, axis("y")?, axis("z")?))
    };
    match tag {
        "translate" => Ok(DAffine3::from_translation(xyz(0.0)?)),
        "scale" => Ok(DAffine3::from_scale(xyz(1.0)?)),
        "rotate" => {
            let axis = xyz(0.0)?.try_normalize().ok_or("a rotation needs an axis")?;
            let angle = attribute("angle").ok_or("a rotation needs an `angle` in degrees")?;
            Ok(DAffine3::from_axis_angle(axis, value::number64(angle)?.to_radians()))
        }
        "lookat" => {
            let point = |name: &str| {
                attribute(name).ok_or(format!("`lookat` needs `{name}`")).and_then(value::triple64)
            };
            look_at(point("origin")?, point("target")?, attribute("up"))
        }
        "matrix" => matrix(&value::numbers64(attribute("value").ok_or("a matrix needs `value`")?)?),
        _ => Err(format!("unknown operation `{tag}`")),
    }
}

fn look_at(origin: DVec3, target: DVec3, up: Option<&str>) -> Result<DAffine3, String> {
    let z = (target - origin).try_normalize().ok_or("origin and target are the same point")?;
    let up = up.map_or(Ok(DVec3::ZERO), value::triple64)?;
    let x = match up.cross(z).try_normalize() {
        Some(x) => x,
        None if up == DVec3::ZERO => z.any_orthonormal_vector(),
        None => return Err("`up` is parallel to the view".into()),
    };
    Ok(DAffine3::from_mat3_translation(DMat3::from_cols(x, z.cross(x), z), origin))
}

/// A matrix of nine or sixteen numbers, row by row; a projective last row is refused.
fn matrix(m: &[f64]) -> Result<DAffine3, String> {
    let rows = match m.len() {
        9 => 3,
        16 if m[12..15] == [0.0; 3] && m[15] == 1.0 => 4,
        16 => return Err("the last row of the matrix is not 0 0 0 1".into()),
        n => return Err(format!("{n} numbers, but a matrix has 9 or 16")),
    };
    let column = |c: usize| DVec3::new(m[c], m[rows + c], m[2 * rows + c]);
    let translation = if rows == 4 { column(3) } else { DVec3::ZERO };
    Ok(DAffine3::from_cols(column(0), column(1), column(2), translation))
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

    fn apply(tag: &str, attributes: &[(&str, &'static str)]) -> Result<DAffine3, String> {
        operation(tag, &|name| attributes.iter().find(|(n, _)| *n == name).map(|(_, v)| *v))
    }

    #[test]
    fn a_matrix_is_read_row_by_row() {
        let m = apply("matrix", &[("value", "1 2 3 4  5 6 7 8  9 10 11 12  0 0 0 1")]).unwrap();
        assert_eq!(m.transform_point3(DVec3::ZERO), DVec3::new(4.0, 8.0, 12.0));
        assert_eq!(m.transform_vector3(DVec3::X), DVec3::new(1.0, 5.0, 9.0));
        assert!(apply("matrix", &[("value", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1")]).is_err());
    }

    #[test]
    fn look_at_looks_along_z_with_x_to_the_left() {
        let m = apply("lookat", &[("origin", "0 0 5"), ("target", "0 0 0"), ("up", "0 1 0")]);
        let m = m.unwrap();
        assert_eq!(m.transform_vector3(DVec3::Z), -DVec3::Z);
        assert_eq!(m.transform_vector3(DVec3::X), -DVec3::X, "left of a viewer who looks along -z");
        assert_eq!(m.transform_point3(DVec3::ZERO), DVec3::new(0.0, 0.0, 5.0));
        assert!(apply("lookat", &[("origin", "0 0 5"), ("target", "0 0 5")]).is_err());
    }

    #[test]
    fn rotations_are_in_degrees_and_right_handed() {
        let m = apply("rotate", &[("z", "1"), ("angle", "90")]).unwrap();
        assert!((m.transform_vector3(DVec3::X) - DVec3::Y).length() < 1e-15);
        assert!(apply("rotate", &[("angle", "90")]).is_err());
    }
}
