//! Ctrl-C: the first asks the run to end after the frame at hand, the second ends it at once.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::failure::Failure;

/// What a shell expects of a program that Ctrl-C ended.
const EXIT_CODE: i32 = 130;

/// Set by the first Ctrl-C.
static IS_ASKED: AtomicBool = AtomicBool::new(false);

/// Whether somebody wants the run to end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Interrupt(());

impl Interrupt {
    /// Listens from now on.
    pub(crate) fn listen() -> Result<Self, Failure> {
        let on_signal = || {
            if IS_ASKED.swap(true, Ordering::Relaxed) {
                std::process::exit(EXIT_CODE);
            }
        };
        match ctrlc::set_handler(on_signal) {
            // A process has one handler, and this is the only one here.
            Ok(()) | Err(ctrlc::Error::MultipleHandlers) => Ok(Self(())),
            Err(error) => Err(Failure::Stated { message: format!("cannot listen to Ctrl-C: {error}"), hint: None }),
        }
    }

    #[expect(clippy::unused_self, reason = "who asks has begun to listen")]
    pub(crate) fn is_asked(self) -> bool {
        IS_ASKED.load(Ordering::Relaxed)
    }
}
