//! The threads that track, for all sensors together.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use crate::ready::{Left, Ready};
use crate::track::Track;

/// The sensors that these threads share.
pub(crate) struct Workers {
    /// Each is locked only by the thread that has taken the sensor; none after its end.
    tracks: Vec<Mutex<Option<Track>>>,
    ready: Arc<Ready>,
}

impl Workers {
    /// Starts threads that run until all sensors have ended. Every sensor has its first frame to be tracked.
    ///
    /// # Errors
    ///
    /// The system's, if it gives no thread; then all sensors have ended.
    pub(crate) fn start(count: usize, tracks: Vec<Track>, ready: Arc<Ready>) -> io::Result<Vec<JoinHandle<()>>> {
        let sensors = tracks.len();
        let tracks = tracks.into_iter().map(|track| Mutex::new(Some(track))).collect();
        let workers = Arc::new(Self { tracks, ready });
        let mut threads = Vec::new();
        for number in 1..=count {
            let worker = Arc::clone(&workers);
            match thread::Builder::new().name(format!("track-{number}")).spawn(move || worker.run()) {
                Ok(thread) => threads.push(thread),
                Err(error) => {
                    // The threads that run already end with the sensors.
                    workers.tracks.iter().for_each(|track| drop(lock(track).take()));
                    (0..sensors).for_each(|sensor| workers.ready.announce(sensor));
                    return Err(error);
                }
            }
        }
        (0..sensors).for_each(|sensor| workers.ready.announce(sensor));
        Ok(threads)
    }

    fn run(&self) {
        while let Some(sensor) = self.ready.take() {
            self.ready.give_back(sensor, self.step(sensor));
        }
    }

    /// A panic ends only the sensor that caused it.
    fn step(&self, sensor: usize) -> Left {
        let mut track = lock(&self.tracks[sensor]);
        let step = catch_unwind(AssertUnwindSafe(|| track.as_mut().map_or(Left::End, Track::step)));
        let left = step.unwrap_or(Left::End);
        if left == Left::End {
            *track = None;
        }
        left
    }
}

fn lock(track: &Mutex<Option<Track>>) -> std::sync::MutexGuard<'_, Option<Track>> {
    track.lock().unwrap_or_else(PoisonError::into_inner)
}
