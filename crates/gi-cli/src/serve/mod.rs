//! The live page of a run (`--serve`): a small HTTP server with the picture so far and how far the run is.
//!
//! | path | answer |
//! |---|---|
//! | `/` | the page; it uses the viewer of `gi-page` |
//! | `/state.json` | program, scene, size, phase, passes, times; of the last picture its passes, error, the technique's numbers, and the list of layers, each with a version that changes with its pixels |
//! | `/layers/NAME` | a layer: half floats, little-endian, channel by channel in row order; the header `X-Scale` says what to multiply them by, `X-Version` which version they are |
//!
//! Pictures are copied for the page only while somebody asks, between two passes and at most as often as a preview: see
//! [`crate::preview`].

mod address;
mod connection;
mod live;
mod picture;
mod request;

use std::net::TcpListener;
use std::sync::Arc;
use std::time::{Duration, Instant};

use gi_core::image_io::Layers;
use serde_json::{Map, Value, json};

use crate::Failure;
use crate::record::SoFar;
use crate::say::say;
use connection::{Answer, Connections};
use live::Live;
use request::Request;

pub use address::Address;
pub(crate) use live::Stage;

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: [&str; 2] = [include_str!("layers.js"), include_str!("page.js")];
/// How long a finished run waits until a page that is open knows of its end: the page asks every second.
const FAREWELL: Duration = Duration::from_secs(3);
/// How long a page may take to ask for a layer after it was told of the end.
const QUIET: Duration = Duration::from_millis(300);

/// A live page. It is served until the process ends.
#[derive(Clone)]
pub(crate) struct Page {
    live: Arc<Live>,
}

impl Page {
    /// Serve the page of a run that begins now.
    pub(crate) fn open(
        address: &Address,
        program: &str,
        scene: &str,
        quiet: bool,
    ) -> Result<Self, Failure> {
        let (listener, own) = address.listen().map_err(|e| {
            let advice = "choose another port, or 0 for any that is free";
            Failure::Input(format!("error: --serve {address}: {e}; {advice}"))
        })?;
        let live = Arc::new(Live::new(program, scene));
        let server = Server {
            live: live.clone(),
            page: page().map_err(|name| Failure::Other(format!("--serve: no part {name}")))?,
        };
        let own_name = Arc::from(own.host());
        let listen = move || server.listen(&listener, &own_name);
        std::thread::Builder::new()
            .name("live page".into())
            .spawn(listen)
            .map_err(|e| Failure::Other(format!("--serve: {e}")))?;
        if !quiet {
            say(format!("live page: http://{own}/"));
        }
        Ok(Page { live })
    }

    /// Say what the run does from now on.
    pub(crate) fn enter(&self, stage: Stage) {
        self.live.enter(stage);
    }

    /// Say how large the picture is.
    pub(crate) fn set_size(&self, size: [usize; 2]) {
        self.live.set_size(size);
    }

    /// If somebody watches: the time that was spent on answers since this was asked last.
    pub(crate) fn watched(&self) -> Option<Duration> {
        self.live.watched()
    }

    /// Show this picture from now on.
    pub(crate) fn show(&self, layers: Layers, so_far: &SoFar) {
        self.live.show(layers, so_far);
    }

    /// Say how the run has ended. If somebody watches, wait a moment until the page has heard it and has the last picture.
    pub(crate) fn end(&self, outcome: String) {
        let is_watched = self.live.watched().is_some();
        self.live.enter(Stage::Ended(outcome));
        let clock = Instant::now();
        while is_watched && !self.live.is_left(QUIET) && clock.elapsed() < FAREWELL {
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

/// Answers clients.
#[derive(Clone)]
struct Server {
    live: Arc<Live>,
    page: Arc<[u8]>,
}

impl Server {
    /// Answer clients for ever.
    fn listen(&self, listener: &TcpListener, own_name: &Arc<str>) {
        let connections = Connections::default();
        for stream in listener.incoming() {
            match stream {
                Ok(stream) => {
                    let server = self.clone();
                    connections.answer(stream, own_name.clone(), move |asked| server.answer(asked));
                }
                // No more open files, say: that passes.
                Err(_) => std::thread::sleep(Duration::from_millis(50)),
            }
        }
    }

    fn answer(&self, request: &Request) -> Answer {
        let none = Answer::refusal((404, "there is no such page"));
        match request.path.as_str() {
            "/" => {
                let mut answer = Answer::ok("text/html; charset=utf-8", self.page.clone());
                answer.headers.push(("Referrer-Policy", "no-referrer".into()));
                answer
            }
            "/state.json" => {
                Answer::ok("application/json", self.live.state().to_string().into_bytes())
            }
            path => {
                let layer = path.strip_prefix("/layers/").and_then(|name| self.live.layer(name));
                let Some(layer) = layer else { return none };
                let mut answer = Answer::ok("application/octet-stream", layer.bytes);
                answer.headers.push(("X-Scale", format!("{:e}", layer.scale)));
                answer.headers.push(("X-Version", layer.version.to_string()));
                answer
            }
        }
    }
}

/// The page, or the name of a part that its template lacks.
fn page() -> Result<Arc<[u8]>, String> {
    let maps: Map<String, Value> =
        gi_page::maps().into_iter().map(|(name, map)| (name.into(), map.into())).collect();
    let script = format!("\"use strict\";\n{}{}", gi_page::SCRIPT.concat(), SCRIPT.concat());
    let viewer = gi_page::fill(gi_page::VIEWER, &[("state", "Waiting for the run")])?;
    let parts = [
        ("style", format!("{}{STYLE}", gi_page::STYLE)),
        ("viewer", viewer),
        ("data", json!({ "maps": maps }).to_string()),
        ("script", script),
    ];
    let parts = parts.each_ref().map(|(name, text)| (*name, text.as_str()));
    Ok(gi_page::fill(PAGE, &parts)?.into_bytes().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_has_all_its_parts_and_nothing_else_is_answered() {
        let server = Server {
            live: Arc::new(Live::new("pathtrace", "<scene>")),
            page: page().expect("a page"),
        };
        let get = |path: &str| server.answer(&Request { is_head: false, path: path.into() });
        let text = String::from_utf8(get("/").body.to_vec()).expect("UTF-8");
        assert!(!text.contains("{{") && text.contains("function showViewer"), "{text}");
        assert_eq!(get("/state.json").status, 200);
        for path in ["/index.html", "/layers/", "/layers/Picture", "/../x", "/state.json/", ""] {
            assert_eq!(get(path).status, 404, "{path}");
        }
    }
}
