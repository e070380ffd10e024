//! Ctrl-C: the first asks the run to end after the frame at hand, the second ends it at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::failure::Failure;

/// What a shell expects of a program that Ctrl-C ended.
const EXIT_CODE: i32 = 130;

/// Whether somebody wants the run to end.
#[derive(Debug, Clone)]
pub(crate) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on. A process can do so once.
    pub(crate) fn listen() -> Result<Self, Failure> {
        let is_asked = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&is_asked);
        let on_signal = move || {
            if flag.swap(true, Ordering::Relaxed) {
                std::process::exit(EXIT_CODE);
            }
        };
        let message = |error| Failure::Stated { message: format!("cannot listen to Ctrl-C: {error}"), hint: None };
        ctrlc::set_handler(on_signal).map_err(message)?;
        Ok(Self(is_asked))
    }

    pub(crate) fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
