//! Irradiance at points instead of a picture: reads the points of `--points`, and writes the table of results.

use std::fmt::Write as _;
use std::path::Path;

use clap::{ArgMatches, Command};
use gi_core::camera::{Sensor, SensorFilm};
use gi_core::files;
use gi_core::film::Film;
use gi_core::image_io::Layers;
use gi_core::scene::Scene;
use glam::{DVec3, Vec3};

use crate::Failure;
use crate::run::input_error;

/// The points of a file.
pub(crate) struct Sensors(Vec<Row>);

/// A point and its normal, world, as the file has them.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Row {
    p: DVec3,
    n: DVec3,
}

/// Most points of a file: each takes a pixel of the film.
const MOST: usize = 1 << 26;

/// Most samples of a point per pass, and about the number of pixels of the film if there are fewer points than that.
const MOST_SAMPLES: usize = 256;
const FILM: usize = 1 << 16;

/// The groups of columns of the output, and the layers that they come from.
const GROUPS: [(&str, &str); 5] = [
    ("", ""),
    ("se_", "Variance."),
    ("direct_", "Direct."),
    ("indirect_", "Indirect."),
    ("caustic_", "Caustic."),
];

/// The columns of an input.
const COLUMNS: &str = "x,y,z,nx,ny,nz";

impl Sensors {
    /// Read a file.
    pub(crate) fn read(path: &Path) -> Result<Self, Failure> {
        let bytes = files::read(path).map_err(input_error)?;
        let text = String::from_utf8(bytes)
            .map_err(|_| input_error(format!("{}: this is not UTF-8 text", path.display())))?;
        parse(&text)
            .map(Sensors)
            .map_err(|(line, cause)| input_error(format!("{}:{line}: {cause}", path.display())))
    }

    /// The number of samples that a pass takes of each point: many if there are few points. Then what a technique does once per pass,
    /// such as tracing photons, is used well.
    pub(crate) fn samples(&self) -> usize {
        (FILM / self.0.len()).clamp(1, MOST_SAMPLES)
    }

    /// The size of the film.
    pub(crate) fn film_size(&self) -> [usize; 2] {
        self.film().size()
    }

    fn film(&self) -> SensorFilm {
        SensorFilm::new(self.0.len(), self.samples())
    }

    /// The mean over all points of what a film shows.
    pub(crate) fn mean(&self, film: &Film) -> [f64; 3] {
        let radiance = film.radiance();
        std::array::from_fn(|c| {
            let of_point = |k| self.mean_of(k, |i| f64::from(radiance[i].to_array()[c]));
            (0..self.0.len()).map(of_point).sum::<f64>() / self.0.len() as f64
        })
    }

    /// The points in the coordinates of a scene that was moved by `shift`.
    pub(crate) fn in_scene(&self, shift: Vec3) -> Vec<Sensor> {
        let place =
            |row: &Row| Sensor { p: (row.p + shift.as_dvec3()).as_vec3(), n: row.n.as_vec3() };
        self.0.iter().map(place).collect()
    }

    /// The table of results after a number of passes: each point with its irradiance, the standard errors, and the components.
    pub(crate) fn table(&self, layers: &Layers, passes: u32) -> Vec<u8> {
        let mut columns: Vec<(String, Vec<f64>)> = Vec::new();
        for (ours, layer) in GROUPS {
            for channel in ["R", "G", "B"] {
                let find = |layer| layers.channel(&format!("{layer}{channel}"));
                if let Some(values) = find(layer) {
                    let values = match (layer, find("")) {
                        ("Variance.", Some(shown)) => {
                            self.errors(shown, (passes > 1).then_some(values))
                        }
                        _ => self.means(values),
                    };
                    columns.push((format!("{ours}{}", channel.to_lowercase()), values));
                }
            }
        }
        let mut text = COLUMNS.to_string();
        columns.iter().for_each(|(name, ..)| text.extend([",", name]));
        for (k, Row { p, n }) in self.0.iter().enumerate() {
            text.push('\n');
            let place: Vec<String> =
                p.to_array().iter().chain(&n.to_array()).map(f64::to_string).collect();
            text.push_str(&place.join(","));
            for (_, values) in &columns {
                write!(text, ",{}", values[k] as f32).expect("writing to a string");
            }
        }
        text.push('\n');
        text.into_bytes()
    }

