//! Decodes the single frames of a camera: JPEG pictures, packed luma and chroma, grey, RGB.
//!
//! A camera delivers bytes in a known layout. Bytes that do not fit this layout are an error, never pixels: a frame
//! that is cut off must not be taken for a dark one.

use crate::FrameFormat;
use crate::guarded::guarded;
use crate::motion_jpeg::MotionJpeg;
use crate::reuse;
use crate::yuv::{Colour, Planes, YuvToRgb};
use fingervision_image::{Image, Pixels};

/// BT.601, by its number in ITU-T H.273: the matrix of USB cameras that name none.
const BT_601: u16 = 6;

/// How a camera codes the pixels of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CameraCoding {
    /// A JPEG picture, possibly without its Huffman tables.
    MotionJpeg,
    /// 4:2:2 in bytes `Y U Y V`; `is_full_range` if luma spans 0 to 255, not 16 to 235.
    Yuyv {
        /// Luma spans 0 to 255, not 16 to 235.
        is_full_range: bool,
    },
    /// A byte of luma per pixel.
    Grey8,
    /// 16 bits of luma per pixel, little-endian.
    Grey16,
    /// Bytes `R G B`.
    Rgb8,
    /// 16 bits each of red, green and blue, little-endian.
    Rgb16,
}

/// The layout of a camera's frames, as agreed on with its driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CameraLayout {
    /// How pixels are coded.
    pub coding: CameraCoding,
    /// Columns, px.
    pub width: usize,
    /// Rows, px.
    pub height: usize,
    /// Bytes from a row to the next; no meaning for JPEG. Zero: the rows follow each other without padding.
    pub row_bytes: usize,
}

impl CameraLayout {
    /// The bytes of a row that hold pixels; `None` for JPEG.
    fn used_row_bytes(&self) -> Option<usize> {
        match self.coding {
            CameraCoding::MotionJpeg => None,
            CameraCoding::Yuyv { .. } => Some(4 * self.width.div_ceil(2)),
            CameraCoding::Grey8 => Some(self.width),
            CameraCoding::Grey16 => Some(2 * self.width),
            CameraCoding::Rgb8 => Some(3 * self.width),
            CameraCoding::Rgb16 => Some(6 * self.width),
        }
    }
}

/// Converts the bytes of a camera's frames into pixels; owns its scratch memory.
pub struct CameraFrameDecoder {
    layout: CameraLayout,
    packed: Packed,
    jpeg: MotionJpeg,
    /// Of JPEG pictures with luma and chroma, luma alone is decoded.
    is_luma_alone: bool,
}

/// The conversion of packed luma and chroma.
enum Packed {
    /// There is none.
    None,
    Colour(Box<(YuvToRgb, Unpacked)>),
    /// The grey level of every luma.
    Luma(Box<[u8; 256]>),
}

impl CameraFrameDecoder {
    /// A decoder for frames of this layout: grey frames become grey pixels, all others red, green and blue.
    #[must_use]
    pub fn new(layout: CameraLayout) -> Self {
        let CameraLayout { coding, width, height, .. } = layout;
        let packed = match coding {
            CameraCoding::Yuyv { is_full_range } => {
                YuvToRgb::new(width, height, Colour { matrix: BT_601, is_full_range })
                    .map_or(Packed::None, |conversion| {
                        Packed::Colour(Box::new((conversion, Unpacked::new(width, height))))
                    })
            }
            _ => Packed::None,
        };
        Self { layout, packed, jpeg: MotionJpeg::default(), is_luma_alone: false }
    }

    /// As [`new`](Self::new), but with the luma alone, as grey pixels, of the codings that store colour coarsely: JPEG with
    /// luma and chroma, and YUYV. Flow from their colour has several times the error of flow from grey, and luma alone is
    /// decoded in half of the time.
    #[must_use]
    pub fn for_tracking(layout: CameraLayout) -> Self {
        let packed = match layout.coding {
            CameraCoding::Yuyv { is_full_range } => Packed::Luma(Box::new(grey_levels(is_full_range))),
            _ => Packed::None,
        };
        Self { layout, packed, jpeg: MotionJpeg::default(), is_luma_alone: true }
    }

    /// The layout of the frames that it decodes.
    #[must_use]
    pub fn layout(&self) -> CameraLayout {
        self.layout
    }

