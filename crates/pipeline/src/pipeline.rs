//! Starts and stops the threads.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use crate::capture::Capture;
use crate::hub::Hub;
use crate::queue::{OnFull, Queue};
use crate::track::Track;
use crate::{Interest, Pace, PipelineError, Sensor, SensorHandle, Subscription, Subscriptions};

/// Frames that may wait for the tracker. With one, a frame that arrives just before the tracker is ready would replace
/// another one.
const WAITING_FRAMES: usize = 2;

/// Sensors that have not started yet. A subscriber that is made before the start gets all messages.
pub struct Pipeline {
    sensors: Vec<Sensor>,
    hub: Arc<Hub>,
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
        Self { sensors, hub }
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

    /// Starts all threads: for each sensor `capture-NAME` and `track-NAME`.
    ///
    /// # Errors
    ///
    /// [`PipelineError::Thread`] if a thread cannot be started; those that run already are stopped.
    pub fn start(self) -> Result<Running, PipelineError> {
        let handles = self.handles();
        let is_stopped = Arc::new(AtomicBool::new(false));
        let mut running = Running { handles, hub: self.hub, threads: Vec::new(), is_stopped };
        for (index, sensor) in self.sensors.into_iter().enumerate() {
            let name = sensor.handle.name().to_owned();
            running.add(index, sensor).map_err(|error| PipelineError::Thread { sensor: name, error })?;
        }
        Ok(running)
    }
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

    fn add(&mut self, index: usize, sensor: Sensor) -> io::Result<()> {
        let Sensor { input, tracker, decoder, first, handle } = sensor;
        let on_full = match input.pace() {
            Pace::Recorded => OnFull::DropOldest,
            Pace::Lossless => OnFull::Wait,
        };
        let queue = Arc::new(Queue::new(WAITING_FRAMES, on_full));
        let hub = &self.hub;
        let layout = first.frame.layout;
        let track = {
            let (handle, first, hub, queue) = (handle.clone(), first.clone(), Arc::clone(hub), Arc::clone(&queue));
            Track { index, tracker, decoder, layout, handle, first, hub, queue, is_rezeroing: false }
        };
        let names = [format!("track-{}", handle.name()), format!("capture-{}", handle.name())];
        let (hub, is_stopped) = (Arc::clone(hub), Arc::clone(&self.is_stopped));
        let capture = Capture { index, input, handle, first, hub, queue: Arc::clone(&queue), is_stopped };
        let [track_name, capture_name] = names;
        self.threads.push(thread::Builder::new().name(track_name).spawn(|| track.run())?);
        let capturing = thread::Builder::new().name(capture_name).spawn(|| capture.run());
        // If capture cannot start, tracking must end, too.
        self.threads.push(capturing.inspect_err(|_| queue.close())?);
        Ok(())
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
