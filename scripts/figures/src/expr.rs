//! Expressions over a figure's data, for claims and for the numbers in captions: `relmse(with) < 0.5 * relmse(without)`.
//!
//! An expression has numbers, `+ - * / ^`, brackets, and functions of files; see [`crate::data`]. A claim compares two
//! expressions by `<` or `>`, or says that one lies `in LOW..HIGH`.

use anyhow::{Context, bail};

/// The value of a function of files, by its name and arguments.
pub(crate) trait Functions {
    fn value(&self, function: &str, arguments: &[&str]) -> anyhow::Result<f64>;
}

/// A claim with the numbers of both sides.
pub(crate) struct Checked {
    pub(crate) holds: bool,
    /// Both sides as numbers: `1.06e-3 < 5.7e-4`.
    pub(crate) numbers: String,
}

/// Evaluate both sides of a claim.
pub(crate) fn check(claim: &str, of: &impl Functions) -> anyhow::Result<Checked> {
    let told = || format!("the claim \"{claim}\"");
    let mut p = Parser { rest: claim, of };
    let left = p.sum().with_context(told)?;
    let word = ["<", ">", "in"].into_iter().find(|w| p.takes(w));
    let word = word.with_context(told).context("expected <, > or in LOW..HIGH")?;
    let right = p.sum().with_context(told)?;
    if word != "in" {
        p.end().with_context(told)?;
        let holds = if word == "<" { left < right } else { left > right };
        return Ok(Checked { holds, numbers: format!("{} {word} {}", short(left), short(right)) });
    }
    if !p.takes("..") {
        bail!("{}: expected in LOW..HIGH", told());
    }
    let high = p.sum().with_context(told)?;
    p.end().with_context(told)?;
    let numbers = format!("{} in {}..{}", short(left), short(right), short(high));
    Ok(Checked { holds: (right..=high).contains(&left), numbers })
}

/// The value of an expression.
pub(crate) fn value(text: &str, of: &impl Functions) -> anyhow::Result<f64> {
    let mut p = Parser { rest: text, of };
    let value = p.sum().and_then(|v| p.end().map(|()| v));
    value.with_context(|| format!("the expression \"{text}\""))
}

/// A text in which every `{expression}` is replaced by its value, and every `{expression %}` by its value in percent.
pub(crate) fn filled(text: &str, of: &impl Functions) -> anyhow::Result<String> {
    let (mut out, mut rest) = (String::new(), text);
    while let Some((before, from)) = rest.split_once('{') {
        let (inside, after) =
            from.split_once('}').with_context(|| format!("a brace is not closed in: {text}"))?;
        out += before;
        out += &match inside.trim_end().strip_suffix('%') {
            Some(fraction) => format!("{} %", short(100.0 * value(fraction, of)?)),
            None => short(value(inside, of)?),
        };
        rest = after;
    }
    Ok(out + rest)
}

/// A number with three digits, or a whole number with its thousands apart.
pub(crate) fn short(v: f64) -> String {
    let size = v.abs();
    if (1000.0..1e9).contains(&size) && (v.round() - v).abs() < 1e-6 * size {
        return grouped(v.round() as i64);
    }
    if size != 0.0 && !(1e-3..1e6).contains(&size) {
        return format!("{v:.2e}");
    }
    if size >= 1000.0 {
        return grouped(v.round() as i64);
    }
    let digits = (2 - size.max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{v:.digits$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
        false => text,
    }
}

/// A whole number with thin spaces between groups of three digits.
fn grouped(v: i64) -> String {
    let digits = v.unsigned_abs().to_string();
    let mut out = String::from(if v < 0 { "-" } else { "" });
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    out
}

struct Parser<'t, F> {
    rest: &'t str,
    of: &'t F,
}

