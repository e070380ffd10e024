//! Lines that the user types, read while other work continues.

use std::io::{BufRead, BufReader, Read};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;

/// The lines of an input.
pub(super) struct Lines(Receiver<String>);

/// The result of waiting for a line.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Typed {
    Line(String),
    Nothing,
    /// The input has ended.
    End,
}

impl Lines {
    /// Reads in its own thread until the end of the input.
    pub(super) fn of(input: impl Read + Send + 'static) -> Self {
        let (sender, lines) = mpsc::channel();
        thread::spawn(move || {
            let lines = BufReader::new(input).lines().map_while(Result::ok);
            // After the end of the command no thread waits for a line.
            let _ = lines.map(|line| sender.send(line)).find(Result::is_err);
        });
        Self(lines)
    }

    /// Waits for a line; none at the end of the input.
    pub(super) fn next(&self) -> Option<String> {
        self.0.recv().ok()
    }

    /// Waits for a line, but not longer than this.
    pub(super) fn next_within(&self, wait: Duration) -> Typed {
        match self.0.recv_timeout(wait) {
            Ok(line) => Typed::Line(line),
            Err(RecvTimeoutError::Timeout) => Typed::Nothing,
            Err(RecvTimeoutError::Disconnected) => Typed::End,
        }
    }
}
