//! Writes all figures to one page that needs no other file.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use serde_json::Value;

use crate::svg::{data_uri, escaped};

/// The options of the page, and of the deck.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// The page to write (.html)
    pub(crate) out: PathBuf,
    /// Heading of the page
    #[arg(long, default_value = "The lecture's figures")]
    pub(crate) title: String,
    /// Folders of the figures, in the order of their slides
    #[arg(required = true)]
    pub(crate) folders: Vec<PathBuf>,
}

#[derive(clap::Args)]
pub(crate) struct ThumbArgs {
    /// The folder to write to
    out: PathBuf,
    /// Folders of the figures
    #[arg(required = true)]
    folders: Vec<PathBuf>,
}

const STYLE: &str = include_str!("page.css");

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let (figures, title) = (read(&args.folders)?, escaped(&args.title));
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>Global illumination: {title}</title>\n<style>\n{STYLE}</style>\n\
         <header><h1>{title}</h1>\n<nav><ol>\n"
    );
    for (_, figure) in &figures {
        let (slide, title) = (text(figure, "slide"), text(figure, "title"));
        writeln!(
            page,
            "<li><a href=\"#slide-{slide}\">{} · {}</a></li>",
            heading(slide),
            escaped(title)
        )?;
    }
    page += "</ol></nav></header>\n<main>\n";
    let home = args.out.parent().unwrap_or(Path::new("."));
    for (folder, figure) in &figures {
        section(&mut page, home, folder, figure)
            .with_context(|| format!("slide {}", text(figure, "slide")))?;
    }
    page += "</main>\n</html>\n";
    std::fs::write(&args.out, page).with_context(|| args.out.display().to_string())
}

/// Read all figure.json files; if several are missing, the error lists all of them.
pub(crate) fn read(folders: &[PathBuf]) -> anyhow::Result<Vec<(&PathBuf, Value)>> {
    let (mut figures, mut missing) = (Vec::new(), Vec::new());
    for folder in folders {
        let sidecar = std::fs::read_to_string(folder.join("figure.json"));
        match sidecar.ok().and_then(|text| serde_json::from_str(&text).ok()) {
            Some(figure) => figures.push((folder, figure)),
            None => missing.push(folder.display().to_string()),
        }
    }
    if !missing.is_empty() {
        bail!("without a figure.json: {}", missing.join(", "));
    }
    Ok(figures)
}

/// "Slide 12", "Slides 29-30"; a figure that belongs to no slide has a name instead of a number.
pub(crate) fn heading(slide: &str) -> String {
    match slide.chars().next() {
        Some(c) if c.is_ascii_digit() && slide.contains(['-', ',']) => format!("Slides {slide}"),
        Some(c) if c.is_ascii_digit() => format!("Slide {slide}"),
        _ => escaped(slide),
    }
}

pub(crate) fn text<'v>(value: &'v Value, key: &str) -> &'v str {
    value[key].as_str().unwrap_or_default()
}

pub(crate) fn panels(figure: &Value) -> &[Value] {
    figure["panels"].as_array().map_or(&[], Vec::as_slice)
}

/// One figure: heading, panels in a grid, caption, and the commands that made it.
fn section(page: &mut String, home: &Path, folder: &Path, figure: &Value) -> anyhow::Result<()> {
    let (slide, title) = (text(figure, "slide"), escaped(text(figure, "title")));
    let columns = figure["columns"].as_u64().unwrap_or(3);
    writeln!(
        page,
        "<section id=\"slide-{slide}\">\n<h2><span>{}</span> {title}</h2>\n\
         <p>{}</p>\n<div class=\"panels\" style=\"--columns:{columns}\">",
        heading(slide),
        escaped(text(figure, "caption"))
    )?;
    let place = folder.strip_prefix(home).unwrap_or(folder).display().to_string();
    for panel in panels(figure) {
        let (image, caption) = (image(folder, panel)?, escaped(text(panel, "caption")));
        write!(page, "<figure>{image}<figcaption>{caption}")?;
        let facts = facts(panel);
        if !facts.is_empty() {
            write!(page, "<br><small>{facts}</small>")?;
        }
        if let Some(data) = panel["data"].as_str() {
            write!(page, " <small><a href=\"{place}/{data}\">{data}</a></small>")?;
        }
        writeln!(page, "</figcaption></figure>")?;
    }
    page.push_str("</div>\n");
    claims(page, figure)?;
    let commands: Vec<String> =
        panels(figure).iter().filter_map(|p| p["command"].as_str()).map(escaped).collect();
    if !commands.is_empty() {
        let mut once: Vec<&String> = Vec::new();
        commands.iter().for_each(|c| {
            if !once.contains(&c) {
                once.push(c);
            }
        });
        let lines: Vec<&str> = once.into_iter().map(String::as_str).collect();
        writeln!(
            page,
            "<details><summary>Commands</summary><pre>{}</pre></details>",
            lines.join("\n")
        )?;
    }
    page.push_str("</section>\n");
    Ok(())
}