impl<'t, F: Functions> Parser<'t, F> {
    /// Take `word` if it comes next.
    fn takes(&mut self, word: &str) -> bool {
        let rest = self.rest.trim_start().strip_prefix(word);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    fn end(&self) -> anyhow::Result<()> {
        match self.rest.trim() {
            "" => Ok(()),
            rest => bail!("not understood: {rest}"),
        }
    }

    fn sum(&mut self) -> anyhow::Result<f64> {
        let mut value = self.product()?;
        loop {
            if self.takes("+") {
                value += self.product()?;
            } else if self.takes("-") {
                value -= self.product()?;
            } else {
                return Ok(value);
            }
        }
    }

    fn product(&mut self) -> anyhow::Result<f64> {
        let mut value = self.power()?;
        loop {
            if self.takes("*") {
                value *= self.power()?;
            } else if self.takes("/") {
                value /= self.power()?;
            } else {
                return Ok(value);
            }
        }
    }

    fn power(&mut self) -> anyhow::Result<f64> {
        let base = self.factor()?;
        if self.takes("^") { Ok(base.powf(self.factor()?)) } else { Ok(base) }
    }

    fn factor(&mut self) -> anyhow::Result<f64> {
        if self.takes("-") {
            return Ok(-self.power()?);
        }
        if self.takes("(") {
            let value = self.sum()?;
            if !self.takes(")") {
                bail!("a bracket is not closed");
            }
            return Ok(value);
        }
        self.rest = self.rest.trim_start();
        let is_name = |c: char| c.is_ascii_alphabetic() || c == '_';
        if self.rest.starts_with(is_name) {
            return self.function();
        }
        self.number()
    }

    /// A number. Two points end it: they belong to a range.
    fn number(&mut self) -> anyhow::Result<f64> {
        let whole = self.rest.split("..").next().unwrap_or_default();
        let mut end = 0;
        for (k, c) in whole.char_indices() {
            let after_exponent = k > 0 && matches!(whole.as_bytes()[k - 1], b'e' | b'E');
            match c {
                '0'..='9' | '.' | 'e' | 'E' => end = k + 1,
                '-' | '+' if after_exponent => end = k + 1,
                _ => break,
            }
        }
        let (number, rest) = self.rest.split_at(end);
        self.rest = rest;
        number.parse().with_context(|| format!("expected a number at \"{number}{rest}\""))
    }

    /// A function with its arguments, which are not expressions but names of files, and numbers.
    fn function(&mut self) -> anyhow::Result<f64> {
        let (name, from) = self.rest.split_once('(').context("expected ( after a name")?;
        let (arguments, rest) = from.split_once(')').context("a bracket is not closed")?;
        self.rest = rest;
        let arguments: Vec<&str> = arguments.split(',').map(str::trim).collect();
        self.of.value(name.trim(), &arguments)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A function whose value is its argument, whatever its name.
    struct Same;

    impl Functions for Same {
        fn value(&self, name: &str, arguments: &[&str]) -> anyhow::Result<f64> {
            match name {
                "same" => Ok(arguments[0].parse()?),
                _ => bail!("no function {name}"),
            }
        }
    }

    #[test]
    fn expressions_follow_the_rules_of_arithmetic() {
        for (text, expected) in [
            ("1 + 2 * 3", 7.0),
            ("(1 + 2) * 3 - 4 / 2", 7.0),
            ("-2 ^ 2 * 3", -12.0),
            ("2 * same(1.5e-1) + 1", 1.3),
            ("10 - 4 - 3", 3.0),
        ] {
            let found = value(text, &Same).expect(text);
            assert!((found - expected).abs() < 1e-12, "{text}: {found}");
        }
        for wrong in ["", "1 +", "(1", "other(2)", "same(", "1 2", "same", "1 <"] {
            assert!(value(wrong, &Same).is_err(), "{wrong}");
        }
    }

    #[test]
    fn claims_are_true_or_false_and_show_both_sides() {
        for (claim, holds, numbers) in [
            ("same(2) < 3 * 0.5", false, "2 < 1.5"),
            ("same(0.00106) > 5e-4", true, "0.00106 > 5.00e-4"),
            ("same(0.99) in 0.98..1.02", true, "0.99 in 0.98..1.02"),
            ("same(1.5) in 1-0.5..1+0.2", false, "1.5 in 0.5..1.2"),
        ] {
            let found = check(claim, &Same).expect(claim);
            assert_eq!((found.holds, found.numbers.as_str()), (holds, numbers), "{claim}");
        }
        for wrong in ["same(2)", "1 < 2 < 3", "1 in 2", "1 in 2..3 4"] {
            assert!(check(wrong, &Same).is_err(), "{wrong}");
        }
    }

    #[test]
    fn braces_in_texts_become_numbers() {
        let text = filled("{same(1234567)} photons, {same(0.1234) %} of {2*2}", &Same);
        assert_eq!(text.expect("a text"), "1\u{202f}234\u{202f}567 photons, 12.3 % of 4");
        assert!(filled("{1", &Same).is_err());
    }
}
