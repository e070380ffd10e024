//! A sensor that sees a moving pattern.

use fingervision_image::{Frame, Image, Pixels};
use fingervision_pipeline::{Input, Pace, Pipeline, Running, Sensor};
use fingervision_source::{Source, SourceError};
use fingervision_touch::{Fields, Profile};

const SIZE: usize = 96;

/// A pattern that moves to and fro by a pixel, without end.
struct Film(u64);

impl Source for Film {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        let sequence = self.0;
        self.0 += 1;
        let value = |x: usize, y: usize| {
            let (x, y) = (x as u64 + sequence % 2, y as u64);
            ((x / 5 * 2_654_435_761) ^ (y / 5 * 40_503_000_003)).wrapping_mul(0x9e37_79b9_7f4a_7c15).to_be_bytes()[0]
        };
        let pixels = Pixels::Grey8(Image::from_fn(SIZE, SIZE, value));
        Ok(Some(Frame { sequence, capture_time_s: sequence as f64 / 50.0, pixels }))
    }

    fn frame_count(&self) -> Option<u64> {
        None
    }

    fn size(&self) -> (usize, usize) {
        (SIZE, SIZE)
    }

    fn description(&self) -> String {
        "a film".into()
    }
}

pub(crate) fn start(name: &str) -> Running {
    let input = Input::source(Box::new(Film(0)), Pace::Recorded);
    let sensor = Sensor::open(name, Profile::default(), input, Fields::NONE).unwrap();
    Pipeline::prepare(vec![sensor]).start().unwrap()
}
