//! The schemas against the definitions that Foxglove publishes, and against the messages.

use std::collections::HashMap;

use prost::Message;

use super::{ALL, FileDescriptorSet, Kind, Schema, Type};
use crate::message;

/// Message, field, number, count and type, as in Foxglove's schemas of 2025. A line for each field.
const PUBLISHED: &str = include_str!("foxglove.txt");

fn line(schema: &Schema, (name, number, kind): &(&str, i32, Kind)) -> String {
    let plain = |kind: Type| kind.as_str_name().trim_start_matches("TYPE_").to_lowercase();
    let (count, kind) = match *kind {
        Kind::One(kind) | Kind::Optional(kind) => ("single", plain(kind)),
        Kind::Many(kind) => ("repeated", plain(kind)),
        Kind::Part(name) => ("single", format!("message {name}")),
        Kind::Parts(name) => ("repeated", format!("message {name}")),
        Kind::Choice(name, values) => {
            let values: Vec<String> =
                values.iter().enumerate().map(|(number, name)| format!("{name}={number}")).collect();
            ("single", format!("enum {}.{name} {}", schema.name, values.join(",")))
        }
    };
    format!("{} {name} {number} {count} {kind}", schema.name)
}

#[test]
fn schemas_are_those_that_foxglove_publishes() {
    let published: Vec<&str> = PUBLISHED.lines().filter(|line| !line.starts_with('#')).collect();
    let ours: Vec<&Schema> = ALL.into_iter().filter(|schema| schema.name.starts_with("foxglove.")).collect();
    let lines: Vec<String> =
        ours.iter().flat_map(|schema| schema.fields.iter().map(|field| line(schema, field))).collect();
    for line in &lines {
        assert!(published.contains(&line.as_str()), "not published: {line}");
    }
    assert_eq!(lines.len(), published.len());
}

/// Number and wire type of every field of an encoded message.
fn wire(mut bytes: &[u8]) -> HashMap<i32, u8> {
    let mut found = HashMap::new();
    while let [key, ..] = bytes {
        // Numbers above 15 need two bytes.
        let (number, len) = if key & 0x80 == 0 { (key >> 3, 1) } else { (key >> 3 & 15 | bytes[1] << 4, 2) };
        found.insert(i32::from(number), key & 7);
        bytes = &bytes[len..];
        bytes = match key & 7 {
            0 => &bytes[bytes.iter().position(|byte| byte & 0x80 == 0).unwrap() + 1..],
            1 => &bytes[8..],
            5 => &bytes[4..],
            _ => &bytes[1 + usize::from(bytes[0])..],
        };
    }
    found
}

fn expect_fields(schema: &Schema, message: &impl Message) {
    let wanted: HashMap<i32, u8> = schema.fields.iter().map(|(_, number, kind)| (*number, wire_type(*kind))).collect();
    assert_eq!(wire(&message.encode_to_vec()), wanted, "{}", schema.name);
}

fn wire_type(kind: Kind) -> u8 {
    match kind {
        Kind::One(Type::Double) => 1,
        Kind::One(Type::Float | Type::Fixed32) | Kind::Optional(Type::Float) => 5,
        Kind::One(Type::Uint32 | Type::Uint64) | Kind::Choice(..) => 0,
        _ => 2,
    }
}

