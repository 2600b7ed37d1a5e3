//! One page that holds everything: pictures as numbers, tables, plots, and the script that shows them.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::planes::{Halves, halves, shares};
use crate::plot::{Curve, legend, plot};
use crate::text::{command_line, escape, number};
use crate::{Budget, Entry, Failure, Picture, Report};

const PAGE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/page.css");
/// In the order in which they build on each other.
const SCRIPT: [&str; 4] = [
    include_str!("page/data.js"),
    include_str!("page/colour.js"),
    include_str!("page/viewer.js"),
    include_str!("page/controls.js"),
];

/// The page.
pub(crate) fn page(report: &Report) -> Result<String, Failure> {
    let mut planes = Planes::default();
    let data = data(report, &mut planes).to_string();
    let script = format!("\"use strict\";\n{}", SCRIPT.concat());
    let parts = [
        ("title", escape(&report.title)),
        ("summary", escape(&summary(report))),
        ("warnings", list(&report.warnings, "warnings")),
        ("errors", errors(report)),
        ("left-out", left_out(report)),
        ("plots", plots(report)),
        ("reference", reference(report)),
        ("runs", report.entries.iter().map(run).collect()),
        ("command", escape(&report.command)),
        ("style", STYLE.to_string()),
        // A script's data must not end the script.
        ("data", data.replace('<', "\\u003c")),
        ("planes", planes.html),
        ("script", script),
    ];
    // Every part once, in the template's order: what a part holds is never looked through for another.
    let (mut out, mut rest) = (String::new(), PAGE);
    while let Some((before, after)) = rest.split_once("{{") {
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        let part = parts.iter().find(|p| p.0 == name).map(|p| p.1.as_str());
        out += before;
        out +=
            part.ok_or_else(|| Failure::Other(format!("the page's template asks for {name}")))?;
        rest = after;
    }
    out += rest;
    Ok(out)
}

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
        let Halves { scale, text } = halves(values, channels);
        json!({ "id": self.keep(&text), "scale": scale, "channels": channels })
    }
}

