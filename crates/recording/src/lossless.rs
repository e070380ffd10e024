//! Stores the bytes of a frame without loss: unchanged, or as a lossless `WebP` picture of its planes.
//!
//! A picture format predicts each value from its neighbours, so the bytes are arranged in planes of values of the same
//! kind: luma above both chromas, low bytes above high bytes. Frames with padding between their rows, which few cameras
//! send, and frames that do not become smaller are stored unchanged.

use std::io::Cursor;

use fingervision_source::{CameraCoding, CameraLayout};
use image_webp::{ColorType, WebPDecoder, WebPEncoder};

/// The largest width and height of a `WebP` picture, px.
const LARGEST_PICTURE: usize = 16383;
/// Longer frames, bytes, are stored unchanged, so that a damaged file cannot request any amount of memory.
const LONGEST_FRAME: usize = 1 << 27;

/// How the bytes of a frame are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Storage {
    /// In the image message.
    Image,
    /// As they are.
    Raw,
    /// As a lossless `WebP` picture.
    WebP,
}

impl Storage {
    const ALL: [Self; 3] = [Self::Image, Self::Raw, Self::WebP];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Image => "image",
            Self::Raw => "raw",
            Self::WebP => "webp",
        }
    }

    pub(crate) fn of(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|storage| storage.name() == name)
    }
}

/// The picture that the planes of a frame make.
#[derive(Debug, Clone, Copy)]
struct Picture {
    width: usize,
    height: usize,
    is_colour: bool,
}

impl Picture {
    /// The picture for frames of this layout and length; absent for JPEG and where rows are padded.
    fn of(layout: CameraLayout, len: usize) -> Option<Self> {
        let CameraLayout { coding, width, height, .. } = layout;
        let (width, height, is_colour) = match coding {
            CameraCoding::MotionJpeg => return None,
            CameraCoding::Yuyv { .. } => (2 * width.div_ceil(2), height.checked_mul(2)?, false),
            CameraCoding::Grey8 => (width, height, false),
            CameraCoding::Grey16 => (width, height.checked_mul(2)?, false),
            CameraCoding::Rgb8 => (width, height, true),
            CameraCoding::Rgb16 => (width, height.checked_mul(2)?, true),
        };
        let sides = 1..=LARGEST_PICTURE;
        let is_possible = sides.contains(&width) && sides.contains(&height) && len <= LONGEST_FRAME;
        let picture = Self { width, height, is_colour };
        (is_possible && picture.len() == len).then_some(picture)
    }

    fn row_len(self) -> usize {
        self.width * if self.is_colour { 3 } else { 1 }
    }

    fn len(self) -> usize {
        self.row_len() * self.height
    }
}

/// Encodes frames; owns its scratch memory.
#[derive(Debug, Default)]
pub(crate) struct Encoder {
    planes: Vec<u8>,
    stored: Vec<u8>,
}

impl Encoder {
    /// The stored bytes of a frame that is not JPEG.
    pub(crate) fn encode<'a>(&'a mut self, layout: CameraLayout, bytes: &'a [u8]) -> (Storage, &'a [u8]) {
        let Some(picture) = Picture::of(layout, bytes.len()) else { return (Storage::Raw, bytes) };
        let planes = match layout.coding {
            CameraCoding::Grey8 | CameraCoding::Rgb8 | CameraCoding::MotionJpeg => bytes,
            coding => {
                self.planes.clear();
                separate(coding, picture.row_len(), bytes, &mut self.planes);
                &self.planes
            }
        };
        self.stored.clear();
        let colours = if picture.is_colour { ColorType::Rgb8 } else { ColorType::L8 };
        let encoder = WebPEncoder::new(&mut self.stored);
        let done = encoder.encode(planes, picture.width as u32, picture.height as u32, colours);
        if done.is_ok() && self.stored.len() < bytes.len() {
            (Storage::WebP, &self.stored)
        } else {
            (Storage::Raw, bytes)
        }
    }
}