#[test]
fn messages_have_the_fields_of_their_schemas() {
    let time = Some(message::timestamp(1_500_000_000));
    let text = || String::from("x");
    let vector = message::Vector3 { x: 1.0, y: 1.0, z: 1.0 };
    let quaternion = message::Quaternion { x: 1.0, y: 1.0, z: 1.0, w: 1.0 };
    let pose = message::Pose { position: Some(vector), orientation: Some(quaternion) };
    let element = message::PackedElementField { name: text(), offset: 1, kind: 1 };
    expect_fields(&super::VECTOR3, &vector);
    expect_fields(&super::QUATERNION, &quaternion);
    expect_fields(&super::POSE, &pose);
    expect_fields(&super::PACKED_ELEMENT_FIELD, &element);
    let (data, frame_id) = (vec![1], text());
    let image = message::CompressedImage { timestamp: time, data, format: text(), frame_id };
    expect_fields(&super::COMPRESSED_IMAGE, &image);
    let (width, height, step, encoding, data) = (1, 1, 1, text(), vec![1]);
    let image = message::RawImage { timestamp: time, width, height, encoding, step, data, frame_id: text() };
    expect_fields(&super::RAW_IMAGE, &image);
    let (pose, fields, data) = (Some(pose), vec![element], vec![1]);
    let cloud = message::PointCloud { timestamp: time, frame_id: text(), pose, point_stride: 1, fields, data };
    expect_fields(&super::POINT_CLOUD, &cloud);
    let (distortion_model, one, frame_id) = (text(), || vec![1.0], text());
    let (distortion, intrinsics, rectification, projection) = (one(), one(), one(), one());
    let calibration = message::CameraCalibration {
        timestamp: time,
        width,
        height,
        distortion_model,
        distortion,
        intrinsics,
        rectification,
        projection,
        frame_id,
    };
    expect_fields(&super::CAMERA_CALIBRATION, &calibration);
    let (parent_frame_id, child_frame_id, translation, rotation) = (text(), text(), Some(vector), Some(quaternion));
    let transform = message::FrameTransform { timestamp: time, parent_frame_id, child_frame_id, translation, rotation };
    expect_fields(&super::FRAME_TRANSFORM, &transform);
    let log = message::Log { timestamp: time, level: 1, message: text(), name: text(), file: text(), line: 1 };
    expect_fields(&super::LOG, &log);
}

#[test]
fn our_messages_have_the_fields_of_their_schemas() {
    let timestamp = Some(message::timestamp(1_500_000_000));
    let text = || String::from("x");
    let frame = message::Frame {
        timestamp,
        sequence: 1,
        capture_time_s: 1.0,
        captured_s: 1.0,
        width: 1,
        height: 1,
        row_bytes: 1,
        coding: text(),
        storage: text(),
        image: 1,
        length: 1,
        crc32: 1,
        data: vec![1],
    };
    expect_fields(&super::FRAME, &frame);
    let reading = message::Reading {
        timestamp,
        sequence: 1,
        capture_time_s: 1.0,
        captured_s: 1.0,
        dropped_frames: 1,
        reference_id: 1,
        reference_count: 1,
        photometric_error: 1.0,
        latency_ms: 1.0,
        flags: vec![text()],
        max_depth_mm: Some(0.0),
        contact_area_mm2: Some(0.0),
        force_x_n: Some(0.0),
        force_y_n: Some(0.0),
        force_z_n: Some(0.0),
        torque_z_nmm: Some(0.0),
        damaged_part: 1.0,
        mean_level: 1.0,
        saturated_part: 1.0,
        sharpness: 1.0,
    };
    expect_fields(&super::READING, &reading);
    let truth = message::Truth {
        timestamp,
        sequence: 1,
        capture_time_s: 1.0,
        depth_mm: 1.0,
        force_x_n: 1.0,
        force_y_n: 1.0,
        force_z_n: 1.0,
        torque_z_nmm: 1.0,
    };
    expect_fields(&super::TRUTH, &truth);
}

#[test]
fn descriptors_contain_what_a_message_needs_and_no_more() {
    for schema in ALL {
        let set = FileDescriptorSet::decode(schema.descriptors().as_slice()).unwrap();
        let mut known: Vec<String> = Vec::new();
        for file in &set.file {
            assert!(file.dependency.iter().all(|needed| known.contains(needed)), "{} in {}", file.name(), schema.name);
            known.push(file.name().into());
        }
        assert_eq!(known.last(), Some(&schema.file_name()));
    }
    let log = FileDescriptorSet::decode(super::LOG.descriptors().as_slice()).unwrap();
    assert_eq!(log.file.len(), 2);
}
