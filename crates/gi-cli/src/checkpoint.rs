//! Checkpoints: a run's state in a file, so that another run goes on from there or adds its passes up with others.

use std::io::{Read, Seek, SeekFrom};
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

/// A whole checkpoint.
pub(crate) struct Checkpoint {
    path: PathBuf,
    bytes: Vec<u8>,
}

/// Which passes a checkpoint holds.
pub(crate) struct Summary {
    pub(crate) seed: String,
    pub(crate) passes: Range<u32>,
}

impl Checkpoint {
    /// Check that a file is of this identity, apart from the values that may differ. `identity` may be without what is only known after
    /// preparation. Only the beginning of the file is read, unless something is wrong.
    pub(crate) fn look(
        path: &Path,
        identity: &Identity,
        may_differ: &[&str],
    ) -> Result<Summary, Failure> {
        if let Some(start) = start(path)
            && let Ok(head) = Head::read(&mut Reader::new(&start))
            && head.check(identity, may_differ).is_ok()
        {
            return Ok(head.summary());
        }
        // The causes are told apart with the whole file: what seems to be of another scene may be damaged.
        let whole = Self::read(path)?;
        let (head, _) = whole.parts(identity, may_differ).map_err(|e| whole.refuse(e))?;
        Ok(head.summary())
    }

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

    /// Take a run's state from it; `restore` takes that of the technique. Returns the passes that were made.
    pub(crate) fn resume(
        &self,
        identity: &Identity,
        may_differ: &[&str],
        film: &mut Film,
        restore: impl FnOnce(&[u8]) -> Result<(), String>,
    ) -> Result<Range<u32>, Failure> {
        let resume = || {
            let (head, [state, its_film]) = self.parts(identity, may_differ)?;
            restore(state)?;
            film.restore(its_film)?;
            Ok(head.passes)
        };
        resume().map_err(|e| self.refuse(e))
    }

    /// What it says of itself, and the states of the technique and of the film.
    fn parts(
        &self,
        identity: &Identity,
        may_differ: &[&str],
    ) -> Result<(Head<'_>, [&[u8]; 2]), String> {
        // The checksum is right.
        let mut r = Reader::new(&self.bytes[..self.bytes.len() - CHECKSUM]);
        let head = Head::read(&mut r)?;
        head.check(identity, may_differ)?;
        let states = [r.bytes()?, r.bytes()?];
        r.end()?;
        Ok((head, states))
    }

    fn refuse(&self, cause: String) -> Failure {
        refuse(&self.path, &cause)
    }
}

/// What a checkpoint says of itself before the states.
struct Head<'b> {
    /// The identity: names and values.
    pairs: Vec<(&'b str, &'b str)>,
    passes: Range<u32>,
}

impl<'b> Head<'b> {
    fn read(r: &mut Reader<'b>) -> Result<Self, String> {
        r.text()?;
        let pairs = (0..r.u32()?).map(|_| Ok((r.text()?, r.text()?)));
        let pairs = pairs.collect::<Result<Vec<_>, String>>()?;
        Ok(Head { pairs, passes: r.u32()?..r.u32()? })
    }

    fn check(&self, identity: &Identity, may_differ: &[&str]) -> Result<(), String> {
        for (k, (name, value)) in identity.iter().enumerate() {
            let Some((_, its_value)) = self.pairs.get(k).filter(|(its_name, _)| its_name == name)
            else {
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
        Ok(())
    }

    fn summary(&self) -> Summary {
        let seed = self.pairs.iter().find(|(name, _)| *name == "seed");
        let seed = seed.map_or_else(String::new, |(_, seed)| seed.to_string());
        Summary { seed, passes: self.passes.clone() }
    }
}

/// Number of bytes that heads fit in, unless a command line was very long.
const HEAD: u64 = 1 << 16;

/// The first bytes of a checkpoint, if the file is as long as they say.
fn start(path: &Path) -> Option<Vec<u8>> {
    let mut file = files::open_regular(path).ok()?;
    let mut start = Vec::new();
    file.by_ref().take(HEAD).read_to_end(&mut start).ok()?;
    let mut r = Reader::new(&start);
    (r.clone().text().ok()? == MAGIC).then_some(())?;
    Head::read(&mut r).ok()?;
    let state = r.u64().ok()?;
    let film = ((start.len() - r.len()) as u64).checked_add(state)?;
    file.seek(SeekFrom::Start(film)).ok()?;
    let mut length = [0; size_of::<u64>()];
    file.read_exact(&mut length).ok()?;
    let end = (film + length.len() as u64).checked_add(u64::from_le_bytes(length))?;
    (file.metadata().ok()?.len() == end.checked_add(CHECKSUM as u64)?).then_some(start)
}

/// What is said of a checkpoint that cannot be used.
pub(crate) fn refuse(path: &Path, cause: &str) -> Failure {
    Failure::Input(format!("error: {}", files::refusal(path, cause)))
}

#[cfg(test)]
mod tests;
