//! Checkpoints: a run's state in a file, so that another run goes on from there or adds its passes up with others.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use gi_core::bytes::{Reader, Writer, unseal};
use gi_core::files;
use gi_core::film::Film;
use gi_core::technique::Technique;

use crate::Failure;
use crate::save::save_bytes;

/// First line of a checkpoint; the number is the format's.
const MAGIC: &str = "gilab checkpoint 3";

/// Size of the checksum at the end, in bytes.
const CHECKSUM: usize = 8;

/// What must be the same for a checkpoint to be of use, by name: program, scene, camera and so on.
pub(crate) type Identity = Vec<(String, String)>;

/// Writes a run's checkpoints.
pub(crate) struct Keeper<'a> {
    path: &'a Path,
    identity: &'a Identity,
    every: Duration,
    /// When the last attempt ended.
    last: Option<Instant>,
    /// Passes in the file, once this run has written it.
    kept: Option<u32>,
}

impl<'a> Keeper<'a> {
    /// A keeper that writes the first checkpoint as soon as it can, and the next ones `every` so often.
    pub(crate) fn new(path: &'a Path, identity: &'a Identity, every: Duration) -> Self {
        Keeper { path, identity, every, last: None, kept: None }
    }

    /// Whether the last attempt is long enough ago.
    pub(crate) fn is_due(&self) -> bool {
        self.last.is_none_or(|last| last.elapsed() >= self.every)
    }

    /// The number of passes in the file, if this run has written it.
    pub(crate) fn kept(&self) -> Option<u32> {
        self.kept
    }

    /// Write a checkpoint.
    pub(crate) fn keep<'t>(
        &mut self,
        technique: &impl Technique<'t>,
        film: &Film,
        passes: &Range<u32>,
    ) -> Result<(), Failure> {
        let written = self.write(technique, film, passes);
        self.last = Some(Instant::now());
        self.kept = if written.is_ok() { Some(passes.len() as u32) } else { self.kept };
        written
    }

    fn write<'t>(
        &self,
        technique: &impl Technique<'t>,
        film: &Film,
        passes: &Range<u32>,
    ) -> Result<(), Failure> {
        let state = technique.save_state();
        let mut w = Writer::default();
        w.text(MAGIC);
        w.u32(self.identity.len() as u32);
        for (name, value) in self.identity {
            w.text(name);
            w.text(value);
        }
        w.u32(passes.start);
        w.u32(passes.end);
        w.bytes(&state);
        w.bytes(&film.save_state());
        save_bytes(self.path, &w.seal())
    }
}

/// A checkpoint of this scene, camera, and so on.
pub(crate) struct Checkpoint {
    path: PathBuf,
    bytes: Vec<u8>,
}

/// A name and a value of an identity.
type Pair<'b> = (&'b str, &'b str);

/// What a checkpoint holds.
struct Parts<'b> {
    passes: Range<u32>,
    state: &'b [u8],
    film: &'b [u8],
}

impl Checkpoint {
    /// Read a checkpoint, and check that it is whole.
    pub(crate) fn read(path: &Path) -> Result<Self, Failure> {
        let bytes = files::read(path).map_err(|e| Failure::Input(format!("error: {e}")))?;
        Self::of_bytes(path, bytes)
    }

    fn of_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self, Failure> {
        let checkpoint = Checkpoint { path: path.to_path_buf(), bytes };
        if Reader::new(&checkpoint.bytes).text().ok() != Some(MAGIC) {
            return Err(checkpoint.refuse("it is no checkpoint, or one of another version".into()));
        }
        unseal(&checkpoint.bytes).map_err(|e| checkpoint.refuse(e))?;
        Ok(checkpoint)
    }

    /// Check that it has this identity, apart from the values that may differ. `identity` may be without what is
    /// only known after preparation.
    pub(crate) fn check(&self, identity: &Identity, may_differ: &[&str]) -> Result<(), Failure> {
        self.parts(identity, may_differ).map(|_| ()).map_err(|e| self.refuse(e))
    }

    /// Take a run's state from it; returns the passes that were made.
    pub(crate) fn resume<'t>(
        &self,
        identity: &Identity,
        may_differ: &[&str],
        technique: &mut impl Technique<'t>,
        film: &mut Film,
    ) -> Result<Range<u32>, Failure> {
        let mut resume = || {
            let parts = self.parts(identity, may_differ)?;
            technique.restore(parts.state)?;
            film.restore(parts.film)?;
            Ok(parts.passes)
        };
        resume().map_err(|e| self.refuse(e))
    }

    /// A value of its identity; empty if it has none of this name.
    pub(crate) fn value(&self, name: &str) -> Result<String, Failure> {
        let (identity, _) = self.identity().map_err(|e| self.refuse(e))?;
        let value = identity.iter().find(|(its_name, _)| *its_name == name);
        Ok(value.map_or_else(String::new, |(_, value)| value.to_string()))
    }

    /// Its identity, and what follows.
    fn identity(&self) -> Result<(Vec<Pair<'_>>, Reader<'_>), String> {
        // The checksum is right.
        let mut r = Reader::new(&self.bytes[..self.bytes.len() - CHECKSUM]);
        r.text()?;
        let pairs = (0..r.u32()?).map(|_| Ok((r.text()?, r.text()?)));
        let pairs = pairs.collect::<Result<Vec<_>, String>>()?;
        Ok((pairs, r))
    }

    fn parts(&self, identity: &Identity, may_differ: &[&str]) -> Result<Parts<'_>, String> {
        let (its, mut r) = self.identity()?;
        for (k, (name, value)) in identity.iter().enumerate() {
            let Some((_, its_value)) = its.get(k).filter(|(its_name, _)| its_name == name) else {
                return Err("it is of another version".into());
            };
            if its_value == value || may_differ.contains(&name.as_str()) {
                continue;
            }
            // Long values are not for people.
            let is_short = its_value.len().max(value.len()) <= 40;
            let values =
                if is_short { format!(": {its_value}, not {value}") } else { String::new() };
            return Err(format!("it is of another {name}{values}"));
        }
        let passes = r.u32()?..r.u32()?;
        let (state, film) = (r.bytes()?, r.bytes()?);
        r.end()?;
        Ok(Parts { passes, state, film })
    }

    fn refuse(&self, cause: String) -> Failure {
        refuse(&self.path, &cause)
    }
}

/// What is said of a checkpoint that cannot be used.
pub(crate) fn refuse(path: &Path, cause: &str) -> Failure {
    Failure::Input(format!("error: cannot use {}: {cause}", path.display()))
}

#[cfg(test)]
mod tests;
