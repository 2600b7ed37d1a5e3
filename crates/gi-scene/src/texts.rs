//! The texts of a scene file and of the files that it includes: each is read once, and memory and length are bounded.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::diagnostics::Report;
use crate::files;

/// What the parts of a text cost.
#[derive(Clone, Copy)]
pub(crate) struct Cost {
    /// Largest length of all included text, counting repeats.
    pub(crate) most_included: u64,
    /// The byte that marks parts, how often it does per part, and the name of the parts.
    pub(crate) mark: (u8, u64, &'static str),
    /// Bytes that a part takes at most while the scene is read.
    pub(crate) part: u64,
}

/// The texts that have been read.
pub(crate) struct Texts {
    cost: Cost,
    known: HashMap<PathBuf, Rc<str>>,
    /// Length of all included text so far, counting repeats.
    included: u64,
}

impl Texts {
    pub(crate) fn new(cost: Cost) -> Self {
        Texts { cost, known: HashMap::new(), included: 0 }
    }

    /// Whether no file could be read.
    pub(crate) fn is_empty(&self) -> bool {
        self.known.is_empty()
    }

    /// The text of a file. Its memory is counted with that of its parts.
    pub(crate) fn read(
        &mut self,
        path: &Path,
        is_included: bool,
        report: &Report,
    ) -> Result<Rc<str>, String> {
        let text = match self.known.get(path) {
            Some(known) => known.clone(),
            None => {
                let mut claim = report.budget.claim(path.display());
                let text: Rc<str> = files::read_text(path, &mut claim)?.into();
                claim.keep(2 * text.len() as u64)?; // here and in the report
                self.known.entry(path.to_owned()).or_insert(text).clone()
            }
        };
        let Cost { most_included, mark: (mark, marks, name), part } = self.cost;
        if is_included {
            self.included += text.len() as u64;
            if self.included > most_included {
                return Err(format!(
                    "all included text is longer than {most_included} bytes, counting repeats"
                ));
            }
        }
        let parts = text.bytes().filter(|byte| *byte == mark).count() as u64 / marks;
        report.budget.claim(format_args!("{} ({name})", path.display())).keep(parts * part)?;
        Ok(text)
    }
}
