//! The sample description: the codec of the frames.
//!
//! Four letters name the codec. `mp4v` covers all codecs that MPEG-4 part 1 numbers. The box `esds` within it contains
//! this number, the object type, which may be motion JPEG (ISO/IEC 14496-1, table 5; `FFmpeg` writes motion JPEG in MP4
//! in this way).

use super::boxes::{Bytes, boxes, find};
use crate::video::fault::Fault;
use crate::video::track::Codec;
use crate::yuv::Colour;

/// Length of a video sample entry before its boxes, bytes.
const SAMPLE_ENTRY_LEN: usize = 78;
/// Tags of the descriptors in `esds`.
const ELEMENTARY_STREAM: u8 = 0x03;
const DECODER_CONFIG: u8 = 0x04;
/// Object type of JPEG pictures.
const JPEG: u8 = 0x6c;

const DAMAGED: Fault = Fault::Damaged("the description of the video track is damaged");

/// The codec of the first sample description.
pub(super) fn codec(descriptions: &[u8]) -> Result<Codec, Fault> {
    let (kind, entry) = descriptions.get(8..).and_then(|entries| boxes(entries).next()).ok_or(DAMAGED)?;
    let described = entry.get(SAMPLE_ENTRY_LEN..).ok_or(DAMAGED)?;
    let name = match &kind {
        b"avc1" | b"avc3" => {
            let config = find(described, *b"avcC").ok_or(DAMAGED)?.to_vec();
            return Ok(Codec::H264 { config, colour: find(described, *b"colr").and_then(colour) });
        }
        b"jpeg" | b"mjpg" | b"MJPG" | b"mjpa" | b"dmb1" => return Ok(Codec::MotionJpeg),
        b"mp4v" => match object_type(described).ok_or(DAMAGED)? {
            JPEG => return Ok(Codec::MotionJpeg),
            other => object_name(other),
        },
        b"mjpb" => "motion JPEG B".into(),
        b"hvc1" | b"hev1" => "H.265 (HEVC)".into(),
        b"vp08" => "VP8".into(),
        b"vp09" => "VP9".into(),
        b"av01" => "AV1".into(),
        b"apch" | b"apcn" | b"apcs" | b"apco" | b"ap4h" | b"ap4x" => "ProRes".into(),
        b"encv" => "encrypted".into(),
        other => other.escape_ascii().to_string().trim_end().into(),
    };
    Err(Fault::NotRead(format!("{name} video in MP4")))
}

/// The object type that the box `esds` states.
fn object_type(described: &[u8]) -> Option<u8> {
    let mut content = Bytes(find(described, *b"esds")?);
    content.version_and_flags()?;
    let mut stream = Bytes(descriptor(&mut content, ELEMENTARY_STREAM)?);
    stream.u16()?;
    let flags = stream.u8()?;
    if flags & 0x80 > 0 {
        stream.u16()?;
    }
    if flags & 0x40 > 0 {
        let len = stream.u8()?;
        stream.take(usize::from(len))?;
    }
    if flags & 0x20 > 0 {
        stream.u16()?;
    }
    descriptor(&mut stream, DECODER_CONFIG)?.first().copied()
}

/// The content of the next descriptor if it has this tag. Its length has seven bits per byte; the eighth indicates that
/// more follow.
fn descriptor<'a>(bytes: &mut Bytes<'a>, tag: u8) -> Option<&'a [u8]> {
    (bytes.u8()? == tag).then_some(())?;
    let mut len = 0;
    for _ in 0..4 {
        let byte = bytes.u8()?;
        len = len << 7 | usize::from(byte & 0x7f);
        if byte & 0x80 == 0 {
            break;
        }
    }
    bytes.take(len)
}

fn object_name(object_type: u8) -> String {
    match object_type {
        0x20 => "MPEG-4 part 2".into(),
        0x60..=0x65 => "MPEG-2".into(),
        0x6a => "MPEG-1".into(),
        0x6d => "PNG".into(),
        0x6e => "JPEG 2000".into(),
        other => format!("MPEG-4 object type {other:#04x}"),
    }
}

/// The content of a `colr` box.
fn colour(content: &[u8]) -> Option<Colour> {
    let mut content = Bytes(content);
    let kind = content.kind()?;
    // Behind the kind: primaries and transfer, which matter to displays only.
    content.take(4)?;
    let matrix = content.u16()?;
    let is_full_range = &kind == b"nclx" && content.u8()? >> 7 == 1;
    matches!(&kind, b"nclx" | b"nclc").then_some(Colour { matrix, is_full_range })
}
