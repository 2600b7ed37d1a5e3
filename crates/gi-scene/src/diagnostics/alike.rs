//! Groups similar warnings: the first few are shown, the others only counted.

use std::collections::HashMap;

use super::Warning;

/// How many times the same message is shown, each time at another place.
const MAX_SAME: usize = 3;
/// How many messages are shown that differ only in names and numbers.
const MAX_LIKE: usize = 24;

/// How often a message occurred, and the output position of its last shown occurrence.
#[derive(Default)]
struct Said {
    shown: usize,
    hidden: usize,
    last: usize,
}

/// The warnings as text, in their original order.
pub(super) fn grouped(warnings: Vec<Warning>) -> Vec<String> {
    let mut said: HashMap<String, Said> = HashMap::new();
    let mut out: Vec<String> = Vec::new();
    let mut groups = Vec::new();
    for Warning { place, message } in warnings {
        let shape = shape(&message);
        let full = |key: &str, most: usize| said.get(key).is_some_and(|s| s.shown >= most);
        let group = if full(&message, MAX_SAME) {
            Some(message.clone())
        } else {
            full(&shape, MAX_LIKE).then(|| shape.clone())
        };
        if let Some(key) = group {
            let group = said.get_mut(&key).expect("inserted above");
            if group.hidden == 0 {
                groups.push((key, message));
            }
            group.hidden += 1;
            continue;
        }
        out.push(format!("{place}{message}"));
        // A message that contains no names or numbers equals its shape.
        let own = (message != shape).then_some(message);
        for key in own.into_iter().chain([shape]) {
            let group = said.entry(key).or_default();
            group.shown += 1;
            group.last = out.len();
        }
    }
    // Insert from the end, so that earlier positions stay valid.
    let mut counted: Vec<(usize, String)> = groups
        .into_iter()
        .map(|(key, message)| {
            let Said { hidden, last, .. } = said[&key];
            (last, format!("and {} more like this: {message}", thousands(hidden)))
        })
        .collect();
    counted.sort_by_key(|(last, _)| *last);
    counted.into_iter().rev().for_each(|(last, text)| out.insert(last, text));
    out
}

/// A message without its digits and without the text inside backquotes.
fn shape(message: &str) -> String {
    let unquoted = message.split('`').step_by(2).collect::<Vec<_>>().join("`");
    unquoted.replace(|c: char| c.is_ascii_digit(), "")
}

/// Format 1994 as `1,994`.
fn thousands(n: usize) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (k, c) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            out.push(',');
        }
        out.push(c);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn warning(line: usize, message: String) -> Warning {
        Warning { place: format!("a.mtl:{line}: "), message }
    }

    #[test]
    fn the_same_warning_at_many_lines_is_shown_three_times_and_counted() {
        let mut all: Vec<Warning> =
            (1..=1997).map(|k| warning(k, "`map_Ks` is ignored".into())).collect();
        all.insert(1, warning(9, "`bump` is ignored".into()));
        let shown = grouped(all);
        assert_eq!(
            shown,
            [
                "a.mtl:1: `map_Ks` is ignored",
                "a.mtl:9: `bump` is ignored",
                "a.mtl:2: `map_Ks` is ignored",
                "a.mtl:3: `map_Ks` is ignored",
                "and 1,994 more like this: `map_Ks` is ignored",
            ]
        );
    }

    #[test]
    fn warnings_that_differ_in_names_are_counted_too() {
        let all = (0..100_000).map(|k| warning(k, format!("no material `m{k}`"))).collect();
        let shown = grouped(all);
        assert_eq!(shown.len(), MAX_LIKE + 1);
        assert_eq!(shown[MAX_LIKE], "and 99,976 more like this: no material `m24`");
    }
}
