//! The numbers of a page: pictures and maps, packed, and what their scales and colours are.

use std::fmt::Write;

use serde_json::{Map, Value, json};

use crate::planes::{pack_halves, shares};
use crate::{Entry, Picture, Report};

/// Packed numbers, each in an element of its own.
#[derive(Default)]
struct Planes {
    html: String,
    count: usize,
}

impl Planes {
    /// Keep packed numbers; returns the element's name.
    fn keep(&mut self, text: &str) -> String {
        let id = format!("plane-{}", self.count);
        self.count += 1;
        // Writing to a string does not fail.
        let _ = writeln!(self.html, "<script type=\"text/plain\" id=\"{id}\">{text}</script>");
        id
    }

    fn halves(&mut self, values: &[f32], channels: usize) -> Value {
        let (scale, text) = pack_halves(values, channels);
        json!({ "id": self.keep(&text), "scale": scale, "channels": channels })
    }
}

/// What the script reads, and the elements that hold the packed numbers.
pub(crate) fn data(report: &Report) -> (Value, String) {
    let mut planes = Planes::default();
    let truth = &report.reference.picture;
    let reference = json!({ "label": "reference", "rgb": planes.halves(&truth.rgb, 3) });
    let mut pictures = vec![reference];
    let (mut bias, mut deviation) = (Vec::new(), Vec::new());
    for entry in &report.entries {
        let mut picture = json!({
            "label": entry.label,
            "rgb": planes.halves(&entry.picture.rgb, 3),
            "flip": { "id": planes.keep(&shares(&entry.errors.flip_map)) },
        });
        if let Some(split) = &entry.split {
            let mean = |of: &[f64]| -> Vec<f32> {
                of.chunks_exact(3).map(|c| ((c[0] + c[1] + c[2]) / 3.0) as f32).collect()
            };
            let b = mean(&split.bias);
            let s: Vec<f32> = mean(&split.variance).into_iter().map(f32::sqrt).collect();
            picture["bias"] = planes.halves(&b, 1);
            picture["deviation"] = planes.halves(&s, 1);
            bias.extend(b);
            deviation.extend(s);
        }
        pictures.push(picture);
    }
    let ranges = ranges(&report.entries, truth, bias, deviation);
    let maps: Map<String, Value> =
        gi_page::maps().into_iter().map(|(name, map)| (name.into(), map.into())).collect();
    let data = json!({
        "size": truth.size,
        "pictures": pictures,
        "ranges": ranges,
        "floor": gi_stats::metrics::RELATIVE_FLOOR,
        "maps": maps,
    });
    (data, planes.html)
}

/// Where each colour scale ends to begin with: 99 of 100 pixels of all pictures lie below.
fn ranges(entries: &[Entry], truth: &Picture, bias: Vec<f32>, deviation: Vec<f32>) -> Value {
    let (mut error, mut relative, mut signed) = (Vec::new(), Vec::new(), Vec::new());
    let floor = gi_stats::metrics::RELATIVE_FLOOR as f32;
    for entry in entries {
        for (a, r) in entry.picture.rgb.chunks_exact(3).zip(truth.rgb.chunks_exact(3)) {
            let mean =
                |of: &dyn Fn(f32, f32) -> f32| (0..3).map(|k| of(a[k], r[k])).sum::<f32>() / 3.0;
            error.push(mean(&|a, r| (a - r) * (a - r)).sqrt());
            relative.push(mean(&|a, r| (a - r) * (a - r) / (r * r + floor)).sqrt());
            signed.push(mean(&|a, r| a - r));
        }
    }
    json!({
        "error": top(error), "relative": top(relative), "signed": top(signed),
        "bias": top(bias), "deviation": top(deviation), "flip": 1.0,
    })
}

/// What 99 of 100 values do not exceed in size, rounded up to a round number; 1 where all are zero.
fn top(mut values: Vec<f32>) -> f64 {
    values.iter_mut().for_each(|v| *v = v.abs());
    values.retain(|v| v.is_finite());
    if values.is_empty() {
        return 1.0;
    }
    let at = (values.len() - 1) * 99 / 100;
    let value = f64::from(*values.select_nth_unstable_by(at, f32::total_cmp).1);
    if value == 0.0 {
        return 1.0;
    }
    let decade = 10f64.powf(value.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|s| s * decade).into_iter().find(|v| *v >= value).unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_ends_at_a_round_number_that_holds_99_of_100() {
        let values: Vec<f32> = (1..=1000).map(|i| i as f32 * -0.001).collect();
        assert_eq!(top(values), 1.0);
        assert_eq!(top(vec![0.013; 10]), 0.02);
        assert_eq!(top(vec![0.0, f32::NAN]), 1.0);
        assert_eq!(top(Vec::new()), 1.0);
    }
}
