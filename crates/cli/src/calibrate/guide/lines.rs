//! Lines that the user types, read beside other work.

use std::io::{BufRead, BufReader, Read};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;

/// The lines of an input.
pub(super) struct Lines(Receiver<String>);

/// What came in some time.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Typed {
    Line(String),
    Nothing,
    /// The input has ended.
    End,
}

impl Lines {
    /// Reads in a thread of its own, to the input's end.
    pub(super) fn of(input: impl Read + Send + 'static) -> Self {
        let (sender, lines) = mpsc::channel();
        thread::spawn(move || {
            let lines = BufReader::new(input).lines().map_while(Result::ok);
            // Nobody waits for a line after the end of the command.
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
