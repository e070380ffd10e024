//! A client that reads all messages of the page, as a browser that shows it does.

use std::fmt;
use std::net::{Shutdown, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};

use anyhow::{Context, Result, bail, ensure};
use fingervision_pipeline::host_time_s;
use serde::Deserialize;
use tungstenite::{Message, WebSocket};

/// What the page has received.
#[derive(Debug, Clone, Default)]
pub(super) struct Seen {
    /// Time from the capture of a frame until its reading is here, ms.
    pub(super) latencies_ms: Vec<f32>,
    /// The last counts of each sensor.
    pub(super) counts: Vec<Counts>,
    /// Why there are no more messages.
    error: Option<String>,
}

/// The counts of a sensor.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub(super) struct Counts {
    tracked: u64,
    dropped: u64,
    dropped_by_camera: u64,
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { tracked, dropped, dropped_by_camera } = self;
        write!(f, "{tracked} readings, {dropped} dropped before tracking, {dropped_by_camera} by the camera")
    }
}

/// A text message; other kinds have none of these.
#[derive(Debug, Default, Deserialize)]
struct Text {
    #[serde(default)]
    readings: Vec<Reading>,
    state: Option<State>,
}

#[derive(Debug, Deserialize)]
struct Reading {
    captured_s: f64,
}

#[derive(Debug, Deserialize)]
struct State {
    sensors: Vec<Counts>,
}

/// The connection of the client, read by its own thread.
#[derive(Debug)]
pub(super) struct PageClient {
    stream: TcpStream,
    seen: Arc<Mutex<Seen>>,
    thread: JoinHandle<()>,
}

impl PageClient {
    /// Opens the page at this host, as in `127.0.0.1:8090`.
    pub(super) fn open(host: &str) -> Result<Self> {
        let stream = TcpStream::connect(host).with_context(|| format!("the page at {host} cannot be reached"))?;
        let address = format!("ws://{host}/ws");
        let (socket, _) = tungstenite::client(&address, stream.try_clone()?)
            .map_err(|error| anyhow::anyhow!("{address} refuses the connection: {error}"))?;
        let seen = Arc::new(Mutex::new(Seen::default()));
        let thread = thread::spawn({
            let seen = Arc::clone(&seen);
            move || read(socket, &seen)
        });
        Ok(Self { stream, seen, thread })
    }

    /// What has been received so far.
    pub(super) fn seen(&self) -> Result<Seen> {
        let seen = lock(&self.seen).clone();
        if let Some(error) = &seen.error {
            bail!("the page's connection has ended: {error}");
        }
        ensure!(!seen.latencies_ms.is_empty(), "the page has received no reading");
        Ok(seen)
    }

    /// Closes the connection.
    pub(super) fn finish(self) -> Result<Seen> {
        let seen = self.seen()?;
        self.stream.shutdown(Shutdown::Both).context("the page's connection cannot be closed")?;
        // The thread ends with the connection.
        ensure!(self.thread.join().is_ok(), "the page's client panicked");
        Ok(seen)
    }
}

fn lock(seen: &Mutex<Seen>) -> MutexGuard<'_, Seen> {
    seen.lock().unwrap_or_else(PoisonError::into_inner)
}

fn read(mut socket: WebSocket<TcpStream>, seen: &Mutex<Seen>) {
    loop {
        match socket.read() {
            Ok(Message::Text(text)) => lock(seen).take(text.as_str(), host_time_s()),
            // Fields.
            Ok(_) => {}
            Err(error) => {
                lock(seen).error = Some(error.to_string());
                return;
            }
        }
    }
}

impl Seen {
    /// Takes a message that has arrived at this time of the host's clock.
    fn take(&mut self, text: &str, now_s: f64) {
        match serde_json::from_str::<Text>(text) {
            Ok(Text { readings, state }) => {
                self.latencies_ms.extend(readings.iter().map(|reading| (1e3 * (now_s - reading.captured_s)) as f32));
                if let Some(state) = state {
                    self.counts = state.sensors;
                }
            }
            Err(error) => self.error = Some(format!("{error} in {text}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn latencies_and_counts_are_read_from_the_messages() {
        let mut seen = Seen::default();
        seen.take(r#"{"hello": {"version": "1", "sensors": []}}"#, 1.0);
        seen.take(r#"{"readings": [{"sensor": 0, "captured_s": 2.0, "ready_s": 2.01, "flags": []}]}"#, 2.25);
        let sensor = r#"{"captured": 9, "tracked": 7, "dropped": 2, "dropped_by_camera": 1, "damaged": 0}"#;
        seen.take(&format!(r#"{{"state": {{"now_s": 3.0, "sensors": [{sensor}], "recording": null}}}}"#), 3.0);
        assert_eq!(seen.latencies_ms, [250.0]);
        assert_eq!(seen.counts, [Counts { tracked: 7, dropped: 2, dropped_by_camera: 1 }]);
        assert_eq!(seen.counts[0].to_string(), "7 readings, 2 dropped before tracking, 1 by the camera");
        assert_eq!(seen.error, None);
    }

    #[test]
    fn a_message_of_another_form_is_an_error() {
        let mut seen = Seen::default();
        seen.take(r#"{"readings": [{"captured": 2.0}]}"#, 2.25);
        assert!(seen.error.unwrap().contains("missing field `captured_s`"));
    }
}
