//! Requests: parsed from whatever bytes a client sends.

use std::net::{IpAddr, Ipv6Addr};

/// Largest head of a request, in bytes. Browsers send about 600.
pub(super) const LARGEST: usize = 8 * 1024;

/// A request that is answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Request {
    /// Whether it asks for the headers only.
    pub(super) is_head: bool,
    /// The path without the query, as it was sent: nothing is decoded.
    pub(super) path: String,
}

/// The status and the reason for refusing a request.
pub(super) type Refusal = (u16, &'static str);

/// The length of a request's head, if all of it is there: up to the empty line.
pub(super) fn head(bytes: &[u8]) -> Option<usize> {
    bytes.windows(4).position(|end| end == b"\r\n\r\n").map(|at| at + 4)
}

/// Parse the head of a request to a server that was started under the name `own_name`.
pub(super) fn parse(head: &[u8], own_name: &str) -> Result<Request, Refusal> {
    const BAD: Refusal = (400, "this is no HTTP request");
    let text = std::str::from_utf8(head).map_err(|_| BAD)?;
    let mut lines = text.split("\r\n");
    let mut words = lines.next().unwrap_or_default().split(' ');
    let [Some(method), Some(target), Some(version), None] = [(); 4].map(|()| words.next()) else {
        return Err(BAD);
    };
    if !["HTTP/1.0", "HTTP/1.1"].contains(&version) || !target.starts_with('/') {
        return Err(BAD);
    }
    if !["GET", "HEAD"].contains(&method) {
        return Err((405, "only GET and HEAD are answered"));
    }
    let mut hosts = lines.filter_map(|line| {
        let (name, value) = line.split_once(':')?;
        name.eq_ignore_ascii_case("host").then(|| value.trim())
    });
    let (Some(host), None) = (hosts.next(), hosts.next()) else {
        return Err((400, "a request must have one Host header"));
    };
    if !is_own(host, own_name) {
        return Err((
            403,
            "open the page by the address that the program has printed, or by this machine's IP address",
        ));
    }
    let path = target.split_once('?').map_or(target, |(path, _)| path);
    Ok(Request { is_head: method == "HEAD", path: path.to_string() })
}

/// Whether a Host header names this server: by an IP address, as localhost, or by the name in its address. A page of another site
/// whose name was made to point here (DNS rebinding) sends that name, and is refused.
fn is_own(host: &str, own_name: &str) -> bool {
    if let Some(bracketed) = host.strip_prefix('[') {
        let inner = bracketed.split_once(']').filter(|(_, port)| is_port(port));
        return inner.is_some_and(|(ip, _)| ip.parse::<Ipv6Addr>().is_ok());
    }
    let at = host.find(':').unwrap_or(host.len());
    let (name, port) = host.split_at(at);
    let is_name = name.parse::<IpAddr>().is_ok()
        || name.eq_ignore_ascii_case("localhost")
        || (!name.is_empty() && name.eq_ignore_ascii_case(own_name));
    is_name && is_port(port)
}

/// Whether this is nothing, or a colon and a port.
fn is_port(text: &str) -> bool {
    text.is_empty() || text.strip_prefix(':').is_some_and(|port| port.parse::<u16>().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn get(lines: &str) -> Result<Request, Refusal> {
        parse(format!("{lines}\r\n\r\n").as_bytes(), "render.example")
    }

    fn status(lines: &str) -> u16 {
        get(lines).expect_err("a refusal").0
    }

    #[test]
    fn a_request_has_a_method_and_a_path_without_its_query() {
        let request = |is_head, path: &str| Ok(Request { is_head, path: path.into() });
        assert_eq!(get("GET / HTTP/1.1\r\nHost: 127.0.0.1:8008"), request(false, "/"));
        assert_eq!(get("HEAD /a/b?c=d?e HTTP/1.0\r\nhOST:localhost"), request(true, "/a/b"));
        assert_eq!(get("GET /%2e HTTP/1.1\r\nA: b\r\nHost: [::1]:80"), request(false, "/%2e"));
    }

    #[test]
    fn other_methods_and_broken_requests_are_refused() {
        let host = "\r\nHost: localhost";
        assert_eq!(status(&format!("POST / HTTP/1.1{host}")), 405);
        for line in ["", "GET", "GET /", "GET  / HTTP/1.1", "GET / HTTP/2", "GET / HTTP/1.1 x"] {
            assert_eq!(status(&format!("{line}{host}")), 400, "{line:?}");
        }
        assert_eq!(status(&format!("GET http://a/ HTTP/1.1{host}")), 400);
        assert_eq!(status("GET / HTTP/1.1"), 400);
        assert_eq!(status(&format!("GET / HTTP/1.1{host}{host}")), 400);
        assert_eq!(parse(b"GET /\xff HTTP/1.1\r\n\r\n", "").expect_err("a refusal").0, 400);
    }

    #[test]
    fn only_hosts_that_are_this_server_are_answered() {
        let asked = |host: &str| get(&format!("GET / HTTP/1.1\r\nHost: {host}")).map_err(|e| e.0);
        for own in ["127.0.0.1", "10.1.2.3:8008", "LOCALHOST:1", "Render.Example:8008", "[::1]"] {
            assert!(asked(own).is_ok(), "{own}");
        }
        let foreign = ["evil.example", "evil.example:8008", "127.0.0.1.evil.example", ""];
        let broken =
            ["localhost:", "localhost:x", "localhost:99999", "[::1", "[evil]", "::1", ":8008"];
        for host in foreign.iter().chain(&broken) {
            assert_eq!(asked(host), Err(403), "{host}");
        }
        assert_eq!(parse(b"GET / HTTP/1.1\r\nHost: \r\n\r\n", "").expect_err("a refusal").0, 403);
    }

    #[test]
    fn a_head_ends_with_an_empty_line() {
        assert_eq!(head(b"GET / HTTP/1.1\r\n\r\nrest"), Some(18));
        assert!(
            [&b""[..], b"\r\n\r", b"GET / HTTP/1.1\r\n", b"a\n\nb"]
                .iter()
                .all(|b| head(b).is_none())
        );
    }

    #[test]
    fn no_bytes_make_the_parser_panic() {
        // All requests that one changed, inserted or missing byte makes.
        let whole = b"GET /a?b HTTP/1.1\r\nHost: [::1]:80\r\n\r\n".to_vec();
        for at in 0..whole.len() {
            for byte in 0..=255u8 {
                let (mut changed, mut longer) = (whole.clone(), whole.clone());
                changed[at] = byte;
                longer.insert(at, byte);
                for bytes in [&changed[..], &longer, &whole[..at]] {
                    let _ = (head(bytes), parse(bytes, "a"));
                }
            }
        }
    }
}
