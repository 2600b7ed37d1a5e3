//! Faults around a run: everything that can still be saved must be saved.

use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};

use gi_tests::program::{Folder, assert_refused, assert_success, run, said, scene};

use crate::running::{PROGRAMS, Running, path_of, picture, says, shell, wait_until};

#[test]
fn a_checkpoint_that_cannot_be_written_is_reported_and_tried_again() {
    let folder = Folder::make();
    let (scene, out) = (scene("cornell-box"), folder.at("out.exr"));
    let (home, away) = (folder.at("home"), folder.at("away"));
    std::fs::create_dir(&home).expect("a folder");
    let kept = folder.at("home/kept");
    let flags = ["--size", "32x32", "--spp", "100000000", "--checkpoint-interval", "200ms"];
    let line = [&[scene.as_str(), "-o", &out, "--checkpoint", &kept], &flags[..]].concat();
    let mut run = Running::start("pathtrace", &line);
    wait_until("there is a checkpoint", || Path::new(&kept).exists());
    std::fs::rename(&home, &away).expect("moved");
    run.wait_for("the run goes on, and tries again");
    std::fs::remove_file(folder.at("away/kept")).expect("removed");
    std::fs::rename(&away, &home).expect("moved back");
    wait_until("there is a checkpoint again", || Path::new(&kept).exists());
    run.signal("TERM");
    let (code, said) = run.end();
    assert_eq!(code, Some(143), "{said}");
    assert!(said.contains("cannot write") && said.contains("home/kept"), "{said}");
}

#[test]
fn the_picture_is_saved_where_the_last_checkpoint_cannot_be_written() {
    let folder = Folder::make();
    let (scene, out, home) = (scene("cornell-box"), folder.at("out.exr"), folder.at("home"));
    std::fs::create_dir(&home).expect("a folder");
    let kept = folder.at("home/kept");
    let flags = ["--size", "16x16", "--time", "2s", "--checkpoint-interval", "1h"];
    let line = [&[scene.as_str(), "-o", &out, "--checkpoint", &kept], &flags[..]].concat();
    let run = Running::start("pathtrace", &line);
    wait_until("there is a checkpoint", || Path::new(&kept).exists());
    std::fs::remove_dir_all(&home).expect("removed");
    let (code, said) = run.end();
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("error: cannot write") && said.contains("home/kept"), "{said}");
    assert_eq!(folder.files(), ["out.exr", "out.png"]);
}

#[test]
fn a_checkpoint_with_a_changed_bit_is_refused() {
    let folder = Folder::make();
    let (scene, out, kept) = (scene("cornell-box"), folder.at("out.exr"), folder.at("kept"));
    let run = |more: &[&str]| {
        let flags = ["-o", &out, "--size", "8x8", "--spp", "2", "--checkpoint", &kept];
        let line = [&[scene.as_str()], &flags[..], more].concat();
        Command::new(path_of("pathtrace")).args(&line).output().expect("it runs")
    };
    assert!(run(&[]).status.success());
    let whole = std::fs::read(&kept).expect("a checkpoint");
    let bits = 8 * whole.len();
    for bit in (0..bits).step_by(bits / 60) {
        let mut changed = whole.clone();
        changed[bit / 8] ^= 1 << (bit % 8);
        std::fs::write(&kept, &changed).expect("written");
        let output = run(&["--resume"]);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(2), "bit {bit}: {text}");
        assert!(text.contains("damaged") || text.contains("no checkpoint"), "bit {bit}: {text}");
    }
    std::fs::write(&kept, &whole).expect("written");
    assert!(run(&["--resume"]).status.success());
}

/// A folder in which nobody can make a file, not even the system's administrator (tests may run as such).
fn read_only(folder: &Folder) -> String {
    use std::os::unix::fs::PermissionsExt;
    let path = folder.at("read-only");
    std::fs::create_dir(&path).expect("a folder");
    std::fs::set_permissions(&path, PermissionsExt::from_mode(0o555)).expect("its owner's right");
    let is_writable = std::fs::write(format!("{path}/trial"), "").is_ok();
    if is_writable { "/proc".to_string() } else { path }
}

#[test]
fn a_folder_where_no_file_can_be_made_is_reported_before_the_run() {
    for program in &PROGRAMS {
        let folder = Folder::make();
        let (scene, home) = (scene("cornell-box"), read_only(&folder));
        let (out, away) = (folder.at("out.exr"), format!("{home}/out.exr"));
        let stats = format!("{home}/stats.json");
        // Far too long to be rendered: the check stands before the work.
        let long = ["--size", "512x512", "--spp", "1000000"];
        for files in [&["-o", &away][..], &["-o", &out, "--stats", &stats]] {
            let line = [&[scene.as_str()], files, &long[..], program.flags].concat();
            let output = Command::new(path_of(program.name)).args(&line).output();
            let output = output.expect("it runs");
            let text = said(&output);
            assert_eq!(output.status.code(), Some(1), "{}: {text}", program.name);
            assert!(text.contains(&format!("cannot write {home}/")), "{text}");
            assert!(!Path::new(&out).exists());
        }
    }
}

