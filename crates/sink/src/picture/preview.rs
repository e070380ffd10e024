//! The picture of a run: its strongest frame, and flow, depth and force over time.

use std::path::Path;

use fingervision_image::{Frame, Image, Rect};
use fingervision_plot::Rgb;
use fingervision_touch::Reading;

use super::course::Course;
use super::page;
use super::strongest::{Strength, Strongest};
use super::write_png;
use crate::{Sink, SinkError};

/// The properties of the sensor that a preview needs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PreviewOptions {
    /// The region of the fields in the camera image, px; the whole of it if absent.
    pub region: Option<Rect>,
    /// Size of a pixel on the gel, mm; the scale bar is in px if absent.
    pub mm_per_px: Option<f32>,
}

/// Keeps the frame with the largest mean flow and draws it, 1600 px wide.
///
/// Left, the camera image with flow arrows; in the middle, the flow as colour with its wheel; right, depth, or the
/// density feature, or the flow's length, whichever of these is first in the reading, with the outline of the contact
/// where that is known. Below, over time, the mean flow, depth and force, as far as they are known. Frames that lost
/// track are not candidates. Memory does not grow with the run.
#[derive(Debug)]
pub struct Preview {
    options: PreviewOptions,
    strongest: Strongest,
    course: Course,
}

impl Preview {
    /// A preview without readings.
    #[must_use]
    pub fn new(options: PreviewOptions) -> Self {
        Self { options, strongest: Strongest::none(), course: Course::new() }
    }

    /// The picture of the readings so far.
    ///
    /// # Errors
    ///
    /// [`SinkError::NoReadings`] if there were none.
    pub fn draw(&self) -> Result<Image<Rgb>, SinkError> {
        if self.course.frames() == 0 {
            return Err(SinkError::NoReadings);
        }
        Ok(page::draw(&self.strongest, &self.course, self.options.mm_per_px))
    }

    /// Writes the picture of the readings so far as PNG.
    ///
    /// # Errors
    ///
    /// [`SinkError::NoReadings`] if nothing was seen, [`SinkError::Write`] if the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), SinkError> {
        write_png(&self.draw()?, path)
    }
}

impl Sink for Preview {
    /// Takes a reading and keeps a copy if it is the strongest so far.
    ///
    /// # Errors
    ///
    /// [`SinkError::SizeMismatch`] if the fields do not cover the frame's region of interest.
    fn write(&mut self, reading: &Reading, frame: &Frame) -> Result<(), SinkError> {
        let strength = Strength::of(reading);
        if self.course.frames() == 0 || strength.exceeds(self.strongest.strength) {
            let (width, height) = frame.pixels.size();
            let region = self.options.region.unwrap_or(Rect::whole(width, height));
            self.strongest.copy_from(reading, frame, region)?;
            (self.strongest.strength, self.strongest.frame) = (strength, self.course.frames());
        }
        self.course.push(reading, strength.mean_px);
        Ok(())
    }
}
