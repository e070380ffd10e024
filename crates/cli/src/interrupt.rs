//! Ctrl-C and SIGTERM: a command that has nothing to save ends at once; one that writes during its work ends after the
//! current frame, and at once after a second signal.

use std::io;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock};
use std::thread;
use std::time::Duration;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::unfinished;

/// A shell adds this to the number of the signal that ended a program.
const EXIT_CODE_OF_SIGNALS: u8 = 128;
/// Interval at which the signal is tested if it ends the command at once.
const POLL: Duration = Duration::from_millis(50);

/// State written by the signal handlers. They may only set a flag.
static HEARD: LazyLock<Heard> = LazyLock::new(Heard::default);

#[derive(Debug, Default)]
struct Heard {
    is_asked: Arc<AtomicBool>,
    /// The last signal; 0 before the first.
    signal: Arc<AtomicUsize>,
    /// Whether the command itself tests for the signal and ends in order.
    is_in_order: AtomicBool,
}

/// Whether the run should end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Interrupt(());

/// Installs the handlers; until [`Interrupt::listen`] a signal ends the command at once, after this call.
pub(crate) fn watch(before_the_end: impl FnOnce() + Send + 'static) -> io::Result<()> {
    // A file that reaches the limit of its size is then an error of writing it. Otherwise the signal ends the program.
    #[cfg(unix)]
    flag::register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false)))?;
    for signal in [SIGINT, SIGTERM] {
        listen_to(signal)?;
    }
    thread::spawn(move || {
        while !HEARD.is_asked.load(Ordering::Acquire) || HEARD.is_in_order.load(Ordering::Acquire) {
            thread::sleep(POLL);
        }
        before_the_end();
        unfinished::remove_all();
        std::process::exit(exit_code().map_or(1, i32::from));
    });
    Ok(())
}

fn listen_to(signal: i32) -> io::Result<()> {
    // The first handler finds the flag set by the previous signal.
    flag::register_conditional_shutdown(signal, i32::from(EXIT_CODE_OF_SIGNALS) + signal, Arc::clone(&HEARD.is_asked))?;
    flag::register_usize(signal, Arc::clone(&HEARD.signal), signal as usize)?;
    flag::register(signal, Arc::clone(&HEARD.is_asked))?;
    Ok(())
}

/// The exit code that a shell expects from an interrupted program; none if it was not interrupted.
pub(crate) fn exit_code() -> Option<u8> {
    let signal = u8::try_from(HEARD.signal.load(Ordering::Acquire)).unwrap_or_default();
    (signal > 0).then(|| EXIT_CODE_OF_SIGNALS.saturating_add(signal))
}

impl Interrupt {
    /// From now on the command tests for the signal; it has something to finish.
    pub(crate) fn listen() -> Self {
        HEARD.is_in_order.store(true, Ordering::Release);
        Self(())
    }

    #[expect(clippy::unused_self, reason = "the value shows that the command listens to signals")]
    pub(crate) fn is_asked(self) -> bool {
        HEARD.is_asked.load(Ordering::Acquire)
    }
}
