//! Draws the steps of a program as boxes with arrows; the numbers in them are from a real run.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::{Context, bail};
use serde_json::Value;

use crate::svg::{FONT, escaped};

#[derive(clap::Args)]
pub(crate) struct Args {
    /// The drawing to write (.svg)
    out: PathBuf,
    /// Title above the drawing
    #[arg(long)]
    title: String,
    /// Statistics of the run, as written by --stats
    #[arg(long)]
    stats: PathBuf,
    /// Steps that are repeated: FROM,TO
    #[arg(long, value_name = "FROM,TO", value_delimiter = ',')]
    again: Vec<usize>,
    /// Steps; {passes} and {technique.global_photons} are replaced by numbers of the run, | starts a new line
    #[arg(required = true)]
    steps: Vec<String>,
}

/// Width, height and gap of the boxes; below, the height of a line.
const BOX: [usize; 3] = [200, 110, 46];
const LINE: usize = 19;

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let text =
        std::fs::read_to_string(&args.stats).with_context(|| args.stats.display().to_string())?;
    let stats: Value =
        serde_json::from_str(&text).with_context(|| args.stats.display().to_string())?;
    let steps = args.steps.iter().map(|s| filled(s, &stats)).collect::<anyhow::Result<Vec<_>>>()?;
    if !args.again.is_empty()
        && !matches!(args.again[..], [a, b] if 1 <= a && a <= b && b <= steps.len())
    {
        bail!("--again: expected two numbers of steps, the first not above the second");
    }
    std::fs::write(&args.out, drawing(&args.title, &steps, &args.again))
        .with_context(|| args.out.display().to_string())
}

/// Replace names in braces by the run's numbers.
fn filled(step: &str, stats: &Value) -> anyhow::Result<String> {
    let mut out = String::new();
    let mut rest = step;
    while let Some((before, after)) = rest.split_once('{') {
        let (name, behind) =
            after.split_once('}').with_context(|| format!("{step}: a closing brace is missing"))?;
        let value = name.split('.').fold(stats, step_into);
        let number = value.as_f64().with_context(|| format!("the run has no number {name}"))?;
        write!(out, "{before}{}", counted(number))?;
        rest = behind;
    }
    Ok(out + rest)
}

/// A member of an object by its name, or an element of an array by its index.
fn step_into<'v>(value: &'v Value, key: &str) -> &'v Value {
    match key.parse::<usize>() {
        Ok(k) => &value[k],
        Err(_) => &value[key],
    }
}

/// Format a number; integers in groups of three digits.
fn counted(v: f64) -> String {
    if v.fract() != 0.0 {
        return format!("{v:.3}");
    }
    let digits = format!("{v:.0}");
    let mut out = String::new();
    for (k, c) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) && digits.len() > 4 {
            out.push('\u{202f}');
        }
        out.push(c);
    }
    out
}

fn drawing(title: &str, steps: &[String], again: &[usize]) -> String {
    let [w, h, gap] = BOX;
    let left = |k: usize| gap / 2 + k * (w + gap);
    let (width, top) = (left(steps.len()) - gap / 2, 44);
    let height = top + h + if again.is_empty() { 16 } else { 56 };
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" font-family=\"{FONT}\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n\
         <marker id=\"tip\" viewBox=\"0 0 8 8\" refX=\"7\" refY=\"4\" markerWidth=\"8\" markerHeight=\"8\" orient=\"auto\"><path d=\"M0 0L8 4L0 8z\" fill=\"#333\"/></marker>\n\
         <text x=\"{}\" y=\"26\" font-size=\"18\" fill=\"#222\">{}</text>\n",
        left(0),
        escaped(title)
    );
    for (k, step) in steps.iter().enumerate() {
        let lines: Vec<&str> = step.split('|').collect();
        let _ = writeln!(
            out,
            "<rect x=\"{}\" y=\"{top}\" width=\"{w}\" height=\"{h}\" rx=\"6\" fill=\"#eef4fa\" stroke=\"#0072b2\"/>",
            left(k)
        );
        let first = top + (h + LINE - lines.len() * LINE) / 2 + 4;
        for (j, line) in lines.iter().enumerate() {
            let _ = writeln!(
                out,
                "<text x=\"{}\" y=\"{}\" font-size=\"14\" text-anchor=\"middle\" fill=\"#222\">{}</text>",
                left(k) + w / 2,
                first + j * LINE,
                escaped(line.trim())
            );
        }
        if k > 0 {
            let (y, from) = (top + h / 2, left(k) - gap);
            let _ = writeln!(
                out,
                "<path d=\"M{from} {y}H{}\" stroke=\"#333\" stroke-width=\"1.5\" marker-end=\"url(#tip)\"/>",
                left(k) - 2
            );
        }
    }
    if let [from, to] = *again {
        let (a, b, y) = (left(from - 1) + w / 2, left(to - 1) + w / 2, top + h);
        let _ = writeln!(
            out,
            "<path d=\"M{b} {y}V{}H{a}V{}\" fill=\"none\" stroke=\"#333\" stroke-width=\"1.5\" marker-end=\"url(#tip)\"/>\n\
             <text x=\"{}\" y=\"{}\" font-size=\"13\" text-anchor=\"middle\" fill=\"#444\">again</text>",
            y + 34,
            y + 3,
            (a + b) / 2,
            y + 28
        );
    }
    out + "</svg>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_braces_become_numbers_and_unknown_ones_are_errors() {
        let stats = serde_json::json!({ "passes": 64, "technique": { "photons": 1_234_567.0 } });
        let text = filled("{passes} passes|{technique.photons} photons", &stats).expect("numbers");
        assert_eq!(text, "64 passes|1\u{202f}234\u{202f}567 photons");
        assert!(filled("{technique.rays}", &stats).is_err() && filled("{passes", &stats).is_err());
    }
}
