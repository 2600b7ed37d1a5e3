//! Groups similar messages: the first few are kept, the others only counted.

use std::collections::HashMap;

/// How many messages are kept in all.
const MAX_KEPT: usize = 500;
/// Key of the messages that are counted because so many others are kept.
const OTHERS: &str = "";

/// How many messages of one kind are kept.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Messages with the same text, at different places.
    pub(super) same: usize,
    /// Messages that differ only in names and numbers.
    pub(super) like: usize,
}

/// Decides which messages are kept. The memory and the time per message do not depend on the number of messages.
#[derive(Debug)]
pub(super) struct Alike {
    limits: Limits,
    kept: usize,
    groups: HashMap<String, Group>,
}

/// The messages with one text, or with one text apart from names and numbers.
#[derive(Debug, Default)]
struct Group {
    kept: usize,
    hidden: usize,
    /// The first message that was not kept.
    sample: String,
    /// Number of messages of all groups that were kept up to the last one of this group.
    last: usize,
}

impl Alike {
    pub(super) fn new(limits: Limits) -> Self {
        Alike { limits, kept: 0, groups: HashMap::new() }
    }

    /// Whether to keep a message; otherwise it is counted.
    pub(super) fn keep(&mut self, message: &str) -> bool {
        let shape = shape(message);
        let full = |key: &str, most: usize| self.groups.get(key).is_some_and(|g| g.kept >= most);
        let full = if full(message, self.limits.same) {
            Some(message)
        } else if full(&shape, self.limits.like) {
            Some(shape.as_str())
        } else {
            (self.kept >= MAX_KEPT).then_some(OTHERS)
        };
        if let Some(key) = full {
            let last = self.kept;
            let fresh = || Group { last, ..Group::default() };
            let group = self.groups.entry(key.to_owned()).or_insert_with(fresh);
            if group.hidden == 0 {
                group.sample = message.to_owned();
            }
            group.hidden += 1;
            return false;
        }
        self.kept += 1;
        // A message that contains no names or numbers equals its shape.
        let own = (message != shape).then(|| message.to_owned());
        for key in own.into_iter().chain([shape]) {
            let group = self.groups.entry(key).or_default();
            group.kept += 1;
            group.last = self.kept;
        }
        true
    }

    /// Number of messages that were counted instead of kept.
    pub(super) fn hidden(&self) -> usize {
        self.groups.values().map(|g| g.hidden).sum()
    }

    /// A line for each group with counted messages, and the number of kept messages to show before it.
    pub(super) fn counted(&self) -> Vec<(usize, String)> {
        let hidden = self.groups.iter().filter(|(_, group)| group.hidden > 0);
        let line = |(key, group): (&String, &Group)| {
            let many = thousands(group.hidden);
            let text = match key.as_str() {
                OTHERS => format!("and {many} more"),
                _ => format!("and {many} more like this: {}", group.sample),
            };
            (group.last, text)
        };
        let mut counted: Vec<(usize, String)> = hidden.map(line).collect();
        counted.sort();
        counted
    }

    /// Insert these lines into the kept messages.
    pub(super) fn insert_into(&self, kept: Vec<String>) -> Vec<String> {
        let mut counted = self.counted().into_iter().peekable();
        let mut out = Vec::with_capacity(kept.len());
        for (before, message) in kept.into_iter().enumerate() {
            while let Some((_, line)) = counted.next_if(|(last, _)| *last <= before) {
                out.push(line);
            }
            out.push(message);
        }
        out.extend(counted.map(|(_, line)| line));
        out
    }
}

/// A message without its digits and without the text inside backquotes.
fn shape(message: &str) -> String {
    let unquoted = message.split('`').step_by(2).collect::<Vec<_>>().join("`");
    unquoted.replace(|c: char| c.is_ascii_digit(), "")
}

/// Format 1994 as `1,994`.
pub(super) fn thousands(n: usize) -> String {
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

    fn grouped(all: impl IntoIterator<Item = (usize, String)>) -> Vec<String> {
        let mut alike = Alike::new(Limits { same: 3, like: 24 });
        let kept = all.into_iter().filter(|(_, message)| alike.keep(message));
        let kept = kept.map(|(line, message)| format!("a.mtl:{line}: {message}")).collect();
        alike.insert_into(kept)
    }

    #[test]
    fn the_same_warning_at_many_lines_is_shown_three_times_and_counted() {
        let mut all: Vec<_> = (1..=1997).map(|k| (k, "`map_Ks` is ignored".to_owned())).collect();
        all.insert(1, (9, "`bump` is ignored".into()));
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
        let shown = grouped((0..100_000).map(|k| (k, format!("no material `m{k}`"))));
        assert_eq!(shown.len(), 25);
        assert_eq!(shown[24], "and 99,976 more like this: no material `m24`");
    }

    #[test]
    fn messages_of_many_kinds_cannot_fill_the_screen() {
        let kind = |k: usize| "z".repeat(k % 700) + if k < 700 { "a" } else { "b" };
        let shown = grouped((0..1400).map(|k| (k, kind(k))));
        assert_eq!(shown.len(), MAX_KEPT + 1);
        assert_eq!(shown[MAX_KEPT], "and 900 more");
    }
}
