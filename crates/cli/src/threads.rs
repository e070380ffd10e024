//! The number of threads that the command uses.

use std::num::NonZero;

use rayon::ThreadPoolBuildError;

use crate::failure::Failure;

#[derive(Debug, Clone, Copy, clap::Args)]
pub(crate) struct ThreadArgs {
    /// Use at most N threads; without it, one per core. The result does not depend on it
    #[arg(long, global = true, value_name = "N", display_order = 990, value_parser = threads)]
    threads: Option<NonZero<usize>>,
}

/// More threads than this only take time to start.
const MOST_THREADS: usize = 1024;

fn threads(text: &str) -> Result<NonZero<usize>, String> {
    let threads = text.parse().ok().filter(|threads: &NonZero<usize>| threads.get() <= MOST_THREADS);
    threads.ok_or_else(|| format!("expected a number of threads, 1 to {MOST_THREADS}"))
}

impl ThreadArgs {
    /// Applies from now on, to all parallel work.
    pub(crate) fn apply(self) -> Result<(), Failure> {
        let Some(threads) = self.threads else { return Ok(()) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.get());
        pool.build_global().map_err(|error| not_started(threads.get(), &error))
    }
}

/// The error if so many threads cannot be started.
pub(crate) fn not_started(threads: usize, error: &ThreadPoolBuildError) -> Failure {
    Failure::new(format!("{threads} threads cannot be started: {error}"), "use fewer with --threads")
}

/// The number of threads that may be used.
pub(crate) fn count() -> NonZero<usize> {
    NonZero::new(rayon::current_num_threads()).unwrap_or(NonZero::<usize>::MIN)
}
