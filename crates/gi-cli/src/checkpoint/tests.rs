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

#[test]
fn damaged_checkpoints_are_refused_or_used() {
    let folder = gi_tests::program::Folder::make();
    let path = folder.path().join("checkpoint");
    let identity = [("program", "test"), ("scene", "7")]
        .map(|(name, value)| (name.to_owned(), value.to_owned()))
        .to_vec();
    let mut film = Film::new([3, 2], Filter::Box, Show::All);
    let mut keeper = Keeper::new(&path, &identity, Duration::ZERO);
    keeper.keep(&Words("some words".into()), &film, &(0..3)).expect("written");
    let whole = std::fs::read(&path).expect("a file");
    let content = unseal(&whole).expect("it is whole").to_vec();
    let mut resume = |bytes: Vec<u8>| {
        Checkpoint::of_bytes(&path, bytes).is_ok_and(|checkpoint| {
            checkpoint.resume(&identity, &[], &mut Words(String::new()), &mut film).is_ok()
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
