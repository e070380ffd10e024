//! A moving pattern as a source.

use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Frame, Pixels};
use fingervision_source::{Source, SourceError};
use std::sync::mpsc::{Receiver, Sender, channel};

/// Columns and rows, px.
pub(crate) const SIZE: (usize, usize) = (96, 80);

/// Frames that exist already.
pub(crate) struct Film {
    frames: std::vec::IntoIter<Frame>,
    /// The number of the frame that waits for a word, and where that comes from.
    gate: Option<(u64, Receiver<()>)>,
    /// The number of the frame that cannot be read.
    damaged: Option<u64>,
}

impl Film {
    /// A pattern that is pushed further in every frame, `rate` frames a second.
    pub(crate) fn of(count: u64, rate: f64) -> Vec<Frame> {
        let sheet = Sheet { width: SIZE.0, height: SIZE.1, ..Sheet::default() };
        let renderer = SheetRenderer::new(&sheet).unwrap();
        let frame = |sequence: u64| Frame {
            sequence,
            capture_time_s: sequence as f64 / rate,
            pixels: Pixels::Rgb8(
                renderer.render(&Motion::shift(0.3 * sequence as f64), Light::EVEN, sequence).unwrap(),
            ),
        };
        (0..count).map(frame).collect()
    }

    pub(crate) fn source(frames: Vec<Frame>) -> Box<dyn Source> {
        Box::new(Self { frames: frames.into_iter(), gate: None, damaged: None })
    }

    /// As [`Film::source`], but frame `number` cannot be read.
    pub(crate) fn damaged(frames: Vec<Frame>, number: u64) -> Box<dyn Source> {
        Box::new(Self { frames: frames.into_iter(), gate: None, damaged: Some(number) })
    }

    /// As [`Film::source`], but frame `number` comes only after something is sent.
    pub(crate) fn gated(frames: Vec<Frame>, number: u64) -> (Box<dyn Source>, Sender<()>) {
        let (open, gate) = channel();
        (Box::new(Self { frames: frames.into_iter(), gate: Some((number, gate)), damaged: None }), open)
    }
}

impl Source for Film {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        let next = self.frames.next();
        if let (Some(frame), Some((number, gate))) = (&next, &self.gate)
            && frame.sequence == *number
        {
            gate.recv().unwrap();
        }
        if next.as_ref().map(|frame| frame.sequence) == self.damaged && self.damaged.is_some() {
            return Err(SourceError::NotFound { path: "frame.png".into() });
        }
        Ok(next)
    }

    fn resume(&mut self) -> bool {
        true
    }

    fn frame_count(&self) -> Option<u64> {
        Some(self.frames.len() as u64)
    }

    fn size(&self) -> (usize, usize) {
        SIZE
    }

    fn description(&self) -> String {
        "a film".into()
    }
}
