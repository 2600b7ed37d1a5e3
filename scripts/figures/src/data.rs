//! The functions of a figure's files that claims and captions may use.
//!
//! | function | value |
//! |---|---|
//! | `mean(P)`, `red(P)`, `green(P)`, `blue(P)` | mean luminance, or mean of a channel |
//! | `max(P)`, `spread(P)`, `percentile(P, 99)` | largest luminance; standard deviation over mean; percentile of luminance |
//! | `relmse(P)`, `rmse(P)`, `ratio(P)` | errors, and the ratio of mean luminances, against the figure's reference |
//! | `relmse(P, Q)`, `rmse(P, Q)`, `ratio(P, Q)` | the same against another picture |
//! | `seconds(P)`, `said(P, NAME)` | a number of the picture's metadata |
//! | `slope(T:X:Y)` | slope of the straight line through log Y over log X |
//! | `first(T:Y)`, `last(T:Y)`, `least(T:Y)`, `most(T:Y)`, `median(T:Y)`, `count(T:Y)`, `sum(T:Y)` | of a column |
//! | `at(T:X:Y, 5)` | Y in the row whose X is nearest to 5 |
//! | `crossing(T:X:Y, U:X:Y)` | the last X at which the curves of two tables with equal X cross, on logarithmic axes |
//! | `holds(T:A:B)` | share of rows in which A is at most B |
//! | `within(T:A:B, 0 1 2 3)` | number of rows with A from 0 to 1 and B from 2 to 3 |
//! | `stat(F:key.key)` | a number of a statistics file |
//!
//! P is a picture of the figure's folder without `.exr`, `reference` for `--reference`; `P:Caustic` is a layer of it, and
//! `P[X Y W H]` the part from X, Y with the size W, H, as fractions of the picture. T is a table and F a JSON file, with extension.

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, bail};
use gi_stats::log_log_line;
use serde_json::Value;

use crate::expr::Functions;
use crate::picture::Picture;
use crate::table::Table;

/// Where a figure's files are, and what its pictures are compared with.
pub(crate) struct Data<'a> {
    pub(crate) folder: &'a Path,
    pub(crate) reference: Option<&'a Path>,
    /// Layer of pictures that do not name one.
    pub(crate) layer: Option<&'a str>,
}

impl Functions for Data<'_> {
    fn value(&self, function: &str, arguments: &[&str]) -> anyhow::Result<f64> {
        let told = || format!("{function}({})", arguments.join(", "));
        self.compute(function, arguments).with_context(told)
    }
}

fn luminance(rgb: &[f32]) -> f64 {
    f64::from(0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2])
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len().max(1) as f64;
    values.sum::<f64>() / n
}

/// Four numbers with spaces between them.
fn numbers(text: &str) -> anyhow::Result<[f64; 4]> {
    let numbers: Vec<f64> = text.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
    numbers.try_into().map_err(|_| anyhow!("expected four numbers, not {text}"))
}

/// The points that logarithmic axes can show.
fn positive(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.retain(|(x, y)| *x > 0.0 && *y > 0.0);
    points
}

