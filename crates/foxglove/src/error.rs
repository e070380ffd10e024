//! Why Foxglove cannot be served.

use std::io;

use foxglove::FoxgloveError;

/// Why Foxglove cannot be served.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FoxgloveServerError {
    /// Another program uses the port.
    #[error("Foxglove cannot be served at port {port}: it is taken")]
    PortTaken {
        /// The port.
        port: u16,
    },
    /// The system refuses the port.
    #[error("Foxglove cannot be served at port {port}: {error}")]
    Bind {
        /// The port.
        port: u16,
        /// The system's message.
        error: io::Error,
    },
    /// The server or its thread cannot be started.
    #[error("Foxglove cannot be served: {reason}")]
    Start {
        /// What went wrong.
        reason: String,
    },
}

impl FoxgloveServerError {
    /// What the user can do about it.
    #[must_use]
    pub fn hint(&self) -> &'static str {
        match self {
            Self::PortTaken { .. } => "name another port, as in --foxglove=8766, or end the other program",
            Self::Bind { .. } => "use a port above 1023",
            Self::Start { .. } => "close other programs and try again",
        }
    }

    pub(crate) fn of(port: u16, error: FoxgloveError) -> Self {
        match error {
            FoxgloveError::Bind(error) | FoxgloveError::IoError(error) => {
                if error.kind() == io::ErrorKind::AddrInUse {
                    Self::PortTaken { port }
                } else {
                    Self::Bind { port, error }
                }
            }
            other => Self::Start { reason: other.to_string() },
        }
    }
}
