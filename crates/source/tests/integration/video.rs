//! Video files compared with the output of `FFmpeg`, and files that are refused.

use fingervision_image::Frame;
use fingervision_source::{Options, Source, SourceError, open};
use std::fs;
use std::path::PathBuf;

/// Levels by which a pixel may differ from the reference: both round.
const H264_TOLERANCE: u8 = 1;
/// JPEG leaves the inverse transform and the interpolation of chroma to the decoder.
const JPEG_TOLERANCE: u8 = 5;

fn clip(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("testdata").join(name)
}

fn frames(source: &mut dyn Source) -> Vec<Frame> {
    std::iter::from_fn(|| source.next_frame().unwrap()).collect()
}

fn all_frames(name: &str) -> Vec<Frame> {
    frames(open(clip(name), &Options::default()).unwrap().as_mut())
}

/// Compares all times, and every `step`-th picture, with what `FFmpeg` makes of a clip.
fn assert_equals_reference(name: &str, step: usize, tolerance: u8) {
    let mut source = open(clip(name), &Options::default()).unwrap();
    let frames = frames(source.as_mut());
    let times = fs::read_to_string(clip(name).with_extension("times")).unwrap();
    let times: Vec<f64> = times.lines().map(|line| line.parse().unwrap()).collect();
    assert_eq!(source.frame_count(), Some(times.len() as u64), "{name}");
    assert_eq!(frames.len(), times.len(), "{name}");
    for (frame, time_s) in frames.iter().zip(&times) {
        // All clips were recorded at 30 frames per second; where one is missing, its number is.
        let sequence = (30.0 * (time_s - times[0])).round() as u64;
        assert_eq!(frame.sequence, sequence, "{name}");
        assert_eq!(frame.pixels.size(), source.size(), "{name}");
        let found = frame.capture_time_s;
        // The reference is written with six digits.
        assert!((found - time_s).abs() < 1e-6, "{name}: frame {sequence} at {found} s, expected {time_s} s");
    }
    let reference = image::open(clip(name).with_extension("png")).unwrap().into_rgb8();
    let shown = frames.iter().step_by(step);
    let (width, height) = source.size();
    assert_eq!(reference.dimensions(), (width as u32, (height * shown.len()) as u32), "{name}");
    for (index, frame) in shown.enumerate() {
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let wanted = reference.get_pixel(x as u32, (index * height + y) as u32).0;
            let found = frame.pixels.levels(x, y).map(|level| level as u8);
            let difference = found.into_iter().zip(wanted).map(|(a, b)| a.abs_diff(b)).max().unwrap();
            let place = format!("{name}: frame {} at ({x}, {y})", frame.sequence);
            assert!(difference <= tolerance, "{place}: {found:?}, expected {wanted:?}");
        }
    }
}

#[test]
fn b_frames_come_in_the_order_in_which_they_are_shown() {
    assert_equals_reference("b_frames.mp4", 1, H264_TOLERANCE);
}

#[test]
fn a_phone_clip_is_turned_upright_and_its_sound_left_aside() {
    assert_equals_reference("phone.mp4", 4, H264_TOLERANCE);
    assert_eq!(all_frames("phone.mp4")[0].pixels.size(), (30, 46));
}

#[test]
fn uneven_frame_times_are_kept() {
    assert_equals_reference("uneven.mp4", 4, H264_TOLERANCE);
}

#[test]
fn frames_that_an_edit_list_hides_are_not_shown() {
    assert_equals_reference("trimmed.mp4", 4, H264_TOLERANCE);
}

#[test]
fn a_fragmented_file_with_fuller_chroma_is_read() {
    assert_equals_reference("fragments.mov", 4, H264_TOLERANCE);
}

#[test]
fn motion_jpeg_is_read_from_avi_and_mov() {
    assert_equals_reference("colour.avi", 4, JPEG_TOLERANCE);
    assert_equals_reference("jpeg.mov", 4, JPEG_TOLERANCE);
}

#[test]
fn motion_jpeg_is_read_from_mp4() {
    assert_equals_reference("jpeg.mp4", 4, JPEG_TOLERANCE);
    assert_equals_reference("odd_jpeg.mp4", 4, JPEG_TOLERANCE);
}

