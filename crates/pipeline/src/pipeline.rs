//! Starts and stops the threads.

use std::num::NonZero;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use fingervision_touch::Team;

use crate::capture::Capture;
use crate::hub::Hub;
use crate::queue::{OnFull, Queue};
use crate::ready::Ready;
use crate::track::Track;
use crate::workers::Workers;
use crate::{Interest, Pace, PipelineError, Sensor, SensorHandle, Subscription, Subscriptions};

/// Frames that may wait for the tracker. With one, a frame that arrives just before the tracker is ready would replace
/// another one.
const WAITING_FRAMES: usize = 2;

/// Sensors that have not started yet. A subscriber that is made before the start gets all messages.
pub struct Pipeline {
    sensors: Vec<Sensor>,
    hub: Arc<Hub>,
    /// Threads that track.
    workers: usize,
}

/// Sensors that run until they are stopped or dropped.
#[derive(Debug)]
pub struct Running {
    handles: Vec<SensorHandle>,
    hub: Arc<Hub>,
    threads: Vec<JoinHandle<()>>,
    is_stopped: Arc<AtomicBool>,
}

impl Pipeline {
    /// A pipeline of these sensors, which get the indices 0, 1, ….
    #[must_use]
    pub fn prepare(sensors: Vec<Sensor>) -> Self {
        let hub = Arc::new(Hub::new(sensors.len()));
        let workers = thread::available_parallelism().map_or(1, NonZero::get);
        Self { sensors, hub, workers }
    }

    /// Tracks on so many threads instead of one per core. If there are at least two for each sensor, they share the work of a
    /// frame ([`Team`]), so that its reading comes earlier; otherwise each tracks a frame alone, which takes less time in all.
    #[must_use]
    pub fn with_workers(self, workers: NonZero<usize>) -> Self {
        Self { workers: workers.get(), ..self }
    }

    /// The sensors, in order.
    #[must_use]
    pub fn handles(&self) -> Vec<SensorHandle> {
        self.sensors.iter().map(|sensor| sensor.handle.clone()).collect()
    }

    /// A new subscriber.
    #[must_use]
    pub fn subscribe(&self, interest: Interest) -> Subscription {
        self.hub.subscribe(interest, OnFull::DropOldest)
    }

    /// A new subscriber that loses no message: while its queue is full, all sensors wait. Only for sources with
    /// [`Pace::Lossless`], because a camera does not wait.
    #[must_use]
    pub fn subscribe_lossless(&self, interest: Interest) -> Subscription {
        self.hub.subscribe(interest, OnFull::Wait)
    }

    /// Starts all threads: `capture-NAME` for each sensor, and `track-1`, `track-2`, … for all of them.
    ///
    /// # Errors
    ///
    /// [`PipelineError::Thread`] if a thread cannot be started; those that run already are stopped.
    pub fn start(self) -> Result<Running, PipelineError> {
        let (handles, count) = (self.handles(), self.sensors.len());
        let (is_stopped, ready) = (Arc::new(AtomicBool::new(false)), Arc::new(Ready::new(count)));
        let (mut captures, mut tracks) = (Vec::new(), Vec::new());
        let no_thread = |error| PipelineError::Thread { sensor: "the trackers".into(), error };
        let shared = self.workers / count.max(1);
        for (index, mut sensor) in self.sensors.into_iter().enumerate() {
            if let Some(tracker) = &mut sensor.tracker {
                tracker.share(&Team::new(shared).map_err(no_thread)?);
            }
            let (capture, track) = parts(index, sensor, &self.hub, &ready, &is_stopped);
            captures.push(capture);
            tracks.push(track);
        }
        // What fails ends with the sensors that it dropped: a worker and a capture end with them.
        let workers = Workers::start(self.workers.min(count), tracks, Arc::clone(&ready));
        let mut running = Running { handles, hub: self.hub, threads: Vec::new(), is_stopped };
        running.threads = workers.map_err(no_thread)?;
        let mut captures = captures.into_iter();
        while let Some(capture) = captures.next() {
            let (name, queue, index) = (capture.handle.name().to_owned(), Arc::clone(&capture.queue), capture.index);
            match thread::Builder::new().name(format!("capture-{name}")).spawn(|| capture.run()) {
                Ok(thread) => running.threads.push(thread),
                Err(error) => {
                    for (queue, index) in
                        captures.map(|rest| (Arc::clone(&rest.queue), rest.index)).chain([(queue, index)])
                    {
                        queue.close();
                        ready.announce(index);
                    }
                    return Err(PipelineError::Thread { sensor: name, error });
                }
            }
        }
        Ok(running)
    }
}

/// What captures and what tracks a sensor's frames.
fn parts(
    index: usize,
    sensor: Sensor,
    hub: &Arc<Hub>,
    ready: &Arc<Ready>,
    is_stopped: &Arc<AtomicBool>,
) -> (Capture, Track) {
    let Sensor { input, tracker, decoder, first, handle } = sensor;
    let on_full = match input.pace() {
        Pace::Recorded => OnFull::DropOldest,
        Pace::Lossless => OnFull::Wait,
    };
    let queue = Arc::new(Queue::new(WAITING_FRAMES, on_full));
    let (hub, ready, is_stopped) = (Arc::clone(hub), Arc::clone(ready), Arc::clone(is_stopped));
    let captured = first.0.clone();
    let track = Track::new(index, (tracker, decoder), first, handle.clone(), (Arc::clone(&hub), Arc::clone(&queue)));
    (Capture { index, input, handle, first: captured, hub, queue, ready, is_stopped }, track)
}

impl Running {
    /// The sensors, in order.
    #[must_use]
    pub fn handles(&self) -> &[SensorHandle] {
        &self.handles
    }

    /// A new subscriber; it gets the messages that follow.
    #[must_use]
    pub fn subscribe(&self, interest: Interest) -> Subscription {
        self.hub.subscribe(interest, OnFull::DropOldest)
    }

    /// A handle that makes subscriptions while the sensors run.
    #[must_use]
    pub fn subscriptions(&self) -> Subscriptions {
        Subscriptions::new(Arc::clone(&self.hub))
    }

    /// Stops capture, tracks the frames that have arrived, and waits for the threads.
    pub fn stop(mut self) {
        self.end();
    }

    fn end(&mut self) {
        self.is_stopped.store(true, Ordering::Release);
        for thread in self.threads.drain(..) {
            // A thread that panicked has ended, and its end was published.
            let _ = thread.join();
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.end();
    }
}
