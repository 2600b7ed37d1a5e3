//! Previews: the current picture is written during the run.

use std::io::Read;
use std::net::TcpListener;
use std::path::Path;

use gi_core::image_io::read_exr;
use gi_tests::program::{Folder, scene};

use crate::running::{PROGRAMS, Running, says, wait_until};

#[test]
fn every_program_updates_its_picture_during_the_run_and_it_is_always_complete() {
    for program in &PROGRAMS {
        let folder = Folder::make();
        let (scene, out) = (scene("cornell-box"), folder.at("out.exr"));
        let flags = ["-o", &out, "--size", "32x32", "--spp", "100000000", "--preview", "10ms"];
        let line = [&[scene.as_str()], &flags[..], program.flags].concat();
        let run = Running::start(program.name, &line);
        wait_until("there is a preview", || Path::new(&out).exists());
        // Each preview is complete, and has more passes than the one before.
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
fn a_long_first_pass_is_seen_tile_by_tile() {
    let folder = Folder::make();
    let (scene, out) = (scene("cornell-glossy"), folder.at("out.exr"));
    let flags = ["-o", &out, "--size", "1024x1024", "--spp", "1", "--preview", "10ms"];
    let mut run = Running::start("lightcuts", &[&[scene.as_str()], &flags[..]].concat());
    wait_until("there is a preview", || Path::new(&out).exists());
    let picture = read_exr(Path::new(&out)).expect("a whole EXR");
    assert_eq!(says(&picture, "gi.passes"), Some("0"));
    // Some tiles are finished, others are not.
    let red = picture.channel("R").expect("red");
    assert!(red.iter().any(|v| *v > 0.0) && red.contains(&0.0));
    // The first signal finishes the pass, the second one abandons it. The preview stays.
    run.signal("INT");
    run.wait_for("finishing this pass");
    run.signal("INT");
    let (code, said) = run.end();
    assert_eq!(code, Some(130));
    assert!(said.contains("before there was a whole picture"), "{said}");
    assert_eq!(folder.files(), ["out.exr", "out.png"]);
}

#[test]
fn without_previews_no_picture_is_written_during_the_run() {
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

/// The image of a picture in a viewer with tev's protocol.
#[derive(Default)]
struct Viewer {
    size: [usize; 2],
    names: Vec<String>,
    channels: Vec<Vec<f32>>,
    updates: usize,
}

/// Reads a packet field by field.
struct Packet<'a>(&'a [u8]);

impl Packet<'_> {
    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let (bytes, rest) = self.0.split_first_chunk().expect("a longer packet");
        self.0 = rest;
        *bytes
    }

    fn number(&mut self) -> usize {
        u32::from_le_bytes(self.bytes()) as usize
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|b| *b == 0).expect("an end");
        let text = String::from_utf8(self.0[..end].to_vec()).expect("UTF-8");
        self.0 = &self.0[end + 1..];
        text
    }
}

impl Viewer {
    /// Process a packet: create an image (4) or update it (6).
    fn take(&mut self, packet: &[u8]) {
        let mut p = Packet(packet);
        let ([kind], [_focus], name) = (p.bytes(), p.bytes(), p.text());
        assert!(name.ends_with("out.exr"), "{name}");
        if kind == 4 {
            self.size = [p.number(), p.number()];
            self.names = (0..p.number()).map(|_| p.text()).collect();
            self.channels = vec![vec![f32::NAN; self.size[0] * self.size[1]]; self.names.len()];
            return;
        }
        assert_eq!(kind, 6);
        let count = p.number();
        let names: Vec<String> = (0..count).map(|_| p.text()).collect();
        assert_eq!(names, self.names);
        let [x, y, w, h] = [p.number(), p.number(), p.number(), p.number()];
        let mut wide = || u64::from_le_bytes(p.bytes()) as usize;
        let offsets: Vec<usize> = (0..count).map(|_| wide()).collect();
        let strides: Vec<usize> = (0..count).map(|_| wide()).collect();
        let floats = p.0.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let data: Vec<f32> = floats.collect();
        for (k, channel) in self.channels.iter_mut().enumerate() {
            for i in 0..w * h {
                let at = (y + i / w) * self.size[0] + x + i % w;
                channel[at] = data[offsets[k] + i * strides[k]];
            }
        }
        self.updates += 1;
    }
}

#[test]
fn a_viewer_gets_all_layers_while_they_converge_and_the_finished_ones_at_the_end() {
    for program in &PROGRAMS {
        let server = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = server.local_addr().expect("an address").to_string();
        let viewer = std::thread::spawn(move || {
            let (mut socket, _) = server.accept().expect("a program");
            let mut viewer = Viewer::default();
            let mut length = [0; 4];
            while socket.read_exact(&mut length).is_ok() {
                let mut packet = vec![0; u32::from_le_bytes(length) as usize - 4];
                socket.read_exact(&mut packet).expect("the whole packet");
                viewer.take(&packet);
            }
            viewer
        });
        let folder = Folder::make();
        let (scene, out) = (scene("cornell-box"), folder.at("out.exr"));
        let flags = ["-o", &out, "--size", "140x33", "--time", "2s", "--display-server", &address];
        let line = [&[scene.as_str()], &flags[..], program.flags].concat();
        let (code, said) = Running::start(program.name, &line).end();
        assert_eq!(code, Some(0), "{said}");
        let viewer = viewer.join().expect("a viewer");
        // There are two tiles, and more updates than those of the finished picture.
        assert!(viewer.updates > 2, "{}: {} updates", program.name, viewer.updates);
        let picture = read_exr(Path::new(&out)).expect("an EXR");
        for (name, values) in &viewer.names.iter().zip(&viewer.channels).collect::<Vec<_>>() {
            assert_eq!(picture.channel(name), Some(values.as_slice()), "{name}");
        }
        assert!(viewer.names.iter().any(|name| name == "Variance.G"));
    }
}

#[test]
fn a_run_continues_if_the_viewer_disconnects_and_does_not_start_without_one() {
    let server = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = server.local_addr().expect("an address").to_string();
    let gone = std::thread::spawn(move || drop(server.accept()));
    let folder = Folder::make();
    let (scene, out) = (scene("cornell-box"), folder.at("out.exr"));
    let flags = ["--size", "140x33", "--time", "2s", "--display-server", &address];
    let line = [&[scene.as_str(), "-o", &out], &flags[..]].concat();
    let (code, said) = Running::start("pathtrace", &line).end();
    gone.join().expect("it came and went");
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("no live view"), "{said}");
    let (code, said) = Running::start("pathtrace", &line).end();
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("--display-server") && said.contains(&address), "{said}");
}
