//! Decides which requests are answered.
//!
//! A web site that the user visits could make the browser send requests to this server. Such requests name the site in
//! `Origin` and are refused. If the site's own name resolves to this machine (DNS rebinding), this name is in `Host`;
//! on a loopback address only names of this machine are accepted.

use std::fmt::Write;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};

use crate::PageError;

/// Bytes of a token.
const TOKEN_BYTES: usize = 16;

/// The conditions that a request must meet.
#[derive(Debug, Clone)]
pub(crate) struct Access {
    address: SocketAddr,
    token: Option<String>,
}

/// Why a request is refused.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// `Host` is not this machine.
    OtherHost,
    /// Another web site makes the request.
    OtherOrigin,
    /// The token is missing or wrong.
    NoToken,
}

impl Refusal {
    pub(crate) fn sentence(&self) -> &'static str {
        match self {
            Self::OtherHost => "this page answers only to localhost and 127.0.0.1",
            Self::OtherOrigin => "requests of other web sites are refused",
            Self::NoToken => "open the whole address that the program prints; it contains a token",
        }
    }
}

impl Access {
    /// The conditions for a server at this address; makes a token if other machines can reach it.
    ///
    /// # Errors
    ///
    /// [`PageError::System`] if the system provides no random numbers.
    pub(crate) fn new(address: SocketAddr) -> Result<Self, PageError> {
        let token = if address.ip().is_loopback() { None } else { Some(random_token()?) };
        Ok(Self { address, token })
    }

    /// The address to open in a browser.
    pub(crate) fn url(&self) -> String {
        let mut url = format!("http://{}/", SocketAddr::new(self.reachable_ip(), self.address.port()));
        if let Some(token) = &self.token {
            // Writing to a String cannot fail.
            let _ = write!(url, "?token={token}");
        }
        url
    }

    /// The address under which other machines find this one, if the server listens at all addresses.
    fn reachable_ip(&self) -> IpAddr {
        let ip = self.address.ip();
        if !ip.is_unspecified() {
            return ip;
        }
        // Connecting a UDP socket sends nothing; the system chooses the interface that leads there. The address is one of
        // those reserved for documentation (RFC 5737).
        let route = UdpSocket::bind((ip, 0)).and_then(|socket| {
            socket.connect((Ipv4Addr::new(192, 0, 2, 1), 9))?;
            socket.local_addr()
        });
        route.map_or(IpAddr::V4(Ipv4Addr::LOCALHOST), |local| local.ip())
    }

    /// Checks the headers and the token of a request that shows data or changes something.
    pub(crate) fn check(&self, host: Option<&str>, origin: Option<&str>, token: Option<&str>) -> Result<(), Refusal> {
        self.check_site(host, origin)?;
        match &self.token {
            Some(expected) if !token.is_some_and(|token| is_same(token, expected)) => Err(Refusal::NoToken),
            _ => Ok(()),
        }
    }

    /// Checks the headers of a request for a file of the page.
    pub(crate) fn check_site(&self, host: Option<&str>, origin: Option<&str>) -> Result<(), Refusal> {
        let host = host.unwrap_or_default();
        if self.token.is_none() && !self.is_own(host) {
            return Err(Refusal::OtherHost);
        }
        match origin {
            Some(origin) if origin.strip_prefix("http://") != Some(host) => Err(Refusal::OtherOrigin),
            _ => Ok(()),
        }
    }

    fn is_own(&self, host: &str) -> bool {
        let Some((name, port)) = host.rsplit_once(':') else { return false };
        let is_port = port.parse() == Ok(self.address.port());
        is_port && (["localhost", "127.0.0.1", "[::1]"].contains(&name) || host == self.address.to_string())
    }
}

/// Compares in a time that does not depend on where the texts differ.
fn is_same(given: &str, expected: &str) -> bool {
    let differing = given.bytes().zip(expected.bytes()).fold(0, |sum, (a, b)| sum | (a ^ b));
    given.len() == expected.len() && differing == 0
}

fn random_token() -> Result<String, PageError> {
    let mut bytes = [0; TOKEN_BYTES];
    getrandom::fill(&mut bytes).map_err(|error| PageError::System { reason: error.to_string() })?;
    Ok(bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn local() -> Access {
        Access::new("127.0.0.1:8090".parse().unwrap()).unwrap()
    }

    #[test]
    fn this_machine_needs_no_token() {
        let access = local();
        assert_eq!(access.url(), "http://127.0.0.1:8090/");
        for host in ["127.0.0.1:8090", "localhost:8090"] {
            assert_eq!(access.check(Some(host), None, None), Ok(()), "{host}");
            assert_eq!(access.check(Some(host), Some(&format!("http://{host}")), None), Ok(()), "{host}");
        }
    }

    #[test]
    fn other_sites_and_names_are_refused() {
        let access = local();
        let own = Some("localhost:8090");
        for origin in ["http://evil.example", "https://localhost:8090", "null", "http://localhost:8091"] {
            assert_eq!(access.check(own, Some(origin), None), Err(Refusal::OtherOrigin), "{origin}");
        }
        for host in [None, Some("evil.example:8090"), Some("localhost"), Some("localhost:80"), Some("")] {
            assert_eq!(access.check(host, None, None), Err(Refusal::OtherHost), "{host:?}");
        }
    }

    #[test]
    fn other_machines_need_the_token() {
        let access = Access::new("0.0.0.0:8090".parse().unwrap()).unwrap();
        assert!(!access.url().contains("0.0.0.0"), "a browser cannot open this address: {}", access.url());
        let token = access.url().split_once("?token=").unwrap().1.to_owned();
        assert_eq!(token.len(), 2 * TOKEN_BYTES);
        assert_ne!(access.url(), Access::new("0.0.0.0:8090".parse().unwrap()).unwrap().url());
        let host = Some("robot.local:8090");
        assert_eq!(access.check(host, None, Some(&token)), Ok(()));
        for wrong in [None, Some(""), Some(&token[1..]), Some("0123456789abcdef0123456789abcdef")] {
            assert_eq!(access.check(host, None, wrong), Err(Refusal::NoToken), "{wrong:?}");
        }
        assert_eq!(access.check(host, Some("http://evil.example"), Some(&token)), Err(Refusal::OtherOrigin));
    }
}
