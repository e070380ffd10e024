//! The server, and the thread that feeds it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use fingervision_pipeline::{Interest, SensorHandle, Subscription};
use fingervision_recording::{Clock, LiveChannel, LiveMessages, LiveSink, RecordedSensor};
use foxglove::{ChannelBuilder, Context, FoxgloveError, PartialMetadata, RawChannel, Schema, WebSocketServerHandle};

use crate::FoxgloveServerError;

/// Only programs on this machine reach the server: it knows no token.
const HOST: &str = "127.0.0.1";
/// Messages that may wait for the thread: half of them are frames, of which the sensors can lend about 190 to all.
const WAITING_MESSAGES: usize = 64;
/// Messages that may wait for one client, a second's worth of pictures.
const CLIENT_MESSAGES: usize = 256;
/// How long the thread waits for a message.
const WAIT: Duration = Duration::from_millis(100);
/// Time between two surfaces of a sensor.
const SURFACE_PERIOD: Duration = Duration::from_millis(100);
/// How often the cameras and the places of the gels are sent, for clients that come later.
const DESCRIBED_EVERY: Duration = Duration::from_secs(1);

/// A WebSocket that Foxglove opens. Dropped, it ends its connections.
#[derive(Debug)]
pub struct FoxgloveServer {
    server: Option<WebSocketServerHandle>,
    port: u16,
    is_stopped: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl FoxgloveServer {
    /// What the server subscribes to. Surfaces are copied only while a client is there.
    #[must_use]
    pub fn interest() -> Interest {
        Interest { frames: true, fields_every: None, capacity: WAITING_MESSAGES }
    }

    /// Serves sensors at a port of this machine; 0 is any free one.
    ///
    /// # Errors
    ///
    /// [`FoxgloveServerError`] if the port is taken or the system gives no thread.
    pub fn start(port: u16, handles: &[SensorHandle], subscription: Subscription) -> Result<Self, FoxgloveServerError> {
        let failed = |error| FoxgloveServerError::of(port, error);
        let sensors: Vec<RecordedSensor> =
            handles.iter().map(|handle| RecordedSensor::of(handle, Clock::Host)).collect();
        let context = Context::new();
        let messages = LiveMessages::new(&sensors);
        let channels = Channels::open(&messages.channels(), &context).map_err(failed)?;
        let server = context.websocket_server().name("fingervision").bind(HOST, port);
        let server = server.message_backlog_size(CLIENT_MESSAGES).start_blocking().map_err(failed)?;
        let is_stopped = Arc::new(AtomicBool::new(false));
        let (port, stop) = (server.port(), Arc::clone(&is_stopped));
        let feed = Feed { subscription, messages, channels, _context: context, has_clients: false };
        let thread = thread::Builder::new().name("foxglove".into()).spawn(move || feed.run(&stop));
        let thread = thread.map_err(|error| FoxgloveServerError::Start { reason: error.to_string() })?;
        Ok(Self { server: Some(server), port, is_stopped, thread: Some(thread) })
    }

    /// Whether the port could be served now, before work that takes long.
    ///
    /// # Errors
    ///
    /// [`FoxgloveServerError`] if the port is taken or the system refuses it.
    pub fn check(port: u16) -> Result<(), FoxgloveServerError> {
        let bound = std::net::TcpListener::bind((HOST, port));
        bound.map(drop).map_err(|error| FoxgloveServerError::of(port, FoxgloveError::Bind(error)))
    }

    /// The address to open in Foxglove.
    #[must_use]
    pub fn url(&self) -> String {
        format!("ws://{HOST}:{}", self.port)
    }
}

impl Drop for FoxgloveServer {
    fn drop(&mut self) {
        self.is_stopped.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has ended, too.
            let _ = thread.join();
        }
        if let Some(server) = self.server.take() {
            server.stop().wait_blocking();
        }
    }
}

/// The channels of the server, by the number of their messages.
struct Channels(Vec<Option<Arc<RawChannel>>>);

impl Channels {
    fn open(channels: &[LiveChannel], context: &Arc<Context>) -> Result<Self, FoxgloveError> {
        let mut opened = Vec::new();
        for LiveChannel { number, topic, schema, descriptors, .. } in channels {
            let schema = Schema::new(*schema, "protobuf", descriptors.clone());
            let builder = ChannelBuilder::new(topic).message_encoding("protobuf").schema(schema);
            let channel = builder.context(context).build_raw()?;
            let index = usize::from(*number);
            opened.resize(opened.len().max(index + 1), None);
            opened[index] = Some(channel);
        }
        Ok(Self(opened))
    }

    fn of(&self, number: u16) -> Option<&RawChannel> {
        self.0.get(usize::from(number))?.as_deref()
    }

    /// Whether a client shows any of the topics.
    fn has_clients(&self) -> bool {
        self.0.iter().flatten().any(|channel| channel.has_sinks())
    }
}

impl LiveSink for Channels {
    fn wants(&self, channel: u16) -> bool {
        self.of(channel).is_some_and(RawChannel::has_sinks)
    }

    fn take(&mut self, channel: u16, time_ns: u64, bytes: &[u8]) {
        if let Some(channel) = self.of(channel) {
            channel.log_with_meta(bytes, PartialMetadata::with_log_time(time_ns));
        }
    }
}

/// What the thread works with.
struct Feed {
    subscription: Subscription,
    messages: LiveMessages,
    channels: Channels,
    /// Channels refer to it.
    _context: Arc<Context>,
    has_clients: bool,
}

impl Feed {
    fn run(mut self, is_stopped: &AtomicBool) {
        let mut described: Option<Instant> = None;
        while !is_stopped.load(Ordering::Acquire) {
            self.look_for_clients();
            if described.is_none_or(|described| described.elapsed() >= DESCRIBED_EVERY) {
                described = Some(Instant::now());
                self.messages.describe(&mut self.channels);
            }
            match self.subscription.next(WAIT) {
                Some(message) => self.messages.send(&message, &mut self.channels),
                None if self.subscription.is_done() => thread::sleep(WAIT),
                None => {}
            }
        }
    }

    /// Surfaces are wanted only while a client is there.
    fn look_for_clients(&mut self) {
        let has_clients = self.channels.has_clients();
        if has_clients != self.has_clients {
            self.has_clients = has_clients;
            self.subscription.set_fields_every(has_clients.then_some(SURFACE_PERIOD));
        }
    }
}
