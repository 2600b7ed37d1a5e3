use gi_core::film::Show;
use gi_core::filter::Filter;
use gi_core::technique::Setting;

use super::*;

#[path = "../../../gi-scene/tests/fuzz/damage.rs"]
mod damage;
#[path = "../../../gi-scene/tests/fuzz/harness.rs"]
#[allow(clippy::print_stdout)] // only tests print here
mod harness;

/// A technique whose state is a text.
struct Words(String);

impl<'a> Technique<'a> for Words {
    type Params = ();

    fn prepare(_: Setting<'a>, (): &()) -> Result<Self, String> {
        Ok(Words(String::new()))
    }

    fn pass(&mut self, _: u32, _: &mut Film) {}

    fn save_state(&self) -> Vec<u8> {
        self.0.clone().into_bytes()
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        self.0 = String::from_utf8(state.to_vec()).map_err(|e| e.to_string())?;
        Ok(())
    }

    fn reach(&self) -> String {
        String::new()
    }
}

/// The parts of a checkpoint's identity.
fn identity(scene: &str) -> Identity {
    let pairs = [("program", "test"), ("seed", "7"), ("scene", scene)];
    pairs.map(|(name, value)| (name.to_owned(), value.to_owned())).to_vec()
}

/// Write a checkpoint of three passes.
fn write(path: &Path, identity: &Identity) {
    let film = Film::new([3, 2], Filter::Box, Show::All);
    let mut keeper = Keeper::new(path, identity, Duration::ZERO);
    keeper.keep(&Words("some words".into()), &film, &(0..3)).expect("written");
}

#[test]
fn a_look_finds_the_passes_of_whole_files_and_the_cause_of_others() {
    let folder = gi_tests::program::Folder::make();
    let path = folder.path().join("checkpoint");
    // The second head is longer than what is read of it at first.
    for scene in ["a", &"a".repeat(1 << 17)] {
        let identity = identity(scene);
        write(&path, &identity);
        let look = |identity: &Identity| {
            let summary = Checkpoint::look(&path, identity, &[]);
            summary.map(|s| (s.seed, s.passes)).map_err(|failure| failure.text().to_owned())
        };
        assert_eq!(look(&identity), Ok(("7".into(), 0..3)));
        assert!(look(&self::identity("b")).is_err_and(|e| e.contains("another scene")));
        let whole = std::fs::read(&path).expect("a file");
        let refused = |bytes: &[u8], cause: &str| {
            std::fs::write(&path, bytes).expect("written");
            let error = look(&identity).expect_err("it is damaged");
            assert!(error.contains(cause), "{error}");
        };
        // In the name of the scene.
        let mut damaged = whole.clone();
        damaged[99] ^= 1;
        refused(&damaged, "damaged");
        refused(&whole[..whole.len() - 1], "damaged");
        refused(&[&whole[..], &[0]].concat(), "damaged");
        refused(&whole[..9], "no checkpoint");
    }
}

#[test]
fn damaged_checkpoints_are_refused_or_used() {
    let folder = gi_tests::program::Folder::make();
    let path = folder.path().join("checkpoint");
    let identity = identity("a");
    write(&path, &identity);
    let mut film = Film::new([3, 2], Filter::Box, Show::All);
    let whole = std::fs::read(&path).expect("a file");
    let content = unseal(&whole).expect("it is whole").to_vec();
    let mut resume = |bytes: Vec<u8>| {
        Checkpoint::of_bytes(&path, bytes).is_ok_and(|checkpoint| {
            let restore = |state: &[u8]| Words(String::new()).restore(state);
            checkpoint.resume(&identity, &[], &mut film, restore).is_ok()
        })
    };
    for bit in (0..8 * whole.len()).step_by(13) {
        let mut damaged = whole.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert!(!resume(damaged), "bit {bit} does not matter");
    }
    harness::fuzz("checkpoint", &[content], |bytes| {
        // With a right checksum, whatever is in it.
        let mut sealed = Writer::default();
        sealed.raw(bytes);
        Ok(resume(sealed.seal()))
    });
}