/// The bytes of a frame that was stored as a `WebP` picture.
///
/// # Errors
///
/// A sentence on what is wrong with it.
pub(crate) fn decode(layout: CameraLayout, len: usize, stored: &[u8], into: &mut Vec<u8>) -> Result<(), String> {
    let picture = Picture::of(layout, len).ok_or("its length does not fit its layout")?;
    let mut decoder = WebPDecoder::new(Cursor::new(stored)).map_err(|error| error.to_string())?;
    if decoder.dimensions() != (picture.width as u32, picture.height as u32) {
        return Err("its picture has another size".into());
    }
    let channels = if decoder.has_alpha() { 4 } else { 3 };
    let mut pixels = vec![0; channels * picture.width * picture.height];
    decoder.read_image(&mut pixels).map_err(|error| error.to_string())?;
    into.clear();
    let planes: Vec<u8> = match (picture.is_colour, channels) {
        (true, 3) => pixels,
        (true, _) => pixels.chunks_exact(channels).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect(),
        (false, _) => pixels.chunks_exact(channels).map(|pixel| pixel[1]).collect(),
    };
    match layout.coding {
        CameraCoding::Grey8 | CameraCoding::Rgb8 | CameraCoding::MotionJpeg => into.extend_from_slice(&planes),
        coding => unite(coding, picture.row_len(), &planes, into),
    }
    Ok(())
}

/// Appends the planes of a frame.
fn separate(coding: CameraCoding, row_len: usize, bytes: &[u8], planes: &mut Vec<u8>) {
    planes.extend(bytes.iter().step_by(2));
    if matches!(coding, CameraCoding::Yuyv { .. }) {
        // A row of chroma: the blue one, then the red one.
        for row in bytes.chunks(2 * row_len) {
            planes.extend(row.iter().skip(1).step_by(4));
            planes.extend(row.iter().skip(3).step_by(4));
        }
    } else {
        planes.extend(bytes.iter().skip(1).step_by(2));
    }
}

/// Appends the frame of these planes: the inverse of [`separate`].
fn unite(coding: CameraCoding, row_len: usize, planes: &[u8], bytes: &mut Vec<u8>) {
    let (first, second) = planes.split_at(planes.len() / 2);
    if !matches!(coding, CameraCoding::Yuyv { .. }) {
        bytes.extend(first.iter().zip(second).flat_map(|(low, high)| [*low, *high]));
        return;
    }
    for (luma, chroma) in first.chunks(row_len).zip(second.chunks(row_len)) {
        let (blue, red) = chroma.split_at(row_len / 2);
        let pairs = luma.as_chunks::<2>().0.iter().zip(blue).zip(red);
        bytes.extend(pairs.flat_map(|((luma, blue), red)| [luma[0], *blue, luma[1], *red]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(coding: CameraCoding, width: usize, height: usize) -> CameraLayout {
        CameraLayout { coding, width, height, row_bytes: 0 }
    }

    fn smooth(len: usize) -> Vec<u8> {
        (0..len).map(|index| (index / 7 % 256) as u8 ^ (index % 3) as u8).collect()
    }

    #[test]
    fn frames_of_every_coding_come_back_bit_by_bit() {
        let codings = [
            (CameraCoding::Yuyv { is_full_range: false }, 4 * 16),
            (CameraCoding::Grey8, 31),
            (CameraCoding::Grey16, 62),
            (CameraCoding::Rgb8, 93),
            (CameraCoding::Rgb16, 186),
        ];
        let mut encoder = Encoder::default();
        for (coding, row_len) in codings {
            let layout = layout(coding, 31, 20);
            let bytes = smooth(20 * row_len);
            let (storage, stored) = encoder.encode(layout, &bytes);
            assert_eq!(storage, Storage::WebP, "{coding:?}");
            assert!(stored.len() < bytes.len());
            let mut decoded = vec![1];
            decode(layout, bytes.len(), stored, &mut decoded).unwrap();
            assert_eq!(decoded, bytes, "{coding:?}");
        }
    }

    #[test]
    fn what_is_no_picture_is_stored_as_it_is() {
        let mut encoder = Encoder::default();
        let grey = layout(CameraCoding::Grey8, 8, 8);
        for bytes in [smooth(63), smooth(65), Vec::new()] {
            assert_eq!(encoder.encode(grey, &bytes), (Storage::Raw, bytes.as_slice()));
        }
        let noise: Vec<u8> = (0..64_u32).map(|index| (index.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        assert_eq!(encoder.encode(grey, &noise).0, Storage::Raw, "noise does not become smaller");
    }

    #[test]
    fn a_picture_of_another_size_is_refused() {
        let grey = layout(CameraCoding::Grey8, 64, 8);
        let bytes = smooth(512);
        let mut encoder = Encoder::default();
        let (_, stored) = encoder.encode(grey, &bytes);
        let mut decoded = Vec::new();
        assert!(decode(layout(CameraCoding::Grey8, 8, 64), 512, stored, &mut decoded).is_err());
        assert!(decode(grey, 511, stored, &mut decoded).is_err());
        assert!(decode(grey, 512, &stored[..20], &mut decoded).is_err());
    }
}
