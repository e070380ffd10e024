//! The camera's image as JPEG: the camera's own bytes if it sends JPEG, otherwise encoded here.

use fingervision_image::Pixels;
use fingervision_source::{CameraCoding, CameraFrameDecoder, CameraLayout, EncodedFrame};
use jpeg_encoder::{ColorType, Encoder};

use crate::wire::Picture;

/// The JPEG quality, enough for viewing.
const QUALITY: u8 = 75;
/// Larger pictures are reduced to half their width and height, so that encoding takes a quarter of the time.
const MOST_COLUMNS: usize = 400;

/// Encodes the pictures of one sensor; owns its scratch memory.
#[derive(Default)]
pub(crate) struct PictureCoder {
    decoder: Option<(CameraLayout, CameraFrameDecoder)>,
    rgb: Vec<u8>,
    jpeg: Vec<u8>,
}

impl PictureCoder {
    /// The picture of a frame; empty if it cannot be decoded or encoded.
    pub(crate) fn code<'a>(&'a mut self, frame: &'a EncodedFrame) -> Picture<'a> {
        // Many cameras leave out the Huffman tables; browsers cannot decode such pictures.
        if frame.layout.coding == CameraCoding::MotionJpeg && has_huffman_tables(&frame.bytes) {
            return Picture { jpeg: &frame.bytes, is_whole_frame: true };
        }
        self.jpeg.clear();
        if self.try_code(frame).is_none() {
            self.jpeg.clear();
        }
        Picture { jpeg: &self.jpeg, is_whole_frame: true }
    }

    fn try_code(&mut self, frame: &EncodedFrame) -> Option<()> {
        if self.decoder.as_ref().is_none_or(|(layout, _)| *layout != frame.layout) {
            self.decoder = Some((frame.layout, CameraFrameDecoder::new(frame.layout)));
        }
        let (_, decoder) = self.decoder.as_mut()?;
        let pixels = decoder.decode(&frame.bytes).ok()?;
        let (width, height) = pixels.size();
        let step = if width > MOST_COLUMNS { 2 } else { 1 };
        let (columns, rows) = (width / step, height / step);
        self.rgb.clear();
        for y in 0..rows {
            for x in 0..columns {
                self.rgb.extend(mean(&pixels, x * step, y * step, step));
            }
        }
        let size = |side: usize| u16::try_from(side).ok();
        let encoder = Encoder::new(&mut self.jpeg, QUALITY);
        encoder.encode(&self.rgb, size(columns)?, size(rows)?, ColorType::Rgb).ok()
    }
}

/// Whether a JPEG picture has its Huffman tables: the segment DHT before the first scan, SOS.
fn has_huffman_tables(jpeg: &[u8]) -> bool {
    const DHT: u8 = 0xc4;
    const SOS: u8 = 0xda;
    let mut at = 2;
    while let Some(&[0xff, marker, high, low]) = jpeg.get(at..).and_then(|rest| rest.first_chunk()) {
        match marker {
            DHT => return true,
            SOS => return false,
            _ => at += 2 + usize::from(u16::from_be_bytes([high, low])),
        }
    }
    false
}

/// The mean of a block of pixels, 8 bit.
fn mean(pixels: &Pixels, left: usize, top: usize, step: usize) -> [u8; 3] {
    let mut sum = [0.0_f32; 3];
    for y in top..top + step {
        for x in left..left + step {
            let levels = pixels.levels(x, y);
            sum.iter_mut().zip(levels).for_each(|(sum, level)| *sum += level);
        }
    }
    sum.map(|sum| (sum / (step * step) as f32).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fingervision_image::{Frame, Image};

    fn frame() -> EncodedFrame {
        let pixels = Pixels::Rgb8(Image::from_fn(640, 480, |x, y| [(x / 3) as u8, (y / 2) as u8, 90]));
        let mut encoded = EncodedFrame::empty();
        encoded.load(&Frame { sequence: 0, capture_time_s: 0.0, pixels });
        encoded
    }

    fn decoded(jpeg: &[u8], width: usize, height: usize) -> Result<Pixels, String> {
        let layout = CameraLayout { coding: CameraCoding::MotionJpeg, width, height, row_bytes: 0 };
        CameraFrameDecoder::new(layout).decode(jpeg)
    }

    #[test]
    fn raw_frames_are_coded_at_half_their_size() {
        let mut coder = PictureCoder::default();
        let pixels = decoded(coder.code(&frame()).jpeg, 320, 240).unwrap();
        let [red, green, blue] = pixels.levels(150, 120);
        assert!((red - 100.0).abs() < 4.0 && (green - 120.0).abs() < 4.0 && (blue - 90.0).abs() < 4.0);
    }

    #[test]
    fn a_camera_s_own_jpeg_is_passed_on_if_a_browser_can_decode_it() {
        let mut coder = PictureCoder::default();
        let jpeg = coder.code(&frame()).jpeg.to_vec();
        let layout = CameraLayout { coding: CameraCoding::MotionJpeg, width: 320, height: 240, row_bytes: 0 };
        let own = EncodedFrame { layout, bytes: jpeg.clone(), ..EncodedFrame::empty() };
        assert_eq!(PictureCoder::default().code(&own).jpeg, jpeg);
        assert!(has_huffman_tables(&jpeg));
        let mut without = jpeg.clone();
        // Every DHT segment is left out, as in the frames of many cameras.
        while let Some(at) = without.windows(2).position(|pair| pair == [0xff, 0xc4]) {
            let length = usize::from(u16::from_be_bytes([without[at + 2], without[at + 3]]));
            without.drain(at..at + 2 + length);
        }
        assert!(!has_huffman_tables(&without));
        let bare = EncodedFrame { layout, bytes: without, ..EncodedFrame::empty() };
        assert!(has_huffman_tables(PictureCoder::default().code(&bare).jpeg));
    }

    #[test]
    fn a_damaged_frame_has_no_picture() {
        let mut damaged = frame();
        damaged.bytes.truncate(100);
        assert!(PictureCoder::default().code(&damaged).jpeg.is_empty());
    }
}
