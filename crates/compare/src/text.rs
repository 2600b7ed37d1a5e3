//! Helpers for words, numbers and files.

use std::io::Write;
use std::path::Path;

use gi_core::files;

use crate::{Failure, show};

/// Split flags into words at spaces; quotes keep spaces.
pub(crate) fn split_words(text: &str) -> Result<Vec<String>, Failure> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for c in text.chars() {
        match (quote, c) {
            (Some(q), c) if c == q => quote = None,
            (None, '"' | '\'') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (None, c) if c.is_whitespace() => words.extend(word.take()),
            (_, c) => word.get_or_insert_default().push(c),
        }
    }
    if quote.is_some() {
        return Err(Failure::Input(format!("error: a quote is not closed: {text}")));
    }
    words.extend(word);
    Ok(words)
}

/// A command line as it can be typed.
pub fn command_line(words: &[String]) -> String {
    let quoted = |w: &String| {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+%@".contains(c);
        if !w.is_empty() && w.chars().all(plain) {
            w.clone()
        } else {
            format!("'{}'", w.replace('\'', r"'\''"))
        }
    };
    words.iter().map(quoted).collect::<Vec<_>>().join(" ")
}

/// Print a progress message.
pub(crate) fn say(quiet: bool, text: &str) {
    if !quiet {
        let _ = writeln!(std::io::stderr(), "{text}"); // standard error may be closed
    }
}

/// Text for HTML, in elements and in attributes.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c => out.push(c),
        }
    }
    out
}

/// Format a number with three significant digits.
pub(crate) fn number(v: f64) -> String {
    let size = v.abs();
    if v == 0.0 {
        "0".into()
    } else if !v.is_finite() {
        v.to_string()
    } else if (1e-3..1e4).contains(&size) {
        let digits = (2 - size.log10().floor() as i32).max(0) as usize;
        format!("{v:.digits$}")
    } else {
        format!("{v:.2e}")
    }
}

/// Create the folder, and check in advance that files can be written to it.
pub(crate) fn check_writable(folder: &Path, json: Option<&Path>) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|e| cannot_write(folder, &e))?;
    for path in [Some(folder.join("index.html").as_path()), json].into_iter().flatten() {
        files::check_writable(path).map_err(|e| cannot_write(path, &e))?;
    }
    Ok(())
}

/// Write a file completely, or not at all.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    files::write(path, bytes).map_err(|e| cannot_write(path, &e))
}

fn cannot_write(path: &Path, error: &std::io::Error) -> Failure {
    Failure::Other(format!("cannot write {}: {error}", show(path)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_command_lines_are_inverse() {
        let text = r#"--map-in "my map" -D 'a=b c' '' x"y"z"#;
        let words = split_words(text).expect("closed quotes");
        assert_eq!(words, ["--map-in", "my map", "-D", "a=b c", "", "xyz"]);
        assert_eq!(split_words(&command_line(&words)), Ok(words));
    }

    #[test]
    fn numbers_keep_three_digits() {
        let cases = [
            (0.0, "0"),
            (1234.5, "1234"),
            (1.0, "1.00"),
            (0.012_345, "0.0123"),
            (-3.21e-6, "-3.21e-6"),
            (12_345.0, "1.23e4"),
        ];
        cases.into_iter().for_each(|(v, text)| assert_eq!(number(v), text));
    }
}
