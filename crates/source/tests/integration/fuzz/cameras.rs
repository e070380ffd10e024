//! Damaged frames of a camera, all of them decoded by the same decoder, as in a live sensor.

use std::io::Cursor;

use fingervision_fuzz::{Form, Parser};
use fingervision_image::{Image, Pixels};
use fingervision_source::{CameraCoding, CameraFrameDecoder, CameraLayout};
use image::{ImageFormat, Rgb, RgbImage};

const SIZE: (usize, usize) = (37, 22);

/// The most memory that one frame may take, bytes.
const MOST_BYTES: u64 = 16 << 20;

fn layout(coding: CameraCoding) -> CameraLayout {
    CameraLayout { coding, width: SIZE.0, height: SIZE.1, row_bytes: 0 }
}

fn jpeg() -> Vec<u8> {
    let level = |x: u32, y: u32| (x * 31 + y * 57 + x * y) as u8;
    let picture = RgbImage::from_fn(SIZE.0 as u32, SIZE.1 as u32, |x, y| Rgb([level(x, y), level(y, x), 7]));
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Jpeg).unwrap();
    bytes.into_inner()
}

/// Without its Huffman tables, as many cameras send it.
fn bare(jpeg: &[u8]) -> Vec<u8> {
    let mut bare = jpeg.to_vec();
    while let Some(at) = bare.windows(2).position(|pair| pair == [0xff, 0xc4]) {
        let len = usize::from(u16::from_be_bytes([bare[at + 2], bare[at + 3]]));
        bare.drain(at..at + 2 + len);
    }
    bare
}

fn run(name: &'static str, mut decoder: CameraFrameDecoder, files: Vec<Vec<u8>>) {
    let mut pixels = Pixels::Grey8(Image::filled(0, 0, 0));
    Parser { name, form: Form::Binary, files, inputs: 3000, most_bytes: MOST_BYTES }.run(|bytes| {
        let is_decoded = decoder.decode_into(bytes, &mut pixels).is_ok();
        assert!(!is_decoded || pixels.size() == SIZE, "a frame of {:?} px", pixels.size());
        is_decoded
    });
}

#[test]
fn a_damaged_camera_jpeg_is_decoded_or_refused() {
    let files = vec![jpeg(), bare(&jpeg())];
    run("camera jpeg", CameraFrameDecoder::new(layout(CameraCoding::MotionJpeg)), files.clone());
    run("camera jpeg, luma", CameraFrameDecoder::for_tracking(layout(CameraCoding::MotionJpeg)), files);
}

#[test]
fn a_damaged_packed_frame_is_decoded_or_refused() {
    for (coding, row_bytes) in [
        (CameraCoding::Yuyv { is_full_range: false }, 4 * SIZE.0.div_ceil(2)),
        (CameraCoding::Grey16, 2 * SIZE.0),
        (CameraCoding::Rgb8, 3 * SIZE.0),
    ] {
        let files = vec![(0..row_bytes * SIZE.1).map(|at| (at * 37) as u8).collect()];
        run("camera packed", CameraFrameDecoder::new(layout(coding)), files.clone());
        run("camera packed, luma", CameraFrameDecoder::for_tracking(layout(coding)), files);
    }
}