/// A limit on file sizes simulates a full disk: a write fails half-way.
#[test]
fn a_picture_too_large_for_the_disk_is_not_half_written_and_other_files_are_kept() {
    for program in &PROGRAMS {
        let folder = Folder::make();
        let (scene, out, stats) = (scene("cornell-box"), folder.at("out.exr"), folder.at("s.json"));
        let flags = ["-o", &out, "--stats", &stats, "--size", "64x64", "--spp", "1"];
        let line = [&[scene.as_str()], &flags[..], program.flags].concat();
        let output = shell("ulimit -f 40", program.name, &line).output().expect("it runs");
        let text = said(&output);
        assert_eq!(output.status.code(), Some(1), "{}: {text}", program.name);
        assert!(text.contains("cannot write") && text.contains("out.exr"), "{text}");
        assert!(!text.contains(".part"), "a temporary name: {text}");
        assert_eq!(folder.files(), ["out.png", "s.json"], "{}", program.name);
    }
}

#[test]
fn closed_message_streams_do_not_end_a_run() {
    for program in &PROGRAMS {
        let folder = Folder::make();
        let (scene, stats) = (scene("cornell-box"), folder.at("run.json"));
        for (name, stderr) in [("full", full()), ("closed", closed())] {
            let out = folder.at(&format!("{name}.exr"));
            let flags = ["-o", &out, "--stats", &stats, "--size", "16x16", "--spp", "2"];
            let mut command = Command::new(path_of(program.name));
            command
                .arg(&scene)
                .args(flags)
                .args(program.flags)
                .stdout(Stdio::null())
                .stderr(stderr);
            let status = command.status().expect("it runs");
            assert_eq!(status.code(), Some(0), "{} {name}", program.name);
            assert_eq!(says(&picture(&folder, &format!("{name}.exr")), "gi.passes"), Some("2"));
        }
        assert!(Path::new(&stats).exists());
    }
}

#[test]
fn errors_keep_their_exit_status_if_standard_error_is_closed() {
    for program in PROGRAMS.iter().map(|p| p.name).chain(["compare"]) {
        for flags in [&["no-such.xml"][..], &["--no-such-flag"], &["scene.txt", "-o", "a.exr"]] {
            for stderr in [full(), closed()] {
                let mut command = Command::new(path_of(program));
                let status = command.args(flags).stdout(Stdio::null()).stderr(stderr).status();
                assert_eq!(status.expect("it runs").code(), Some(2), "{program} {flags:?}");
            }
        }
    }
}

#[test]
fn compare_writes_its_page_if_standard_output_is_closed() {
    for (stdout, stderr) in [(full(), full()), (closed(), closed())] {
        let folder = Folder::make();
        let (scene, out) = (scene("cornell-box"), folder.at("out"));
        path_of("pathtrace");
        let flags = ["--techniques", "pathtrace", "--spp", "1", "--size", "16x16", "-o", &out];
        let mut command = Command::new(path_of("compare"));
        let status = command.arg(&scene).args(flags).stdout(stdout).stderr(stderr).status();
        assert_eq!(status.expect("it runs").code(), Some(0));
        assert!(Path::new(&folder.at("out/index.html")).exists());
    }
}

/// An output to a full disk.
fn full() -> Stdio {
    File::options().write(true).open("/dev/full").expect("a device").into()
}

/// A pipe whose reader has exited.
fn closed() -> Stdio {
    let mut gone = Command::new("true");
    let mut child = gone.stdin(Stdio::piped()).spawn().expect("it starts");
    let pipe = child.stdin.take().expect("a pipe");
    child.wait().expect("it ends");
    pipe.into()
}

/// A medium whose density varies, in a program or mode that cannot simulate it.
#[test]
fn a_medium_whose_density_varies_is_refused_by_programs_that_do_not_simulate_it() {
    let folder = Folder::make();
    let scene = folder.at("scene.xml");
    let text = "<scene version='3.0.0'><sensor type='perspective'/><emitter type='constant'/>\
        <medium type='heterogeneous' id='m'/><shape type='sphere'><bsdf type='null'/><ref name='interior' id='m'/></shape></scene>";
    std::fs::write(&scene, text).expect("written");
    let flags = [scene.as_str(), "--size", "8x8", "--spp", "1", "-o", &folder.at("a.exr")]
        .map(String::from);
    let start = |program: &str, mode: &str| {
        let mut line: Vec<&str> = flags.iter().map(String::as_str).collect();
        line.extend(mode.split_whitespace());
        run(path_of(program).to_str().expect("UTF-8"), &line)
    };
    for (program, mode) in [
        ("pathtrace", ""),
        ("pathtrace", "--mode bdpt"),
        ("pathtrace", "--mode vcm"),
        ("irrcache", ""),
        ("radcache", ""),
        ("photonmap", ""),
        ("ppm", ""),
        ("instant-radiosity", ""),
        ("lightcuts", ""),
    ] {
        let says = ["scene.xml", "the density of a medium varies", "pathtrace --mode volpath"];
        assert_refused(&start(program, mode), 2, &says);
    }
    for mode in ["--mode volpath", "--mode light"] {
        assert_success(&start("pathtrace", mode));
    }
}
