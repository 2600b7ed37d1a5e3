//! One page that holds everything: pictures as numbers, tables, plots, and the script that shows them.

mod data;

use crate::plot::{Curve, legend, plot};
use crate::text::{command_line, escape, number};
use crate::{Budget, Entry, Failure, Report};

const PAGE: &str = include_str!("page/page.html");
const SCRIPT: &str = include_str!("page/data.js");

/// The page.
pub(crate) fn page(report: &Report) -> Result<String, Failure> {
    let (data, planes) = data::data(report);
    let script = format!("\"use strict\";\n{}{SCRIPT}", gi_page::SCRIPT.concat());
    let viewer = gi_page::fill(gi_page::VIEWER, &[("state", "Unpacking pictures")]);
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
        ("style", gi_page::STYLE.to_string()),
        ("viewer", viewer.map_err(unknown)?),
        // A script's data must not end the script.
        ("data", data.to_string().replace('<', "\\u003c")),
        ("planes", planes),
        ("script", script),
    ];
    let parts = parts.each_ref().map(|(name, text)| (*name, text.as_str()));
    gi_page::fill(PAGE, &parts).map_err(unknown)
}

/// A template has a place that nothing is written for.
fn unknown(name: String) -> Failure {
    Failure::Other(format!("the page's template asks for {name}"))
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
