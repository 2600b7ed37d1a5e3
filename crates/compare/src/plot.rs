//! Plots error against time on logarithmic axes, as SVG.

use std::fmt::Write;

use crate::text::{escape, number};

/// The curve of one technique.
pub(crate) struct Curve<'a> {
    pub(crate) label: &'a str,
    /// Index of its colour and mark.
    pub(crate) style: usize,
    /// Seconds and error, all positive.
    pub(crate) points: Vec<(f64, f64)>,
    /// Slope of the fitted line, and its error at one second.
    pub(crate) line: Option<(f64, f64)>,
}

/// Colours that colour-blind readers can distinguish, ordered so that neighbours differ most \[Okabe08\].
pub(crate) const COLOURS: [&str; 7] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c6d46"];

const WIDTH: f64 = 620.0;
const HEIGHT: f64 = 380.0;
/// Left, right, top and bottom margin.
const MARGINS: [f64; 4] = [70.0, 16.0, 14.0, 48.0];

/// A logarithmic axis.
struct Axis {
    low: f64,
    high: f64,
    /// Positions of the low and the high end in the plot.
    at: [f64; 2],
}

impl Axis {
    fn new(values: impl Iterator<Item = f64>, at: [f64; 2]) -> Self {
        let (low, high) =
            values.fold((f64::INFINITY, 0.0f64), |(lo, hi), v| (lo.min(v), hi.max(v)));
        Axis { low: low / 1.25, high: high * 1.25, at }
    }

    fn place(&self, v: f64) -> f64 {
        let t = (v / self.low).ln() / (self.high / self.low).ln();
        self.at[0] + (self.at[1] - self.at[0]) * t
    }

    /// 1, 2 and 5 times powers of ten; only powers of ten if there are many.
    fn ticks(&self) -> Vec<f64> {
        let decades = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
        let steps: &[f64] = if self.high / self.low > 3e3 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        decades
            .flat_map(|d| steps.iter().map(move |s| s * 10f64.powi(d)))
            .filter(|v| (self.low..=self.high).contains(v))
            .collect()
    }
}

/// Draw a plot; `None` if there are no points.
pub(crate) fn plot(name: &str, curves: &[Curve]) -> Option<String> {
    let points = || curves.iter().flat_map(|c| c.points.iter());
    points().next()?;
    let [left, right, top, bottom] = MARGINS;
    let x = Axis::new(points().map(|p| p.0), [left, WIDTH - right]);
    let y = Axis::new(points().map(|p| p.1), [HEIGHT - bottom, top]);
    let mut svg = format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{} against seconds, logarithmic axes\">",
        escape(name)
    );
    // Writing to a string cannot fail.
    let _ = grid(&mut svg, name, &x, &y);
    for curve in curves {
        let _ = draw(&mut svg, curve, &x, &y);
    }
    svg += "</svg>";
    Some(svg)
}

fn grid(svg: &mut String, name: &str, x: &Axis, y: &Axis) -> std::fmt::Result {
    let ([x0, x1], [y0, y1]) = (x.at, y.at);
    for v in x.ticks() {
        let at = x.place(v);
        write!(svg, "<path class=\"grid\" d=\"M{at:.1} {y0}V{y1}\"/>")?;
        write!(
            svg,
            "<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            y0 + 18.0,
            plain(v)
        )?;
    }
    for v in y.ticks() {
        let at = y.place(v);
        write!(svg, "<path class=\"grid\" d=\"M{x0} {at:.1}H{x1}\"/>")?;
        write!(
            svg,
            "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            x0 - 6.0,
            at + 4.0,
            plain(v)
        )?;
    }
    let (middle, centre) = (0.5 * (x0 + x1), 0.5 * (y0 + y1));
    write!(
        svg,
        "<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">seconds, including preparation</text>",
        HEIGHT - 8.0
    )?;
    write!(
        svg,
        "<text x=\"14\" y=\"{centre}\" text-anchor=\"middle\" transform=\"rotate(-90 14 {centre})\">{}</text>",
        escape(name)
    )
}

