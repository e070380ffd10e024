//! The part of a recording that is tracked and written.

use std::fmt;

use serde::Serialize;

use crate::failure::Failure;
use crate::whole_number::whole_number;

#[derive(Debug, Clone, Copy, clap::Args)]
pub(crate) struct PartArgs {
    /// Write only the readings of these frames: from A up to but not including B, as in 100..200, 100.. or ..200
    ///
    /// Frames are numbered as in readings.csv: from 0, or as in the names of the images. Tracking still begins at the
    /// reference frame, so that the readings are identical, bit for bit, to those of the whole recording, with the same
    /// numbers and times. To save the time until A, name a later frame that shows the gel untouched with
    /// --reference-frame.
    #[arg(long, value_name = "A..B", value_parser = frames)]
    frames: Option<Frames>,
    /// The frame that shows the gel untouched: tracking begins with it, and displacement is relative to it
    ///
    /// Without it the first one of the recording.
    #[arg(long, value_name = "N", value_parser = whole_number::<u64>)]
    reference_frame: Option<u64>,
}

/// Frames from the first up to but not including the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Frames {
    first: u64,
    end: Option<u64>,
}

/// The part of a recording that is tracked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub(crate) struct Part {
    /// The first frame tracked; absent: the first of the recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) reference: Option<u64>,
    /// The first frame written.
    pub(crate) first: u64,
    /// The frame after the last.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) end: Option<u64>,
}

impl PartArgs {
    /// The requested part.
    ///
    /// # Errors
    ///
    /// A reference after the first frame to write.
    pub(crate) fn part(self) -> Result<Part, Failure> {
        let reference = self.reference_frame;
        let frames = self.frames.unwrap_or(Frames { first: reference.unwrap_or(0), end: None });
        let Some(reference_frame) = reference.filter(|&reference| reference > frames.first) else {
            return Ok(Part { reference, first: frames.first, end: frames.end });
        };
        Err(Failure::new(
            format!("--reference-frame {reference_frame} comes after the first frame of --frames {frames}"),
            "name a frame before the part, or its first one",
        ))
    }
}

impl Part {
    /// Whether it is the whole recording.
    pub(crate) fn is_whole(&self) -> bool {
        *self == Self::default()
    }

    /// Whether a frame is written.
    pub(crate) fn is_written(&self, sequence: u64) -> bool {
        sequence >= self.first
    }

    /// Whether a frame is after the part.
    pub(crate) fn is_behind(&self, sequence: u64) -> bool {
        self.end.is_some_and(|end| sequence >= end)
    }

    /// Tests whether a recording with this last frame contains the reference and a frame of the part.
    ///
    /// # Errors
    ///
    /// [`Self::without_reference`] or [`Self::absent`].
    pub(crate) fn expect_within(&self, last: u64) -> Result<(), Failure> {
        if let Some(reference) = self.reference.filter(|&reference| reference > last) {
            return Err(Self::without_reference(reference, Some(last)));
        }
        if self.first > last { Err(self.absent(Some(last))) } else { Ok(()) }
    }

    /// The error of a recording that ends before the reference frame.
    pub(crate) fn without_reference(reference: u64, last: Option<u64>) -> Failure {
        Failure::new(
            format!("the recording has no frame {reference} to begin with{}", ending(last)),
            "use --reference-frame with a frame that shows the gel untouched",
        )
    }

    /// The error of a recording that contains none of the frames.
    pub(crate) fn absent(&self, last: Option<u64>) -> Failure {
        let hint = "name frames that it contains: readings.csv of a run over the whole recording lists them";
        Failure::new(format!("the recording has no frame in --frames {}{}", self.frames(), ending(last)), hint)
    }

    /// The error of a run that is interrupted before the first frame of the part.
    pub(crate) fn interrupted(&self) -> Failure {
        let message = format!("interrupted before the first frame of --frames {}: nothing is written", self.frames());
        Failure::new(message, "run the command again")
    }

    fn frames(&self) -> Frames {
        Frames { first: self.first, end: self.end }
    }

    /// Upper limit of the number of frames written, for a recording of this length.
    pub(crate) fn written(&self, count: Option<u64>) -> Option<u64> {
        let part = self.end.map(|end| end - self.first);
        count.map_or(part, |count| Some(part.map_or(count, |part| part.min(count))))
    }

    /// Number of frames tracked, for a recording of this length; known only for the whole recording, because numbers
    /// may have gaps.
    pub(crate) fn tracked(&self, count: Option<u64>) -> Option<u64> {
        count.filter(|_| self.is_whole())
    }
}

impl fmt::Display for Frames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..", self.first)?;
        self.end.map_or(Ok(()), |end| write!(f, "{end}"))
    }
}

/// Where a recording ends, if that is known.
fn ending(last: Option<u64>) -> String {
    last.map_or_else(String::new, |last| format!(": its last one is frame {last}"))
}

fn frames(text: &str) -> Result<Frames, String> {
    let number = |text: &str| text.trim().parse::<u64>().ok();
    let parse = || {
        let (first, end) = text.split_once("..")?;
        let first = if first.is_empty() { 0 } else { number(first)? };
        let end = if end.is_empty() { None } else { Some(number(end)?) };
        end.is_none_or(|end| end > first).then_some(Frames { first, end })
    };
    parse().ok_or_else(|| "expected A..B with A below B, as in 100..200, 100.. or ..200".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn either_end_may_be_left_open() {
        for (text, first, end) in [("3..7", 3, Some(7)), ("3..", 3, None), ("..7", 0, Some(7)), ("..", 0, None)] {
            assert_eq!(frames(text), Ok(Frames { first, end }), "{text}");
        }
    }

    #[test]
    fn what_is_no_part_is_refused() {
        for text in ["", "3", "7..3", "3..3", "-1..3", "a..b", "3..=7"] {
            assert!(frames(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_part_must_begin_before_the_recording_ends() {
        let part = |reference, first| Part { reference, first, end: None };
        assert!(part(None, 3).expect_within(3).is_ok() && part(Some(3), 3).expect_within(3).is_ok());
        let message = |part: Part| part.expect_within(3).unwrap_err().to_string();
        let expected = "the recording has no frame in --frames 4..: its last one is frame 3";
        assert_eq!(message(part(Some(3), 4)), expected);
        let expected = "the recording has no frame 4 to begin with: its last one is frame 3";
        assert_eq!(message(part(Some(4), 4)), expected);
    }

    #[test]
    fn no_more_is_written_than_the_part_and_the_recording_have() {
        let part = |end| Part { reference: None, first: 3, end };
        assert_eq!(part(Some(10)).written(Some(100)), Some(7));
        assert_eq!(part(Some(10)).written(None), Some(7));
        assert_eq!(part(Some(10)).written(Some(5)), Some(5));
        assert_eq!(part(None).written(Some(5)), Some(5));
        assert_eq!(part(None).written(None), None);
    }
}
