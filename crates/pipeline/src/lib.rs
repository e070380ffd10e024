//! Live sensors: threads that capture and track, and send their results to subscribers.
//!
//! Every sensor has a thread that *captures*: it takes frames from a camera as they arrive, or from a file or a simulation at their
//! recorded times. As many threads as there are cores decode and *track* them for all sensors together: a free thread takes the
//! sensor that has waited longest, for one frame. Where there are two cores for each sensor, two threads share a frame. The tracker
//! is the same as offline, so the same frames give the same readings, bit for bit.
//!
//! Before each tracker is a queue of two frames. If tracking is slower than the camera, the oldest frame is dropped and counted, and
//! the next reading is flagged `dropped`. So a frame waits for at most two others, and the delay does not grow. Files and simulations
//! can also be tracked without loss ([`Pace::Lossless`]); capture then waits for tracking.
//!
//! A [subscriber](Pipeline::subscribe) gets captured frames, the numbers of readings, and whole readings at a limited
//! rate, through its own queue. A slow subscriber loses its oldest messages, which are counted; it does not slow down
//! capture or tracking. Fields are copied only for subscribers that request them, and all memory is reused.
//!
//! Times are seconds of the host's monotonic clock ([`host_time_s`]), the same for all sensors and for the time stamps of
//! V4L2 cameras.
//!
//! ```no_run
//! use std::time::Duration;
//! use fingervision_pipeline::{Input, Interest, Message, Pace, Pipeline, Sensor};
//! use fingervision_touch::{Fields, Profile};
//!
//! let profile = Profile::load("sensor.toml".as_ref())?;
//! let source = fingervision_source::open("press.mp4", &Default::default())?;
//! let sensor = Sensor::open("finger", profile, Input::source(source, Pace::Recorded), Fields::default())?;
//! let pipeline = Pipeline::prepare(vec![sensor]);
//! let readings = pipeline.subscribe(Interest::readings());
//! let running = pipeline.start()?;
//! while let Some(message) = readings.next(Duration::from_secs(1)) {
//!     match message {
//!         Message::Reading { numbers, .. } => println!("{:?} N", numbers.force_n),
//!         Message::End { .. } => break,
//!         _ => {}
//!     }
//! }
//! running.stop();
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod capture;
mod captured;
mod clock;
mod error;
mod hub;
mod input;
mod message;
mod next;
mod pipeline;
mod pool;
mod queue;
mod ready;
mod replay;
mod sensor;
mod shared;
mod subscription;
mod subscriptions;
mod track;
mod workers;

pub use clock::host_time_s;
pub use error::PipelineError;
pub use input::{Input, Pace};
pub use message::{FrameTimes, Interest, Message, Snapshot};
pub use pipeline::{Pipeline, Running};
pub use replay::Replay;
pub use sensor::{Sensor, SensorHandle};
pub use shared::SensorCounts;
pub use subscription::Subscription;
pub use subscriptions::Subscriptions;
