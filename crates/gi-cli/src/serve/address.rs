//! Where the live page is served.

use std::net::TcpListener;

/// The host if the command line names none: only programs on this machine reach it.
const HOST: &str = "127.0.0.1";

/// A host and a port to listen on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address {
    /// A name, or an IP address without brackets.
    host: String,
    port: u16,
}

impl std::fmt::Display for Address {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.host.contains(':') {
            write!(f, "[{}]:{}", self.host, self.port)
        } else {
            write!(f, "{}:{}", self.host, self.port)
        }
    }
}

impl std::str::FromStr for Address {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        // `--serve scene.xml` takes the scene for the address.
        let wrong = "expected PORT or HOST:PORT; if this is the scene, name it before --serve";
        let (host, port) = text.rsplit_once(':').unwrap_or((HOST, text));
        let port = port.parse().map_err(|_| wrong)?;
        let bracketed = host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
        let host = match bracketed {
            Some(host) => host,
            None if host.contains(':') => return Err(wrong),
            None => host,
        };
        if host.is_empty() { Err(wrong) } else { Ok(Address { host: host.into(), port }) }
    }
}

impl Address {
    /// The name in it.
    pub(super) fn host(&self) -> &str {
        &self.host
    }

    /// Listen there. Returns the listener with the address that it has: port 0 stands for any that is free.
    pub(super) fn listen(&self) -> std::io::Result<(TcpListener, Address)> {
        let listener = TcpListener::bind((self.host.as_str(), self.port))?;
        let port = listener.local_addr()?.port();
        Ok((listener, Address { host: self.host.clone(), port }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_is_a_port_or_a_host_with_a_port() {
        let address = |text: &str| text.parse::<Address>().map(|a| a.to_string());
        assert_eq!(address("9000").as_deref(), Ok("127.0.0.1:9000"));
        assert_eq!(address("render.example:80").as_deref(), Ok("render.example:80"));
        assert_eq!(address("[::1]:0").as_deref(), Ok("[::1]:0"));
        for wrong in ["", "scene.xml", "65536", "host:", ":80", "::1:80", "[::1]", "host:http"] {
            assert!(address(wrong).is_err(), "{wrong}");
        }
    }
}
