//! Connections: one request each, answered and closed. Clients that are slow, silent or hostile cost a bounded number of threads for a
//! bounded time.

use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::time::{Duration, Instant};

use super::request::{self, Refusal, Request};

/// Most connections at a time; others are closed at once. A browser opens six, and may keep some silent.
const MOST: usize = 64;
/// How long a client may take to send its request.
const PATIENCE: Duration = Duration::from_secs(5);
/// How long a client may take to receive an answer: 100 MB at 3 MB/s.
const LONGEST: Duration = Duration::from_secs(30);

/// An answer.
pub(super) struct Answer {
    /// HTTP status.
    pub(super) status: u16,
    /// Headers beside those that all answers have.
    pub(super) headers: Vec<(&'static str, String)>,
    /// The body.
    pub(super) body: Arc<[u8]>,
}

impl Answer {
    /// A successful answer of a media type.
    pub(super) fn ok(media_type: &str, body: impl Into<Arc<[u8]>>) -> Self {
        let body = body.into();
        Answer { status: 200, headers: vec![("Content-Type", media_type.into())], body }
    }

    /// An answer that says why there is no other.
    pub(super) fn refusal((status, reason): Refusal) -> Self {
        let body = format!("{reason}\n").into_bytes();
        Answer { status, ..Answer::ok("text/plain; charset=utf-8", body) }
    }

    /// The status line and the headers.
    fn head(&self) -> String {
        let name = match self.status {
            200 => "OK",
            403 => "Forbidden",
            404 => "Not Found",
            405 => "Method Not Allowed",
            _ => "Bad Request",
        };
        let mut head = format!("HTTP/1.1 {} {name}\r\n", self.status);
        let length = self.body.len().to_string();
        let common = [
            ("Content-Length", length.as_str()),
            ("Cache-Control", "no-store"),
            ("Connection", "close"),
            ("Cross-Origin-Resource-Policy", "same-origin"),
            ("X-Content-Type-Options", "nosniff"),
            ("Allow", "GET, HEAD"),
        ];
        let own = self.headers.iter().map(|(name, value)| (*name, value.as_str()));
        for (name, value) in own.chain(common) {
            head += &format!("{name}: {value}\r\n");
        }
        head + "\r\n"
    }
}

/// Counts open connections.
#[derive(Default)]
pub(super) struct Connections(Arc<AtomicUsize>);

/// An open connection, counted until it is dropped.
struct Open(Arc<AtomicUsize>);

impl Drop for Open {
    fn drop(&mut self) {
        self.0.fetch_sub(1, SeqCst);
    }
}

impl Connections {
    /// Answer a client in a thread of its own, unless there are too many.
    pub(super) fn answer(
        &self,
        stream: TcpStream,
        own_name: Arc<str>,
        answer: impl Fn(&Request) -> Answer + Send + 'static,
    ) {
        let before = self.0.fetch_add(1, SeqCst);
        let open = Open(self.0.clone());
        if before >= MOST {
            return;
        }
        // If there is no thread for it, the client is left without an answer.
        let _ = std::thread::Builder::new().name("live page".into()).spawn(move || {
            let _open = open;
            // A client that has gone away needs no answer.
            let _ = serve(stream, &own_name, answer);
        });
    }
}

/// Read a request and write the answer.
fn serve(
    mut stream: TcpStream,
    own_name: &str,
    answer: impl Fn(&Request) -> Answer,
) -> std::io::Result<()> {
    let Some(head) = read_head(&mut stream)? else { return Ok(()) };
    let request = request::parse(&head, own_name);
    let answer = match &request {
        Ok(request) => answer(request),
        Err(refusal) => Answer::refusal(*refusal),
    };
    let is_head = request.is_ok_and(|request| request.is_head);
    let end = Instant::now() + LONGEST;
    // Else the body would wait until the head has been acknowledged.
    stream.set_nodelay(true)?;
    write_until(&mut stream, answer.head().as_bytes(), end)?;
    if !is_head {
        write_until(&mut stream, &answer.body, end)?;
    }
    stream.shutdown(Shutdown::Write)
}

/// The head of a request; what does not end in time or is too long is cut off, and no request. None if nothing came.
fn read_head(stream: &mut TcpStream) -> std::io::Result<Option<Vec<u8>>> {
    let end = Instant::now() + PATIENCE;
    let (mut bytes, mut piece) = (Vec::new(), [0; 1024]);
    while bytes.len() < request::LARGEST {
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            break;
        }
        stream.set_read_timeout(Some(left))?;
        let count = match stream.read(&mut piece) {
            Ok(count) => count,
            Err(e) if e.kind() == ErrorKind::Interrupted => continue,
            Err(_) => break,
        };
        if count == 0 {
            break;
        }
        bytes.extend_from_slice(&piece[..count]);
        if let Some(length) = request::head(&bytes) {
            bytes.truncate(length);
            return Ok(Some(bytes));
        }
    }
    // The start of a request is not taken for a whole one.
    Ok((!bytes.is_empty()).then(Vec::new))
}

/// Write all bytes, unless that takes until `end`.
fn write_until(stream: &mut TcpStream, mut bytes: &[u8], end: Instant) -> std::io::Result<()> {
    while !bytes.is_empty() {
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(ErrorKind::TimedOut.into());
        }
        stream.set_write_timeout(Some(left))?;
        match stream.write(&bytes[..bytes.len().min(1 << 16)]) {
            Ok(0) => return Err(ErrorKind::WriteZero.into()),
            Ok(count) => bytes = &bytes[count..],
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(())
}
