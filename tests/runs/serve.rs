//! The server of the live page: what it tells of a run, and what it makes of hostile clients.

use std::io::Write;
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::time::Duration;

use gi_core::image_io::Layers;
use gi_tests::program::{Folder, scene};
use serde_json::Value;

use crate::running::{PROGRAMS, Running, picture, says, wait_until};
use crate::served::Served;

/// Check that all layers that a state lists are those of a file, to the last bit of a half float.
fn assert_layers(served: &Served, state: &Value, file: &Layers) {
    let layers = state["picture"]["layers"].as_array().expect("layers");
    for layer in layers {
        let name = layer["name"].as_str().expect("a name");
        let (numbers, smallest) = served.layer(name);
        let channels = layer["channels"].as_array().expect("channels");
        for (k, channel) in channels.iter().enumerate() {
            let channel = channel.as_str().expect("a name");
            let full = if ["Picture", "Z"].contains(&name) {
                channel.to_string()
            } else {
                format!("{name}.{channel}")
            };
            let right = file.channel(&full).unwrap_or_else(|| panic!("no layer {full}"));
            for (shown, right) in numbers[k * right.len()..].iter().zip(right) {
                let right = f64::from(*right);
                let error = (shown - right).abs();
                assert!(error <= right.abs() / 2048.0 + smallest, "{full}: {shown}, not {right}");
            }
        }
        assert_eq!(numbers.len(), channels.len() * file.width * file.height, "{name}");
    }
    let names: Vec<&Value> = layers.iter().map(|layer| &layer["name"]).collect();
    for name in ["Picture", "Variance", "Direct", "Indirect", "Albedo", "N", "Z"] {
        assert!(names.iter().any(|n| *n == name), "{name}: {names:?}");
    }
}

#[test]
fn every_program_serves_its_progress_and_in_the_end_the_picture_that_it_has_written() {
    for program in &PROGRAMS {
        let folder = Folder::make();
        let stats = folder.at("stats.json");
        let served = Served::start(program, &folder, &["--time", "3s", "--stats", &stats]);
        let mut versions = Vec::new();
        let state = loop {
            let state = served.state();
            assert_eq!(state["program"], program.name);
            if state["phase"] == "passes" {
                let fraction = state["fraction"].as_f64().expect("a number");
                assert!((0.0..=1.0).contains(&fraction), "{state}");
                assert!(state["remaining"].as_f64().is_some_and(|s| s <= 3.0), "{state}");
                assert_eq!(state["size"], serde_json::json!([40, 30]));
            }
            versions.extend(state["picture"]["layers"][0]["version"].as_u64());
            if state["phase"] == "ended" {
                break state;
            }
            std::thread::sleep(Duration::from_millis(20));
        };
        assert_eq!(state["outcome"], "finished");
        assert!(versions.is_sorted() && versions.last() > versions.first(), "{versions:?}");
        let file = picture(&folder, "out.exr");
        assert_layers(&served, &state, &file);
        let passes = says(&file, "gi.passes").and_then(|n| n.parse::<u64>().ok());
        assert_eq!(state["picture"]["passes"].as_u64(), passes);
        let stats: Value =
            serde_json::from_slice(&std::fs::read(&stats).expect("statistics")).expect("JSON");
        let technique = state["picture"]["technique"].as_array().expect("numbers");
        let recorded = stats["technique"].as_object().expect("numbers");
        assert_eq!(technique.len(), recorded.len());
        for entry in technique {
            assert_eq!(entry[1], recorded[entry[0].as_str().expect("a name")], "{entry}");
        }
        assert_eq!(served.run.end().0, Some(0));
    }
}

#[test]
fn a_page_does_not_change_a_bit_of_the_picture_and_is_only_made_while_somebody_asks() {
    let folders = [Folder::make(), Folder::make()];
    let start = |folder, spp| Served::start(&PROGRAMS[0], folder, &["--spp", spp]);
    let watched = start(&folders[0], "600");
    while watched.state()["phase"] != "ended" {}
    assert!(watched.state()["picture"]["layers"][0]["version"].as_u64() > Some(1));
    assert_eq!(watched.run.end().0, Some(0));
    let alone = start(&folders[1], "600");
    assert_eq!(alone.run.end().0, Some(0));
    let [a, b] = folders.each_ref().map(|folder| picture(folder, "out.exr"));
    for ((name, one), (_, other)) in a.channels.iter().zip(&b.channels) {
        assert!(one.iter().zip(other).all(|(x, y)| x.to_bits() == y.to_bits()), "{name}");
    }
    assert_eq!(a.channels.len(), b.channels.len());
    // The first who asks finds no picture, however long the run has been going on.
    let lonely = start(&folders[1], "100000000");
    std::thread::sleep(Duration::from_secs(2));
    let state = lonely.state();
    assert!(state["pass"].as_u64() > Some(1) && state["picture"].is_null(), "{state}");
    wait_until("there is a picture", || !lonely.state()["picture"].is_null());
    lonely.run.signal("TERM");
    wait_until("it has ended", || lonely.state()["phase"] == "ended");
    assert_eq!(lonely.state()["outcome"], "stopped by SIGTERM");
    assert_eq!(lonely.run.end().0, Some(143));
}

