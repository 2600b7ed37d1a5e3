//! Draws curves from the columns of tables.

mod draw;
mod source;

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::{BindKeyPoints, IntoLogRange};

use crate::data::Data;
use crate::expr;
use draw::Shown;
use source::{Curve, Source, curve};

#[derive(clap::Args)]
pub(crate) struct Args {
    /// The drawing to write (.svg)
    out: PathBuf,
    /// Title above the drawing
    #[arg(long)]
    title: String,
    /// Name and unit of the horizontal axis
    #[arg(long)]
    x: String,
    /// Name and unit of the vertical axis
    #[arg(long)]
    y: String,
    /// Axes with a logarithmic scale
    #[arg(long, value_enum, default_value_t = Log::None)]
    log: Log,
    /// Add the fitted slope of log y over log x to each curve's name
    #[arg(long)]
    slopes: bool,
    /// A horizontal line: a name, in which {EXPRESSION} becomes a number, and an expression over the files beside the drawing
    #[arg(long, value_name = "NAME=Y")]
    level: Vec<String>,
    /// A vertical line
    #[arg(long, value_name = "NAME=X")]
    vertical: Vec<String>,
    /// A line of theory: y ~ x^POWER through the middle of curve K (from 1), or y = FACTOR x^POWER
    #[arg(long, value_name = "NAME=POWER@K|NAME=POWER*FACTOR")]
    power: Vec<String>,
    /// Draw points without lines between them
    #[arg(long)]
    scatter: bool,
    /// Curves: name, table, and the columns of both axes
    #[arg(value_name = "NAME=TABLE.csv:X:Y", required = true)]
    curves: Vec<Source>,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Log {
    None,
    X,
    Y,
    Xy,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let [log_x, log_y] =
        [[Log::X, Log::Xy], [Log::Y, Log::Xy]].map(|logs| logs.contains(&args.log));
    let curves: Vec<Curve> =
        args.curves.iter().map(|s| curve(s, [log_x, log_y])).collect::<Result<_, _>>()?;
    let folder = args.out.parent().unwrap_or(Path::new("."));
    let lines = |all: &[String]| -> anyhow::Result<Vec<(String, f64)>> {
        all.iter().map(|text| line(text, folder)).collect()
    };
    let (levels, verticals) = (lines(&args.level)?, lines(&args.vertical)?);
    let powers = args.power.iter().map(|text| power(text, &curves));
    let powers = powers.collect::<anyhow::Result<Vec<_>>>()?;
    // A logarithmic axis of less than a factor of 3 would have hardly any tick marks, so such an axis is linear.
    let x_range = range(&curves, &[], log_x, 0);
    let y_range = range(&curves, &levels, log_y, 1);
    let long = |r: &std::ops::Range<f64>| r.end >= 3.0 * r.start;
    let [log_x, log_y] = [log_x && long(&x_range), log_y && long(&y_range)];
    let (x, y) = (|| x_range.clone(), || y_range.clone());
    let shown = Shown {
        args,
        curves: &curves,
        levels: &levels,
        verticals: &verticals,
        powers: &powers,
        y_range: [y_range.start, y_range.end],
    };
    let picture = match (log_x, log_y) {
        (false, false) => shown.draw(x(), y()),
        (true, false) => shown.draw(log_axis(x()), y()),
        (false, true) => shown.draw(x(), log_axis(y())),
        (true, true) => shown.draw(log_axis(x()), log_axis(y())),
    };
    let picture = picture.map_err(|e| anyhow!("{}: {e}", args.out.display()))?;
    std::fs::write(&args.out, picture).with_context(|| args.out.display().to_string())
}

/// A line: its name, and the value of its expression.
fn line(text: &str, folder: &Path) -> anyhow::Result<(String, f64)> {
    let (name, y) =
        text.rsplit_once('=').with_context(|| format!("{text}: expected NAME=NUMBER"))?;
    let data = Data { folder, reference: None, layer: None };
    Ok((expr::filled(name, &data)?, expr::value(y, &data)?))
}

/// A line of theory. It belongs to a curve, and runs over its range through the middle of its points on logarithmic axes, or stands
/// for itself.
struct Power {
    name: String,
    curve: Option<usize>,
    points: Vec<(f64, f64)>,
}

fn power(text: &str, curves: &[Curve]) -> anyhow::Result<Power> {
    let told = || format!("--power {text}: expected NAME=POWER@K or NAME=POWER*FACTOR");
    let (name, law) = text.rsplit_once('=').with_context(told)?;
    let on_curve = law.contains('@');
    let (power, last) = law.split_once(['@', '*']).with_context(told)?;
    let power: f64 = power.parse().with_context(told)?;
    let all = curves.iter().flat_map(|c| &c.points);
    if !on_curve {
        let factor: f64 = last.parse().with_context(told)?;
        let ends = all.fold([f64::MAX, 0.0f64], |[l, h], p| [l.min(p.0), h.max(p.0)]);
        let points = law_points(ends, |x| factor * x.powf(power));
        return Ok(Power { name: name.into(), curve: None, points });
    }
    let k: usize = last.parse().with_context(told)?;
    let curve = k.checked_sub(1).and_then(|k| curves.get(k));
    let points = &curve.with_context(|| format!("--power {text}: there is no curve {k}"))?.points;
    let mean = |of: fn(&(f64, f64)) -> f64| {
        (points.iter().map(|p| of(p).ln()).sum::<f64>() / points.len() as f64).exp()
    };
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let ends = points.iter().fold([f64::MAX, 0.0f64], |[l, h], p| [l.min(p.0), h.max(p.0)]);
    let points = law_points(ends, |at| y * (at / x).powf(power));
    Ok(Power { name: name.into(), curve: Some(k - 1), points })
}

/// Points of a law between two ends, close enough on logarithmic axes that the drawing may leave out those outside.
fn law_points([low, high]: [f64; 2], law: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let at = |k: i32| low * (high / low).powf(f64::from(k) / 100.0);
    (0..=100).map(at).map(|x| (x, law(x))).collect()
}

/// The range of an axis: from the smallest to the largest number, with a margin.
fn range(
    curves: &[Curve],
    levels: &[(String, f64)],
    log: bool,
    axis: usize,
) -> std::ops::Range<f64> {
    let of = |p: &(f64, f64)| if axis == 0 { p.0 } else { p.1 };
    let levels = levels.iter().map(|(_, y)| *y).filter(|_| axis == 1);
    let all = curves.iter().flat_map(|c| c.points.iter().map(of)).chain(levels);
    let (low, high) =
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if log {
        let room = (high / low).powf(0.05).max(1.1);
        return low / room..high * room;
    }
    let room = (0.05 * (high - low)).max(1e-6 * high.abs().max(1e-30));
    // If all numbers are non-negative and the smallest is close to zero, start the axis at zero.
    let low = if low >= 0.0 && low < 0.5 * high { 0.0 } else { low - room };
    low..high + room
}

/// A logarithmic axis. The shorter it is, the more digits of every decade have a number.
fn log_axis(
    range: std::ops::Range<f64>,
) -> impl AsRangedCoord<Value = f64, CoordDescType: ValueFormatter<f64>> {
    let numbers = ticks(&range, digits_with_number(range.end / range.start));
    let lines = ticks(&range, &[1, 2, 3, 4, 5, 6, 7, 8, 9]);
    range.log_scale().with_key_points(numbers).with_light_points(lines)
}

/// The digits of a decade that have a number, on an axis whose end is `ratio` times its start.
fn digits_with_number(ratio: f64) -> &'static [u32] {
    match ratio {
        r if r < 6.0 => &[1, 2, 3, 4, 5, 6, 7, 8, 9],
        r if r < 20.0 => &[1, 2, 3, 5, 7],
        r if r < 300.0 => &[1, 2, 5],
        _ => &[1],
    }
}

/// These digits times powers of ten, as far as they are within the range.
fn ticks(range: &std::ops::Range<f64>, digits: &[u32]) -> Vec<f64> {
    let [low, high] = [range.start.log10().floor() as i32, range.end.log10().ceil() as i32];
    let decades = (low..=high).map(|decade| 10f64.powi(decade));
    let all = decades.flat_map(|ten| digits.iter().map(move |&digit| f64::from(digit) * ten));
    all.filter(|tick| range.contains(tick)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_within_the_range() {
        assert_eq!(ticks(&(0.3..25.0), &[1, 2, 5]), [0.5, 1.0, 2.0, 5.0, 10.0, 20.0]);
        assert_eq!(ticks(&(0.5..2e3), &[1]), [1.0, 10.0, 100.0, 1000.0]);
    }

    #[test]
    fn the_axes_of_narrow_ranges_have_three_numbers() {
        for (start, ratio) in
            [0.0013, 0.0024, 0.0055, 0.0072].map(|s| (s, 3.3)).into_iter().chain([(6e-4, 7.0)])
        {
            let range = start..ratio * start;
            let numbers = ticks(&range, digits_with_number(ratio));
            assert!(numbers.len() >= 3, "{range:?}: {numbers:?}");
        }
    }
}
