//! H.264 in MP4: parameter sets in the `avcC` box, samples of length-prefixed units.
//!
//! One sample is one picture. It is flushed out of the decoder at once, so that a picture is never confused with its
//! neighbour; the display order is determined by the caller, from the container's times.

mod references;

use crate::guarded::guarded;
use crate::video::decoder::Decoder;
use crate::video::fault::Fault;
use crate::yuv::{Colour, Planes, YuvToRgb};
use fingervision_image::Pixels;
use references::References;
use rust_h264::decoder::{ChromaFormat, Decoder as Bitstream, Frame};
use rust_h264::error::DecodeError;
use rust_h264::nal::{NalUnit, NalUnitType, SpsInfo, parse_avcc, parse_avcc_config, parse_sps_info};

/// The most macroblocks of 16×16 px that any level of H.264 allows in a picture.
const MAX_MACROBLOCKS: u32 = 139_264;
/// The most reference pictures that H.264 allows.
const MAX_REFERENCES: u32 = 16;
/// H.273's number for "not said".
const UNSPECIFIED: u8 = 2;

/// Decodes the samples of an H.264 track.
pub(crate) struct H264 {
    bitstream: Bitstream,
    references: References,
    /// Bytes of the length in front of every unit.
    length_size: usize,
    /// Colour information of the container; that of the stream takes precedence.
    colour: Option<Colour>,
    /// The stream's size and colour conversion, once its parameters have been read.
    stream: Option<(SpsInfo, YuvToRgb)>,
}

impl H264 {
    /// A decoder for a track with this `avcC` content.
    pub(crate) fn new(config: &[u8], colour: Option<Colour>) -> Result<Self, Fault> {
        const DAMAGED: Fault = Fault::Damaged("the H.264 parameters are damaged");
        let config = guarded(|| parse_avcc_config(config).ok()).ok().flatten().ok_or(DAMAGED)?;
        let mut decoder = Self {
            bitstream: Bitstream::new(),
            references: References::default(),
            length_size: config.length_size,
            colour,
            stream: None,
        };
        for unit in config.sps_nals.iter().chain(&config.pps_nals) {
            decoder.feed(unit).map_err(|fault| match fault {
                UnitFault::NotRead(what) => Fault::NotRead(what),
                UnitFault::Damaged(_) => DAMAGED,
            })?;
        }
        Ok(decoder)
    }

    /// Passes one unit to the decoder; a picture is returned when the unit starts the next one.
    fn feed(&mut self, unit: &NalUnit) -> Result<Option<Frame>, UnitFault> {
        if unit.nal_unit_type == NalUnitType::Sps {
            let info = guarded(|| parse_sps_info(unit))??;
            let conversion = admit(&info, self.colour)?;
            self.stream = Some((info, conversion));
        }
        self.references.check(unit)?;
        Ok(guarded(|| self.bitstream.decode_nal(unit))??)
    }

    fn picture(&mut self, sample: &[u8]) -> Result<Frame, UnitFault> {
        check_lengths(sample, self.length_size)?;
        for unit in &parse_avcc(sample, self.length_size) {
            if self.feed(unit)?.is_some() {
                return Err("two pictures in one sample".into());
            }
        }
        guarded(|| self.bitstream.flush())?.ok_or_else(|| "no picture in the sample".into())
    }
}

impl Decoder for H264 {
    fn decode(&mut self, sample: &[u8]) -> Result<Pixels, String> {
        let picture = self.picture(sample).map_err(|fault| match fault {
            UnitFault::Damaged(reason) => reason,
            UnitFault::NotRead(what) => format!("{what} is not supported"),
        })?;
        let Some((info, conversion)) = &mut self.stream else { return Err("the H.264 parameters are missing".into()) };
        if (picture.width, picture.height) != (info.width, info.height) {
            return Err("half a picture: one of its fields is missing".into());
        }
        conversion.convert(&planes(&picture)).map(Pixels::Rgb8)
    }

    fn is_key(&self, sample: &[u8]) -> bool {
        let is_whole = check_lengths(sample, self.length_size).is_ok();
        is_whole && parse_avcc(sample, self.length_size).iter().any(|unit| unit.nal_unit_type == NalUnitType::SliceIdr)
    }
}

/// The planes of a decoded picture.
fn planes(picture: &Frame) -> Planes<'_> {
    Planes {
        y: &picture.y,
        u: &picture.u,
        v: &picture.v,
        chroma_size: [picture.chroma_width() as usize, picture.chroma_height() as usize],
        has_half_rows: picture.chroma_format == ChromaFormat::Yuv420,
    }
}

/// Why a unit is refused.
enum UnitFault {
    Damaged(String),
    /// A noun.
    NotRead(String),
}

impl From<String> for UnitFault {
    fn from(reason: String) -> Self {
        Self::Damaged(reason)
    }
}

impl From<&str> for UnitFault {
    fn from(reason: &str) -> Self {
        Self::Damaged(reason.into())
    }
}

impl From<DecodeError> for UnitFault {
    fn from(error: DecodeError) -> Self {
        match error {
            DecodeError::Unsupported(what) => Self::NotRead(format!("H.264 with this feature ({what})")),
            error => Self::Damaged(error.to_string()),
        }
    }
}

/// Checks that a stream can be decoded within limits, and selects its colour conversion.
///
/// Sizes are checked before the decoder gets them: it allocates whatever a damaged file requests.
fn admit(info: &SpsInfo, container: Option<Colour>) -> Result<YuvToRgb, UnitFault> {
    if (info.bit_depth_luma, info.bit_depth_chroma) != (8, 8) {
        return Err(UnitFault::NotRead(format!("H.264 with {} bits a channel", info.bit_depth_luma)));
    }
    if info.chroma_format > 2 {
        return Err(UnitFault::NotRead("H.264 with full-size chroma (4:4:4)".into()));
    }
    let macroblocks = (info.coded_width / 16).saturating_mul(info.coded_height / 16);
    let is_empty = info.width == 0 || info.height == 0;
    if is_empty || macroblocks > MAX_MACROBLOCKS || info.reference_frames > MAX_REFERENCES {
        return Err("the H.264 parameters are out of bounds".into());
    }
    let (width, height) = (info.width as usize, info.height as usize);
    let conversion = YuvToRgb::new(width, height, colour_of(info, container));
    conversion.ok_or_else(|| UnitFault::NotRead(format!("H.264 with colour matrix {}", info.matrix)))
}

/// The stream's own information first, then the container's, then BT.601 in limited range, as in `FFmpeg` and `OpenCV`.
fn colour_of(info: &SpsInfo, container: Option<Colour>) -> Colour {
    let matrix = match (info.matrix, container) {
        (UNSPECIFIED, Some(colour)) => colour.matrix,
        (matrix, _) => u16::from(matrix),
    };
    Colour { matrix, is_full_range: info.full_range || container.is_some_and(|colour| colour.is_full_range) }
}

/// Checks that the units fill the sample exactly; the parser would drop an incomplete one silently.
fn check_lengths(mut sample: &[u8], length_size: usize) -> Result<(), UnitFault> {
    const DAMAGED: &str = "the lengths of the H.264 units do not fit the sample";
    while !sample.is_empty() {
        let (length, rest) = sample.split_at_checked(length_size).ok_or(DAMAGED)?;
        let length = length.iter().fold(0, |length, &byte| length << 8 | usize::from(byte));
        sample = rest.get(length..).ok_or(DAMAGED)?;
    }
    Ok(())
}
