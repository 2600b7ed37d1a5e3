//! The results of a comparison: as a table and as JSON.

use serde_json::{Map, Value, json};

use crate::reference::Reference;
use crate::{Budget, Entry, Stats, text};

/// The results of a comparison.
#[derive(Clone, Debug)]
pub struct Report {
    /// The scene's file, or "pictures".
    pub title: String,
    /// The command line.
    pub command: String,
    /// The layer compared, if it is not the radiance.
    pub layer: Option<String>,
    /// The budget of each run.
    pub budget: Option<Budget>,
    /// Number of seeds per run.
    pub seeds: u32,
    /// The reference.
    pub reference: Reference,
    /// The pictures.
    pub entries: Vec<Entry>,
    /// Warnings about the scene or the reference.
    pub warnings: Vec<String>,
}

/// A column of a table: its name, and its text for an entry.
type Column = (&'static str, fn(&Entry) -> String);

/// The error columns, in the order used in the text and on the page.
const COLUMNS: [Column; 12] = [
    ("passes", |e| e.passes().map_or("-".into(), |n| n.to_string())),
    ("seconds", |e| e.seconds().map_or("-".into(), |s| format!("{s:.2}"))),
    ("prepared", |e| e.stats.as_ref().map_or("-".into(), |s| format!("{:.2}", s.seconds[2]))),
    ("MSE", |e| text::number(e.errors.metrics.mse)),
    ("RMSE", |e| text::number(e.errors.metrics.rmse)),
    ("relMSE", |e| text::number(e.errors.metrics.rel_mse)),
    ("MAE", |e| text::number(e.errors.metrics.mae)),
    ("SMAPE", |e| text::number(e.errors.metrics.smape)),
    ("within 2 %", |e| format!("{:.1} %", 100.0 * e.errors.metrics.close)),
    ("FLIP LDR", |e| format!("{:.4}", e.errors.flip_ldr)),
    ("FLIP HDR", |e| format!("{:.4}", e.errors.flip_hdr)),
    ("mean ratio R G B", |e| e.errors.metrics.mean_ratio.map(|r| format!("{r:.4}")).join(" ")),
];

/// The columns of bias and variance.
const SPLIT_COLUMNS: [Column; 2] = [
    ("bias^2", |e| match &e.split {
        None => "-".into(),
        Some(s) => match s.mean_bias_sq_error {
            None => text::number(s.mean_bias_sq),
            Some(error) => format!("{} +- {}", text::number(s.mean_bias_sq), text::number(error)),
        },
    }),
    ("variance", |e| e.split.as_ref().map_or("-".into(), |s| text::number(s.mean_variance))),
];

/// The columns of slopes.
const SLOPE_COLUMNS: [Column; 2] =
    [("slope of MSE", |e| slope(e, 0)), ("slope of relMSE", |e| slope(e, 1))];

fn slope(entry: &Entry, which: usize) -> String {
    entry.line(which).map_or("-".into(), |(slope, _)| format!("{slope:.2}"))
}

impl Report {
    /// The errors as rows of text: a header, then a row for each entry.
    pub fn rows(&self) -> Vec<Vec<String>> {
        let mut columns = COLUMNS.to_vec();
        if self.entries.iter().any(|e| e.split.is_some()) {
            columns.extend(SPLIT_COLUMNS);
        }
        if self.entries.iter().any(|e| !e.rungs.is_empty()) {
            columns.extend(SLOPE_COLUMNS);
        }
        let head = std::iter::once(String::new()).chain(columns.iter().map(|c| c.0.to_string()));
        let row = |e: &Entry| {
            std::iter::once(e.label.clone()).chain(columns.iter().map(|c| c.1(e))).collect()
        };
        std::iter::once(head.collect()).chain(self.entries.iter().map(row)).collect()
    }

    /// The errors as a table to print.
    pub fn table(&self) -> String {
        let rows = self.rows();
        let width = |k: usize| rows.iter().map(|r| r[k].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..rows[0].len()).map(width).collect();
        let mut out = String::new();
        for row in &rows {
            let mut line = format!("{:<1$}", row[0], widths[0]);
            row[1..]
                .iter()
                .zip(&widths[1..])
                .for_each(|(cell, w)| line += &format!("  {cell:>w$}"));
            out += line.trim_end();
            out.push('\n');
        }
        self.reference.sources.iter().for_each(|s| out += &format!("reference: {s}\n"));
        if let Some([mse, rel_mse]) = self.reference.noise.map(|n| n.map(text::number)) {
            out += &format!("its own noise is {mse} of each MSE and {rel_mse} of each relMSE\n");
        }
        self.reference.notes.iter().for_each(|n| out += &format!("reference: {n}\n"));
        for (label, note) in self.entries.iter().flat_map(|e| e.notes.iter().map(|n| (&e.label, n)))
        {
            out += &format!("{label}: {note}\n");
        }
        self.warnings.iter().for_each(|w| out += &format!("warning: {w}\n"));
        out
    }

    /// All results except the pictures.
    pub fn json(&self) -> Value {
        let budget = self.budget.map(|b| match b {
            Budget::Time(time) => json!({ "seconds": time.as_secs_f64() }),
            Budget::Passes(n) => json!({ "passes": n }),
        });
        let size = self.reference.picture.size;
        json!({
            "title": self.title,
            "command": self.command,
            "layer": self.layer,
            "size": size,
            "budget": budget,
            "seeds": self.seeds,
            "reference": {
                "sources": self.reference.sources,
                "reach": self.reference.reach,
                "notes": self.reference.notes,
                "noise": self.reference.noise.map(|[mse, rel]| json!({ "mse": mse, "rel_mse": rel })),
            },
            "entries": self.entries.iter().map(entry).collect::<Vec<_>>(),
            "warnings": self.warnings,
        })
    }
}

fn entry(e: &Entry) -> Value {
    let m = &e.errors.metrics;
    let split = e.split.as_ref().map(|s| {
        json!({ "bias_sq": s.mean_bias_sq, "bias_sq_error": s.mean_bias_sq_error, "variance": s.mean_variance })
    });
    let rung = |r: &crate::Rung| json!({ "seconds": r.seconds, "passes": r.passes, "mse": r.errors[0], "rel_mse": r.errors[1] });
    json!({
        "label": e.label,
        "file": crate::show(&e.picture.path),
        "command": e.command,
        "reach": e.reach,
        "passes": e.passes(),
        "seconds": e.seconds(),
        "errors": {
            "mse": m.mse, "rmse": m.rmse, "rel_mse": m.rel_mse, "mae": m.mae, "smape": m.smape,
            "within_2_percent": 100.0 * m.close,
            "mean_ratio": m.mean_ratio, "flip_ldr": e.errors.flip_ldr, "flip_hdr": e.errors.flip_hdr,
            "pixels_left_out": m.left_out,
        },
        "split": split,
        "ladder": e.rungs.iter().map(rung).collect::<Vec<_>>(),
        "slope": { "mse": e.line(0).map(|l| l.0), "rel_mse": e.line(1).map(|l| l.0) },
        "run": e.stats.as_ref().map(run),
        "notes": e.notes,
    })
}

fn run(s: &Stats) -> Value {
    let [load, build, prepare, render] = s.seconds;
    let technique: Map<String, Value> =
        s.technique.iter().map(|(k, v)| (k.clone(), json!(v))).collect();
    json!({
        "passes": s.passes,
        "seconds": { "load": load, "build": build, "prepare": prepare, "render": render },
        "threads": s.threads,
        "seed": s.seed,
        "technique": technique,
    })
}
