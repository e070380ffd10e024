//! Threads that share the work of one frame.

use rayon::{ThreadPool, ThreadPoolBuilder};
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Parts of a frame.
const PARTS: usize = 2;

/// Threads that share the work of one frame, so that it takes less time; without threads of its own, the work is done by the
/// thread that asks for it. The results are the same bits.
///
/// A team does one work at a time: of several trackers with the same team, one waits for the other. Several sensors need no
/// team: each of them can have a thread.
#[derive(Debug, Clone, Default)]
pub struct Team {
    threads: Option<Arc<Threads>>,
}

#[derive(Debug)]
struct Threads {
    pool: ThreadPool,
    /// Locked while a work is done: a thread that waits for its parts would otherwise begin another work, and the first one would
    /// have to wait for all of that.
    is_busy: Mutex<()>,
}

impl Team {
    /// A team of at most so many threads, named `team-1` and `team-2`: a frame is divided into two parts. With one thread, and by
    /// default, the thread that asks does all the work.
    ///
    /// # Errors
    ///
    /// The system's error, if it gives no thread.
    pub fn new(threads: usize) -> io::Result<Self> {
        if threads < PARTS {
            return Ok(Self::default());
        }
        let name = |index: usize| format!("team-{}", index + 1);
        let pool = ThreadPoolBuilder::new().num_threads(PARTS).thread_name(name).build().map_err(io::Error::other)?;
        Ok(Self { threads: Some(Arc::new(Threads { pool, is_busy: Mutex::new(()) })) })
    }

    /// Whether work is divided among several threads.
    #[must_use]
    pub fn is_shared(&self) -> bool {
        self.threads.is_some()
    }

    /// Does the work on a thread of the team, where [`Team::join`] takes little time.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.threads {
            Some(threads) if threads.pool.current_thread_index().is_none() => threads.run(work),
            _ => work(),
        }
    }

    /// Does two parts of a work, at the same time if the team has several threads.
    pub fn join<A: Send, B: Send>(
        &self,
        first: impl FnOnce() -> A + Send,
        second: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        match &self.threads {
            Some(threads) => threads.pool.join(first, second),
            None => (first(), second()),
        }
    }
}

impl Threads {
    /// Does the work on one thread, while the other one waits for its parts awake: a thread that sleeps takes long to wake up.
    fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        let _busy = self.is_busy.lock().unwrap_or_else(PoisonError::into_inner);
        let is_done = AtomicBool::new(false);
        let work = || {
            let _done = Done(&is_done);
            work()
        };
        let wait = || {
            while !is_done.load(Ordering::Acquire) {
                if rayon::yield_now() != Some(rayon::Yield::Executed) {
                    std::thread::yield_now();
                }
            }
        };
        self.pool.join(work, wait).0
    }
}

/// Says that the work is done when it is dropped, also after a panic.
struct Done<'a>(&'a AtomicBool);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}
