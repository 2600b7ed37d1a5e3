//! The tokens of a pbrt file: words and numbers, quoted strings, and brackets. Comments are skipped.

use std::borrow::Cow;
use std::ops::Range;

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A directive, a number, `true` or `false`.
    Word,
    /// A string in quotes.
    Quoted,
    /// `[`.
    Open,
    /// `]`.
    Close,
}

/// A token and its bytes in the text, with its quotes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Token {
    pub(super) kind: Kind,
    pub(super) range: Range<usize>,
}

/// A mistake and its place.
pub(super) type Mistake = (Range<usize>, &'static str);

/// Splits a text into tokens.
#[derive(Debug)]
pub(super) struct Lexer<'t> {
    text: &'t str,
    at: usize,
}

impl<'t> Lexer<'t> {
    pub(super) fn new(text: &'t str) -> Self {
        Lexer { text, at: 0 }
    }

    /// The text of a word.
    pub(super) fn word(&self, token: &Token) -> &'t str {
        &self.text[token.range.clone()]
    }

    /// The contents of a quoted string; escapes are replaced.
    pub(super) fn unquoted(&self, token: &Token) -> Cow<'t, str> {
        let inner = &self.text[token.range.start + 1..token.range.end - 1];
        if !inner.contains('\\') {
            return Cow::Borrowed(inner);
        }
        let (mut out, mut chars) = (String::with_capacity(inner.len()), inner.chars());
        while let Some(c) = chars.next() {
            out.push(match c {
                '\\' => match chars.next() {
                    Some('n') => '\n',
                    Some('t') => '\t',
                    Some('r') => '\r',
                    Some(other) => other,
                    None => '\\',
                },
                c => c,
            });
        }
        Cow::Owned(out)
    }

    /// The next token; `None` at the end of the text. After a mistake, the lexer goes on behind it.
    pub(super) fn next(&mut self) -> Option<Result<Token, Mistake>> {
        let bytes = self.text.as_bytes();
        loop {
            match bytes.get(self.at)? {
                b if b.is_ascii_whitespace() => self.at += 1,
                b'#' => self.at = self.find(self.at, |b| matches!(b, b'\n' | b'\r')),
                _ => break,
            }
        }
        let start = self.at;
        let kind = match bytes[start] {
            b'[' => Kind::Open,
            b']' => Kind::Close,
            b'"' => return Some(self.string(start)),
            _ => {
                let ends = |b: u8| b.is_ascii_whitespace() || matches!(b, b'"' | b'[' | b']');
                self.at = self.find(start, ends);
                return Some(Ok(Token { kind: Kind::Word, range: start..self.at }));
            }
        };
        self.at += 1;
        Some(Ok(Token { kind, range: start..self.at }))
    }

    /// The first byte at or after `from` that passes a test, or the end of the text.
    fn find(&self, from: usize, test: impl Fn(u8) -> bool) -> usize {
        let rest = &self.text.as_bytes()[from..];
        rest.iter().position(|b| test(*b)).map_or(self.text.len(), |i| from + i)
    }

    /// A string that starts at `start`.
    fn string(&mut self, start: usize) -> Result<Token, Mistake> {
        let bytes = self.text.as_bytes();
        let mut at = start + 1;
        loop {
            match bytes.get(at) {
                Some(b'"') => break,
                Some(b'\\') if at + 1 < bytes.len() => at += 2,
                Some(b'\n') | None => {
                    self.at = at;
                    return Err((start..start + 1, "this string has no closing quote"));
                }
                Some(_) => at += 1,
            }
        }
        self.at = at + 1;
        Ok(Token { kind: Kind::Quoted, range: start..self.at })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &str) -> Vec<String> {
        let mut lexer = Lexer::new(text);
        let mut out = Vec::new();
        while let Some(token) = lexer.next() {
            out.push(match token {
                Ok(t) if t.kind == Kind::Quoted => format!("'{}'", lexer.unquoted(&t)),
                Ok(t) => lexer.word(&t).to_owned(),
                Err((range, _)) => format!("mistake at {}", range.start),
            });
        }
        out
    }

    #[test]
    fn text_is_split_at_blanks_quotes_and_brackets() {
        let text = "Shape\"sphere\" # a \"comment\"\r\n\"float radius\"[1.5 -2e3]true";
        let expected = ["Shape", "'sphere'", "'float radius'", "[", "1.5", "-2e3", "]", "true"];
        assert_eq!(all(text), expected);
        assert_eq!(all(""), [""; 0]);
        assert_eq!(all("a\x0c[\x0c\x0b"), ["a", "[", "\u{b}"]);
        assert_eq!(all("# only a comment"), [""; 0]);
    }

    #[test]
    fn escapes_are_replaced() {
        assert_eq!(all(r#""a\"b\\c\n""#), ["'a\"b\\c\n'"]);
        assert_eq!(all("\"\u{e4}\\\u{e4}\""), ["'\u{e4}\u{e4}'"]);
    }

    #[test]
    fn a_string_ends_on_its_line() {
        assert_eq!(all("Shape \"sphere\nMaterial"), ["Shape", "mistake at 6", "Material"]);
        assert_eq!(all("\"a"), ["mistake at 0"]);
        assert_eq!(all("\"\\"), ["mistake at 0"]);
    }
}
