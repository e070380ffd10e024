//! The interface of all video codecs.

use crate::motion_jpeg::MotionJpeg;
use fingervision_image::{Image, Pixels};

/// Turns one sample into one picture; samples come in decoding order.
pub(crate) trait Decoder: Send {
    fn decode(&mut self, sample: &[u8]) -> Result<Pixels, String>;

    /// Whether a sample can be decoded without those before it.
    fn is_key(&self, sample: &[u8]) -> bool;
}

impl Decoder for MotionJpeg {
    fn decode(&mut self, sample: &[u8]) -> Result<Pixels, String> {
        let mut pixels = Pixels::Grey8(Image::filled(0, 0, 0));
        self.decode_into(sample, false, &mut pixels).map(|()| pixels)
    }

    fn is_key(&self, _: &[u8]) -> bool {
        true
    }
}
