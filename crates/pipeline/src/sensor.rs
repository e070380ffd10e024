//! One sensor: its input, its profile and its tracker.

use std::sync::Arc;
use std::time::{Duration, Instant};

use fingervision_image::{Frame, Pixels};
use fingervision_source::{CameraFrameDecoder, EncodedFrame};
use fingervision_touch::{Fields, Profile, Tracker};

use crate::captured::Captured;
use crate::next::Next;
use crate::shared::Shared;
use crate::{Input, PipelineError, SensorCounts};

/// Longest time for one attempt to get the first frame.
const FIRST_FRAME: Duration = Duration::from_secs(5);
/// After this time without a usable frame no further attempt is made.
const LONGEST_START: Duration = Duration::from_secs(10);
/// Largest number of attempts to get the first usable frame: a camera's first frames are often cut off.
const MOST_DAMAGED: usize = 10;

/// A sensor that is ready to start: its first frame has arrived, and its profile fits this frame.
pub struct Sensor {
    pub(crate) input: Input,
    pub(crate) tracker: Option<Tracker>,
    pub(crate) decoder: CameraFrameDecoder,
    /// The first frame, which was not tracked yet, as it came and decoded.
    pub(crate) first: (Captured, Frame),
    pub(crate) handle: SensorHandle,
}

/// A handle of a running sensor: its properties, its counts and requests to it. Clones refer to the same sensor.
#[derive(Debug, Clone)]
pub struct SensorHandle {
    name: Arc<str>,
    description: Arc<str>,
    profile: Arc<Profile>,
    scene_toml: Option<Arc<str>>,
    fields: Fields,
    size: (usize, usize),
    frame_size: (usize, usize),
    is_tracked: bool,
    pub(crate) shared: Arc<Shared>,
}

impl Sensor {
    /// Waits for the first frame, and makes the tracker for it.
    ///
    /// # Errors
    ///
    /// [`PipelineError`] if no frame comes that can be decoded, or the profile does not fit it.
    pub fn open(name: &str, mut profile: Profile, mut input: Input, fields: Fields) -> Result<Self, PipelineError> {
        // Part of the profile, so that a recording is tracked in the same way.
        profile.flow.colour &= input.has_full_colour();
        let mut first = EncodedFrame::empty();
        let (start, mut failure) = (Instant::now(), None);
        for _ in 0..MOST_DAMAGED {
            if start.elapsed() > LONGEST_START {
                break;
            }
            let captured_s = match input.next(FIRST_FRAME, &mut first) {
                Next::Frame { captured_s } => captured_s,
                Next::Event(text) | Next::Damaged(text) => {
                    failure.get_or_insert(text);
                    continue;
                }
                Next::Nothing => continue,
                Next::End(Some(error)) => return Err(error),
                Next::End(None) => break,
            };
            let mut decoder = CameraFrameDecoder::for_tracking(first.layout);
            match decoder.decode(&first.bytes) {
                Ok(pixels) => {
                    let tracker = Tracker::new(&profile, pixels.size(), pixels.is_colour(), fields)?;
                    let handle = SensorHandle::new(name, &input, profile, fields, &tracker, &pixels);
                    let frame = frame_of(&first, pixels);
                    let first = (Captured { frame: Arc::new(first), captured_s, truth: input.truth() }, frame);
                    return Ok(Self { input, tracker: Some(tracker), decoder, first, handle });
                }
                Err(reason) => failure = Some(reason),
            }
        }
        let reason = failure.unwrap_or_else(|| "none arrived".into());
        Err(PipelineError::NoFrame { sensor: name.into(), reason })
    }

    /// The same sensor, whose frames are captured and not tracked: it has frames and events, no readings.
    #[must_use]
    pub fn without_tracking(mut self) -> Self {
        (self.tracker, self.handle.is_tracked) = (None, false);
        self
    }

    /// The sensor's handle.
    #[must_use]
    pub fn handle(&self) -> &SensorHandle {
        &self.handle
    }

    /// Remarks of the camera or the source, one sentence each.
    #[must_use]
    pub fn remarks(&self) -> Vec<String> {
        self.input.remarks()
    }
}

/// A frame of these pixels.
fn frame_of(encoded: &EncodedFrame, pixels: Pixels) -> Frame {
    Frame { sequence: encoded.sequence, capture_time_s: encoded.capture_time_s, pixels }
}

impl SensorHandle {
    fn new(name: &str, input: &Input, profile: Profile, fields: Fields, tracker: &Tracker, pixels: &Pixels) -> Self {
        Self {
            name: name.into(),
            description: input.description().into(),
            profile: Arc::new(profile),
            scene_toml: input.scene_toml().map(Into::into),
            fields,
            size: tracker.size(),
            frame_size: pixels.size(),
            is_tracked: true,
            shared: Arc::default(),
        }
    }

    /// The sensor's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// One line that describes the source of its frames.
    #[must_use]
    pub fn description(&self) -> &str {
        &self.description
    }

    /// The profile in use.
    #[must_use]
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// The scene that it shows, as TOML, if it is simulated.
    #[must_use]
    pub fn scene_toml(&self) -> Option<&str> {
        self.scene_toml.as_deref()
    }

    /// The fields that its readings have.
    #[must_use]
    pub fn fields(&self) -> Fields {
        self.fields
    }

    /// Columns and rows of the reference grid, px.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        self.size
    }

    /// Columns and rows of the camera's frames, px.
    #[must_use]
    pub fn frame_size(&self) -> (usize, usize) {
        self.frame_size
    }

    /// Whether its frames are tracked.
    #[must_use]
    pub fn is_tracked(&self) -> bool {
        self.is_tracked
    }

    /// Counts of its frames so far.
    #[must_use]
    pub fn counts(&self) -> SensorCounts {
        self.shared.counts()
    }

    /// The frame to which displacement, depth and force are relative, and when it was captured, s of
    /// [`host_time_s`](crate::host_time_s); absent before the first reading.
    #[must_use]
    pub fn reference(&self) -> Option<(Arc<EncodedFrame>, f64)> {
        self.shared.reference().map(|Captured { frame, captured_s, .. }| (frame, captured_s))
    }

    /// Makes the next frame the new reference: from there on displacement, depth and force are relative to it.
    pub fn rezero(&self) {
        self.shared.ask_rezero();
    }

    /// Whether the sensor has ended.
    #[must_use]
    pub fn is_ended(&self) -> bool {
        self.shared.is_ended()
    }
}
