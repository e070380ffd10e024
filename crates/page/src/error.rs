//! Why the page cannot be served.

use std::io;
use std::net::SocketAddr;

/// Why the page cannot be served.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PageError {
    /// Another program uses the port.
    #[error("the page cannot be served at {address}: the port is taken")]
    PortTaken {
        /// The address.
        address: SocketAddr,
    },
    /// The address is not one of this machine, or the program is not allowed to use the port.
    #[error("the page cannot be served at {address}: {error}")]
    Bind {
        /// The address.
        address: SocketAddr,
        /// The system's message.
        error: io::Error,
    },
    /// The system provides no thread or no random numbers.
    #[error("the page cannot be served: {reason}")]
    System {
        /// The system's message.
        reason: String,
    },
}

impl PageError {
    /// What the user can do about it.
    #[must_use]
    pub fn hint(&self) -> &'static str {
        match self {
            Self::PortTaken { .. } => "leave --port out to use a free one, or end the other program",
            Self::Bind { .. } => "use --bind with an address of this machine, and a port above 1023",
            Self::System { .. } => "close other programs and try again",
        }
    }

    pub(crate) fn bind(address: SocketAddr, error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::AddrInUse {
            Self::PortTaken { address }
        } else {
            Self::Bind { address, error }
        }
    }
}
