//! The messages of a recording. Those of Foxglove have the fields that Foxglove publishes; `schema.rs` describes all of
//! them.

use prost::Message;
use prost_types::Timestamp;

/// A picture as a JPEG file: `foxglove.CompressedImage`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct CompressedImage {
    #[prost(message, optional, tag = "1")]
    pub(crate) timestamp: Option<Timestamp>,
    #[prost(bytes = "vec", tag = "2")]
    pub(crate) data: Vec<u8>,
    #[prost(string, tag = "3")]
    pub(crate) format: String,
    #[prost(string, tag = "4")]
    pub(crate) frame_id: String,
}

/// A picture as pixels: `foxglove.RawImage`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct RawImage {
    #[prost(message, optional, tag = "1")]
    pub(crate) timestamp: Option<Timestamp>,
    #[prost(fixed32, tag = "2")]
    pub(crate) width: u32,
    #[prost(fixed32, tag = "3")]
    pub(crate) height: u32,
    #[prost(string, tag = "4")]
    pub(crate) encoding: String,
    #[prost(fixed32, tag = "5")]
    pub(crate) step: u32,
    #[prost(bytes = "vec", tag = "6")]
    pub(crate) data: Vec<u8>,
    #[prost(string, tag = "7")]
    pub(crate) frame_id: String,
}

/// Points: `foxglove.PointCloud`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct PointCloud {
    #[prost(message, optional, tag = "1")]
    pub(crate) timestamp: Option<Timestamp>,
    #[prost(string, tag = "2")]
    pub(crate) frame_id: String,
    #[prost(message, optional, tag = "3")]
    pub(crate) pose: Option<Pose>,
    #[prost(fixed32, tag = "4")]
    pub(crate) point_stride: u32,
    #[prost(message, repeated, tag = "5")]
    pub(crate) fields: Vec<PackedElementField>,
    #[prost(bytes = "vec", tag = "6")]
    pub(crate) data: Vec<u8>,
}

/// A value that each point has: `foxglove.PackedElementField`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct PackedElementField {
    #[prost(string, tag = "1")]
    pub(crate) name: String,
    #[prost(fixed32, tag = "2")]
    pub(crate) offset: u32,
    #[prost(int32, tag = "3")]
    pub(crate) kind: i32,
}

/// `foxglove.Pose`.
#[derive(Clone, Copy, PartialEq, Message)]
pub(crate) struct Pose {
    #[prost(message, optional, tag = "1")]
    pub(crate) position: Option<Vector3>,
    #[prost(message, optional, tag = "2")]
    pub(crate) orientation: Option<Quaternion>,
}

/// `foxglove.Vector3`.
#[derive(Clone, Copy, PartialEq, Message)]
pub(crate) struct Vector3 {
    #[prost(double, tag = "1")]
    pub(crate) x: f64,
    #[prost(double, tag = "2")]
    pub(crate) y: f64,
    #[prost(double, tag = "3")]
    pub(crate) z: f64,
}

/// `foxglove.Quaternion`.
#[derive(Clone, Copy, PartialEq, Message)]
pub(crate) struct Quaternion {
    #[prost(double, tag = "1")]
    pub(crate) x: f64,
    #[prost(double, tag = "2")]
    pub(crate) y: f64,
    #[prost(double, tag = "3")]
    pub(crate) z: f64,
    #[prost(double, tag = "4")]
    pub(crate) w: f64,
}

/// Intrinsics of a camera: `foxglove.CameraCalibration`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct CameraCalibration {
    #[prost(message, optional, tag = "1")]
    pub(crate) timestamp: Option<Timestamp>,
    #[prost(fixed32, tag = "2")]
    pub(crate) width: u32,
    #[prost(fixed32, tag = "3")]
    pub(crate) height: u32,
    #[prost(string, tag = "4")]
    pub(crate) distortion_model: String,
    /// `D`.
    #[prost(double, repeated, tag = "5")]
    pub(crate) distortion: Vec<f64>,
    /// `K`.
    #[prost(double, repeated, tag = "6")]
    pub(crate) intrinsics: Vec<f64>,
    /// `R`.
    #[prost(double, repeated, tag = "7")]
    pub(crate) rectification: Vec<f64>,
    /// `P`.
    #[prost(double, repeated, tag = "8")]
    pub(crate) projection: Vec<f64>,
    #[prost(string, tag = "9")]
    pub(crate) frame_id: String,
}

/// Position and orientation of one coordinate frame in another: `foxglove.FrameTransform`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct FrameTransform {
    #[prost(message, optional, tag = "1")]
    pub(crate) timestamp: Option<Timestamp>,
    #[prost(string, tag = "2")]
    pub(crate) parent_frame_id: String,
    #[prost(string, tag = "3")]
    pub(crate) child_frame_id: String,
    #[prost(message, optional, tag = "4")]
    pub(crate) translation: Option<Vector3>,
    #[prost(message, optional, tag = "5")]
    pub(crate) rotation: Option<Quaternion>,
}

/// A sentence for the user: `foxglove.Log`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct Log {
    #[prost(message, optional, tag = "1")]
    pub(crate) timestamp: Option<Timestamp>,
    #[prost(int32, tag = "2")]
    pub(crate) level: i32,
    #[prost(string, tag = "3")]
    pub(crate) message: String,
    #[prost(string, tag = "4")]
    pub(crate) name: String,
    #[prost(string, tag = "5")]
    pub(crate) file: String,
    #[prost(fixed32, tag = "6")]
    pub(crate) line: u32,
}

