//! Files that programs write and read again. Most damaged copies get a new checksum, because all others are refused.

use std::path::Path;

use gi_core::bytes::{Writer, unseal};
use gi_core::film::{Film, Show};
use gi_core::filter::Filter;
use gi_core::technique::Technique;
use gi_tests::World;

use crate::common::Folder;
use crate::harness;

/// A kind of file.
pub(crate) struct Target {
    /// Its extension in `found`.
    pub(crate) name: &'static str,
    world: World,
    folder: Folder,
    /// Write a file.
    write: fn(&World, &Path) -> Vec<u8>,
    /// Make a pass with a file.
    read: fn(&World, &Path) -> Result<(), String>,
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

/// The state of a run with progressive photon mapping, and its film, as in a checkpoint.
fn write_state(world: &World, _: &Path) -> Vec<u8> {
    let (technique, film) = world.run::<ppm::Ppm>(&ppm(), 1, 1, Show::All);
    let mut out = Writer::default();
    out.bytes(&technique.save_state());
    out.bytes(&film.save_state());
    out.seal()
}

fn read_state(world: &World, path: &Path) -> Result<(), String> {
    let bytes = gi_core::files::read(path)?;
    let mut input = gi_core::bytes::Reader::new(unseal(&bytes)?);
    let (mut film, setting) = (film(world), world.setting(1, Show::All));
    let mut technique = <ppm::Ppm as Technique>::prepare(setting, &ppm())?;
    technique.restore(input.bytes()?)?;
    film.restore(input.bytes()?)?;
    technique.pass(1, &mut film);
    film.layers();
    Ok(())
}

/// All kinds of files.
pub(crate) fn all() -> Vec<Target> {
    let target = |name, write, read| {
        // Matt and glossy surfaces, and a caustic.
        let world = World::load("cornell-spheres.xml", [4, 4], &[]);
        Target { name, world, folder: Folder::new(), write, read }
    };
    vec![
        target(
            "irradiance",
            |world, path| {
                let t = pass::<irrcache::IrradianceCaching>(world, &irrcache(path, false));
                t.expect("a cache").export(path)
            },
            |world, path| {
                pass::<irrcache::IrradianceCaching>(world, &irrcache(path, true)).map(drop)
            },
        ),
        target(
            "radiance",
            |world, path| {
                let t = pass::<radcache::RadianceCaching>(world, &radcache(path, false));
                t.expect("a cache").export(path)
            },
            |world, path| pass::<radcache::RadianceCaching>(world, &radcache(path, true)).map(drop),
        ),
        target(
            "photons",
            |world, path| {
                let t = pass::<photonmap::PhotonMapping>(world, &photonmap(path, false));
                t.expect("a map").export(path)
            },
            |world, path| pass::<photonmap::PhotonMapping>(world, &photonmap(path, true)).map(drop),
        ),
        target("checkpoint", write_state, read_state),
    ]
}

impl Target {
    /// Read damaged bytes with a right checksum. Returns whether they are valid.
    pub(crate) fn check(&self, content: &[u8]) -> Result<bool, String> {
        let mut sealed = Writer::default();
        sealed.raw(content);
        let path = self.folder.write("file", sealed.seal());
        Ok((self.read)(&self.world, &path).is_ok())
    }

    fn fuzz(&self) {
        let path = self.folder.path("file");
        let whole = (self.write)(&self.world, &path);
        let content = unseal(&whole).expect("it is whole").to_vec();
        harness::fuzz(self.name, &[content], |bytes| self.check(bytes));
        // Without a right checksum, every damaged file is refused.
        for at in (0..whole.len()).step_by(whole.len() / 50 + 1) {
            let mut damaged = whole.clone();
            damaged[at] ^= 0x04;
            let path = self.folder.write("file", damaged);
            assert!((self.read)(&self.world, &path).is_err(), "{}: byte {at}", self.name);
        }
    }
}

#[test]
fn files_that_programs_read_again() {
    all().iter().for_each(Target::fuzz);
}
