//! A bounded queue between two threads.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// What happens to a new item if the queue is full.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OnFull {
    /// The oldest item is dropped.
    DropOldest,
    /// The sender waits.
    Wait,
}

/// A queue with a fixed capacity.
#[derive(Debug)]
pub(crate) struct Queue<T> {
    state: Mutex<State<T>>,
    changed: Condvar,
    capacity: usize,
    on_full: OnFull,
}

#[derive(Debug)]
struct State<T> {
    items: VecDeque<T>,
    lost: u64,
    is_closed: bool,
}

impl<T> Queue<T> {
    pub(crate) fn new(capacity: usize, on_full: OnFull) -> Self {
        let capacity = capacity.max(1);
        let state = State { items: VecDeque::with_capacity(capacity), lost: 0, is_closed: false };
        Self { state: Mutex::new(state), changed: Condvar::new(), capacity, on_full }
    }

    /// Appends an item; returns the item that was dropped for it.
    pub(crate) fn push(&self, item: T) -> Option<T> {
        let mut state = self.lock();
        while state.items.len() >= self.capacity && self.on_full == OnFull::Wait && !state.is_closed {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        if state.is_closed {
            return None;
        }
        let oldest = if state.items.len() >= self.capacity { state.items.pop_front() } else { None };
        state.lost += u64::from(oldest.is_some());
        state.items.push_back(item);
        drop(state);
        self.changed.notify_all();
        oldest
    }

    /// The oldest item. `None` if there is none within `wait`, or the queue is closed and empty.
    pub(crate) fn pop(&self, wait: Duration) -> Option<T> {
        let start = Instant::now();
        let mut state = self.lock();
        loop {
            if let Some(item) = state.items.pop_front() {
                drop(state);
                self.changed.notify_all();
                return Some(item);
            }
            let left = wait.checked_sub(start.elapsed()).filter(|_| !state.is_closed)?;
            state = self.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Accepts no more items; those in the queue can still be read.
    pub(crate) fn close(&self) {
        self.lock().is_closed = true;
        self.changed.notify_all();
    }

    /// Whether it is closed and empty.
    pub(crate) fn is_done(&self) -> bool {
        let state = self.lock();
        state.is_closed && state.items.is_empty()
    }

    /// Number of items that were dropped.
    pub(crate) fn lost(&self) -> u64 {
        self.lock().lost
    }

    /// A thread that panicked leaves a consistent state, because no call panics between its changes.
    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread;

    const NO_WAIT: Duration = Duration::ZERO;
    const LONG: Duration = Duration::from_mins(1);

    #[test]
    fn the_oldest_item_goes_and_is_counted() {
        let queue = Queue::new(2, OnFull::DropOldest);
        assert_eq!([1, 2, 3, 4].map(|item| queue.push(item)), [None, None, Some(1), Some(2)]);
        assert_eq!((queue.pop(NO_WAIT), queue.pop(NO_WAIT), queue.pop(NO_WAIT)), (Some(3), Some(4), None));
        assert_eq!(queue.lost(), 2);
    }

    #[test]
    fn a_sender_that_waits_loses_nothing() {
        let queue = Queue::new(1, OnFull::Wait);
        let received: Vec<i32> = thread::scope(|scope| {
            scope.spawn(|| {
                (0..100).for_each(|item| assert_eq!(queue.push(item), None));
                queue.close();
            });
            std::iter::from_fn(|| queue.pop(LONG)).collect()
        });
        assert_eq!(received, (0..100).collect::<Vec<_>>());
        assert!(queue.is_done() && queue.lost() == 0);
    }

    #[test]
    fn closing_wakes_everybody() {
        let queue = Queue::new(1, OnFull::Wait);
        queue.push(1);
        thread::scope(|scope| {
            let sender = scope.spawn(|| queue.push(2));
            thread::yield_now();
            queue.close();
            assert_eq!(sender.join().unwrap(), None);
        });
        assert_eq!((queue.pop(LONG), queue.pop(LONG)), (Some(1), None));
    }
}
