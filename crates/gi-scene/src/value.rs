//! Parses the text of attributes as numbers, colours and vectors.

use gi_core::math::Rgb;
use gi_core::texture::srgb_to_linear;
use glam::{DVec3, Vec3};

/// Longest list of numbers. It bounds the memory that one attribute can request, and no matrix or measured spectrum
/// comes near it.
const MAX_NUMBERS: usize = 1 << 16;

/// Largest number in a scene. Products of a few such numbers are still finite where it matters, and no real length or
/// radiance comes near it.
pub(crate) const MAX_NUMBER: f32 = 1e15;

/// Split at commas and blanks.
pub(crate) fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c == ',' || c.is_whitespace()).filter(|w| !w.is_empty())
}

/// One finite number of at most [`MAX_NUMBER`].
pub(crate) fn number(text: &str) -> Result<f32, String> {
    match text.trim().parse::<f32>() {
        Ok(v) if v.abs() <= MAX_NUMBER => Ok(v),
        Ok(v) if v.is_finite() => Err(format!("`{}` is too large: at most 1e15", text.trim())),
        Ok(_) => Err(format!("`{}` is not a finite number", text.trim())),
        Err(_) => Err(format!("`{}` is not a number", text.trim())),
    }
}

/// A finite number in double precision, for positions: a scene may be far from the origin of its coordinates.
pub(crate) fn number64(text: &str) -> Result<f64, String> {
    number(text)?;
    text.trim().parse().map_err(|_| format!("`{}` is not a number", text.trim()))
}

/// Numbers in double precision separated by commas or blanks.
pub(crate) fn numbers64(text: &str) -> Result<Vec<f64>, String> {
    words(text).take(MAX_NUMBERS).map(number64).collect()
}

/// Three numbers in double precision, or one for all three.
pub(crate) fn triple64(text: &str) -> Result<DVec3, String> {
    match numbers64(text)?.as_slice() {
        [v] => Ok(DVec3::splat(*v)),
        [x, y, z] => Ok(DVec3::new(*x, *y, *z)),
        other => Err(format!("{} numbers instead of one or three", other.len())),
    }
}

/// Finite numbers separated by commas or blanks.
pub(crate) fn numbers(text: &str) -> Result<Vec<f32>, String> {
    words(text).take(MAX_NUMBERS).map(number).collect()
}

/// Three numbers, or one for all three.
pub(crate) fn triple(text: &str) -> Result<Vec3, String> {
    triple64(text).map(|v| v.as_vec3())
}

/// An integer; `12.0` is accepted too.
pub(crate) fn integer(text: &str) -> Result<i64, String> {
    let text = text.trim();
    if let Ok(v) = text.parse::<i64>() {
        return Ok(v);
    }
    match text.parse::<f64>() {
        Ok(v) if v.fract() == 0.0 && v.abs() < 1e15 => Ok(v as i64),
        _ => Err(format!("`{text}` is not a whole number")),
    }
}

/// `true` or `false`.
pub(crate) fn boolean(text: &str) -> Result<bool, String> {
    match text.trim().to_lowercase().as_str() {
        "true" => Ok(true),
        "false" => Ok(false),
        other => Err(format!("`{other}` is neither `true` nor `false`")),
    }
}

/// A colour: one number, three numbers, or `#rrggbb`. With `srgb`, the numbers are converted from the sRGB curve.
pub(crate) fn color(text: &str, srgb: bool) -> Result<Rgb, String> {
    let text = text.trim();
    let raw = match text.strip_prefix('#') {
        Some(hex) if hex.len() == 6 && hex.is_ascii() => {
            let code =
                u32::from_str_radix(hex, 16).map_err(|_| format!("`{text}` is not a colour"))?;
            Vec3::new((code >> 16) as f32, (code >> 8 & 255) as f32, (code & 255) as f32) / 255.0
        }
        Some(_) => return Err(format!("`{text}` is not a colour of the form #rrggbb")),
        None => triple(text)?,
    };
    let rgb = Rgb::from(raw.to_array());
    Ok(if srgb { rgb.map(srgb_to_linear) } else { rgb })
}

/// `nm:value` pairs, ascending.
pub(crate) fn pairs(text: &str) -> Result<Vec<(f32, f32)>, String> {
    let mut out = Vec::new();
    for word in words(text).take(MAX_NUMBERS) {
        let (nm, v) =
            word.split_once(':').ok_or_else(|| format!("`{word}` is not an nm:value pair"))?;
        out.push((number(nm)?, number(v)?));
    }
    if !out.is_sorted_by(|a, b| a.0 < b.0) {
        return Err("the wavelengths are not in ascending order".into());
    }
    Ok(out)
}

/// Convert `intIOR` and `toUV` to the names of Mitsuba 3: `int_ior`, `to_uv`.
pub(crate) fn snake_case(name: &str) -> String {
    let mut out = String::with_capacity(name.len() + 4);
    let mut after_lower = false;
    for c in name.chars() {
        if c.is_ascii_uppercase() {
            if after_lower {
                out.push('_');
            }
            out.push(c.to_ascii_lowercase());
            after_lower = false;
        } else {
            out.push(c);
            after_lower = c.is_ascii_alphanumeric();
        }
    }
    out
}

/// Refuse a vertex so far away that areas and distances would overflow.
pub(crate) fn check_size(p: Vec3) -> Result<(), String> {
    if p.abs().max_element() <= MAX_NUMBER {
        return Ok(());
    }
    Err(format!("a vertex is too far away: {p}, at most 1e15"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn camel_case_becomes_snake_case() {
        let cases = [
            ("toWorld", "to_world"),
            ("intIOR", "int_ior"),
            ("toUV", "to_uv"),
            ("alphaU", "alpha_u"),
            ("diffuseReflectance", "diffuse_reflectance"),
            ("sigma_t", "sigma_t"),
            ("fov", "fov"),
        ];
        for (camel, snake) in cases {
            assert_eq!(snake_case(camel), snake);
        }
    }

    #[test]
    fn vectors_take_commas_blanks_and_one_number_for_all() {
        for text in ["1,2,3", "1 2 3", " 1, 2 ,3 ", "1\t2\n3"] {
            assert_eq!(triple(text), Ok(Vec3::new(1.0, 2.0, 3.0)));
        }
        assert_eq!(triple("2"), Ok(Vec3::splat(2.0)));
        assert!(triple("1 2").is_err());
        assert_eq!(triple("1 x 2").unwrap_err(), "`x` is not a number");
        assert!(triple("1 nan 2").is_err(), "NaN is not a number");
    }

    #[test]
    fn colours_take_hex_and_the_srgb_curve() {
        assert_eq!(color("#ff0033", false), Ok(Rgb::new(1.0, 0.0, 0.2)));
        assert!((color("0.5", true).unwrap().r - 0.214_041).abs() < 1e-5);
        assert!(color("#ff", false).is_err());
        assert!(color("#ffäää", false).is_err());
    }

    #[test]
    fn spectra_must_be_in_ascending_order() {
        assert_eq!(pairs("400:1, 500:0.5"), Ok(vec![(400.0, 1.0), (500.0, 0.5)]));
        assert!(pairs("500:1 400:1").is_err());
        assert!(pairs("500").is_err());
    }
}