    /// The pixels of one frame. Bytes behind the last row are ignored, because some drivers append padding.
    ///
    /// # Errors
    ///
    /// A sentence on what is wrong with a damaged frame: not a JPEG picture, cut off, of another size.
    pub fn decode(&mut self, bytes: &[u8]) -> Result<Pixels, String> {
        let mut pixels = Pixels::Grey8(Image::filled(0, 0, 0));
        self.decode_into(bytes, &mut pixels).map(|()| pixels)
    }

    /// As [`decode`](Self::decode), into pixels that are used again: they are allocated only for the first frame, or
    /// where the format changes. After an error they have any values.
    ///
    /// # Errors
    ///
    /// As [`decode`](Self::decode).
    pub fn decode_into(&mut self, bytes: &[u8], pixels: &mut Pixels) -> Result<(), String> {
        let Some(used) = self.layout.used_row_bytes() else { return self.decode_jpeg(bytes, pixels) };
        let rows = self.rows(bytes, used)?;
        let (width, size) = (self.layout.width, (self.layout.width, self.layout.height));
        match (&mut self.packed, self.layout.coding) {
            (Packed::Colour(conversion), _) => {
                let (conversion, unpacked) = &mut **conversion;
                unpacked.fill(rows, width);
                conversion.convert_into(&unpacked.planes(), reuse::rgb8(pixels, size))?;
            }
            (Packed::Luma(levels), _) => {
                let luma = rows.flat_map(|row| row.iter().step_by(2).take(width));
                fill(reuse::grey8(pixels, size), luma.map(|&luma| levels[usize::from(luma)]));
            }
            (Packed::None, CameraCoding::Grey16) => {
                let values = rows.flat_map(|row| row.as_chunks().0.iter().map(|pair| u16::from_le_bytes(*pair)));
                fill(reuse::grey16(pixels, size), values);
            }
            (Packed::None, CameraCoding::Rgb8) => {
                copy_rows(rows.map(|row| row.as_chunks().0), width, reuse::rgb8(pixels, size));
            }
            (Packed::None, CameraCoding::Rgb16) => {
                let of_pixel = |bytes: &[u8; 6]| {
                    let [r0, r1, g0, g1, b0, b1] = *bytes;
                    [[r0, r1], [g0, g1], [b0, b1]].map(u16::from_le_bytes)
                };
                fill(reuse::rgb16(pixels, size), rows.flat_map(|row| row.as_chunks().0.iter().map(of_pixel)));
            }
            (Packed::None, _) => copy_rows(rows, width, reuse::grey8(pixels, size)),
        }
        Ok(())
    }

    /// The used bytes of every row, if all rows are present.
    fn rows<'a>(&self, bytes: &'a [u8], used: usize) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, String> {
        let height = self.layout.height;
        let step = self.layout.row_bytes.max(used);
        let needed = step * height.saturating_sub(1) + used;
        if bytes.len() < needed {
            return Err(format!("cut off: {} of {needed} bytes", bytes.len()));
        }
        Ok(bytes.chunks(step.max(1)).take(height).map(move |row| &row[..used]))
    }

    fn decode_jpeg(&mut self, bytes: &[u8], pixels: &mut Pixels) -> Result<(), String> {
        if !bytes.starts_with(&[0xff, 0xd8]) {
            return Err("not a JPEG picture".into());
        }
        guarded(|| self.jpeg.decode_into(bytes, self.is_luma_alone, pixels)).flatten()?;
        if pixels.size() == (self.layout.width, self.layout.height) {
            return Ok(());
        }
        let found = FrameFormat::from(&*pixels);
        Err(format!("{found}, expected {}x{} px", self.layout.width, self.layout.height))
    }
}

/// The grey level, 0 to 255, of every luma.
fn grey_levels(is_full_range: bool) -> [u8; 256] {
    let (black, gain) = if is_full_range { (0.0, 1.0) } else { (16.0, 255.0 / 219.0) };
    std::array::from_fn(|luma| ((luma as f64 - black) * gain).round().clamp(0.0, 255.0) as u8)
}

fn fill<T>(to: &mut [T], from: impl Iterator<Item = T>) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to = from);
}