/// The claims that the figure's data was checked for.
fn claims(page: &mut String, figure: &Value) -> anyhow::Result<()> {
    let claims = figure["claims"].as_array().map_or(&[][..], Vec::as_slice);
    if claims.is_empty() {
        return Ok(());
    }
    page.push_str("<details><summary>Checked claims</summary><pre>");
    for claim in claims {
        let (claim, numbers) = (escaped(text(claim, "claim")), escaped(text(claim, "numbers")));
        writeln!(page, "{claim}   ({numbers})")?;
    }
    page.push_str("</pre></details>\n");
    Ok(())
}

/// A panel as an image that needs no other file.
pub(crate) fn image(folder: &Path, panel: &Value) -> anyhow::Result<String> {
    let file = text(panel, "file");
    let bytes = std::fs::read(folder.join(file)).with_context(|| file.to_string())?;
    let kind = if file.ends_with(".svg") { "image/svg+xml" } else { "image/png" };
    let alt = escaped(text(panel, "caption"));
    Ok(format!("<img src=\"{}\" alt=\"{alt}\">", data_uri(kind, &bytes)))
}

/// Time and errors of a panel, on one line that breaks only between them.
pub(crate) fn facts(panel: &Value) -> String {
    let mut facts = Vec::new();
    if let Some(seconds) = panel["seconds"].as_str().and_then(|s| s.parse::<f64>().ok()) {
        facts.push(format!("{seconds:.1} s"));
    }
    if let Some(stops) = panel["exposure"].as_f64() {
        facts.push(format!("shown {stops:+} stops"));
    }
    if let Some(e) = panel["relmse"].as_f64().filter(|e| *e > 0.0) {
        facts.push(format!("relMSE {e:.2e}"));
        let mean = panel["mean_ratio"].as_array().map_or(1.0, |r| {
            r.iter().filter_map(Value::as_f64).sum::<f64>() / r.len().max(1) as f64
        });
        facts.push(format!("mean {} %", signed(100.0 * (mean - 1.0))));
    }
    let whole: Vec<String> = facts.iter().map(|fact| fact.replace(' ', "\u{a0}")).collect();
    whole.join(" · ")
}

/// A number with its sign and one digit after the point. What rounds to zero has both signs.
fn signed(v: f64) -> String {
    let text = format!("{v:+.1}");
    match text.as_str() {
        "+0.0" | "-0.0" => "\u{b1}0.0".into(),
        _ => text.replace('-', "\u{2212}"),
    }
}

/// Copy the first panel of every figure to `SLIDE.png` or `SLIDE.svg`.
pub(crate) fn thumbs(args: &ThumbArgs) -> anyhow::Result<()> {
    std::fs::create_dir_all(&args.out)?;
    for (folder, figure) in &read(&args.folders)? {
        let first = panels(figure).first().context("a figure without panels")?;
        let file = Path::new(text(first, "file"));
        let kind = file.extension().and_then(|e| e.to_str()).unwrap_or("png");
        let name = text(figure, "slide").replace(',', "-");
        let to = args.out.join(format!("{name}.{kind}"));
        std::fs::copy(folder.join(file), &to).with_context(|| to.display().to_string())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn facts_are_not_broken_inside_and_zero_has_no_sign() {
        let panel = |mean: f64| json!({ "seconds": "1.23", "relmse": 0.01, "mean_ratio": [mean] });
        assert_eq!(
            facts(&panel(0.9999)),
            "1.2\u{a0}s · relMSE\u{a0}1.00e-2 · mean\u{a0}\u{b1}0.0\u{a0}%"
        );
        assert!(facts(&panel(0.97)).ends_with("mean\u{a0}\u{2212}3.0\u{a0}%"));
    }
}
