//! Draws curves from the columns of tables.

mod source;

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use gi_stats::log_log_line;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;

use crate::data::Data;
use crate::expr;
use crate::svg::FONT;
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
    /// A horizontal line: a name, and an expression over the files beside the drawing
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
    // A logarithmic axis of less than a decade would have no tick marks, so such an axis is linear.
    let x_range = range(&curves, &[], log_x, 0);
    let y_range = range(&curves, &levels, log_y, 1);
    let long = |r: &std::ops::Range<f64>| r.end >= 8.0 * r.start;
    let [log_x, log_y] = [log_x && long(&x_range), log_y && long(&y_range)];
    let (x, y) = (|| x_range.clone(), || y_range.clone());
    let shown = Shown {
        args,
        curves: &curves,
        levels: &levels,
        verticals: &verticals,
        powers: &powers,
        y_range: [y_range.start, y_range.end],
        corner: corner(&curves, [x(), y()], [log_x, log_y]),
    };
    let picture = match (log_x, log_y) {
        (false, false) => shown.draw(x(), y()),
        (true, false) => shown.draw(x().log_scale(), y()),
        (false, true) => shown.draw(x(), y().log_scale()),
        (true, true) => shown.draw(x().log_scale(), y().log_scale()),
    };
    let picture = picture.map_err(|e| anyhow!("{}: {e}", args.out.display()))?;
    std::fs::write(&args.out, picture).with_context(|| args.out.display().to_string())
}

/// A line: its name, and the value of its expression.
fn line(text: &str, folder: &Path) -> anyhow::Result<(String, f64)> {
    let (name, y) =
        text.rsplit_once('=').with_context(|| format!("{text}: expected NAME=NUMBER"))?;
    let data = Data { folder, reference: None, layer: None };
    Ok((name.into(), expr::value(y, &data)?))
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
        let points = ends.map(|x| (x, factor * x.powf(power))).to_vec();
        return Ok(Power { name: name.into(), curve: None, points });
    }
    let k: usize = last.parse().with_context(told)?;
    let curve = k.checked_sub(1).and_then(|k| curves.get(k));
    let points = &curve.with_context(|| format!("--power {text}: there is no curve {k}"))?.points;
    let mean = |of: fn(&(f64, f64)) -> f64| {
        (points.iter().map(|p| of(p).ln()).sum::<f64>() / points.len() as f64).exp()
    };
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let points = points.iter().map(|p| (p.0, y * (p.0 / x).powf(power))).collect();
    Ok(Power { name: name.into(), curve: Some(k - 1), points })
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

/// Seven colours that colour-blind readers can distinguish \[Okabe & Ito\]. Marks and dashes distinguish the curves in
/// grey print.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
];

/// Format a number with few digits.
fn label(v: &f64) -> String {
    let size = v.abs();
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        return format!("{v:.0e}");
    }
    let text = format!("{v:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

/// The marks of curves, in turn: a disc, a triangle, a cross, a ring.
macro_rules! mark {
    ($curve:expr, $at:expr, $size:expr, $colour:expr) => {
        match $curve % 4 {
            0 => Circle::new($at, $size, $colour.filled()).into_dyn(),
            1 => TriangleMarker::new($at, $size + 1, $colour.filled()).into_dyn(),
            2 => Cross::new($at, $size, $colour.stroke_width(2)).into_dyn(),
            _ => Circle::new($at, $size, $colour.stroke_width(2)).into_dyn(),
        }
    };
}

/// The corner with the fewest points, for the legend.
fn corner(
    curves: &[Curve],
    ranges: [std::ops::Range<f64>; 2],
    log: [bool; 2],
) -> SeriesLabelPosition {
    let share = |v: f64, axis: usize| {
        let f = |v: f64| if log[axis] { v.ln() } else { v };
        let r = &ranges[axis];
        (f(v) - f(r.start)) / (f(r.end) - f(r.start))
    };
    let points = || curves.iter().flat_map(|c| &c.points).map(|p| (share(p.0, 0), share(p.1, 1)));
    let corners = [
        (SeriesLabelPosition::UpperRight, [true, true]),
        (SeriesLabelPosition::UpperLeft, [false, true]),
        (SeriesLabelPosition::LowerLeft, [false, false]),
        (SeriesLabelPosition::LowerRight, [true, false]),
    ];
    let within = |[right, up]: [bool; 2]| {
        let near = |(x, y): &(f64, f64)| {
            (if right { 1.0 - x } else { *x }) < 0.45 && (if up { 1.0 - y } else { *y }) < 0.4
        };
        points().filter(near).count()
    };
    let best = corners.into_iter().min_by_key(|(_, c)| within(*c));
    best.map_or(SeriesLabelPosition::UpperRight, |(position, _)| position)
}

type Chart<'b, X, Y> = ChartContext<'b, SVGBackend<'b>, Cartesian2d<X, Y>>;
type Drawn = Result<(), Box<dyn std::error::Error>>;

/// The content of a drawing.
struct Shown<'a> {
    args: &'a Args,
    curves: &'a [Curve],
    levels: &'a [(String, f64)],
    verticals: &'a [(String, f64)],
    powers: &'a [Power],
    y_range: [f64; 2],
    corner: SeriesLabelPosition,
}

