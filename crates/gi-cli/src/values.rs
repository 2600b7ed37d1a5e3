//! Values of flags that several programs have.

use std::path::PathBuf;

/// A bound: a number above 0, or `inf` for none.
///
/// # Errors
/// What was expected.
pub fn parse_bound(text: &str) -> Result<f32, String> {
    let wrong = "expected a number above 0, or inf";
    text.parse().ok().filter(|b: &f32| *b > 0.0).ok_or_else(|| wrong.into())
}

/// A pixel: its column and row, X,Y.
///
/// # Errors
/// What was expected.
pub fn parse_pixel(text: &str) -> Result<[usize; 2], String> {
    let wrong = "expected two pixel coordinates: X,Y";
    let (x, y) = text.split_once(',').ok_or(wrong)?;
    let number = |t: &str| t.trim().parse().map_err(|_| wrong.to_string());
    Ok([number(x)?, number(y)?])
}

/// Check that the file of points that `flag` asks for, if it does, is a point cloud or a table by its name.
///
/// # Errors
/// What the name must end in.
pub fn check_points_file(flag: &str, path: &Option<PathBuf>) -> Result<(), String> {
    let extension = path.as_ref().and_then(|p| p.extension());
    let known = |e: &std::ffi::OsStr| ["ply", "csv"].iter().any(|k| e.eq_ignore_ascii_case(k));
    if path.is_some() && !extension.is_some_and(known) {
        return Err(format!("{flag}: the file's name ends in .ply or .csv"));
    }
    Ok(())
}
