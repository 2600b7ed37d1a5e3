//! Previews: the picture so far, during the run.

use std::path::Path;

use gi_core::image_io::read_exr;
use gi_tests::program::{Folder, scene};

use crate::running::{PROGRAMS, Running, says, wait_until};

#[test]
fn every_program_rewrites_its_picture_during_the_run_and_always_whole() {
    for program in &PROGRAMS {
        let folder = Folder::make();
        let (scene, out) = (scene("cornell-box"), folder.at("out.exr"));
        let flags = ["-o", &out, "--size", "32x32", "--spp", "100000000", "--preview", "10ms"];
        let line = [&[scene.as_str()], &flags[..], program.flags].concat();
        let run = Running::start(program.name, &line);
        wait_until("there is a preview", || Path::new(&out).exists());
        // Each of them can be read whole, and has more passes than the one before.
        let passes = || -> u64 {
            let picture = read_exr(Path::new(&out)).expect("a whole EXR");
            assert!(says(&picture, "gi.stopped").is_none());
            says(&picture, "gi.passes").and_then(|n| n.parse().ok()).expect("passes")
        };
        let first = passes();
        wait_until("there is another preview", || passes() > first);
        assert!(Path::new(&folder.at("out.png")).exists(), "{}", program.name);
        run.signal("TERM");
        assert_eq!(run.end().0, Some(143));
    }
}

#[test]
fn nothing_is_written_during_the_run_where_nobody_watches() {
    let folder = Folder::make();
    let (scene, out, keep) = (scene("cornell-box"), folder.at("out.exr"), folder.at("kept"));
    let flags = ["--size", "32x32", "--spp", "100000000", "--checkpoint-interval", "100ms"];
    let line = [&[scene.as_str(), "-o", &out, "--checkpoint", &keep], &flags[..]].concat();
    let run = Running::start("pathtrace", &line);
    wait_until("there is a checkpoint", || Path::new(&keep).exists());
    std::thread::sleep(std::time::Duration::from_secs(1));
    assert_eq!(folder.files(), ["kept"]);
    run.signal("TERM");
    assert_eq!(run.end().0, Some(143));
}
