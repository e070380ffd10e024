//! Ends the test when one input takes too long: a parser that hangs cannot be stopped from within.

use std::io::{self, Write};
use std::process;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread;
use std::time::Duration;

/// Time limit for one input. The slowest parser takes a fraction of a second.
const PATIENCE: Duration = Duration::from_mins(1);

/// Watches one parser's inputs for as long as it lives.
pub(crate) struct Watchdog {
    started: Sender<u64>,
}

impl Watchdog {
    /// Watches the inputs of a parser.
    pub(crate) fn new(parser: &'static str, seed: u64) -> Self {
        let (started, inputs) = mpsc::channel();
        thread::spawn(move || {
            let mut running = None;
            loop {
                match inputs.recv_timeout(PATIENCE) {
                    Ok(input) => running = Some(input),
                    Err(RecvTimeoutError::Disconnected) => return,
                    Err(RecvTimeoutError::Timeout) => {
                        if let Some(input) = running {
                            // Not through a macro: the test harness would keep the line, and the process ends here.
                            let _ = writeln!(
                                io::stderr(),
                                "{parser}: seed {seed}, input {input} takes longer than {PATIENCE:?}"
                            );
                            process::abort();
                        }
                    }
                }
            }
        });
        Self { started }
    }

    /// The next input begins.
    pub(crate) fn start(&self, input: u64) {
        // The thread listens as long as this exists.
        let _ = self.started.send(input);
    }
}
