//! Values of flags that several programs have.

use std::path::{Path, PathBuf};

use clap::ValueEnum;

/// What becomes of the light that a bound cuts off virtual point lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Compensation {
    /// It is lost
    None,
    /// Paths bring it back, without bias
    Path,
}

/// How light that mirrors and glass focus is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Caustics {
    /// By paths from the eye, without bias: small lamps behind glass show as bright specks
    Path,
    /// By photons, blurred over discs that shrink with the passes
    Photon,
}

/// A bound: a number above 0, or `inf` for none.
///
/// # Errors
/// What was expected.
pub fn parse_bound(text: &str) -> Result<f32, String> {
    let wrong = "expected a number above 0, or inf";
    text.parse().ok().filter(|b: &f32| *b > 0.0).ok_or_else(|| wrong.into())
}

/// The accuracy of a cache, an error relative to the whole: above 0, up to 1.
///
/// # Errors
/// What was expected.
pub fn parse_accuracy(text: &str) -> Result<f32, String> {
    let wrong = "expected a number above 0 and up to 1";
    text.parse().ok().filter(|a| *a > 0.0 && *a <= 1.0).ok_or_else(|| wrong.into())
}

/// A radius of a cache's records in pixels; 0 sets no limit.
///
/// # Errors
/// What was expected.
pub fn parse_spacing(text: &str) -> Result<f32, String> {
    let wrong = "expected a number of pixels, 0 or more";
    text.parse().ok().filter(|p: &f32| *p >= 0.0 && p.is_finite()).ok_or_else(|| wrong.into())
}

/// Check that the least and the largest radius of records leave one between them.
///
/// # Errors
/// That they do not.
pub fn check_spacings(min: f32, max: f32) -> Result<(), String> {
    if max > 0.0 && max < min {
        return Err(format!("--max-spacing {max} is less than --min-spacing {min}"));
    }
    Ok(())
}

/// A pixel: its column and row from the top left corner, X,Y.
///
/// # Errors
/// What was expected.
pub fn parse_pixel(text: &str) -> Result<[usize; 2], String> {
    let wrong = "expected two pixel coordinates from the top left corner: X,Y";
    let (x, y) = text.split_once(',').ok_or(wrong)?;
    let number = |t: &str| t.trim().parse().map_err(|_| wrong.to_string());
    Ok([number(x)?, number(y)?])
}

/// Whether a file of points is to be a table by its name; else it is a point cloud.
pub fn is_table(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_in_their_ranges_or_refused() {
        assert_eq!(parse_bound("inf"), Ok(f32::INFINITY));
        assert!(["0", "-1", "nan", "x"].iter().all(|t| parse_bound(t).is_err()));
        assert_eq!(parse_accuracy("1"), Ok(1.0));
        assert!(["0", "1.1", "nan", "x"].iter().all(|t| parse_accuracy(t).is_err()));
        assert_eq!(parse_spacing("0"), Ok(0.0));
        assert!(["-1", "inf", "nan", "x"].iter().all(|t| parse_spacing(t).is_err()));
        assert_eq!(parse_pixel("3, 4"), Ok([3, 4]));
        assert!(["3", "3,4,5", "-1,4", "1.5,4", ","].iter().all(|t| parse_pixel(t).is_err()));
    }

    #[test]
    fn a_largest_spacing_of_0_is_no_limit() {
        assert_eq!(check_spacings(3.0, 0.0), Ok(()));
        assert_eq!(check_spacings(3.0, 3.0), Ok(()));
        assert!(check_spacings(3.0, 2.0).is_err());
    }

    #[test]
    fn files_of_points_are_known_by_their_names() {
        let check = |name: &str| check_points_file("--points-out", &Some(name.into()));
        assert!(["a.ply", "a.csv", "b/a.CSV"].iter().all(|name| check(name).is_ok()));
        assert!(["a.txt", "csv", "a.csv.gz"].iter().all(|name| check(name).is_err()));
        assert_eq!(check_points_file("--points-out", &None), Ok(()));
        let table = ["a.ply", "a.csv", "a.CSV"].map(|name| is_table(Path::new(name)));
        assert_eq!(table, [false, true, true]);
    }
}
