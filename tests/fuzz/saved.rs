//! Files that programs write and read again. Most damaged copies get a new checksum, because all others are refused.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use gi_core::bytes::{Reader, Writer, unseal};
use gi_core::film::{Film, Show};
use gi_core::filter::Filter;
use gi_core::technique::Technique;
use gi_tests::World;

use crate::common::{Folder, Slot};

/// Names of all kinds of files: their extensions in `found`.
pub(crate) const KINDS: [&str; 4] = ["irradiance", "radiance", "photons", "checkpoint"];

/// One of so many files that can be read is used for a pass, because a pass takes much longer.
const MANY: u64 = 10;

/// A kind of file.
pub(crate) struct Target {
    /// Its extension in `found`.
    pub(crate) name: &'static str,
    world: &'static World,
    _folder: Folder,
    input: Slot,
    functions: Functions,
    /// A technique and its film, which take the state of a run.
    run: Mutex<(ppm::Ppm<'static>, Film)>,
    /// Number of files that could be read.
    parsed: AtomicU64,
}

/// What there is to do with a kind of file.
#[derive(Clone, Copy)]
struct Functions {
    /// Write a file.
    write: fn(&World, &Path) -> Vec<u8>,
    /// Read the bytes of a file. Where only a pass reads them, this accepts everything.
    parse: fn(&Target, &[u8]) -> Result<(), String>,
    /// Make a pass with a file.
    read: fn(&World, &Path) -> Result<(), String>,
    /// One of so many files that can be read is used.
    every: u64,
}

/// Prepare a technique and make one pass.
fn pass<'a, T: Technique<'a>>(world: &'a World, params: &T::Params) -> Result<T, String> {
    let mut technique = T::prepare(world.setting(1, Show::All), params)?;
    technique.pass(0, &mut film(world));
    Ok(technique)
}

fn film(world: &World) -> Film {
    Film::new(world.camera.size(), Filter::Box, Show::All)
}

fn irrcache(path: &Path, reads: bool) -> irrcache::Params {
    let mut params = irrcache::Params { rays: 16, ..Default::default() };
    let files = &mut params.files;
    *(if reads { &mut files.cache_in } else { &mut files.cache_out }) = Some(path.to_owned());
    params
}

fn radcache(path: &Path, reads: bool) -> radcache::Params {
    let mut params = radcache::Params { rays: 16, glossy_rays: 16, order: 3, ..Default::default() };
    let files = &mut params.files;
    *(if reads { &mut files.cache_in } else { &mut files.cache_out }) = Some(path.to_owned());
    params
}

fn photonmap(path: &Path, reads: bool) -> photonmap::Params {
    let mut params =
        photonmap::Params { photons: 30, caustic_photons: 10, lookup: 5, ..Default::default() };
    *(if reads { &mut params.map_in } else { &mut params.map_out }) = Some(path.to_owned());
    params
}

fn ppm() -> ppm::Params {
    ppm::Params { photons: 30, initial_photons: 30, ..Default::default() }
}

/// A run with progressive photon mapping before its first pass.
fn start(world: &World) -> Result<(ppm::Ppm<'_>, Film), String> {
    Ok((<ppm::Ppm as Technique>::prepare(world.setting(1, Show::All), &ppm())?, film(world)))
}

/// The state of a run with progressive photon mapping, and its film, as in a checkpoint.
fn write_state(world: &World, _: &Path) -> Vec<u8> {
    let (technique, film) = world.run::<ppm::Ppm>(&ppm(), 1, 1, Show::All);
    let mut out = Writer::default();
    out.bytes(&technique.save_state());
    out.bytes(&film.save_state());
    out.seal()
}

fn restore(run: &mut (ppm::Ppm, Film), bytes: &[u8]) -> Result<(), String> {
    let mut input = Reader::new(unseal(bytes)?);
    run.0.restore(input.bytes()?)?;
    run.1.restore(input.bytes()?)
}

fn read_state(world: &World, path: &Path) -> Result<(), String> {
    let mut run = start(world)?;
    restore(&mut run, &gi_core::files::read(path)?)?;
    let (mut technique, mut film) = run;
    technique.pass(1, &mut film);
    film.layers();
    Ok(())
}

/// What there is to do with a kind of file.
fn functions(kind: &str) -> Functions {
    match kind {
        "irradiance" => Functions {
            write: |world, path| {
                let t = pass::<irrcache::IrradianceCaching>(world, &irrcache(path, false));
                t.expect("a cache").export(path)
            },
            parse: |_, bytes| irrcache::file::SavedCache::from_bytes(bytes).map(drop),
            read: |world, path| {
                pass::<irrcache::IrradianceCaching>(world, &irrcache(path, true)).map(drop)
            },
            every: MANY,
        },
        "radiance" => Functions {
            write: |world, path| {
                let t = pass::<radcache::RadianceCaching>(world, &radcache(path, false));
                t.expect("a cache").export(path)
            },
            parse: |_, bytes| radcache::file::SavedCache::from_bytes(bytes).map(drop),
            read: |world, path| {
                pass::<radcache::RadianceCaching>(world, &radcache(path, true)).map(drop)
            },
            every: MANY,
        },
        "photons" => Functions {
            write: |world, path| {
                let t = pass::<photonmap::PhotonMapping>(world, &photonmap(path, false));
                t.expect("a map").export(path)
            },
            parse: |_, _| Ok(()),
            read: |world, path| {
                pass::<photonmap::PhotonMapping>(world, &photonmap(path, true)).map(drop)
            },
            every: 1,
        },
        _ => Functions {
            write: write_state,
            parse: |target, bytes| restore(&mut target.run.lock().expect("no panic"), bytes),
            read: read_state,
            every: MANY,
        },
    }
}

/// All kinds of files.
#[cfg(test)]
pub(crate) fn all() -> Vec<Target> {
    KINDS.map(Target::new).into()
}

impl Target {
    pub(crate) fn new(name: &'static str) -> Self {
        // Matt and glossy surfaces, and a caustic.
        let world = Box::leak(Box::new(World::load("cornell-spheres.xml", [4, 4], &[])));
        let run = Mutex::new(start(world).expect("a run"));
        let folder = Folder::in_memory();
        let input = folder.slot("file");
        Target {
            name,
            world,
            _folder: folder,
            input,
            functions: functions(name),
            run,
            parsed: 0.into(),
        }
    }

