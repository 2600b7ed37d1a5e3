//! Draws curves and lines with axes and a legend.

use gi_stats::log_log_line;
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
const SIZE: (u32, u32) = (600, 420);

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
    pub(super) corner: SeriesLabelPosition,
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
            let root = SVGBackend::with_string(&mut out, SIZE).into_drawing_area();
            root.fill(&WHITE)?;
            let mut chart = ChartBuilder::on(&root)
                .caption(&self.args.title, (FONT, 22))
                .margin(12)
                .x_label_area_size(48)
                .y_label_area_size(78)
                .build_cartesian_2d(x, y)?;
            chart
                .configure_mesh()
                .x_desc(&self.args.x)
                .y_desc(&self.args.y)
                .axis_desc_style((FONT, 18))
                .label_style((FONT, 16))
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
                let [low, high] = self.y_range;
                let mut shown = power.points.clone();
                shown.retain(|p| (low..=high).contains(&p.1));
                self.draw_line(&mut chart, (&power.name, colour), &shown)?;
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
                .label_font((FONT, 16))
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
        let style = colour.stroke_width(2);
        // Two elements: one of four points would be a line without a gap.
        let dash = move |from: i32| PathElement::new([(from, 0), (from + 7, 0)], style);
        let series = chart.draw_series(line)?.label(name);
        series.legend(move |at| EmptyElement::at(at) + dash(1) + dash(12));
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
