//! The names of a camera's codings in files.

use fingervision_source::CameraCoding;

const CODINGS: [(CameraCoding, &str); 7] = [
    (CameraCoding::MotionJpeg, "mjpeg"),
    (CameraCoding::Yuyv { is_full_range: false }, "yuyv"),
    (CameraCoding::Yuyv { is_full_range: true }, "yuyv-full-range"),
    (CameraCoding::Grey8, "grey8"),
    (CameraCoding::Grey16, "grey16"),
    (CameraCoding::Rgb8, "rgb8"),
    (CameraCoding::Rgb16, "rgb16"),
];

pub(crate) fn name(coding: CameraCoding) -> &'static str {
    CODINGS.iter().find(|(known, _)| *known == coding).map_or("", |(_, name)| name)
}

pub(crate) fn of(name: &str) -> Option<CameraCoding> {
    CODINGS.iter().find(|(_, known)| *known == name).map(|(coding, _)| *coding)
}