    /// A valid file.
    fn file(&self) -> Vec<u8> {
        (self.functions.write)(self.world, &self.input.path)
    }

    /// A valid file without its checksum.
    pub(crate) fn content(&self) -> Vec<u8> {
        unseal(&self.file()).expect("it is whole").to_vec()
    }

    /// Make a pass with a file.
    fn read(&self, bytes: &[u8]) -> Result<(), String> {
        (self.functions.read)(self.world, self.input.replace(bytes))
    }

    /// Read damaged bytes with a right checksum, and use some that can be read. Returns whether they are
    /// valid.
    pub(crate) fn check(&self, content: &[u8]) -> Result<bool, String> {
        let mut sealed = Writer::default();
        sealed.raw(content);
        let sealed = sealed.seal();
        if (self.functions.parse)(self, &sealed).is_err() {
            return Ok(false);
        }
        let is_used = self.parsed.fetch_add(1, Relaxed).is_multiple_of(self.functions.every);
        Ok(!is_used || self.read(&sealed).is_ok())
    }

    /// Read damaged bytes with a right checksum, and use them. Returns whether they are valid.
    #[cfg(test)]
    pub(crate) fn check_and_use(&self, content: &[u8]) -> Result<bool, String> {
        let mut sealed = Writer::default();
        sealed.raw(content);
        Ok(self.read(&sealed.seal()).is_ok())
    }

    #[cfg(test)]
    fn fuzz(&self) {
        crate::harness::fuzz(self.name, &[self.content()], |bytes| self.check(bytes));
        // Without a right checksum, every damaged file is refused.
        let whole = self.file();
        for at in (0..whole.len()).step_by(whole.len() / 50 + 1) {
            let mut damaged = whole.clone();
            damaged[at] ^= 0x04;
            assert!(self.read(&damaged).is_err(), "{}: byte {at}", self.name);
        }
    }
}

#[test]
fn files_that_programs_read_again() {
    all().iter().for_each(Target::fuzz);
}

#[test]
fn a_checkpoint_that_states_the_largest_counts_does_not_overflow() {
    let world = World::load("cornell-spheres.xml", [4, 4], &[]);
    let (mut run, mut film) = start(&world).expect("a run");
    // Passes, paths, and photons that were stored and that contributed.
    let counts = 4..32;
    let mut state = run.save_state();
    state[counts.clone()].fill(0xff);
    for _ in 0..2 {
        run.restore(&state).expect("a state");
    }
    run.pass(0, &mut film);
    assert!(run.save_state()[counts].iter().all(|byte| *byte == 0xff));
}
