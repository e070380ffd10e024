use crate::producer::Producer;
use crate::{expect_growth, next_frame, open, wanted};
use fingervision_camera::{Bus, CameraError, Captured, Device, Event, FourCc, Mode, Video4Linux};
use fingervision_image::Frame;
use image::codecs::jpeg::JpegEncoder;
use image::{Rgb, RgbImage};
use std::path::PathBuf;
use std::time::Duration;

/// The name that the module was loaded with.
const NAME: &str = "Loopback";

fn node() -> PathBuf {
    crate::node(NAME)
}

/// A picture whose left half tells its number.
fn picture(number: u32, [width, height]: [u32; 2]) -> Vec<u8> {
    let level = |x: u32| if x < width / 2 { 25 * number as u8 } else { 200 };
    let mut bytes = Vec::new();
    JpegEncoder::new(&mut bytes).encode_image(&RgbImage::from_fn(width, height, |x, _| Rgb([level(x); 3]))).unwrap();
    bytes
}

fn pictures(size: [u32; 2]) -> Vec<Vec<u8>> {
    (0..10).map(|number| picture(number, size)).collect()
}

/// Frames per second, from the first and the last number and time.
fn rate(frames: &[(u32, f64)]) -> f64 {
    let ((first, start_s), (last, end_s)) = (frames[0], frames[frames.len() - 1]);
    f64::from(last - first) / (end_s - start_s)
}

#[test]
#[ignore = "needs the cameras of cargo xtask camera-test"]
fn motion_jpeg_arrives_at_90_frames_a_second() {
    let size = [640, 480];
    let _producer = Producer::start(node(), size, 90, pictures(size));
    let mut device = Video4Linux::default().open(&node()).unwrap();
    let layout = device.set_mode(Mode { format: FourCc::MJPG, size, frames_per_second: 90.0 }).unwrap();
    assert_eq!(layout.mode.size, size);
    device.start().unwrap();
    // Without decoding, which the emulator is too slow for.
    let whole_frame = |device: &mut Box<dyn Device>| {
        let buffer = device.next(Duration::from_secs(5)).unwrap();
        let is_whole = buffer.bytes.starts_with(&[0xff, 0xd8]) && buffer.bytes.ends_with(&[0xff, 0xd9]);
        // The module gives frame 0 the length of its buffer, and may deliver it twice.
        assert!(is_whole || buffer.sequence == 0, "{} bytes of frame {}", buffer.bytes.len(), buffer.sequence);
        (buffer.sequence, buffer.stamp_s)
    };
    let frames = std::iter::repeat_with(|| whole_frame(&mut device));
    let seen: Vec<(u32, f64)> = frames.skip_while(|(sequence, _)| *sequence == 0).take(900).collect();
    // In most of the seconds: the emulator may be stopped for a while by other programs.
    let mut rates: Vec<f64> = seen.chunks_exact(90).map(rate).collect();
    rates.sort_by(f64::total_cmp);
    assert!((85.0..95.0).contains(&rates[rates.len() / 2]), "{rates:?} frames/s");
    assert!(seen.windows(2).all(|pair| pair[1].0 > pair[0].0 && pair[1].1 > pair[0].1), "{seen:?}");
}

#[test]
#[ignore = "needs the cameras of cargo xtask camera-test"]
fn motion_jpeg_is_decoded_and_corrupt_pictures_left_out() {
    let size = [320, 240];
    let mut pictures = pictures(size);
    pictures[4].truncate(300);
    let _producer = Producer::start(node(), size, 20, pictures);
    let mut camera = open(wanted(NAME, "MJPG", size)).unwrap();
    let mut frames: Vec<Frame> = Vec::new();
    for _ in 0..40 {
        match camera.next(crate::WAIT).unwrap() {
            Some(Captured::Frame(frame)) => frames.push(frame),
            Some(Captured::Event(Event::Damaged { reason, .. })) => {
                assert_eq!(reason, "the JPEG picture is cut off");
            }
            other => panic!("{other:?}"),
        }
    }
    expect_growth(&frames);
    assert!(camera.counts().damaged >= 2, "{:?}", camera.counts());
    for frame in &frames {
        let ([left, ..], [right, ..]) = (frame.pixels.levels(10, 10), frame.pixels.levels(310, 10));
        let number = (left / 25.0).round();
        assert!((left - 25.0 * number).abs() <= 2.0 && (right - 200.0).abs() <= 2.0, "{left} and {right}");
        assert!((number - 4.0).abs() > 0.5, "the cut picture was shown");
    }
}

#[test]
#[ignore = "needs the cameras of cargo xtask camera-test"]
fn a_camera_that_falls_silent_times_out_and_goes_on_later() {
    let size = [160, 120];
    let producer = Producer::start(node(), size, 20, pictures(size));
    let mut camera = open(wanted(NAME, "MJPG", size)).unwrap();
    let before = next_frame(&mut camera);
    drop(producer);
    let short = Duration::from_millis(700);
    let error = (0..20).find_map(|_| camera.next(short).err()).unwrap();
    assert!(matches!(error, CameraError::TimedOut { .. }), "{error}");
    let _producer = Producer::start(node(), size, 20, pictures(size));
    let after = (0..20).find_map(|_| match camera.next(crate::WAIT) {
        Ok(Some(Captured::Frame(frame))) => Some(frame),
        _ => None,
    });
    let after = after.unwrap();
    assert!(after.sequence > before.sequence && after.capture_time_s > before.capture_time_s);
    assert!(camera.counts().restarts >= 1);
}
