//! Decides which requests are served: those of pages that this run of the server gave out, to this machine.
//!
//! Any page that a user has open may send requests to a loopback port. It cannot read this run's token, or
//! choose the `Host` and `Origin` that its browser sends.

use std::fmt::Write as _;
use std::net::SocketAddr;

use tiny_http::Request;

/// Why a request is not answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// It is for another host: a name that was made to resolve to this machine.
    Host,
    /// It comes from another page.
    Origin,
    /// It has no token, or not this run's.
    Token,
}

/// What a request must have.
#[derive(Debug)]
pub struct Guard {
    token: String,
    hosts: [String; 2],
}

impl Guard {
    /// A guard with its own token for a server at this address.
    pub fn new(address: SocketAddr) -> Result<Self, getrandom::Error> {
        let mut bytes = [0_u8; 32];
        getrandom::fill(&mut bytes)?;
        let mut token = String::new();
        for byte in bytes {
            let _ = write!(token, "{byte:02x}");
        }
        let port = address.port();
        Ok(Self { token, hosts: [format!("127.0.0.1:{port}"), format!("localhost:{port}")] })
    }

    /// The token of this run.
    pub fn token(&self) -> &str {
        &self.token
    }

    /// Whether a request is from a page of this server. The page's own request has the token in its address,
    /// every other one in a header.
    pub fn check(&self, request: &Request) -> Result<(), Refusal> {
        if !header(request, "Host").is_some_and(|host| self.is_host(host)) {
            return Err(Refusal::Host);
        }
        let origin = header(request, "Origin");
        if !origin.is_none_or(|origin| origin.strip_prefix("http://").is_some_and(|host| self.is_host(host)))
        {
            return Err(Refusal::Origin);
        }
        let given = match request.url().split_once('?') {
            Some(("/", query)) => query.strip_prefix("token="),
            _ => header(request, "Authorization").and_then(|value| value.strip_prefix("Bearer ")),
        };
        if given.is_some_and(|given| is_same(given.as_bytes(), self.token.as_bytes())) {
            Ok(())
        } else {
            Err(Refusal::Token)
        }
    }

    fn is_host(&self, host: &str) -> bool {
        self.hosts.iter().any(|own| own == host)
    }
}

/// Compares in constant time, so that the time does not reveal where the two first differ.
fn is_same(given: &[u8], token: &[u8]) -> bool {
    given.len() == token.len() && given.iter().zip(token).fold(0, |differ, (a, b)| differ | (a ^ b)) == 0
}

/// A request's header.
pub fn header<'a>(request: &'a Request, name: &'static str) -> Option<&'a str> {
    request.headers().iter().find(|header| header.field.equiv(name)).map(|header| header.value.as_str())
}
