//! Draws curves and lines with axes and a legend.

use gi_stats::log_log_line;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;

use super::source::Curve;
use super::{Args, Power};
use crate::svg::FONT;

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

/// Width and height. Small, so that the text is large: on a slide, a drawing may be a quarter of the picture.
const SIZE: (u32, u32) = (500, 360);

/// Height of a row of the legend, which has two columns below the axes, where it covers no curve.
const LEGEND_ROW: u32 = 22;

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

type Chart<'b, X, Y> = ChartContext<'b, SVGBackend<'b>, Cartesian2d<X, Y>>;
type Drawn = Result<(), Box<dyn std::error::Error>>;

/// The content of a drawing.
pub(super) struct Shown<'a> {
    pub(super) args: &'a Args,
    pub(super) curves: &'a [Curve],
    pub(super) levels: &'a [(String, f64)],
    pub(super) verticals: &'a [(String, f64)],
    pub(super) powers: &'a [Power],
    pub(super) y_range: [f64; 2],
}

/// An entry of the legend.
struct Entry {
    name: String,
    colour: RGBColor,
    /// The curve that it belongs to, whose mark it has; a line without marks has a dash.
    curve: Option<usize>,
}

impl Shown<'_> {
    pub(super) fn draw<X, Y>(&self, x: X, y: Y) -> Result<String, Box<dyn std::error::Error>>
    where
        X: AsRangedCoord<Value = f64>,
        Y: AsRangedCoord<Value = f64>,
        X::CoordDescType: ValueFormatter<f64>,
        Y::CoordDescType: ValueFormatter<f64>,
    {
        let mut out = String::new();
        {
            let legend = self.legend();
            let (_, height) = SIZE;
            let root = SVGBackend::with_string(&mut out, SIZE).into_drawing_area();
            root.fill(&WHITE)?;
            let rows = legend.len().div_ceil(2) as u32;
            let (axes, below) = root.split_vertically(height - LEGEND_ROW * rows);
            let mut chart = ChartBuilder::on(&axes)
                .caption(&self.args.title, (FONT, 22))
                .margin(8)
                .x_label_area_size(50)
                .y_label_area_size(78)
                .build_cartesian_2d(x, y)?;
            chart
                .configure_mesh()
                .x_desc(&self.args.x)
                .y_desc(&self.args.y)
                .axis_desc_style((FONT, 20))
                .label_style((FONT, 18))
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
                let [low, high] = self.y_range;
                let mut shown = power.points.clone();
                shown.retain(|p| (low..=high).contains(&p.1));
                draw_line(&mut chart, power.colour(), &shown)?;
            }
            let xs = self.curves.iter().flat_map(|c| c.points.iter().map(|p| p.0));
            let [low, high] = xs.fold([f64::MAX, -f64::MAX], |[l, h], x| [l.min(x), h.max(x)]);
            for (_, y) in self.levels {
                draw_line(&mut chart, BLACK, &[(low, *y), (high, *y)])?;
            }
            let [low, high] = self.y_range;
            for (_, x) in self.verticals {
                draw_line(&mut chart, BLACK, &[(*x, low), (*x, high)])?;
            }
            draw_legend(&below, &legend)?;
            root.present()?;
        }
        Ok(out)
    }

    /// Draw curve number `k`.
    fn draw_curve<'b, X, Y>(&self, chart: &mut Chart<'b, X, Y>, k: usize) -> Drawn
    where
        X: Ranged<ValueType = f64>,
        Y: Ranged<ValueType = f64>,
    {
        let (scatter, c) = (self.args.scatter, &self.curves[k]);
        let colour = COLOURS[k % COLOURS.len()];
        if !scatter {
            let line = LineSeries::new(c.points.iter().copied(), colour.stroke_width(2));
            chart.draw_series(line)?;
        }
        // If there are many points, mark only some of them.
        let every = c.points.len().div_ceil(if scatter { 4000 } else { 24 });
        let size = if scatter { 1 } else { 4 };
        let marked = c.points.iter().copied().step_by(every.max(1));
        chart.draw_series(marked.map(|p| mark!(k, p, size, colour)))?;
        Ok(())
    }

    /// The legend: curves, with their slopes if these are asked for, then lines.
    fn legend(&self) -> Vec<Entry> {
        let curves = self.curves.iter().enumerate().map(|(k, c)| {
            let fit = if self.args.slopes { log_log_line(&c.points) } else { None };
            let name = match fit {
                Some((slope, _)) => format!("{} (slope {slope:.2})", c.name),
                None => c.name.clone(),
            };
            Entry { name, colour: COLOURS[k % COLOURS.len()], curve: Some(k) }
        });
        let line = |name: &String, colour| Entry { name: name.clone(), colour, curve: None };
        let powers = self.powers.iter().map(|p| line(&p.name, p.colour()));
        let others = self.levels.iter().chain(self.verticals).map(|(name, _)| line(name, BLACK));
        curves.chain(powers).chain(others).collect()
    }
}

impl Power {
    fn colour(&self) -> RGBColor {
        self.curve.map_or(BLACK, |k| COLOURS[k % COLOURS.len()])
    }
}

/// Draw a dashed line.
fn draw_line<'b, X, Y>(
    chart: &mut Chart<'b, X, Y>,
    colour: RGBColor,
    points: &[(f64, f64)],
) -> Drawn
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    let line = DashedLineSeries::new(points.iter().copied(), 7, 4, colour.stroke_width(2));
    chart.draw_series(line)?;
    Ok(())
}

/// Draw the entries of the legend in two columns, row by row.
fn draw_legend<'b>(area: &DrawingArea<SVGBackend<'b>, Shift>, legend: &[Entry]) -> Drawn {
    let (width, row) = (SIZE.0 as i32, LEGEND_ROW as i32);
    let left = [20, width / 2 + 10];
    for (i, entry) in legend.iter().enumerate() {
        let (x, y) = (left[i % 2], (i as i32 / 2) * row + row / 2 - 4);
        match entry.curve {
            Some(k) => area.draw(&mark!(k, (x + 10, y), 4, entry.colour))?,
            None => {
                // Two elements: one of four points would be a line without a gap.
                for from in [x + 1, x + 12] {
                    let ends = [(from, y), (from + 7, y)];
                    area.draw(&PathElement::new(ends, entry.colour.stroke_width(2)))?;
                }
            }
        }
        area.draw(&Text::new(entry.name.clone(), (x + 26, y - 8), (FONT, 18)))?;
    }
    Ok(())
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