impl Data<'_> {
    fn compute(&self, function: &str, arguments: &[&str]) -> anyhow::Result<f64> {
        let first = *arguments.first().unwrap_or(&"");
        match function {
            "mean" | "red" | "green" | "blue" | "max" | "spread" | "percentile" => {
                self.of_picture(function, &self.picture(first)?, arguments)
            }
            "relmse" | "rmse" | "ratio" => {
                let (picture, other) = (first, arguments.get(1).unwrap_or(&"reference"));
                // A part of a picture is compared with the same part of the reference.
                let part = picture.find('[').map_or("", |k| &picture[k..]);
                let other =
                    if other.contains('[') { other.to_string() } else { format!("{other}{part}") };
                let (picture, other) = (self.picture(picture)?, self.picture(&other)?);
                let errors = picture.errors(&other)?;
                Ok(match function {
                    "relmse" => errors.rel_mse,
                    "rmse" => errors.rmse,
                    _ => {
                        mean(picture.rgb.chunks(3).map(luminance))
                            / mean(other.rgb.chunks(3).map(luminance))
                    }
                })
            }
            "seconds" | "said" => {
                let name = if function == "said" {
                    arguments.get(1).context("expected P, NAME")?
                } else {
                    function
                };
                let picture = self.picture(first)?;
                let said = picture.said(name).with_context(|| format!("it does not say {name}"))?;
                said.parse().with_context(|| format!("{name}: {said}"))
            }
            "crossing" => self.crossing(arguments),
            "slope" | "first" | "last" | "least" | "most" | "median" | "count" | "sum" | "at"
            | "holds" | "within" => self.of_table(function, arguments),
            "stat" => self.statistic(first),
            _ => bail!(
                "no function {function}; there are mean, red, green, blue, max, spread, percentile, relmse, rmse, ratio, seconds, said, slope, first, last, least, most, median, count, sum, at, crossing, holds, within, stat"
            ),
        }
    }

    /// The picture that an argument names: `NAME:LAYER[X Y W H]`.
    fn picture(&self, argument: &str) -> anyhow::Result<Picture> {
        let (name, part) = match argument.split_once('[') {
            Some((name, part)) => (name, Some(part.strip_suffix(']').context("expected ]")?)),
            None => (argument, None),
        };
        let (name, layer) = match name.split_once(':') {
            Some((name, layer)) => (name, Some(layer)),
            None => (name, self.layer),
        };
        let file = self.file(name)?;
        let picture = Picture::read(&file, layer)?;
        let Some(part) = part else { return Ok(picture) };
        picture.part(numbers(part)?)
    }

    fn file(&self, name: &str) -> anyhow::Result<PathBuf> {
        // The reference that was asked for, though an older one may be in the folder.
        if let Some(reference) = self.reference.filter(|_| name == "reference") {
            return Ok(reference.to_path_buf());
        }
        if name == "reference" && !self.folder.join("reference.exr").exists() {
            bail!("the figure has no --reference");
        }
        // Names may contain points, so the extension is appended, not replaced.
        let name = if name.ends_with(".exr") { name.to_string() } else { format!("{name}.exr") };
        Ok(self.folder.join(name))
    }

    fn of_picture(
        &self,
        function: &str,
        picture: &Picture,
        arguments: &[&str],
    ) -> anyhow::Result<f64> {
        let mut lights: Vec<f64> = picture.rgb.chunks(3).map(luminance).collect();
        let channel = |k: usize| mean(picture.rgb.chunks(3).map(|c| f64::from(c[k])));
        let middle = mean(lights.iter().copied());
        Ok(match function {
            "red" => channel(0),
            "green" => channel(1),
            "blue" => channel(2),
            "max" => lights.into_iter().fold(0.0, f64::max),
            "spread" => mean(lights.iter().map(|v| (v - middle).powi(2))).sqrt() / middle,
            "percentile" => {
                let share: f64 = arguments.get(1).context("expected P, PERCENT")?.parse()?;
                lights.sort_by(f64::total_cmp);
                let k = (share / 100.0 * lights.len() as f64) as usize;
                lights[k.min(lights.len() - 1)]
            }
            _ => middle,
        })
    }

    fn of_table(&self, function: &str, arguments: &[&str]) -> anyhow::Result<f64> {
        let mut parts = arguments[0].split(':');
        let file = self.folder.join(parts.next().unwrap_or_default());
        let names: Vec<&str> = parts.collect();
        let table = Table::read(&file)?;
        let both = || match names[..] {
            [x, y] => table.points([x, y]),
            _ => bail!("expected TABLE:X:Y"),
        };
        match function {
            "slope" => {
                Ok(log_log_line(&positive(both()?)).context("fewer than two positive points")?.0)
            }
            "holds" => {
                let rows = both()?;
                let within = rows.iter().filter(|(a, b)| *a <= b * (1.0 + 1e-4) + 1e-12).count();
                Ok(within as f64 / rows.len() as f64)
            }
            "within" => {
                let box_of = arguments.get(1).context("expected TABLE:A:B, LOW HIGH LOW HIGH")?;
                let [a, b, c, d] = numbers(box_of)?;
                let inside = |p: &&(f64, f64)| (a..=b).contains(&p.0) && (c..=d).contains(&p.1);
                Ok(both()?.iter().filter(inside).count() as f64)
            }
            "at" => {
                let x: f64 = arguments.get(1).context("expected TABLE:X:Y, X")?.parse()?;
                let rows = both()?;
                let near = rows.iter().min_by(|a, b| (a.0 - x).abs().total_cmp(&(b.0 - x).abs()));
                Ok(near.context("an empty table")?.1)
            }
            _ => {
                let [name] = names[..] else { bail!("expected TABLE:COLUMN") };
                let mut values: Vec<f64> =
                    table.points([name, name])?.iter().map(|p| p.0).collect();
                match function {
                    "first" => Ok(values[0]),
                    "last" => Ok(values[values.len() - 1]),
                    "count" => Ok(values.len() as f64),
                    "sum" => Ok(values.iter().sum()),
                    _ => {
                        values.sort_by(f64::total_cmp);
                        let k = match function {
                            "least" => 0,
                            "most" => values.len() - 1,
                            _ => values.len() / 2,
                        };
                        Ok(values[k])
                    }
                }
            }
        }
    }

    /// Where the curves of two tables cross.
    fn crossing(&self, arguments: &[&str]) -> anyhow::Result<f64> {
        let points = |argument: &str| {
            let parts: Vec<&str> = argument.split(':').collect();
            let [table, x, y] = parts[..] else { bail!("expected TABLE:X:Y") };
            Table::read(&self.folder.join(table))?.points([x, y])
        };
        let [a, b] = arguments[..] else { bail!("expected two curves") };
        let (a, b) = (points(a)?, points(b)?);
        let apart: Vec<(f64, f64)> =
            a.iter().zip(&b).map(|(a, b)| (a.0.ln(), (a.1 / b.1).ln())).collect();
        let crosses = |w: &&[(f64, f64)]| (w[0].1 > 0.0) != (w[1].1 > 0.0);
        // The last one: short times at the left are noisy, and may cross more than once.
        let found = apart.windows(2).rev().find(crosses).context("the curves do not cross")?;
        let [(x, u), (y, v)] = [found[0], found[1]];
        Ok((x + (y - x) * u / (u - v)).exp())
    }

    fn statistic(&self, argument: &str) -> anyhow::Result<f64> {
        let (name, keys) = argument.split_once(':').context("expected FILE.json:key.key")?;
        let file = self.folder.join(name);
        let text = std::fs::read_to_string(&file).with_context(|| file.display().to_string())?;
        let all: Value = serde_json::from_str(&text).with_context(|| file.display().to_string())?;
        let found = keys.split('.').try_fold(&all, |v, key| match v {
            Value::Array(items) => items.get(key.parse::<usize>().ok()?),
            _ => v.get(key),
        });
        found.and_then(Value::as_f64).with_context(|| format!("{name} has no number {keys}"))
    }
}