fn copy_rows<'a, T: Copy + 'a>(rows: impl Iterator<Item = &'a [T]>, width: usize, to: &mut [T]) {
    to.chunks_mut(width.max(1)).zip(rows).for_each(|(to, row)| to.copy_from_slice(row));
}

/// Packed luma and chroma (4:2:2), separated into planes.
struct Unpacked {
    y: Vec<u8>,
    u: Vec<u8>,
    v: Vec<u8>,
    chroma_size: [usize; 2],
}

impl Unpacked {
    /// Planes for frames of this size; an odd width has chroma for one column more.
    fn new(width: usize, height: usize) -> Self {
        let pairs = width.div_ceil(2);
        let chroma = vec![0; pairs * height];
        Self { y: vec![0; width * height], u: chroma.clone(), v: chroma, chroma_size: [pairs, height] }
    }

    /// Takes the rows of a frame. Of an odd width, the last luma is left out.
    fn fill<'a>(&mut self, rows: impl Iterator<Item = &'a [u8]>, width: usize) {
        let pairs = self.chroma_size[0];
        for (number, row) in rows.enumerate() {
            let luma = &mut self.y[number * width..][..width];
            let (u, v) = (&mut self.u[number * pairs..][..pairs], &mut self.v[number * pairs..][..pairs]);
            let chroma = u.iter_mut().zip(v);
            for ((luma, chroma), &[y0, cb, y1, cr]) in luma.chunks_mut(2).zip(chroma).zip(row.as_chunks().0) {
                (*chroma.0, *chroma.1) = (cb, cr);
                luma[0] = y0;
                if let Some(second) = luma.get_mut(1) {
                    *second = y1;
                }
            }
        }
    }

    fn planes(&self) -> Planes<'_> {
        Planes { y: &self.y, u: &self.u, v: &self.v, chroma_size: self.chroma_size, has_half_rows: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::codecs::jpeg::JpegEncoder;
    use image::{GrayImage, Luma};

    fn layout(coding: CameraCoding, width: usize, height: usize, row_bytes: usize) -> CameraLayout {
        CameraLayout { coding, width, height, row_bytes }
    }

    fn jpeg(width: u32, height: u32) -> Vec<u8> {
        let picture = GrayImage::from_fn(width, height, |x, y| Luma([(7 * x + 5 * y) as u8]));
        let mut bytes = Vec::new();
        JpegEncoder::new(&mut bytes).encode_image(&picture).unwrap();
        bytes
    }

    #[test]
    fn grey_rows_with_padding_are_taken_apart() {
        let mut decoder = CameraFrameDecoder::new(layout(CameraCoding::Grey8, 2, 2, 4));
        let pixels = decoder.decode(&[1, 2, 99, 99, 3, 4]).unwrap();
        assert_eq!(pixels, Pixels::Grey8(Image::from_vec(2, 2, vec![1, 2, 3, 4]).unwrap()));
        let mut decoder = CameraFrameDecoder::new(layout(CameraCoding::Grey16, 2, 1, 0));
        let pixels = decoder.decode(&[0x34, 0x12, 0xff, 0xff, 0, 0]).unwrap();
        assert_eq!(pixels, Pixels::Grey16(Image::from_vec(2, 1, vec![0x1234, 0xffff]).unwrap()));
    }

    #[test]
    fn packed_chroma_becomes_colour_in_both_ranges() {
        let wanted = [(false, 235, 255), (true, 235, 235), (false, 16, 0), (true, 255, 255)];
        for (is_full_range, luma, level) in wanted {
            let mut decoder = CameraFrameDecoder::new(layout(CameraCoding::Yuyv { is_full_range }, 3, 2, 8));
            let row = [luma, 128, luma, 128, luma, 128, 7, 128];
            let Pixels::Rgb8(image) = decoder.decode(&[row, row].concat()).unwrap() else { panic!("colour") };
            assert_eq!(image.at(2, 1), [level; 3], "full range {is_full_range}, luma {luma}");
        }
        // Pure red in limited range: Y 81, U 90, V 240.
        let mut decoder = CameraFrameDecoder::new(layout(CameraCoding::Yuyv { is_full_range: false }, 2, 1, 0));
        let Pixels::Rgb8(image) = decoder.decode(&[81, 90, 81, 240]).unwrap() else { panic!("colour") };
        let [red, green, blue] = image.at(0, 0);
        assert!(red >= 252 && green <= 3 && blue <= 3, "{:?}", image.at(0, 0));
    }

    #[test]
    fn tracking_gets_the_luma_of_coarse_colour() {
        for (is_full_range, luma, level) in [(false, 235, 255), (true, 235, 235), (false, 16, 0), (false, 81, 76)] {
            let mut decoder = CameraFrameDecoder::for_tracking(layout(CameraCoding::Yuyv { is_full_range }, 3, 2, 8));
            let row = [luma, 90, 16, 240, luma, 90, 7, 240];
            let Pixels::Grey8(image) = decoder.decode(&[row, row].concat()).unwrap() else { panic!("grey") };
            assert_eq!([image.at(0, 0), image.at(2, 1)], [level; 2], "full range {is_full_range}, luma {luma}");
        }
        // Full colour stays.
        let decoded = CameraFrameDecoder::for_tracking(layout(CameraCoding::Rgb8, 1, 1, 0)).decode(&[1, 2, 3]).unwrap();
        assert!(decoded.is_colour());
    }

    #[test]
    fn luma_alone_is_that_of_the_colour_for_every_sampling_and_size() {
        use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
        let samplings =
            [SamplingFactor::R_4_4_4, SamplingFactor::R_4_2_2, SamplingFactor::R_4_4_0, SamplingFactor::R_4_2_0];
        for (sampling, (width, height)) in samplings
            .into_iter()
            .flat_map(|sampling| [(48, 40), (50, 37), (33, 16), (640, 48)].map(|size| (sampling, size)))
        {
            // Grey texture in even colour: halved chroma is then as good as whole.
            let texture = |x: usize, y: usize| ((x * 7 + y * 13) % 32 * 3 + 80) as u8;
            let pixels = (0..width * height).map(|at| texture(at % width, at / width));
            let bytes: Vec<u8> = pixels.flat_map(|level| [level + 30, level, level - 20]).collect();
            let mut jpeg = Vec::new();
            let mut encoder = Encoder::new(&mut jpeg, 95);
            encoder.set_sampling_factor(sampling);
            encoder.encode(&bytes, width as u16, height as u16, ColorType::Rgb).unwrap();
            let layout = layout(CameraCoding::MotionJpeg, width, height, 0);
            let (mut colour, mut luma) = (CameraFrameDecoder::new(layout), CameraFrameDecoder::for_tracking(layout));
            let Pixels::Rgb8(colour) = colour.decode(&jpeg).unwrap() else { panic!("colour") };
            let Pixels::Grey8(grey) = luma.decode(&jpeg).unwrap() else { panic!("grey") };
            for (at, (grey, [red, green, blue])) in grey.values().iter().zip(colour.values()).enumerate() {
                let luma = 0.299 * f64::from(*red) + 0.587 * f64::from(*green) + 0.114 * f64::from(*blue);
                let difference = (f64::from(*grey) - luma).abs();
                assert!(difference < 3.0, "{sampling:?}, {width}x{height}, pixel {at}: {grey} and {luma}");
            }
        }
    }

    #[test]
    fn a_frame_that_lacks_bytes_is_refused() {
        let mut decoder = CameraFrameDecoder::new(layout(CameraCoding::Yuyv { is_full_range: false }, 4, 2, 0));
        assert_eq!(decoder.decode(&[0; 15]).unwrap_err(), "cut off: 15 of 16 bytes");
    }

    #[test]
    fn a_damaged_jpeg_is_refused_and_a_whole_one_read() {
        let whole = jpeg(24, 16);
        let mut decoder = CameraFrameDecoder::new(layout(CameraCoding::MotionJpeg, 24, 16, 0));
        assert_eq!(decoder.decode(&whole).unwrap().size(), (24, 16));
        assert_eq!(decoder.decode(&whole[..whole.len() / 2]).unwrap_err(), "the JPEG picture is cut off");
        assert_eq!(decoder.decode(&[0; 100]).unwrap_err(), "not a JPEG picture");
        assert_eq!(decoder.decode(&[]).unwrap_err(), "not a JPEG picture");
        assert_eq!(decoder.decode(&jpeg(16, 16)).unwrap_err(), "16x16 px 8-bit grey, expected 24x16 px");
    }
}
