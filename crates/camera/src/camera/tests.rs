use super::*;
use crate::FourCc;
use crate::fake::{Coming, FakeBus, frame};
use fingervision_image::Pixels;

const WAIT: Duration = Duration::ZERO;

fn opened(bus: &FakeBus, capture: CaptureSection) -> Result<Camera, CameraError> {
    Camera::open(Box::new(bus.clone()), capture)
}

fn camera(bus: &FakeBus) -> Camera {
    opened(bus, CaptureSection::default()).unwrap()
}

/// The number and the first grey level of the next frame.
fn next_frame(camera: &mut Camera) -> (u64, u8) {
    match camera.next(WAIT).unwrap() {
        Some(Captured::Frame(Frame { sequence, pixels: Pixels::Grey8(image), .. })) => (sequence, image.at(0, 0)),
        other => panic!("not a grey frame: {other:?}"),
    }
}

fn next_event(camera: &mut Camera) -> Event {
    match camera.next(WAIT).unwrap() {
        Some(Captured::Event(event)) => event,
        other => panic!("not an event: {other:?}"),
    }
}

#[test]
fn frames_have_the_drivers_number_and_time() {
    let bus = FakeBus::new(&["left"]);
    bus.send(&[3, 4, 6]);
    let mut camera = camera(&bus);
    let Some(Captured::Frame(first)) = camera.next(WAIT).unwrap() else { panic!("a frame") };
    assert_eq!((first.sequence, first.pixels.size()), (0, (4, 2)));
    assert!((first.capture_time_s - 10.03).abs() < 1e-9);
    assert_eq!([next_frame(&mut camera), next_frame(&mut camera)], [(1, 4), (3, 6)]);
    assert_eq!(camera.counts(), Counts { frames: 3, dropped: 1, ..Counts::default() });
    assert_eq!(camera.mode(), Mode { format: FourCc::GREY, size: [4, 2], frames_per_second: 100.0 });
}

