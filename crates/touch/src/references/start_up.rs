//! Decides whether the gel was pressed when tracking began.
//!
//! The motion is observed until it shows whether the gel was at rest or pressed in the first image ([`FirstMotion`]).
//! As long as this is not decided, no flag is raised.
//!
//! The elastic model, if there is one, can also decide. It cannot explain a release as an indentation, for any gel. If
//! it explains several consecutive frames as an indentation, the gel was at rest in the first image.
//!
//! A gel that is pressed in the first image and then pressed harder looks like one at rest, until it is released: then it is still, the
//! elastic model finds no indentation, and the flow is that of a release. From then on the first image is known to be wrong. It is
//! not replaced without being asked: what is seen here may also be a press that the model does not explain.

use fingervision_flow::{Estimate, FlowHistory};

use super::first_motion::{FirstImage, FirstMotion};
use super::thresholds::THRESHOLDS;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Nothing has moved yet, or the motion does not decide.
    Undecided,
    /// The reference showed the gel pressed.
    Pressed {
        /// Number of consecutive frames without motion.
        still: u64,
    },
    /// The reference shows the gel at rest.
    Settled,
    /// It seemed so, but a later release showed that the gel was pressed.
    Refuted,
}

/// Observes the first motion.
#[derive(Debug)]
pub(crate) struct StartUp {
    state: State,
    first_motion: FirstMotion,
    rest_frames: u64,
    /// Number of consecutive frames, up to the last one, that the elastic model explains as an indentation.
    explained: u64,
    /// Whether there is an elastic model.
    has_model: bool,
    /// Number of consecutive frames without motion and without an indentation.
    idle: u64,
}

impl StartUp {
    /// For a camera with this centre of perspective, px.
    pub(crate) fn new(rest_frames: u64, centre_px: [f32; 2]) -> Self {
        Self {
            state: State::Undecided,
            first_motion: FirstMotion::new(centre_px),
            rest_frames,
            explained: 0,
            has_model: false,
            idle: 0,
        }
    }

    /// Forgets the frames so far: tracking begins again.
    pub(crate) fn restart(&mut self) {
        self.state = State::Undecided;
        (self.explained, self.idle) = (0, 0);
    }

    /// Whether the reference showed a pressed gel, according to the frames so far.
    pub(crate) fn is_pressed(&self) -> bool {
        self.state == State::Refuted || self.explained == 0 && matches!(self.state, State::Pressed { .. })
    }

    /// Whether a gel that was pressed at the start has been still for long enough and is not held pressed by an object.
    pub(crate) fn has_come_to_rest(&self) -> bool {
        self.explained == 0 && matches!(self.state, State::Pressed { still } if still >= self.rest_frames)
    }

    /// Stores whether the elastic model explains the last frame as an indentation.
    pub(crate) fn note_press(&mut self, is_press: bool) {
        self.has_model = true;
        self.explained = if is_press { self.explained + 1 } else { 0 };
        if self.explained >= THRESHOLDS.explained_frames && self.state != State::Refuted {
            self.state = State::Settled;
        }
    }

    /// To be called when the reference has been replaced by one at rest.
    pub(crate) fn settle(&mut self) {
        self.state = State::Settled;
    }

    /// Takes a frame that was found, which is the last one of the history.
    pub(crate) fn watch(&mut self, history: &FlowHistory, now: &Estimate) {
        let is_still = || history.largest_change_px() < THRESHOLDS.still_px;
        match &mut self.state {
            State::Refuted => {}
            State::Settled => {
                self.idle = if self.has_model && self.explained == 0 && is_still() { self.idle + 1 } else { 0 };
                let is_due = self.idle > 0 && self.idle.is_multiple_of(self.rest_frames);
                if is_due && self.first_motion.judge(now) == Some(FirstImage::Pressed) {
                    self.state = State::Refuted;
                }
            }
            State::Undecided => match self.first_motion.judge(now) {
                Some(FirstImage::Pressed) => self.state = State::Pressed { still: 0 },
                Some(FirstImage::AtRest) => self.state = State::Settled,
                None => {}
            },
            State::Pressed { still } => {
                *still = if is_still() { *still + 1 } else { 0 };
            }
        }
    }
}
