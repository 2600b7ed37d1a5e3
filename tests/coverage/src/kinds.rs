//! The kinds of inputs.

use gi_core::bytes::checksum;

use crate::harness::Guard;
use crate::loaders::{self, Loader};
use crate::pixels::{self, RENDERERS};
use crate::saved;

/// Whether an input is valid, or what must not happen.
type Check = Box<dyn Fn(&[u8]) -> Result<bool, String>>;

/// A kind of input, with small valid files of it.
pub(crate) struct Kind {
    pub(crate) files: Vec<Vec<u8>>,
    check: Check,
    guard: Guard,
}

/// The names of all kinds.
pub(crate) fn names() -> Vec<&'static str> {
    loaders::KINDS.into_iter().chain(saved::KINDS).chain(["pixels.xml", "pixels.pbrt"]).collect()
}

impl Kind {
    /// The kind of that name.
    pub(crate) fn new(name: &str) -> Option<Self> {
        let name = names().into_iter().find(|known| *known == name)?;
        let guard = Guard::new();
        if let Some(kind) = name.strip_prefix("pixels.") {
            let target = pixels::Target::new(kind);
            let files = target.files.clone();
            // The same technique each time for the same bytes.
            let technique = |bytes: &[u8]| checksum(bytes) as usize % RENDERERS.len();
            let check = Box::new(move |b: &[u8]| target.check(b, Some(technique(b))));
            return Some(Kind { files, check, guard });
        }
        if saved::KINDS.contains(&name) {
            let target = saved::Target::new(name);
            let files = vec![target.content()];
            return Some(Kind { files, check: Box::new(move |b| target.check(b)), guard });
        }
        let loader = Loader::new(name);
        let files = loader.files.clone();
        Some(Kind { files, check: Box::new(move |b| loader.check(b)), guard })
    }

    /// Whether an input is valid, or what must not happen. A panic ends the program at once.
    pub(crate) fn check(&mut self, bytes: &[u8]) -> Result<bool, String> {
        self.guard.run(|| (self.check)(bytes))
    }
}