#[test]
fn a_repeated_frame_is_not_handed_out() {
    let bus = FakeBus::new(&["left"]);
    bus.send(&[1, 2, 2, 1, 3]);
    let mut camera = camera(&bus);
    let long = Duration::from_mins(1);
    let sequences: Vec<u64> = (0..3)
        .map(|_| match camera.next(long).unwrap() {
            Some(Captured::Frame(frame)) => frame.sequence,
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(sequences, [0, 1, 2]);
    assert_eq!(camera.counts().duplicates, 2);
}

#[test]
fn a_camera_that_only_repeats_a_frame_times_out() {
    let bus = FakeBus::new(&["left"]);
    bus.send(&[1, 1]);
    let mut camera = camera(&bus);
    next_frame(&mut camera);
    assert!(matches!(camera.next(WAIT), Err(CameraError::TimedOut { .. })));
}

#[test]
fn damaged_frames_are_counted_and_left_out() {
    let bus = FakeBus::new(&["left"]);
    bus.send(&[0]);
    bus.with(|world| {
        world.coming.push_back(frame(1, 5));
        let Coming::Frame { sequence, stamp_s, bytes, .. } = frame(2, 8) else { return };
        world.coming.push_back(Coming::Frame { sequence, stamp_s, bytes, is_damaged: true });
    });
    bus.send(&[3]);
    let mut camera = camera(&bus);
    next_frame(&mut camera);
    assert_eq!(next_event(&mut camera).to_string(), "frame 1 is left out: cut off: 5 of 8 bytes");
    assert_eq!(next_event(&mut camera).to_string(), "frame 2 is left out: the driver reports it as damaged");
    assert_eq!(next_frame(&mut camera), (3, 3));
    assert_eq!(camera.counts(), Counts { frames: 2, damaged: 2, ..Counts::default() });
}

#[test]
fn corrupt_jpeg_frames_do_not_end_capture() {
    let mut jpeg = Vec::new();
    let picture = image::RgbImage::from_fn(24, 16, |x, y| image::Rgb([9 * x as u8, 9 * y as u8, 30]));
    image::codecs::jpeg::JpegEncoder::new(&mut jpeg).encode_image(&picture).unwrap();
    let cut = jpeg[..jpeg.len() / 2].to_vec();
    let bus = FakeBus::new(&["left"]);
    bus.with(|world| {
        for (sequence, bytes) in [jpeg.clone(), cut, vec![0x55; 500], jpeg].into_iter().enumerate() {
            let (sequence, stamp_s) = (sequence as u32, sequence as f64 / 90.0);
            world.coming.push_back(Coming::Frame { sequence, stamp_s, bytes, is_damaged: false });
        }
    });
    let mut camera = opened(&bus, CaptureSection { format: Some("mjpg".into()), ..CaptureSection::default() }).unwrap();
    let handed: Vec<Captured> = (0..4).map(|_| camera.next(WAIT).unwrap().unwrap()).collect();
    assert!(matches!(&handed[0], Captured::Frame(frame) if frame.pixels.size() == (24, 16)), "{:?}", handed[0]);
    assert!(matches!(&handed[1], Captured::Event(Event::Damaged { sequence: 1, .. })));
    assert!(matches!(&handed[2], Captured::Event(Event::Damaged { sequence: 2, .. })));
    assert!(matches!(&handed[3], Captured::Frame(frame) if frame.sequence == 3));
}

#[test]
fn an_unplugged_camera_is_found_again_by_its_id() {
    let bus = FakeBus::new(&["left", "right"]);
    bus.send(&[0, 1]);
    bus.with(|world| world.coming.push_back(Coming::Error(19)));
    let mut camera =
        opened(&bus, CaptureSection { camera: Some("right".into()), ..CaptureSection::default() }).unwrap();
    assert_eq!([next_frame(&mut camera), next_frame(&mut camera)], [(0, 0), (1, 1)]);
    bus.with(|world| world.ids = vec!["left".into()]);
    assert_eq!(next_event(&mut camera), Event::Unplugged);
    assert_eq!(camera.next(WAIT).unwrap(), None);
    assert_eq!(camera.next(WAIT).unwrap(), None);
    // It comes back with another number, after three looks of the next call.
    bus.with(|world| world.back = Some((2, ["new", "left", "right"].map(Into::into).to_vec())));
    assert_eq!(camera.next(Duration::from_mins(1)).unwrap(), Some(Captured::Event(Event::Restarted)));
    assert_eq!(camera.node().path.to_str(), Some("/dev/video2"));
    // The driver counts from 0 again, 1 s later.
    bus.with(|world| {
        world.coming.push_back(Coming::Frame { sequence: 0, stamp_s: 11.01, bytes: vec![7; 8], is_damaged: false });
    });
    assert_eq!(next_frame(&mut camera), (101, 7));
    assert_eq!(camera.counts(), Counts { frames: 3, dropped: 99, restarts: 1, ..Counts::default() });
}

#[test]
fn a_camera_that_is_silent_times_out_and_is_started_again() {
    let bus = FakeBus::new(&["left"]);
    bus.with(|world| world.coming.push_back(Coming::Silence));
    let mut camera = camera(&bus);
    let error = camera.next(WAIT).unwrap_err();
    assert_eq!(error.to_string(), "left: no frame in 0.0 s");
    assert_eq!(next_event(&mut camera), Event::Restarted);
    bus.send(&[0]);
    assert_eq!(next_frame(&mut camera), (0, 0));
}

#[test]
fn a_camera_that_fails_again_and_again_is_an_error() {
    let bus = FakeBus::new(&["left"]);
    bus.with(|world| world.coming.extend((0..100).map(|_| Coming::Error(5))));
    let mut camera = camera(&bus);
    let error = (0..200).find_map(|_| camera.next(WAIT).err()).unwrap();
    assert!(matches!(&error, CameraError::Io { doing: "capture", .. }), "{error}");
    // One that cannot be opened any more, too.
    let bus = FakeBus::new(&["left"]);
    bus.with(|world| world.coming.push_back(Coming::Error(19)));
    let mut camera = opened(&bus, CaptureSection::default()).unwrap();
    assert_eq!(next_event(&mut camera), Event::Unplugged);
    bus.with(|world| world.open_error = Some(13));
    let error = (0..200).find_map(|_| camera.next(WAIT).err()).unwrap();
    assert!(matches!(&error, CameraError::Denied { .. }), "{error}");
}

#[test]
fn what_prevents_opening_is_named() {
    let bus = FakeBus::new(&["left"]);
    let error = |open, start| {
        bus.with(|world| (world.open_error, world.start_error) = (open, start));
        opened(&bus, CaptureSection::default()).err().unwrap()
    };
    let denied = error(Some(13), None);
    assert_eq!(denied.to_string(), "left: no permission to open /dev/video0");
    assert!(denied.hint().contains("usermod -aG video"));
    assert_eq!(error(None, Some(16)).to_string(), "left: busy, another program uses it");
    let bandwidth = error(None, Some(28));
    assert_eq!(bandwidth.to_string(), "left: not enough USB bandwidth for GREY 4x2 px at 100 frames/s");
}

#[test]
fn a_mode_that_is_not_offered_is_refused_with_what_is() {
    let bus = FakeBus::new(&["left"]);
    let capture =
        CaptureSection { format: Some("YUYV".into()), size_px: Some([640, 480]), ..CaptureSection::default() };
    let error = opened(&bus, capture).err().unwrap();
    assert_eq!(error.to_string(), "left does not offer YUYV 640x480 px");
    assert_eq!(error.hint(), "it offers GREY 4x2 at 100, 50 frames/s; MJPG 24x16 at 90 frames/s");
}

#[test]
fn a_rate_that_the_driver_changes_is_remarked() {
    let bus = FakeBus::new(&["left"]);
    bus.with(|world| world.forced_rate = Some(15.0));
    assert_eq!(camera(&bus).remarks(), ["the rate is 15 frames/s instead of 100 frames/s: the driver chose it"]);
}
