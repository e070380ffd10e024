//! A page with a sensor that sees a moving pattern.

use std::net::TcpStream;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Frame, Pixels};
use fingervision_page::{Actions, Page, PageOptions};
use fingervision_pipeline::{Input, Interest, Pace, Pipeline, Running, Sensor};
use fingervision_source::{Source, SourceError};
use fingervision_touch::{Fields, Profile};
use serde_json::Value;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// Columns and rows of the pattern, px.
pub(crate) const SIZE: (usize, usize) = (96, 80);

/// A page that is served at a free port.
pub(crate) struct Bench {
    pub(crate) page: Page,
    pub(crate) running: Running,
    pub(crate) actions: Arc<Recorder>,
}

/// Notes what the page asks for.
#[derive(Debug, Default)]
pub(crate) struct Recorder {
    is_on: AtomicBool,
    pub(crate) refusal: Mutex<Option<String>>,
}

impl Actions for Recorder {
    fn set_recording(&self, on: bool) -> Result<Option<PathBuf>, String> {
        if let Some(refusal) = self.refusal.lock().unwrap().clone() {
            return Err(refusal);
        }
        self.is_on.store(on, Ordering::Release);
        Ok(on.then(|| "touch.mcap".into()))
    }

    fn recording(&self) -> Option<(PathBuf, u64, f64)> {
        self.is_on.load(Ordering::Acquire).then(|| ("touch.mcap".into(), 42, 1.5))
    }
}

/// Two patterns in turn, at 50 frames a second, without end.
struct Film {
    frames: [Pixels; 2],
    next: u64,
}

impl Source for Film {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        let sequence = self.next;
        self.next += 1;
        let pixels = self.frames[(sequence % 2) as usize].clone();
        Ok(Some(Frame { sequence, capture_time_s: sequence as f64 / 50.0, pixels }))
    }

    fn frame_count(&self) -> Option<u64> {
        None
    }

    fn size(&self) -> (usize, usize) {
        SIZE
    }

    fn description(&self) -> String {
        "a film".into()
    }
}

fn film() -> Box<dyn Source> {
    let sheet = Sheet { width: SIZE.0, height: SIZE.1, ..Sheet::default() };
    let renderer = SheetRenderer::new(&sheet).unwrap();
    let frame = |shift: f64| Pixels::Rgb8(renderer.render(&Motion::shift(shift), Light::EVEN, 1).unwrap());
    Box::new(Film { frames: [frame(0.0), frame(2.0)], next: 0 })
}

impl Bench {
    pub(crate) fn start() -> Self {
        let input = Input::source(film(), Pace::Recorded);
        let sensor = Sensor::open("finger", Profile::default(), input, Fields::NONE).unwrap();
        let pipeline = Pipeline::prepare(vec![sensor]);
        let messages = pipeline.subscribe(Interest::readings());
        let running = pipeline.start().unwrap();
        let actions = Arc::new(Recorder::default());
        let options = PageOptions { port: Some(0), ..PageOptions::default() };
        let page = Page::start(options, running.handles(), messages, actions.clone()).unwrap();
        Self { page, running, actions }
    }

    /// Stops the server, and serves the page at the same port again after something was done.
    pub(crate) fn restart(&mut self, between: impl FnOnce()) {
        let port = self.host().rsplit(':').next().unwrap().parse().unwrap();
        let start = |port: u16| {
            let (messages, options) = (self.running.subscribe(Interest::readings()), PageOptions::default());
            let options = PageOptions { port: Some(port), ..options };
            Page::start(options, self.running.handles(), messages, self.actions.clone()).unwrap()
        };
        let other = start(0);
        std::mem::replace(&mut self.page, other).stop();
        between();
        let page = start(port);
        self.page = page;
    }

    /// As in `127.0.0.1:8090`.
    pub(crate) fn host(&self) -> String {
        self.page.url().trim_start_matches("http://").trim_end_matches('/').to_owned()
    }

    /// An open page.
    pub(crate) fn open(&self) -> Socket {
        let (socket, _) = tungstenite::connect(format!("ws://{}/ws", self.host())).unwrap();
        Socket(socket)
    }
}

/// The connection of one page.
pub(crate) struct Socket(WebSocket<MaybeTlsStream<TcpStream>>);

impl Socket {
    pub(crate) fn send(&mut self, request: &str) {
        self.0.send(Message::text(request)).unwrap();
    }

    /// The next text of this kind.
    pub(crate) fn text(&mut self, kind: &str) -> Value {
        loop {
            if let Message::Text(text) = self.0.read().unwrap() {
                let value: Value = serde_json::from_str(&text).unwrap();
                if let Some(value) = value.get(kind) {
                    return value.clone();
                }
            }
        }
    }

    /// The next message with fields.
    pub(crate) fn fields(&mut self) -> Vec<u8> {
        loop {
            if let Message::Binary(bytes) = self.0.read().unwrap() {
                return bytes.to_vec();
            }
        }
    }

    /// Reads until the server ends the connection.
    pub(crate) fn until_closed(mut self) {
        while self.0.read().is_ok() {}
    }
}
