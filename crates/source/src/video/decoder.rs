//! The interface of all video codecs.

use fingervision_image::Pixels;

/// Turns one sample into one picture; samples come in decoding order.
pub(crate) trait Decoder: Send {
    fn decode(&mut self, sample: &[u8]) -> Result<Pixels, String>;

    /// Whether a sample can be decoded without those before it.
    fn is_key(&self, sample: &[u8]) -> bool;
}
