//! The documents: links lead somewhere, files that they name exist, and the book has all pages.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().expect("the repository")
}

/// All documents, with their text.
fn documents() -> Vec<(PathBuf, String)> {
    let mut all = Vec::new();
    for folder in ["", "docs", "python"] {
        let entries = std::fs::read_dir(root().join(folder)).expect("a folder");
        all.extend(entries.map(|entry| entry.expect("an entry").path()));
    }
    all.retain(|path| path.extension().is_some_and(|e| e == "md"));
    all.sort();
    let text = |path: PathBuf| std::fs::read_to_string(&path).map(|text| (path, text));
    all.into_iter().map(|path| text(path).expect("a document")).collect()
}

/// The text without blocks of code.
fn prose(text: &str) -> String {
    let mut in_code = false;
    let mut lines = Vec::new();
    for line in text.lines() {
        if line.starts_with("```") {
            in_code = !in_code;
        } else if !in_code {
            lines.push(line);
        }
    }
    lines.join("\n")
}

/// What stands between `open` and the next `close`, for each `open`.
fn between<'t>(text: &'t str, open: &str, close: char) -> Vec<&'t str> {
    text.split(open).skip(1).filter_map(|rest| Some(rest.split_once(close)?.0)).collect()
}

/// The anchors of a document's headings, as GitHub and mdBook make them.
fn anchors(text: &str) -> BTreeSet<String> {
    let of = |heading: &str| {
        let kept = |c: char| match c {
            ' ' => Some('-'),
            c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c.to_ascii_lowercase()),
            _ => None,
        };
        heading.trim_start_matches('#').trim().chars().filter_map(kept).collect()
    };
    prose(text).lines().filter(|line| line.starts_with('#')).map(of).collect()
}

/// What is wrong with a link in the document `from`, if anything.
fn broken(from: &Path, link: &str) -> Option<String> {
    if link.contains("://") || link.starts_with("mailto:") {
        return None;
    }
    let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
    let path = if file.is_empty() { from.into() } else { from.with_file_name("").join(file) };
    let complaint = |what: &str| Some(format!("{}: {link}: {what}", from.display()));
    if !path.exists() {
        return complaint("there is no such file");
    }
    if !anchor.is_empty() {
        let text = std::fs::read_to_string(&path).expect("a document");
        if !anchors(&text).contains(anchor) {
            return complaint("there is no such heading");
        }
    }
    None
}

#[test]
fn every_link_leads_to_a_file_and_a_heading() {
    let mut problems = Vec::new();
    let mut count = 0;
    for (path, text) in documents() {
        let text = prose(&text);
        let links = between(&text, "](", ')').into_iter().chain(between(&text, "src=\"", '"'));
        for link in links {
            count += 1;
            problems.extend(broken(&path, link));
        }
    }
    assert!(count > 50, "only {count} links were found");
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn every_file_that_a_document_names_exists() {
    let mut problems = Vec::new();
    for (path, text) in documents() {
        for name in between(&prose(&text), "`", '`') {
            let is_ours =
                ["crates/", "scripts/", "tests/", "scenes/"].iter().any(|f| name.starts_with(f));
            let is_name = name.chars().all(|c| c.is_alphanumeric() || "/._-".contains(c));
            // Names in capitals stand for any name.
            let is_example =
                name.chars().any(|c| c.is_ascii_uppercase()) && !name.ends_with("file");
            if is_ours && is_name && !is_example && !root().join(name).exists() {
                problems.push(format!("{}: {name}", path.display()));
            }
        }
    }
    assert!(problems.is_empty(), "these files do not exist:\n{}", problems.join("\n"));
}

#[test]
fn the_book_has_every_page() {
    let summary = std::fs::read_to_string(root().join("docs/SUMMARY.md")).expect("a summary");
    let pages: BTreeSet<&str> = between(&summary, "](", ')').into_iter().collect();
    for (path, _) in documents() {
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        if path.parent() == Some(&root().join("docs")) && name != "SUMMARY.md" {
            assert!(pages.contains(name.as_str()), "docs/{name} is not in docs/SUMMARY.md");
        }
    }
}
