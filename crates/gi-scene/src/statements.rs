//! Statements of OBJ and MTL files. Handles all line endings, continued lines, comments, and text that is not UTF-8.

use std::borrow::Cow;
use std::ops::Range;

/// A line together with its continuation lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Statement<'a> {
    /// Number of its first line, from 1.
    pub(crate) line: usize,
    /// Its byte range in the file.
    pub(crate) range: Range<usize>,
    text: Cow<'a, str>,
}

impl Statement<'_> {
    /// The first word, and the rest. The rest is unchanged, because names may contain blanks and `#`.
    pub(crate) fn split(&self) -> (&str, &str) {
        let text = self.text.trim();
        let (keyword, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        (keyword, rest.trim())
    }

    /// Whether it is empty or only a comment.
    pub(crate) fn is_blank(&self) -> bool {
        let text = self.text.trim_start();
        text.is_empty() || text.starts_with('#')
    }
}

/// The text before a comment, for numbers and anything else that contains no `#`.
pub(crate) fn without_comment(rest: &str) -> &str {
    rest.split('#').next().unwrap_or_default().trim()
}

/// The name before a comment, if there is one. Names may contain `#` too, so the caller tries both readings.
pub(crate) fn name_before_comment(name: &str) -> Option<&str> {
    let at = name.match_indices('#').map(|(at, _)| at);
    let mut after_blank = at.filter(|at| name[..*at].ends_with(char::is_whitespace));
    after_blank.next().map(|at| name[..at].trim_end()).filter(|name| !name.is_empty())
}

/// A name without its quotes.
pub(crate) fn unquoted(name: &str) -> &str {
    name.strip_prefix('"').and_then(|n| n.strip_suffix('"')).unwrap_or(name)
}

/// All statements, except blank ones.
pub(crate) fn statements(bytes: &[u8]) -> impl Iterator<Item = Statement<'_>> {
    let mut lines = Lines { bytes, at: 0, number: 0 };
    std::iter::from_fn(move || lines.statement()).filter(|s| !s.is_blank())
}

struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    number: usize,
}

impl<'a> Lines<'a> {
    fn line(&mut self) -> Option<Range<usize>> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        let ending = if rest[length..].starts_with(b"\r\n") { 2 } else { 1 };
        let line = self.at..self.at + length;
        self.at += length + ending;
        self.number += 1;
        Some(line)
    }

    fn statement(&mut self) -> Option<Statement<'a>> {
        let first = self.line()?;
        let line = self.number;
        let mut text = decode(&self.bytes[first.clone()]);
        let mut end = first.end;
        // A comment that ends in a backslash (of a folder's name, for example) does not continue on the next line.
        if !text.trim_start().starts_with('#') {
            while let Some(kept) = text.trim_end().strip_suffix('\\').map(str::len) {
                let Some(next) = self.line() else { break };
                end = next.end;
                let joined = text.to_mut();
                joined.truncate(kept);
                joined.push(' ');
                joined.push_str(&decode(&self.bytes[next]));
            }
        }
        Some(Statement { line, range: first.start..end, text })
    }
}

/// Decode as UTF-8, or as Latin-1 if it is not valid UTF-8.
fn decode(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(latin_1(bytes)),
    }
}

/// Text in which each byte is one code point.
pub(crate) fn latin_1(bytes: &[u8]) -> String {
    bytes.iter().map(|&b| char::from(b)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> Vec<(usize, String, String)> {
        let own = |s: Statement| {
            let (keyword, rest) = s.split();
            (s.line, keyword.to_owned(), rest.to_owned())
        };
        statements(bytes).map(own).collect()
    }

    #[test]
    fn lines_end_as_on_any_system_and_go_on_after_a_backslash() {
        let text = b"v 1\r\n# a comment\\\nv 2\rf 1 \\\n 2 \\\r\n3\n\nusemtl a #1";
        let expected = [(1, "v", "1"), (3, "v", "2"), (4, "f", "1   2   3"), (8, "usemtl", "a #1")];
        let got = read(text);
        let got: Vec<_> = got.iter().map(|(n, k, r)| (*n, k.as_str(), r.as_str())).collect();
        let squeeze = |t: &str| t.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(got.len(), expected.len(), "{got:?}");
        for ((n, k, r), (line, keyword, rest)) in got.into_iter().zip(expected) {
            assert_eq!((n, k, squeeze(r)), (line, keyword, squeeze(rest)));
        }
        assert_eq!(read(b"v 1\\"), [(1, "v".into(), "1\\".into())], "nothing follows");
    }

    #[test]
    fn bytes_that_are_no_utf_8_are_latin_1() {
        assert_eq!(read(b"usemtl f\xfcr"), [(1, "usemtl".into(), "für".into())]);
        assert_eq!(read("usemtl für".as_bytes()), [(1, "usemtl".into(), "für".into())]);
    }

    #[test]
    fn a_comment_follows_a_blank() {
        assert_eq!(name_before_comment("red # the red one"), Some("red"));
        assert_eq!(name_before_comment("Material #26"), Some("Material"));
        assert_eq!(name_before_comment("a#b"), None);
        assert_eq!(name_before_comment("# b"), None);
    }
}