/// A frame as the camera sent it: `fingervision.Frame`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct Frame {
    #[prost(message, optional, tag = "1")]
    pub(crate) timestamp: Option<Timestamp>,
    #[prost(uint64, tag = "2")]
    pub(crate) sequence: u64,
    #[prost(double, tag = "3")]
    pub(crate) capture_time_s: f64,
    #[prost(double, tag = "4")]
    pub(crate) captured_s: f64,
    #[prost(uint32, tag = "5")]
    pub(crate) width: u32,
    #[prost(uint32, tag = "6")]
    pub(crate) height: u32,
    #[prost(uint32, tag = "7")]
    pub(crate) row_bytes: u32,
    /// The camera's coding, by its name.
    #[prost(string, tag = "8")]
    pub(crate) coding: String,
    /// How the bytes are stored, by its name.
    #[prost(string, tag = "9")]
    pub(crate) storage: String,
    /// Number of the image message that contains the bytes, if they are not in this message.
    #[prost(uint32, tag = "10")]
    pub(crate) image: u32,
    /// Length of the original bytes, and their CRC-32.
    #[prost(uint64, tag = "11")]
    pub(crate) length: u64,
    #[prost(fixed32, tag = "12")]
    pub(crate) crc32: u32,
    #[prost(bytes = "vec", tag = "13")]
    pub(crate) data: Vec<u8>,
}

/// The numbers of a reading: `fingervision.Reading`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct Reading {
    #[prost(message, optional, tag = "1")]
    pub(crate) timestamp: Option<Timestamp>,
    #[prost(uint64, tag = "2")]
    pub(crate) sequence: u64,
    #[prost(double, tag = "3")]
    pub(crate) capture_time_s: f64,
    #[prost(double, tag = "4")]
    pub(crate) captured_s: f64,
    #[prost(uint64, tag = "5")]
    pub(crate) dropped_frames: u64,
    #[prost(uint64, tag = "6")]
    pub(crate) reference_id: u64,
    #[prost(uint64, tag = "7")]
    pub(crate) reference_count: u64,
    #[prost(float, tag = "8")]
    pub(crate) photometric_error: f32,
    #[prost(double, tag = "9")]
    pub(crate) latency_ms: f64,
    #[prost(string, repeated, tag = "10")]
    pub(crate) flags: Vec<String>,
    #[prost(float, optional, tag = "11")]
    pub(crate) max_depth_mm: Option<f32>,
    #[prost(float, optional, tag = "12")]
    pub(crate) contact_area_mm2: Option<f32>,
    #[prost(float, optional, tag = "13")]
    pub(crate) force_x_n: Option<f32>,
    #[prost(float, optional, tag = "14")]
    pub(crate) force_y_n: Option<f32>,
    #[prost(float, optional, tag = "15")]
    pub(crate) force_z_n: Option<f32>,
    #[prost(float, optional, tag = "16")]
    pub(crate) torque_z_nmm: Option<f32>,
    #[prost(float, tag = "17")]
    pub(crate) damaged_part: f32,
    #[prost(float, tag = "18")]
    pub(crate) mean_level: f32,
    #[prost(float, tag = "19")]
    pub(crate) saturated_part: f32,
    #[prost(float, tag = "20")]
    pub(crate) sharpness: f32,
}

/// What a simulation knows of a frame: `fingervision.Truth`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct Truth {
    #[prost(message, optional, tag = "1")]
    pub(crate) timestamp: Option<Timestamp>,
    #[prost(uint64, tag = "2")]
    pub(crate) sequence: u64,
    #[prost(double, tag = "3")]
    pub(crate) capture_time_s: f64,
    #[prost(double, tag = "4")]
    pub(crate) depth_mm: f64,
    #[prost(double, tag = "5")]
    pub(crate) force_x_n: f64,
    #[prost(double, tag = "6")]
    pub(crate) force_y_n: f64,
    #[prost(double, tag = "7")]
    pub(crate) force_z_n: f64,
    #[prost(double, tag = "8")]
    pub(crate) torque_z_nmm: f64,
}

/// A time, ns since 1970, as messages have it.
pub(crate) fn timestamp(time_ns: u64) -> Timestamp {
    Timestamp { seconds: (time_ns / 1_000_000_000).cast_signed(), nanos: (time_ns % 1_000_000_000) as i32 }
}

/// Appends a message, and behind it the bytes of its field `field` (below 16). The field is empty in the message, so
/// that the bytes need not be copied into it.
pub(crate) fn put_with_bytes(message: &impl Message, field: u8, bytes: &[u8], into: &mut Vec<u8>) {
    message.encode_raw(into);
    if bytes.is_empty() {
        return;
    }
    into.push(field << 3 | 2);
    let mut len = bytes.len();
    while len >= 0x80 {
        into.push(len as u8 | 0x80);
        len >>= 7;
    }
    into.push(len as u8);
    into.extend_from_slice(bytes);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_behind_a_message_are_one_of_its_fields() {
        for len in [0, 1, 127, 128, 70_000] {
            let mut image = CompressedImage { format: "jpeg".into(), ..CompressedImage::default() };
            let bytes = vec![7; len];
            let mut encoded = Vec::new();
            put_with_bytes(&image, 2, &bytes, &mut encoded);
            image.data = bytes;
            assert_eq!(CompressedImage::decode(encoded.as_slice()), Ok(image));
        }
    }
}
