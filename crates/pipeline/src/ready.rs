//! Which sensors have work, for the threads that do it.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// The sensors that wait for a thread, the first first. A sensor is worked on by one thread at a time.
#[derive(Debug)]
pub(crate) struct Ready {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug)]
struct State {
    waiting: VecDeque<usize>,
    sensors: Vec<Work>,
    running: usize,
}

/// The work on one sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Work {
    /// Nothing to do.
    Idle,
    /// In the queue.
    Waiting,
    /// A thread works on it.
    Busy,
    /// A thread works on it, and more has come.
    BusyAndMore,
    Ended,
}

/// What remains after a piece of work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Left {
    /// Possibly more.
    More,
    /// Nothing until something comes.
    Nothing,
    /// The sensor has ended.
    End,
}

impl Ready {
    /// For sensors without work.
    pub(crate) fn new(sensors: usize) -> Self {
        let waiting = VecDeque::with_capacity(sensors);
        let state = State { waiting, sensors: vec![Work::Idle; sensors], running: sensors };
        Self { state: Mutex::new(state), changed: Condvar::new() }
    }

    /// A sensor has work.
    pub(crate) fn announce(&self, sensor: usize) {
        let mut state = self.lock();
        match state.sensors[sensor] {
            Work::Idle => self.list(state, sensor),
            Work::Busy => state.sensors[sensor] = Work::BusyAndMore,
            Work::Waiting | Work::BusyAndMore | Work::Ended => {}
        }
    }

    /// Waits for a sensor that has work, and reserves it; `None` if all have ended.
    pub(crate) fn take(&self) -> Option<usize> {
        let mut state = self.lock();
        loop {
            if let Some(sensor) = state.waiting.pop_front() {
                state.sensors[sensor] = Work::Busy;
                return Some(sensor);
            }
            if state.running == 0 {
                return None;
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Returns a sensor after a piece of work; it joins the end of the queue if there is more.
    pub(crate) fn give_back(&self, sensor: usize, left: Left) {
        let mut state = self.lock();
        if left == Left::End {
            state.sensors[sensor] = Work::Ended;
            state.running -= 1;
            drop(state);
            self.changed.notify_all();
        } else if left == Left::More || state.sensors[sensor] == Work::BusyAndMore {
            self.list(state, sensor);
        } else {
            state.sensors[sensor] = Work::Idle;
        }
    }

    fn list(&self, mut state: MutexGuard<'_, State>, sensor: usize) {
        state.sensors[sensor] = Work::Waiting;
        state.waiting.push_back(sensor);
        drop(state);
        self.changed.notify_one();
    }

    /// A thread that panicked leaves a consistent state: no call is interrupted half-way.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::thread;

    #[test]
    fn sensors_take_turns_and_none_is_worked_on_twice_at_a_time() {
        let ready = Ready::new(3);
        for sensor in [2, 0, 2, 1] {
            ready.announce(sensor);
        }
        assert_eq!(ready.take(), Some(2));
        ready.announce(2);
        ready.give_back(2, Left::Nothing);
        assert_eq!([ready.take(), ready.take(), ready.take()], [Some(0), Some(1), Some(2)]);
        ready.give_back(0, Left::More);
        assert_eq!(ready.take(), Some(0));
        for sensor in [0, 1, 2] {
            ready.give_back(sensor, Left::End);
        }
        ready.announce(1);
        assert_eq!(ready.take(), None);
    }

    #[test]
    fn nothing_that_is_announced_is_forgotten() {
        const PIECES: usize = 2000;
        let (ready, arrived, done) = (Ready::new(2), [0, 0].map(AtomicUsize::new), [0, 0].map(AtomicUsize::new));
        thread::scope(|scope| {
            for _ in 0..3 {
                scope.spawn(|| {
                    while let Some(sensor) = ready.take() {
                        let open = arrived[sensor].load(Ordering::SeqCst) - done[sensor].load(Ordering::SeqCst);
                        let count = done[sensor].fetch_add(open.min(1), Ordering::SeqCst) + open.min(1);
                        let left = if count == PIECES { Left::End } else { [Left::Nothing, Left::More][open.min(1)] };
                        ready.give_back(sensor, left);
                    }
                });
            }
            for piece in 0..2 * PIECES {
                arrived[piece % 2].fetch_add(1, Ordering::SeqCst);
                ready.announce(piece % 2);
            }
        });
        assert_eq!(done.map(AtomicUsize::into_inner), [PIECES; 2]);
    }
}