impl Shown<'_> {
    fn draw<X, Y>(&self, x: X, y: Y) -> Result<String, Box<dyn std::error::Error>>
    where
        X: AsRangedCoord<Value = f64>,
        Y: AsRangedCoord<Value = f64>,
        X::CoordDescType: ValueFormatter<f64>,
        Y::CoordDescType: ValueFormatter<f64>,
    {
        let mut out = String::new();
        {
            let root = SVGBackend::with_string(&mut out, (720, 480)).into_drawing_area();
            root.fill(&WHITE)?;
            let mut chart = ChartBuilder::on(&root)
                .caption(&self.args.title, (FONT, 20))
                .margin(12)
                .x_label_area_size(44)
                .y_label_area_size(68)
                .build_cartesian_2d(x, y)?;
            chart
                .configure_mesh()
                .x_desc(&self.args.x)
                .y_desc(&self.args.y)
                .axis_desc_style((FONT, 16))
                .label_style((FONT, 13))
                .x_labels(6)
                .y_labels(6)
                .x_label_formatter(&label)
                .y_label_formatter(&label)
                .light_line_style(RGBColor(240, 240, 240))
                .bold_line_style(RGBColor(215, 215, 215))
                .draw()?;
            for k in 0..self.curves.len() {
                self.draw_curve(&mut chart, k)?;
            }
            for power in self.powers {
                let colour = power.curve.map_or(BLACK, |k| COLOURS[k % COLOURS.len()]);
                self.draw_line(&mut chart, (&power.name, colour), &power.points)?;
            }
            let xs = self.curves.iter().flat_map(|c| c.points.iter().map(|p| p.0));
            let [low, high] = xs.fold([f64::MAX, -f64::MAX], |[l, h], x| [l.min(x), h.max(x)]);
            for (name, y) in self.levels {
                self.draw_line(&mut chart, (name, BLACK), &[(low, *y), (high, *y)])?;
            }
            let [low, high] = self.y_range;
            for (name, x) in self.verticals {
                self.draw_line(&mut chart, (name, BLACK), &[(*x, low), (*x, high)])?;
            }
            chart
                .configure_series_labels()
                .position(self.corner.clone())
                .background_style(WHITE.mix(0.85))
                .border_style(RGBColor(180, 180, 180))
                .label_font((FONT, 14))
                .draw()?;
            root.present()?;
        }
        Ok(out)
    }

    /// Draw curve number `k`, with its entry in the legend.
    fn draw_curve<'b, X, Y>(&self, chart: &mut Chart<'b, X, Y>, k: usize) -> Drawn
    where
        X: Ranged<ValueType = f64>,
        Y: Ranged<ValueType = f64>,
    {
        let (args, c) = (self.args, &self.curves[k]);
        let colour = COLOURS[k % COLOURS.len()];
        let fit = if args.slopes { log_log_line(&c.points) } else { None };
        let name = match fit {
            Some((slope, _)) => format!("{} (slope {slope:.2})", c.name),
            None => c.name.clone(),
        };
        if !args.scatter {
            let line = LineSeries::new(c.points.iter().copied(), colour.stroke_width(2));
            chart.draw_series(line)?;
        }
        // If there are many points, mark only some of them.
        let every = c.points.len().div_ceil(if args.scatter { 4000 } else { 24 });
        let size = if args.scatter { 1 } else { 4 };
        let marked = c.points.iter().copied().step_by(every.max(1));
        let series = chart.draw_series(marked.map(|p| mark!(k, p, size, colour)))?;
        series.label(name).legend(move |(x, y)| mark!(k, (x + 10, y), 4, colour));
        Ok(())
    }

    /// Draw a dashed line, with its entry in the legend.
    fn draw_line<'b, X, Y>(
        &self,
        chart: &mut Chart<'b, X, Y>,
        (name, colour): (&str, RGBColor),
        points: &[(f64, f64)],
    ) -> Drawn
    where
        X: Ranged<ValueType = f64>,
        Y: Ranged<ValueType = f64>,
    {
        let line = DashedLineSeries::new(points.iter().copied(), 7, 4, colour.stroke_width(2));
        let dash = move |from: i32, (x, y): (i32, i32)| [(x + from, y), (x + from + 7, y)];
        chart.draw_series(line)?.label(name).legend(move |at| {
            PathElement::new([dash(1, at), dash(12, at)].concat(), colour.stroke_width(2))
        });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_have_few_digits() {
        let all = [0.0, 0.25, 1000.0, 2e6, 3e-5].map(|v| label(&v));
        assert_eq!(all, ["0", "0.25", "1000", "2e6", "3e-5"]);
    }
}
