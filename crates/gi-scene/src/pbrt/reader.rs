//! Reads the arguments of directives: numbers, names and lists of parameters. Mistakes are reported where they are.

use std::rc::Rc;

use super::lexer::{Kind, Lexer, Token};
use super::params::Param;
use super::types::{Text, Type, Values};
use crate::diagnostics::{Report, Span};
use crate::value;

/// Largest number of parameters of a directive: each is compared with every name that the directive knows.
pub(super) const MAX_PARAMETERS: usize = 256;

/// One file that is being read.
pub(super) struct Reader<'t> {
    lexer: Lexer<'t>,
    /// The file's index in the report.
    file: usize,
    length: usize,
    report: &'t Report,
    peeked: Option<Token>,
}

impl<'t> Reader<'t> {
    pub(super) fn new(text: &'t str, file: usize, report: &'t Report) -> Self {
        Reader { lexer: Lexer::new(text), file, length: text.len(), report, peeked: None }
    }

    /// Where a token is.
    pub(super) fn span(&self, token: &Token) -> Span {
        Span { file: self.file, start: token.range.start, end: token.range.end }
    }

    /// The next token, which stays. Mistakes of the lexer are reported and skipped.
    pub(super) fn peek(&mut self) -> Option<Token> {
        while self.peeked.is_none() {
            match self.lexer.next()? {
                Ok(token) => self.peeked = Some(token),
                Err((range, message)) => {
                    let span = Span { file: self.file, start: range.start, end: range.end };
                    self.report.error(span, message, "");
                }
            }
        }
        self.peeked.clone()
    }

    /// The next token.
    pub(super) fn next(&mut self) -> Option<Token> {
        let token = self.peek();
        self.peeked = None;
        token
    }

