//! Writes all figures as slides for a projector: one per page, each with its slide's number. The deck needs no other file, and
//! prints each page on a sheet.

use std::fmt::Write;
use std::path::Path;

use anyhow::Context;
use serde_json::Value;

use crate::index::{Args, facts, heading, image, panels, read, text};
use crate::svg::escaped;

const STYLE: &str = include_str!("deck.css");
const SCRIPT: &str = include_str!("deck.js");

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let (figures, title) = (read(&args.folders)?, escaped(&args.title));
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n<style>\n{STYLE}</style>\n\
         <section class=\"cover\"><h1>{title}</h1>\n<p>One figure per page; one with many panels takes several. Arrow keys or Page Down and Page Up turn pages; each prints on a sheet of its own.</p>\n<ol>\n"
    );
    for (_, figure) in &figures {
        let (slide, title) = (text(figure, "slide"), escaped(text(figure, "title")));
        writeln!(
            page,
            "<li><a href=\"#slide-{slide}\"><b>{}</b> {title}</a></li>",
            escaped(slide)
        )?;
    }
    page += "</ol></section>\n";
    for (folder, figure) in &figures {
        slide(&mut page, folder, figure).with_context(|| heading(text(figure, "slide")))?;
    }
    writeln!(page, "<script>\n{SCRIPT}</script>\n</html>")?;
    std::fs::write(&args.out, page).with_context(|| args.out.display().to_string())
}

/// The most rows of panels on one page: more would be too small to see.
const ROWS: usize = 2;

/// One figure as a page, or as several if it has many panels. All have the caption.
fn slide(page: &mut String, folder: &Path, figure: &Value) -> anyhow::Result<()> {
    let (slide, title) = (text(figure, "slide"), escaped(text(figure, "title")));
    let columns = figure["columns"].as_u64().unwrap_or(3).max(1) as usize;
    let pages: Vec<&[Value]> = panels(figure).chunks(columns * ROWS).collect();
    for (k, panels) in pages.iter().enumerate() {
        let (rows, columns) = (panels.len().div_ceil(columns), columns.min(panels.len()));
        let (id, part) = match (k, pages.len()) {
            (0, 1) => (format!(" id=\"slide-{slide}\""), String::new()),
            (0, n) => (format!(" id=\"slide-{slide}\""), format!(" (1 of {n})")),
            (k, n) => (String::new(), format!(" ({} of {n})", k + 1)),
        };
        writeln!(
            page,
            "<section{id}>\n<h2><span>{}</span> {title}{part}</h2>\n\
             <div class=\"panels\" style=\"--columns:{columns};--rows:{rows}\">",
            heading(slide)
        )?;
        for panel in *panels {
            let (image, caption) = (image(folder, panel)?, escaped(text(panel, "caption")));
            let facts = facts(panel);
            let facts = if facts.is_empty() { facts } else { format!("<small>{facts}</small>") };
            writeln!(page, "<figure>{image}<figcaption>{caption} {facts}</figcaption></figure>")?;
        }
        writeln!(page, "</div>\n<p>{}</p>\n</section>", escaped(text(figure, "caption")))?;
    }
    Ok(())
}