    /// The mean of each point over its pixels.
    fn means(&self, pixels: &[f32]) -> Vec<f64> {
        (0..self.0.len()).map(|k| self.mean_of(k, |i| f64::from(pixels[i]))).collect()
    }

    /// The mean of a function of the pixels of point `k`.
    fn mean_of(&self, k: usize, value: impl Fn(usize) -> f64) -> f64 {
        self.film().pixels_of(k).map(value).sum::<f64>() / self.samples() as f64
    }

    /// The standard error of the mean of each point, from the variances of its pixels over the passes. A single pass has none; then the
    /// spread of the pixels takes their place. It is NaN if there is only one sample.
    fn errors(&self, pixels: &[f32], variances: Option<&[f32]>) -> Vec<f64> {
        let samples = self.samples() as f64;
        let error = |k: usize| {
            if let Some(variances) = variances {
                return (self.mean_of(k, |i| f64::from(variances[i])) / samples).sqrt();
            }
            let mean = self.mean_of(k, |i| f64::from(pixels[i]));
            let square = self.mean_of(k, |i| (f64::from(pixels[i]) - mean).powi(2));
            (square / (samples - 1.0)).sqrt()
        };
        (0..self.0.len()).map(error).collect()
    }
}

/// Refuse a scene in which sensors do not work.
pub(crate) fn check_scene(scene: &Scene, file: &Path) -> Result<(), Failure> {
    if !scene.has_media() {
        return Ok(());
    }
    Err(input_error(format!(
        "{}: --points does not work in a scene with participating media: remove the media, or render a picture",
        file.display()
    )))
}

/// Refuse flags that draw over a picture.
pub(crate) fn check_flags(command: &Command, matches: &ArgMatches) -> Result<(), Failure> {
    let draws = |name: &str| ["show", "probe", "trace-pixel"].contains(&name);
    let given = command.get_arguments().find(|flag| {
        flag.get_long().is_some_and(draws) && matches.contains_id(flag.get_id().as_str())
    });
    match given.and_then(|flag| flag.get_long()) {
        Some(name) => Err(input_error(format!(
            "--{name} belongs to a picture, and --points makes none: leave one of them out"
        ))),
        None => Ok(()),
    }
}

/// The rows of a file, or the number of a line and what is wrong there. Numbers are separated by commas, semicolons or white space; text
/// after `#` is a comment, and the first line may be a header.
fn parse(text: &str) -> Result<Vec<Row>, (usize, String)> {
    let mut rows = Vec::new();
    let mut may_be_header = true;
    for (k, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default().trim_start_matches('\u{feff}').trim();
        let words: Vec<&str> = if line.contains([',', ';']) {
            line.split([',', ';']).map(str::trim).collect()
        } else {
            line.split_whitespace().collect()
        };
        if words.is_empty() {
            continue;
        }
        let is_header = may_be_header && words.iter().all(|word| word.parse::<f64>().is_err());
        may_be_header = false;
        if !is_header {
            rows.push(row(&words).map_err(|cause| (k + 1, cause))?);
        }
    }
    match rows.len() {
        0 => Err((1, format!("there is no point: expected lines of {COLUMNS}"))),
        1..=MOST => Ok(rows),
        _ => Err((MOST, format!("at most {MOST} points are accepted: divide the file"))),
    }
}