#[test]
fn reading_twice_gives_the_same_bits() {
    for name in ["b_frames.mp4", "colour.avi"] {
        assert_eq!(all_frames(name), all_frames(name));
    }
}

#[test]
fn a_video_describes_itself() {
    let source = open(clip("colour.avi"), &Options::default()).unwrap();
    let description = source.description();
    assert!(description.ends_with("colour.avi: motion JPEG video, 12 frames, 48x32 px 8-bit colour"), "{description}");
}

#[test]
fn what_is_not_read_is_named_with_the_command_that_converts_it() {
    let cases = [
        ("h265.mp4", "H.265 (HEVC) video in MP4"),
        ("vp9.webm", "Matroska or WebM video"),
        ("ten_bit.mp4", "H.264 with 10 bits a channel"),
        ("mpeg2.mp4", "MPEG-2 video in MP4"),
        ("h264.avi", "H264 video in AVI"),
    ];
    for (name, what) in cases {
        let error = open(clip(name), &Options::default()).err().unwrap();
        assert!(error.to_string().ends_with(&format!("{name}: {what} is not supported")), "{error}");
        let hint = error.hint().unwrap();
        assert!(hint.starts_with("convert it: ffmpeg -i '") && hint.contains("libx264"), "{hint}");
    }
}

#[test]
fn a_video_of_one_frame_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("one.avi");
    // The second chunk's name is changed, and those of all that follow.
    let mut bytes = fs::read(clip("colour.avi")).unwrap();
    let chunks: Vec<usize> = places(&bytes, b"00dc").collect();
    let movie = places(&bytes, b"movi").next().unwrap();
    let frames = chunks.into_iter().filter(|&chunk| chunk > movie);
    for chunk in frames.skip(1) {
        bytes[chunk..chunk + 4].copy_from_slice(b"JUNK");
    }
    fs::write(&path, bytes).unwrap();
    let error = open(&path, &Options::default()).err().unwrap();
    assert!(matches!(error, SourceError::TooFewFrames { count: 1, .. }), "{error}");
}

#[test]
fn a_dropped_frame_in_an_avi_leaves_its_number_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dropped.avi");
    let mut bytes = fs::read(clip("colour.avi")).unwrap();
    // An empty frame before the fourth, as a recorder writes it that missed one.
    let movie = places(&bytes, b"movi").next().unwrap();
    let fourth = places(&bytes, b"00dc").filter(|&chunk| chunk > movie).nth(3).unwrap();
    bytes.splice(fourth..fourth, *b"00dc\0\0\0\0");
    fs::write(&path, bytes).unwrap();
    let mut source = open(&path, &Options::default()).unwrap();
    let sequences: Vec<u64> = frames(source.as_mut()).iter().map(|frame| frame.sequence).collect();
    assert_eq!(sequences[..5], [0, 1, 2, 4, 5]);
}

#[test]
fn a_frame_of_two_interlaced_fields_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fields.avi");
    let mut bytes = fs::read(clip("colour.avi")).unwrap();
    let movie = places(&bytes, b"movi").next().unwrap();
    let first = places(&bytes, b"00dc").find(|&chunk| chunk > movie).unwrap();
    let len = u32::from_le_bytes(bytes[first + 4..first + 8].try_into().unwrap()) as usize;
    // The first frame's picture once more in the same chunk, as recorders of analogue video write the second field.
    let mut frame = bytes[first + 8..first + 8 + len].to_vec();
    frame.extend_from_within(..);
    bytes[first + 4..first + 8].copy_from_slice(&(2 * len as u32).to_le_bytes());
    bytes.splice(first + 8..first + 8 + len + len % 2, frame);
    fs::write(&path, bytes).unwrap();
    let error = open(&path, &Options::default()).err().unwrap();
    assert!(error.to_string().contains("interlaced"), "{error}");
    assert!(error.hint().unwrap().contains("yadif"), "{:?}", error.hint());
}

fn places<'a>(bytes: &'a [u8], text: &'a [u8]) -> impl Iterator<Item = usize> + 'a {
    bytes.windows(text.len()).enumerate().filter(move |(_, window)| *window == text).map(|(place, _)| place)
}
