//! Names (`$name`) and the values that replace them.

use std::cell::Cell;
use std::collections::{BTreeMap, HashMap};

pub(super) struct Define {
    pub(super) name: String,
    pub(super) value: String,
    /// Whether it comes from `-D`. Then it overrides `<default>`, and it is reported if the scene never uses it.
    pub(super) forced: bool,
    pub(super) used: Cell<bool>,
}

/// All names. The time to find one does not depend on their number.
#[derive(Default)]
pub(super) struct Defines {
    all: Vec<Define>,
    index_of: HashMap<String, usize>,
    /// Number of names per length.
    lengths: BTreeMap<usize, usize>,
}

impl Defines {
    /// Add a name, unless it is defined already.
    pub(super) fn add(&mut self, define: Define) {
        if !self.index_of.contains_key(&define.name) {
            *self.lengths.entry(define.name.len()).or_default() += 1;
            self.index_of.insert(define.name.clone(), self.all.len());
            self.all.push(define);
        }
    }

    pub(super) fn get(&self, name: &str) -> Option<&Define> {
        self.index_of.get(name).map(|k| &self.all[*k])
    }

    /// The longest defined name that is a prefix of `text`.
    pub(super) fn at_start_of(&self, text: &str) -> Option<&Define> {
        let lengths = self.lengths.range(..=text.len()).rev();
        lengths.filter_map(|(length, _)| text.get(..*length)).find_map(|name| self.get(name))
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Define> {
        self.all.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_name_and_the_first_value_win() {
        let mut defines = Defines::default();
        for (name, value) in [("r", "1"), ("rad", "2"), ("rad", "3"), ("\u{e4}", "4")] {
            let (name, value) = (name.to_owned(), value.to_owned());
            defines.add(Define { name, value, forced: false, used: Cell::new(false) });
        }
        let value = |text: &str| defines.at_start_of(text).map(|d| d.value.as_str());
        assert_eq!(["radius", "ra", "\u{e4}x"].map(value), [Some("2"), Some("1"), Some("4")]);
        assert_eq!([value("x"), value("")], [None, None]);
    }
}
