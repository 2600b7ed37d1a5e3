//! Pictures of the statistics of all pixels, and traces of the statistics of chosen pixels.

use gi_core::canvas::{Legend, viridis};
use gi_core::film::PerPixel;
use gi_core::points::csv;
use gi_core::technique::Picture;

use crate::params::Figure;
use crate::region::Region;

/// The statistics of a pixel after every pass [slides 40 to 42].
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// The pixel.
    pub at: [usize; 2],
    pub(crate) rows: Vec<Row>,
}

/// A pixel after a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Row {
    /// Number of the pass.
    pub(crate) pass: u32,
    /// R in scene radii.
    pub(crate) radius: f64,
    /// N.
    pub(crate) photons: f64,
    /// M.
    pub(crate) found: u64,
    /// tau / (pi R^2 n).
    pub(crate) radiance: [f64; 3],
}

impl Trace {
    pub(crate) fn new(at: [usize; 2]) -> Self {
        Trace { at, rows: Vec::new() }
    }

    pub(crate) fn push(&mut self, pass: u32, passes: u32, region: &Region, unit: f64) {
        let s = &region.statistics;
        self.rows.push(Row {
            pass,
            radius: s.radius / unit,
            photons: s.photons,
            found: region.pass.photons,
            radiance: s.radiance(passes),
        });
    }
}

/// The traced pixels as CSV: one line per pixel and pass.
pub(crate) fn to_csv(traces: &[Trace]) -> Vec<u8> {
    let line = |[x, y]: [usize; 2], row: &Row| {
        let Row { pass, radius, photons, found, radiance: [r, g, b] } = row;
        format!("{x},{y},{pass},{radius:e},{photons},{found},{r:e},{g:e},{b:e}")
    };
    let lines = traces.iter().flat_map(|t| t.rows.iter().map(move |row| line(t.at, row)));
    csv("x,y,pass,radius,N,M,L_r,L_g,L_b", lines)
}

impl Figure {
    /// Draw a map of the pixels' statistics. `unit` is the radius of the scene.
    pub(crate) fn draw(self, pixels: &PerPixel<Region>, unit: f64) -> Picture {
        let column = |value: &dyn Fn(&Region) -> f64| -> Vec<f32> {
            pixels.rows().map(|r| value(r) as f32).collect()
        };
        let (name, title, channels): (&str, &str, Vec<(&str, Vec<f32>)>) = match self {
            Figure::Radius => (
                "radius",
                "Radius R (radii of the scene)",
                vec![("R", column(&|r| r.statistics.radius / unit))],
            ),
            Figure::Photons => {
                ("photons", "Number of photons N", vec![("N", column(&|r| r.statistics.photons))])
            }
            Figure::Error => (
                "error",
                "Estimated error (radiance), the larger of noise and bias",
                vec![
                    ("Noise", column(&|r| r.moments.noise_sq().sqrt())),
                    ("Bias", column(&|r| r.moments.bias())),
                ],
            ),
        };
        let magnitude = |i: usize| channels.iter().map(|(_, v)| v[i].abs()).fold(0.0, f32::max);
        let values: Vec<f32> = (0..channels[0].1.len()).map(magnitude).collect();
        let (low, high) = percentiles(&values);
        let place = |v: &f32| if *v > 0.0 { (v / low).ln() / (high / low).ln() } else { 0.0 };
        let view = values.iter().map(|v| viridis(place(v))).collect();
        let channels = channels.into_iter().map(|(n, v)| (n.to_string(), v)).collect();
        let legend = Some(Legend::logarithmic(title, low, high));
        Picture { name: name.into(), channels, view, legend }
    }
}

/// The ends of a logarithmic scale: the first and the last percentile of the values above zero.
fn percentiles(values: &[f32]) -> (f32, f32) {
    let mut positive: Vec<f32> =
        values.iter().copied().filter(|v| *v > 0.0 && v.is_finite()).collect();
    if positive.is_empty() {
        return (1.0, 2.0);
    }
    positive.sort_by(f32::total_cmp);
    let low = positive[positive.len() / 100].max(f32::MIN_POSITIVE);
    let high = positive[(positive.len() - 1) * 99 / 100];
    (low, high.max(low * 1.001))
}