fn row(words: &[&str]) -> Result<Row, String> {
    let numbers: Option<Vec<f64>> = words.iter().map(|word| word.parse().ok()).collect();
    let Some([x, y, z, nx, ny, nz]) = numbers.as_deref().and_then(|n| <[f64; 6]>::try_from(n).ok())
    else {
        return Err(format!("expected six numbers, {COLUMNS}, found `{}`", words.join(",")));
    };
    let (p, n) = (DVec3::new(x, y, z), DVec3::new(nx, ny, nz));
    if !p.as_vec3().is_finite() {
        return Err("the point is not finite".into());
    }
    match n.try_normalize() {
        Some(n) => Ok(Row { p, n }),
        None => Err("the normal is zero or not finite: give a direction".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_read_with_header_comments_and_either_separator() {
        let text = "x,y,z,nx,ny,nz\n# a comment\n1, 2.5,-3e2, 0,0,2 # another\n\n1 2 3 0 -1 0\n";
        let rows = parse(text).expect("two points");
        assert_eq!(rows[0], Row { p: DVec3::new(1.0, 2.5, -300.0), n: DVec3::Z });
        assert_eq!(rows[1], Row { p: DVec3::new(1.0, 2.0, 3.0), n: -DVec3::Y });
    }

    #[test]
    fn wrong_points_are_refused_with_their_line() {
        let line = |text: &str| parse(text).expect_err(text).0;
        assert_eq!(line(""), 1);
        assert_eq!(line("0,0,0,0,0,1\n1,2,3\n"), 2);
        assert_eq!(line("0 0 0 0 0 1\n\nx y z nx ny nz\n"), 3);
        assert_eq!(line("0,0,0,0,0,0"), 1);
        assert_eq!(line("nan,0,0,0,0,1"), 1);
        assert_eq!(line("1e300,0,0,0,0,1"), 1);
        assert_eq!(line("0,0,0,0,inf,1"), 1);
    }

    #[test]
    fn the_table_has_the_means_of_the_columns_and_their_standard_errors() {
        let sensors = Sensors(parse("1,2,3,0,0,1\n4,5,6,0,0,1").expect("two points"));
        let [width, height] = sensors.film_size();
        assert_eq!((width, height), (2, MOST_SAMPLES));
        // The first point is 1 and 3 in turn, the second 0.5; the variance of a pixel is 4 and 0.
        let value = |k: usize| if k % 2 == 1 { 0.5 } else { 1.0 + (k / 2 % 2 * 2) as f32 };
        let pixels = (0..width * height).map(|k| [value(k); 3]);
        let mut layers = Layers::of_rgb([width, height], pixels);
        for channel in ["R", "G", "B"] {
            let variances = (0..width * height).map(|k| if k % 2 == 1 { 0.0 } else { 4.0 });
            layers.channels.push((format!("Variance.{channel}"), variances.collect()));
        }
        let table = String::from_utf8(sensors.table(&layers, 4)).expect("text");
        let header = "x,y,z,nx,ny,nz,r,g,b,se_r,se_g,se_b";
        let rows = "1,2,3,0,0,1,2,2,2,0.125,0.125,0.125\n4,5,6,0,0,1,0.5,0.5,0.5,0,0,0";
        assert_eq!(table, format!("{header}\n{rows}\n"));
    }

    #[test]
    fn the_standard_error_of_a_single_pass_is_not_zero() {
        let sensors = Sensors(parse("1,2,3,0,0,1\n4,5,6,0,0,1").expect("two points"));
        let [width, height] = sensors.film_size();
        let samples = height as f64;
        // The first point is 1 and 3 in turn, the second 0.5.
        let value = |k: usize| if k % 2 == 1 { 0.5 } else { 1.0 + (k / 2 % 2 * 2) as f32 };
        let pixels: Vec<f32> = (0..width * height).map(value).collect();
        assert_eq!(sensors.errors(&pixels, None), [(1.0 / (samples - 1.0)).sqrt(), 0.0]);
        let many = Sensors(vec![Row { p: DVec3::ZERO, n: DVec3::Z }; 100_000]);
        let [width, height] = many.film_size();
        let (dark, none) = (vec![0.0; width * height], vec![0.0; width * height]);
        let errors = many.errors(&dark, None);
        assert!(errors.iter().all(|e| e.is_nan()), "one sample has no standard error");
        let errors = many.errors(&dark, Some(&none));
        assert!(
            errors.iter().all(|e| *e == 0.0),
            "a point that all passes found dark has no error"
        );
    }

    #[test]
    fn many_points_have_one_sample_each_per_pass_and_take_no_more_memory_than_a_picture() {
        let sensors = Sensors(vec![Row { p: DVec3::ZERO, n: DVec3::Z }; 100_000]);
        assert_eq!(sensors.samples(), 1);
        let tiles = |size| Film::memory(size, gi_core::filter::Filter::Box);
        assert!(tiles(sensors.film_size()) < 2 * tiles([320, 320]));
    }
}