/// What the script reads.
fn data(report: &Report, planes: &mut Planes) -> Value {
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
    let map = |gradient: colorous::Gradient| -> String {
        (0..256).map(|i| format!("{:x}", gradient.eval_rational(i, 256))).collect()
    };
    json!({
        "size": truth.size,
        "pictures": pictures,
        "ranges": ranges,
        "floor": gi_stats::metrics::RELATIVE_FLOOR,
        "maps": { "magma": map(colorous::MAGMA), "signed": map(colorous::PURPLE_ORANGE) },
    })
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

fn summary(report: &Report) -> String {
    let [w, h] = report.reference.picture.size;
    let what = match report.budget {
        None => "finished pictures".to_string(),
        Some(Budget::Time(time)) => format!(
            "{} s each: preparing and passes; reading the scene and building its tree are not counted",
            time.as_secs_f64()
        ),
        Some(Budget::Passes(n)) => format!("{n} passes each"),
    };
    let layer = report.layer.as_ref().map_or(String::new(), |l| format!("; layer {l}"));
    format!("{w} x {h} pixels{layer}; {what}")
}

/// Lines as a list, nothing for none.
fn list(lines: &[String], class: &str) -> String {
    let items: String = lines.iter().map(|l| format!("<li>{}</li>", escape(l))).collect();
    if items.is_empty() { items } else { format!("<ul class=\"{class}\">{items}</ul>") }
}

/// The table of errors.
fn errors(report: &Report) -> String {
    let rows = report.rows();
    let cells = |tag: &str, row: &[String]| -> String {
        row.iter().map(|c| format!("<{tag}>{}</{tag}>", escape(c))).collect()
    };
    let mut out =
        format!("<table><thead><tr><td></td>{}</tr></thead><tbody>", cells("th", &rows[0][1..]));
    for row in &rows[1..] {
        out += &format!(
            "<tr><th scope=\"row\">{}</th>{}</tr>",
            escape(&row[0]),
            cells("td", &row[1..])
        );
    }
    out + "</tbody></table>"
}

/// What the errors do not count.
fn left_out(report: &Report) -> String {
    let lines: Vec<String> = report
        .entries
        .iter()
        .flat_map(|e| e.notes.iter().map(|n| format!("{}: {n}", e.label)))
        .collect();
    list(&lines, "notes")
}

/// Error against time.
fn plots(report: &Report) -> String {
    let mut out = String::new();
    let less = if report.reference.noise.is_some() { ", less the reference's noise" } else { "" };
    for (which, name) in ["MSE", "relMSE"].into_iter().enumerate() {
        let curves: Vec<Curve> = report
            .entries
            .iter()
            .enumerate()
            .map(|(style, e)| Curve {
                label: &e.label,
                style,
                points: e
                    .rungs
                    .iter()
                    .map(|r| (r.seconds, r.errors[which]))
                    .filter(|p| p.1 > 0.0)
                    .collect(),
                line: e.line(which),
            })
            .collect();
        if let Some(svg) = plot(&format!("{name}{less}"), &curves) {
            let legend: String = curves.iter().map(legend).collect();
            out += &format!(
                "<figure><figcaption>{name}</figcaption>{svg}<ul class=\"legend\">{legend}</ul></figure>"
            );
        }
    }
    let lost: usize = report
        .entries
        .iter()
        .flat_map(|e| &e.rungs)
        .filter(|r| r.errors.iter().any(|v| *v <= 0.0))
        .count();
    if out.is_empty() {
        return out;
    }
    let lost = if lost > 0 {
        format!("<p>{lost} runs are nearer to the reference than its noise, and not drawn.</p>")
    } else {
        String::new()
    };
    format!("<section><h2>Error against time</h2><div class=\"plots\">{out}</div>{lost}</section>")
}

fn reference(report: &Report) -> String {
    let r = &report.reference;
    let reach = r
        .reach
        .as_ref()
        .map_or(String::new(), |reach| format!("<p>It reaches {}.</p>", escape(reach)));
    let noise = r.noise.map(|n| n.map(number)).map_or(String::new(), |[mse, rel_mse]| {
        format!(
            "<p>It is the mean of parts with independent seeds; by their differences its own noise is {mse} of each MSE and {rel_mse} \
             of each relMSE.</p>"
        )
    });
    let sources = escape(&r.sources.join("\n"));
    format!("<pre>{sources}</pre>{reach}{noise}{}", list(&r.notes, "notes"))
}

/// What is known of a run.
fn run(entry: &Entry) -> String {
    let mut out = format!("<details><summary>{}</summary>", escape(&entry.label));
    if let Some(command) = &entry.command {
        out += &format!("<pre>{}</pre>", escape(command));
    }
    if let Some(reach) = &entry.reach {
        out += &format!("<p>It reaches {}.</p>", escape(reach));
    }
    if let Some(stats) = &entry.stats {
        let [load, build, prepare, render] = stats.seconds.map(number);
        out += &format!(
            "<p>{} passes on {} threads, seed {}. Seconds: {prepare} preparing, {render} passes; apart from these {load} \
             reading the scene, {build} building its tree.</p>",
            stats.passes, stats.threads, stats.seed
        );
        let rows: String = stats
            .technique
            .iter()
            .map(|(name, value)| {
                format!(
                    "<tr><th scope=\"row\">{}</th><td>{}</td></tr>",
                    escape(&name.replace('_', " ")),
                    number_in_full(*value)
                )
            })
            .collect();
        if !rows.is_empty() {
            out += &format!("<table>{rows}</table>");
        }
    } else {
        out += &format!("<p>{}</p>", escape(&command_line(&[crate::show(&entry.picture.path)])));
    }
    out + "</details>"
}

/// Whole numbers in full, others to three digits.
fn number_in_full(v: f64) -> String {
    if v.fract() == 0.0 && v.abs() < 1e15 { format!("{v}") } else { number(v) }
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