    /// The text of a word, number or bracket.
    pub(super) fn word(&self, token: &Token) -> &'t str {
        self.lexer.word(token)
    }

    /// The contents of a quoted string.
    pub(super) fn unquoted(&self, token: &Token) -> String {
        self.lexer.unquoted(token).into_owned()
    }

    /// The next token if it is of this kind; otherwise an error says what was expected, and the token stays.
    fn expect(&mut self, kind: Kind, expected: &str) -> Option<Token> {
        match self.peek() {
            Some(token) if token.kind == kind => self.next(),
            Some(token) => {
                let found = self.word(&token);
                let found: String = found.chars().take(40).collect();
                let message = format!("unexpected `{found}`");
                self.report.error(self.span(&token), message, &format!("expected {expected}"));
                None
            }
            None => {
                let end = Span { file: self.file, start: self.length, end: self.length };
                self.report.error(end, "the file ends early", &format!("expected {expected}"));
                None
            }
        }
    }

    /// A quoted name.
    pub(super) fn name(&mut self, expected: &str) -> Option<Text> {
        let token = self.expect(Kind::Quoted, expected)?;
        Some(Text { text: self.unquoted(&token), span: self.span(&token) })
    }

    /// A second quoted name, if there is one.
    pub(super) fn another_name(&mut self) -> Option<Text> {
        let is_name = self.peek().is_some_and(|t| t.kind == Kind::Quoted);
        if is_name { self.name("a name") } else { None }
    }

    /// A word such as `All`.
    pub(super) fn bare_word(&mut self, expected: &str) -> Option<(&'t str, Span)> {
        let token = self.expect(Kind::Word, expected)?;
        Some((self.word(&token), self.span(&token)))
    }

    /// Several numbers, in brackets or not.
    pub(super) fn numbers<const N: usize>(&mut self) -> Option<[f64; N]> {
        let brackets = self.peek().is_some_and(|t| t.kind == Kind::Open);
        if brackets {
            self.next();
        }
        let mut out = [0.0; N];
        for slot in &mut out {
            let token = self.expect(Kind::Word, &format!("{N} numbers"))?;
            *slot = self.number(&token)?;
        }
        if brackets {
            self.expect(Kind::Close, "`]`")?;
        }
        Some(out)
    }

    fn number(&self, token: &Token) -> Option<f64> {
        let parsed = value::number64(self.word(token));
        parsed.map_err(|why| self.report.error(self.span(token), why, "expected a number")).ok()
    }

    /// The parameters of a directive: `"type name" value`, again and again.
    pub(super) fn parameters(&mut self) -> Vec<Rc<Param>> {
        let mut all = Vec::new();
        while let Some(token) = self.peek().filter(|t| t.kind == Kind::Quoted) {
            self.next();
            let parameter = self.parameter(&token);
            if all.len() == MAX_PARAMETERS {
                let message = format!("more than {MAX_PARAMETERS} parameters");
                self.report.error(self.span(&token), message, "");
            }
            if all.len() <= MAX_PARAMETERS {
                all.extend(parameter.map(Rc::new));
            }
        }
        all
    }

    /// A parameter whose declaration is `token`; its values follow.
    fn parameter(&mut self, token: &Token) -> Option<Param> {
        let span = self.span(token);
        let declaration = self.unquoted(token);
        let mut words = declaration.split_whitespace();
        let (kind, name) = match (words.next(), words.next(), words.next()) {
            (Some(kind), Some(name), None) => (kind, name),
            _ => {
                let message = format!("`{declaration}` is not a parameter");
                self.report.error(span, message, "expected a type and a name");
                self.values(Type::String);
                return None;
            }
        };
        let Some(kind) = Type::of(kind) else {
            let help = self.report.suggestion(kind, Type::names());
            let message = format!("unknown type `{kind}`");
            self.report.error_help(span, message, "expected a type and a name", help);
            self.values(Type::String);
            return None;
        };
        let values = self.values(kind)?;
        if !kind.accepts(&values) {
            let message = format!("`{name}` is {}", values.kind());
            self.report.error(span, message, &format!("expected {}", kind.expected()));
            return None;
        }
        Some(Param::new(kind, name, span, values))
    }

    /// The values of a parameter: one, or several in brackets.
    fn values(&mut self, kind: Type) -> Option<Values> {
        match self.peek().map(|t| t.kind) {
            Some(Kind::Open) => self.next(),
            Some(Kind::Word | Kind::Quoted) => {
                let token = self.next()?;
                let mut values = Values::Numbers(Vec::new());
                self.value(kind, &token, &mut values)?;
                return Some(values);
            }
            _ => {
                self.expect(Kind::Open, "a value");
                return None;
            }
        };
        let (mut values, mut fine) = (Values::Numbers(Vec::new()), true);
        loop {
            match self.peek() {
                Some(token) if matches!(token.kind, Kind::Word | Kind::Quoted) => {
                    // A directive's name: the bracket was not closed.
                    if fine && self.value(kind, &token, &mut values).is_none() {
                        fine = false;
                    }
                    if !fine && super::directives::is_directive(self.word(&token)) {
                        return None;
                    }
                    self.next();
                }
                _ => break,
            }
        }
        self.expect(Kind::Close, "a value or `]`")?;
        fine.then_some(values)
    }

    /// Add one value to those before it. `None` after an error.
    fn value(&mut self, kind: Type, token: &Token, values: &mut Values) -> Option<()> {
        let word = self.word(token);
        let empty = values.is_empty();
        match (&mut *values, token.kind) {
            (Values::Texts(all), Kind::Quoted) => all.push(self.text(token)),
            (_, Kind::Quoted) if empty => *values = Values::Texts(vec![self.text(token)]),
            (Values::Bools(all), Kind::Word) if matches!(word, "true" | "false") => {
                all.push(word == "true");
            }
            (_, Kind::Word) if empty && matches!(word, "true" | "false") => {
                *values = Values::Bools(vec![word == "true"]);
            }
            (Values::Numbers(all), Kind::Word) => all.push(self.number(token)?),
            _ => {
                let expected = format!("expected {}", kind.expected());
                self.report.error(self.span(token), "values of different kinds", &expected);
                return None;
            }
        }
        Some(())
    }

    fn text(&self, token: &Token) -> Text {
        Text { text: self.unquoted(token), span: self.span(token) }
    }
}