/// Format a tick's number without needless digits.
fn plain(v: f64) -> String {
    if (1e-3..1e4).contains(&v) {
        format!("{}", (v * 1e6).round() / 1e6)
    } else {
        format!("{v:.0e}")
    }
}

fn draw(svg: &mut String, curve: &Curve, x: &Axis, y: &Axis) -> std::fmt::Result {
    let colour = COLOURS[curve.style % COLOURS.len()];
    write!(svg, "<g stroke=\"{colour}\" fill=\"{colour}\">")?;
    let slope = curve.line.map_or(String::new(), |(slope, _)| format!(", slope {slope:.2}"));
    write!(svg, "<title>{}{slope}</title>", escape(curve.label))?;
    if let Some((slope, at_one)) = curve.line {
        let ends = curve
            .points
            .iter()
            .fold((f64::INFINITY, 0.0f64), |(lo, hi), p| (lo.min(p.0), hi.max(p.0)));
        let place = |s: f64| (x.place(s), y.place(at_one * s.powf(slope)));
        let ((ax, ay), (bx, by)) = (place(ends.0), place(ends.1));
        write!(svg, "<path class=\"fit\" d=\"M{ax:.1} {ay:.1}L{bx:.1} {by:.1}\"/>")?;
    }
    for (seconds, error) in &curve.points {
        svg.push_str(&mark(curve.style, x.place(*seconds), y.place(*error)));
    }
    svg.push_str("</g>");
    Ok(())
}

/// A mark of one of seven shapes.
pub(crate) fn mark(style: usize, x: f64, y: f64) -> String {
    let path = |d: &str| format!("<path d=\"M{x:.1} {y:.1}{d}\"/>");
    match style % 7 {
        0 => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4.5\"/>"),
        1 => path("m-4.5 -4.5h9v9h-9z"),
        2 => path("m0 -6l5.5 9.5h-11z"),
        3 => path("m0 -6l6 6l-6 6l-6 -6z"),
        4 => path("m0 6l5.5 -9.5h-11z"),
        5 => path("m-5 -1.5h3.5v-3.5h3v3.5h3.5v3h-3.5v3.5h-3v-3.5h-3.5z"),
        _ => path("m-6 -3h12v6h-12z"),
    }
}

/// An entry's line in the legend: mark, name, slope.
pub(crate) fn legend(curve: &Curve) -> String {
    let colour = COLOURS[curve.style % COLOURS.len()];
    let slope = curve.line.map_or("no slope: its times hardly differ".into(), |(slope, at_one)| {
        format!("slope {slope:.2}, {} at 1 s", number(at_one))
    });
    format!(
        "<li><svg viewBox=\"0 0 14 14\" class=\"mark\" fill=\"{colour}\" aria-hidden=\"true\">{}</svg>{}: {slope}</li>",
        mark(curve.style, 7.0, 7.0),
        escape(curve.label)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_lie_within_the_axis_and_points_where_their_logarithms_say() {
        let axis = Axis::new([1.0, 100.0].into_iter(), [0.0, 100.0]);
        assert!(axis.ticks().iter().all(|t| (axis.low..=axis.high).contains(t)));
        assert!((axis.place(10.0) - 50.0).abs() < 1e-9);
        assert_eq!(plain(0.02), "0.02");
        assert_eq!(plain(2e-5), "2e-5");
    }

    #[test]
    fn no_points_give_no_plot_and_names_are_escaped() {
        assert!(plot("MSE", &[]).is_none());
        let curve = Curve {
            label: "<a>",
            style: 9,
            points: vec![(1.0, 2.0), (2.0, 1.0)],
            line: Some((-1.0, 2.0)),
        };
        let svg = plot("MSE", &[curve]).expect("a plot");
        assert!(svg.contains("&lt;a&gt;, slope -1.00") && !svg.contains("<a>"));
    }
}
