//! Runs whose live page is served, and a client of it.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use gi_tests::program::{Folder, scene};
use serde_json::Value;

use crate::running::{Program, Running};

/// A run whose page is served.
pub(crate) struct Served {
    pub(crate) run: Running,
    /// HOST:PORT of the page.
    pub(crate) address: String,
}

/// An answer.
pub(crate) struct Answer {
    pub(crate) status: u16,
    pub(crate) head: String,
    pub(crate) body: Vec<u8>,
}

impl Answer {
    /// The value of a header.
    pub(crate) fn header(&self, name: &str) -> Option<&str> {
        self.head.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(": "))
    }
}

impl Served {
    /// Start a program that makes a small picture `out.exr` in the folder.
    pub(crate) fn start(program: &Program, folder: &Folder, flags: &[&str]) -> Self {
        let (scene, out) = (scene("cornell-box"), folder.at("out.exr"));
        let common = [scene.as_str(), "-o", &out, "--size", "40x30", "--serve", "0"];
        let mut run = Running::start(program.name, &[&common, program.flags, flags].concat());
        run.wait_for("live page: ");
        let url = run.said().lines().find_map(|line| line.strip_prefix("live page: http://"));
        let address = url.expect("a URL").trim_end_matches('/').to_string();
        Served { run, address }
    }

    pub(crate) fn url(&self) -> String {
        format!("http://{}/", self.address)
    }

    /// Send bytes; returns what comes back until the server closes the connection.
    pub(crate) fn send(&self, bytes: &[u8]) -> std::io::Result<Vec<u8>> {
        let mut stream = TcpStream::connect(&self.address)?;
        stream.set_read_timeout(Some(Duration::from_secs(60)))?;
        stream.write_all(bytes)?;
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer)?;
        Ok(answer)
    }

    /// Ask with this method and Host. None if there is no answer.
    pub(crate) fn ask(&self, method: &str, path: &str, host: &str) -> Option<Answer> {
        let request = format!("{method} {path} HTTP/1.1\r\nHost: {host}\r\nAccept: */*\r\n\r\n");
        let bytes = self.send(request.as_bytes()).ok()?;
        let end = bytes.windows(4).position(|end| end == b"\r\n\r\n")?;
        let head = String::from_utf8(bytes[..end].to_vec()).expect("UTF-8");
        let status = head.split(' ').nth(1).and_then(|s| s.parse().ok()).expect("a status");
        let answer = Answer { status, head, body: bytes[end + 4..].to_vec() };
        let length = answer.header("Content-Length").and_then(|n| n.parse().ok());
        assert!(method == "HEAD" || length == Some(answer.body.len()), "{}", answer.head);
        Some(answer)
    }

    pub(crate) fn get(&self, path: &str) -> Option<Answer> {
        self.ask("GET", path, &self.address)
    }

    /// How far the run is.
    #[track_caller]
    pub(crate) fn state(&self) -> Value {
        let answer = self.get("/state.json").expect("it listens");
        assert_eq!(answer.status, 200, "{}", answer.head);
        serde_json::from_slice(&answer.body).expect("JSON")
    }

    /// A layer's numbers, and how large the rounding errors of small ones may be.
    pub(crate) fn layer(&self, name: &str) -> (Vec<f64>, f64) {
        let answer = self.get(&format!("/layers/{name}")).expect("it listens");
        assert_eq!(answer.status, 200, "{name}");
        let scale: f64 = answer.header("X-Scale").and_then(|s| s.parse().ok()).expect("a scale");
        let halves = answer.body.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]]));
        (halves.map(|half| number(half) * scale).collect(), scale * 2f64.powi(-25))
    }
}

/// The number that a half float stands for.
fn number(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    let size = match exponent {
        0 => fraction * 2f64.powi(-24),
        31 => f64::INFINITY,
        _ => (1.0 + fraction / 1024.0) * 2f64.powi(exponent - 15),
    };
    if bits >> 15 == 1 { -size } else { size }
}