#[test]
fn preparation_is_shown_step_by_step() {
    let program = PROGRAMS.iter().find(|p| p.name == "photonmap").expect("it is there");
    let folder = Folder::make();
    let served = Served::start(program, &folder, program.long_preparation);
    wait_until("photons are counted", || {
        let state = served.state();
        state["phase"] == "preparing"
            && state["step"]["done"].as_u64() > Some(0)
            && state["step"]["done"].as_u64() <= state["step"]["total"].as_u64()
    });
    assert!(served.state()["picture"].is_null());
    served.run.signal("TERM");
    assert_eq!(served.run.end().0, Some(143));
}

#[test]
fn foreign_hosts_other_methods_and_unknown_paths_are_refused() {
    let folder = Folder::make();
    let served = Served::start(&PROGRAMS[0], &folder, &["--spp", "100000000"]);
    let status = |method, path, host: &str| served.ask(method, path, host).map(|a| a.status);
    wait_until("there is a picture", || !served.state()["picture"].is_null());
    let port = served.address.rsplit_once(':').expect("a port").1;
    for path in ["/", "/state.json", "/layers/Picture"] {
        assert_eq!(status("GET", path, &format!("localhost:{port}")), Some(200), "{path}");
        for foreign in ["evil.example", &format!("evil.example:{port}"), "127.0.0.1.evil.example"] {
            assert_eq!(status("GET", path, foreign), Some(403), "{path} {foreign}");
        }
        assert_eq!(status("POST", path, &served.address), Some(405), "{path}");
    }
    for path in ["/x", "/layers/x", "/layers/../state.json", "//", "/%00"] {
        assert_eq!(status("GET", path, &served.address), Some(404), "{path}");
    }
    // The headers alone, and none that lets another site read.
    let head = served.ask("HEAD", "/layers/Picture", &served.address).expect("an answer");
    assert!(head.status == 200 && head.body.is_empty());
    assert_eq!(head.header("Content-Length"), Some("7200"));
    assert_eq!(head.header("Access-Control-Allow-Origin"), None);
    let page = served.get("/").expect("the page");
    assert!(String::from_utf8(page.body).is_ok_and(|text| text.contains("</html>")));
    served.run.signal("TERM");
    assert_eq!(served.run.end().0, Some(143));
}

#[test]
fn garbage_and_clients_that_say_nothing_do_not_hurt() {
    let folder = Folder::make();
    let served = Served::start(&PROGRAMS[0], &folder, &["--spp", "100000000"]);
    let long = vec![b'a'; 1 << 20];
    let zeros = vec![0; 100];
    let mut random = vec![0u8; 4096];
    let mut bits = 1u32;
    random.iter_mut().for_each(|byte| {
        bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *byte = (bits >> 24) as u8;
    });
    let requests: [&[u8]; 8] = [
        b"\r\n\r\n",
        b"GET\r\n\r\n",
        b"GET / HTTP/1.1\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost\r\nHost: \xff\r\n\r\n",
        b"\x16\x03\x01\x02\x00\x01\r\n\r\n",
        &long,
        &zeros,
        &random,
    ];
    for bytes in requests {
        // A server that closes the connection in the middle of what we send is right, too.
        if let Ok(answer) = served.send(&[bytes, b"\r\n\r\n"].concat()) {
            let text = String::from_utf8_lossy(&answer);
            assert!(text.is_empty() || text.starts_with("HTTP/1.1 400 "), "{text}");
        }
    }
    // Many clients that say nothing take all connections, for a few seconds.
    let silent: Vec<_> = (0..40).map(|_| TcpStream::connect(&served.address)).collect();
    assert!(silent.iter().all(Result::is_ok));
    wait_until("there is a connection again", || {
        served.get("/state.json").is_some_and(|a| a.status == 200)
    });
    drop(silent);
    // One that leaves after the request.
    for _ in 0..100 {
        let mut stream = TcpStream::connect(&served.address).expect("it listens");
        let _ = stream.write_all(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
    }
    wait_until("it answers", || served.get("/state.json").is_some());
    served.run.signal("TERM");
    let (code, said) = served.run.end();
    assert_eq!(code, Some(143), "{said}");
    assert!(Path::new(&folder.at("out.exr")).exists(), "{said}");
}

#[test]
fn an_address_that_is_taken_or_wrong_is_refused_before_any_work() {
    let holder = TcpListener::bind("127.0.0.1:0").expect("a port");
    let taken = holder.local_addr().expect("an address").to_string();
    let folder = Folder::make();
    for (address, words) in [(taken.as_str(), "--serve 127.0.0.1:"), ("0x1f", "HOST:PORT")] {
        // The scene is not even read.
        let (scene, out) = (scene("cornell-box"), folder.at("out.exr"));
        let (code, said) =
            Running::start("pathtrace", &[&scene, "-o", &out, "--serve", address]).end();
        assert_eq!(code, Some(2), "{said}");
        assert!(said.contains(words) && !said.contains("primitives"), "{said}");
    }
    assert_eq!(folder.files(), [""; 0]);
}
