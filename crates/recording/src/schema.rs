//! The schemas of the messages: name, number and type of every field. The descriptors made from them are written into a
//! file, so that other programs can read it.

use prost::Message;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{
    DescriptorProto, EnumDescriptorProto, EnumValueDescriptorProto, FieldDescriptorProto, FileDescriptorProto,
    FileDescriptorSet, OneofDescriptorProto,
};

/// The type of a field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    /// A plain type.
    One(Type),
    /// A plain type that may be absent.
    Optional(Type),
    /// Any number of a plain type.
    Many(Type),
    /// A message, by its full name.
    Part(&'static str),
    /// Any number of a message.
    Parts(&'static str),
    /// An enumeration inside the message: its name and its values from 0.
    Choice(&'static str, &'static [&'static str]),
}

/// A schema: its full name, and name, number and type of each field.
#[derive(Debug)]
pub(crate) struct Schema {
    pub(crate) name: &'static str,
    pub(crate) fields: &'static [(&'static str, i32, Kind)],
}

use Kind::{Choice, Many, One, Optional, Part, Parts};
use Type::{Bytes, Double, Fixed32, Float, Int32, Int64, String as Text, Uint32, Uint64};

const TIME: (&str, i32, Kind) = ("timestamp", 1, Part("google.protobuf.Timestamp"));

pub(crate) static COMPRESSED_IMAGE: Schema = Schema {
    name: "foxglove.CompressedImage",
    fields: &[TIME, ("frame_id", 4, One(Text)), ("data", 2, One(Bytes)), ("format", 3, One(Text))],
};

pub(crate) static RAW_IMAGE: Schema = Schema {
    name: "foxglove.RawImage",
    fields: &[
        TIME,
        ("frame_id", 7, One(Text)),
        ("width", 2, One(Fixed32)),
        ("height", 3, One(Fixed32)),
        ("encoding", 4, One(Text)),
        ("step", 5, One(Fixed32)),
        ("data", 6, One(Bytes)),
    ],
};

pub(crate) static POINT_CLOUD: Schema = Schema {
    name: "foxglove.PointCloud",
    fields: &[
        TIME,
        ("frame_id", 2, One(Text)),
        ("pose", 3, Part("foxglove.Pose")),
        ("point_stride", 4, One(Fixed32)),
        ("fields", 5, Parts("foxglove.PackedElementField")),
        ("data", 6, One(Bytes)),
    ],
};

const NUMERIC_TYPES: &[&str] =
    &["UNKNOWN", "UINT8", "INT8", "UINT16", "INT16", "UINT32", "INT32", "FLOAT32", "FLOAT64"];

/// `FLOAT32` of `foxglove.PackedElementField.NumericType`.
pub(crate) const FLOAT32: i32 = 7;

pub(crate) static PACKED_ELEMENT_FIELD: Schema = Schema {
    name: "foxglove.PackedElementField",
    fields: &[("name", 1, One(Text)), ("offset", 2, One(Fixed32)), ("type", 3, Choice("NumericType", NUMERIC_TYPES))],
};

pub(crate) static POSE: Schema = Schema {
    name: "foxglove.Pose",
    fields: &[("position", 1, Part("foxglove.Vector3")), ("orientation", 2, Part("foxglove.Quaternion"))],
};

pub(crate) static VECTOR3: Schema =
    Schema { name: "foxglove.Vector3", fields: &[("x", 1, One(Double)), ("y", 2, One(Double)), ("z", 3, One(Double))] };

pub(crate) static QUATERNION: Schema = Schema {
    name: "foxglove.Quaternion",
    fields: &[("x", 1, One(Double)), ("y", 2, One(Double)), ("z", 3, One(Double)), ("w", 4, One(Double))],
};

pub(crate) static CAMERA_CALIBRATION: Schema = Schema {
    name: "foxglove.CameraCalibration",
    fields: &[
        TIME,
        ("frame_id", 9, One(Text)),
        ("width", 2, One(Fixed32)),
        ("height", 3, One(Fixed32)),
        ("distortion_model", 4, One(Text)),
        ("D", 5, Many(Double)),
        ("K", 6, Many(Double)),
        ("R", 7, Many(Double)),
        ("P", 8, Many(Double)),
    ],
};

pub(crate) static FRAME_TRANSFORM: Schema = Schema {
    name: "foxglove.FrameTransform",
    fields: &[
        TIME,
        ("parent_frame_id", 2, One(Text)),
        ("child_frame_id", 3, One(Text)),
        ("translation", 4, Part("foxglove.Vector3")),
        ("rotation", 5, Part("foxglove.Quaternion")),
    ],
};

pub(crate) static LOG: Schema = Schema {
    name: "foxglove.Log",
    fields: &[
        TIME,
        ("level", 2, Choice("Level", &["UNKNOWN", "DEBUG", "INFO", "WARNING", "ERROR", "FATAL"])),
        ("message", 3, One(Text)),
        ("name", 4, One(Text)),
        ("file", 5, One(Text)),
        ("line", 6, One(Fixed32)),
    ],
};

/// `INFO` of `foxglove.Log.Level`.
pub(crate) const INFO: i32 = 2;

pub(crate) static FRAME: Schema = Schema {
    name: "fingervision.Frame",
    fields: &[
        TIME,
        ("sequence", 2, One(Uint64)),
        ("capture_time_s", 3, One(Double)),
        ("captured_s", 4, One(Double)),
        ("width", 5, One(Uint32)),
        ("height", 6, One(Uint32)),
        ("row_bytes", 7, One(Uint32)),
        ("coding", 8, One(Text)),
        ("storage", 9, One(Text)),
        ("image", 10, One(Uint32)),
        ("length", 11, One(Uint64)),
        ("crc32", 12, One(Fixed32)),
        ("data", 13, One(Bytes)),
    ],
};

pub(crate) static READING: Schema = Schema {
    name: "fingervision.Reading",
    fields: &[
        TIME,
        ("sequence", 2, One(Uint64)),
        ("capture_time_s", 3, One(Double)),
        ("captured_s", 4, One(Double)),
        ("dropped_frames", 5, One(Uint64)),
        ("reference_id", 6, One(Uint64)),
        ("reference_count", 7, One(Uint64)),
        ("photometric_error", 8, One(Float)),
        ("latency_ms", 9, One(Double)),
        ("flags", 10, Many(Text)),
        ("max_depth_mm", 11, Optional(Float)),
        ("contact_area_mm2", 12, Optional(Float)),
        ("force_x_n", 13, Optional(Float)),
        ("force_y_n", 14, Optional(Float)),
        ("force_z_n", 15, Optional(Float)),
        ("torque_z_nmm", 16, Optional(Float)),
        ("damaged_part", 17, One(Float)),
        ("mean_level", 18, One(Float)),
        ("saturated_part", 19, One(Float)),
        ("sharpness", 20, One(Float)),
    ],
};

pub(crate) static TRUTH: Schema = Schema {
    name: "fingervision.Truth",
    fields: &[
        TIME,
        ("sequence", 2, One(Uint64)),
        ("capture_time_s", 3, One(Double)),
        ("depth_mm", 4, One(Double)),
        ("force_x_n", 5, One(Double)),
        ("force_y_n", 6, One(Double)),
        ("force_z_n", 7, One(Double)),
        ("torque_z_nmm", 8, One(Double)),
    ],
};

static TIMESTAMP: Schema =
    Schema { name: "google.protobuf.Timestamp", fields: &[("seconds", 1, One(Int64)), ("nanos", 2, One(Int32))] };

/// Every schema; one that is part of another comes before it.
pub(crate) static ALL: [&Schema; 14] = [
    &TIMESTAMP,
    &VECTOR3,
    &QUATERNION,
    &POSE,
    &PACKED_ELEMENT_FIELD,
    &COMPRESSED_IMAGE,
    &RAW_IMAGE,
    &POINT_CLOUD,
    &CAMERA_CALIBRATION,
    &FRAME_TRANSFORM,
    &LOG,
    &FRAME,
    &READING,
    &TRUTH,
];

impl Schema {
    /// The descriptors of this message and of all its parts, as a file contains them.
    pub(crate) fn descriptors(&self) -> Vec<u8> {
        let mut needed = vec![self.name];
        for schema in ALL.iter().rev() {
            if needed.contains(&schema.name) {
                needed.extend(schema.parts());
            }
        }
        let file = ALL.iter().filter(|schema| needed.contains(&schema.name)).map(|schema| schema.file()).collect();
        FileDescriptorSet { file }.encode_to_vec()
    }

    fn parts(&self) -> impl Iterator<Item = &'static str> {
        self.fields.iter().filter_map(|(_, _, kind)| match kind {
            Part(name) | Parts(name) => Some(*name),
            _ => None,
        })
    }

    /// Package and name.
    fn names(&self) -> (&'static str, &'static str) {
        self.name.rsplit_once('.').unwrap_or(("", self.name))
    }

    fn file_name(&self) -> String {
        if self.name == TIMESTAMP.name {
            return "google/protobuf/timestamp.proto".into();
        }
        format!("{}.proto", self.name.replace('.', "/"))
    }

    fn file(&self) -> FileDescriptorProto {
        let mut dependency: Vec<String> = Vec::new();
        for part in self.parts() {
            let files = ALL.iter().filter(|schema| schema.name == part).map(|schema| schema.file_name());
            dependency.extend(files.filter(|file| !dependency.contains(file)).collect::<Vec<_>>());
        }
        FileDescriptorProto {
            name: Some(self.file_name()),
            package: Some(self.names().0.into()),
            dependency,
            message_type: vec![self.message()],
            syntax: Some("proto3".into()),
            ..FileDescriptorProto::default()
        }
    }

    fn message(&self) -> DescriptorProto {
        let mut message = DescriptorProto { name: Some(self.names().1.into()), ..DescriptorProto::default() };
        for (name, number, kind) in self.fields {
            let (label, kind_code, type_name) = self.resolved(*kind);
            let is_optional = matches!(kind, Optional(_));
            // In the descriptor, a field that may be absent is the only member of a `oneof`.
            let oneof_index = i32::try_from(message.oneof_decl.len()).ok().filter(|_| is_optional);
            if is_optional {
                message
                    .oneof_decl
                    .push(OneofDescriptorProto { name: Some(format!("_{name}")), ..OneofDescriptorProto::default() });
            }
            if let Choice(name, values) = kind {
                message.enum_type.push(enumeration(name, values));
            }
            message.field.push(FieldDescriptorProto {
                name: Some((*name).into()),
                number: Some(*number),
                label: Some(label as i32),
                r#type: Some(kind_code as i32),
                type_name,
                json_name: Some((*name).into()),
                oneof_index,
                proto3_optional: is_optional.then_some(true),
                ..FieldDescriptorProto::default()
            });
        }
        message
    }

    fn resolved(&self, kind: Kind) -> (Label, Type, Option<String>) {
        match kind {
            One(plain) | Optional(plain) => (Label::Optional, plain, None),
            Many(plain) => (Label::Repeated, plain, None),
            Part(name) => (Label::Optional, Type::Message, Some(format!(".{name}"))),
            Parts(name) => (Label::Repeated, Type::Message, Some(format!(".{name}"))),
            Choice(name, _) => (Label::Optional, Type::Enum, Some(format!(".{}.{name}", self.name))),
        }
    }
}

fn enumeration(name: &str, values: &[&str]) -> EnumDescriptorProto {
    let value = |(number, name): (i32, &&str)| EnumValueDescriptorProto {
        name: Some((*name).into()),
        number: Some(number),
        ..EnumValueDescriptorProto::default()
    };
    let value = (0..).zip(values).map(value).collect();
    EnumDescriptorProto { name: Some(name.into()), value, ..EnumDescriptorProto::default() }
}

#[cfg(test)]
mod tests;
