use crate::{expect_growth, next_event, next_frame, open, wanted};
use fingervision_camera::{Access, Bus, CameraError, Event, Video4Linux, cameras};
use fingervision_image::{Frame, Pixels};
use moq_v4l::control::{Control, Value};
use std::fs;
use std::path::PathBuf;

pub(crate) const ID: &str = "path-vivid.0-video-index0";
const SIZE: [u32; 2] = [640, 480];

fn node() -> PathBuf {
    let nodes = Video4Linux::default().nodes();
    nodes.into_iter().find(|node| node.id == ID).unwrap().path
}

/// Sets a control by its name; `None` presses a button.
pub(crate) fn set(name: &str, value: Option<i64>) {
    let device = moq_v4l::Device::with_path(node()).unwrap();
    let controls = device.query_controls().unwrap();
    let names: Vec<&str> = controls.iter().map(|control| control.name.as_str()).collect();
    let control = controls.iter().find(|control| control.name == name).unwrap_or_else(|| panic!("{names:?}"));
    device.set_control(Control { id: control.id, value: value.map_or(Value::None, Value::Integer) }).unwrap();
}

/// The driver in sysfs, where it can be unbound from its device.
pub(crate) fn driver() -> PathBuf {
    PathBuf::from("/sys/bus/platform/drivers/vivid")
}

#[test]
#[ignore = "needs the cameras of cargo xtask camera-test"]
fn a_camera_is_listed_and_its_metadata_node_hidden() {
    let bus = Video4Linux::default();
    let from_vivid = |card: &str| card.starts_with("vivid");
    assert_eq!(bus.nodes().iter().filter(|node| from_vivid(&node.card)).count(), 2, "images and metadata");
    let listed = cameras(&bus);
    let vivid: Vec<_> = listed.iter().filter(|camera| from_vivid(&camera.node.card)).collect();
    assert_eq!(vivid.len(), 1, "{vivid:?}");
    assert_eq!((vivid[0].node.id.as_str(), vivid[0].node.driver.as_str()), (ID, "vivid"));
    assert_eq!(vivid[0].access, Access::Open);
    let offers: Vec<String> = vivid[0].offers.iter().map(ToString::to_string).collect();
    assert!(offers.iter().any(|offer| offer.starts_with("YUYV 640x360 at ")), "{offers:?}");
}

#[test]
#[ignore = "needs the cameras of cargo xtask camera-test"]
fn raw_formats_are_captured_with_numbers_and_times() {
    for (format, size) in [("YUYV", [640, 360]), ("GREY", [320, 180]), ("Y16", [320, 180])] {
        let mut camera = open(wanted(ID, format, size)).unwrap();
        let frames: Vec<Frame> = (0..10).map(|_| next_frame(&mut camera)).collect();
        expect_growth(&frames);
        let counts = camera.counts();
        assert_eq!(frames[9].sequence + 1, counts.frames + counts.dropped, "{counts:?}");
        assert_eq!(counts.duplicates + counts.damaged + counts.clock_steps, 0, "{counts:?}");
        let pixels = &frames[9].pixels;
        assert_eq!(pixels.size(), (size[0] as usize, size[1] as usize));
        let is_wanted = match format {
            "YUYV" | "GREY" => matches!(pixels, Pixels::Grey8(_)),
            _ => matches!(pixels, Pixels::Grey16(_)),
        };
        assert!(is_wanted, "{format}");
        // Colour bars: from left to right the picture is not of one colour.
        let level = |x: usize| pixels.levels(x, 40)[2];
        assert!((0..size[0] as usize).any(|x| (level(x) - level(0)).abs() > 20.0), "{format}: flat");
    }
}

#[test]
#[ignore = "needs the cameras of cargo xtask camera-test"]
fn a_camera_in_use_is_busy() {
    let mut first = open(wanted(ID, "YUYV", [640, 360])).unwrap();
    next_frame(&mut first);
    let error = open(wanted(ID, "YUYV", [320, 180])).err().unwrap();
    assert!(matches!(error, CameraError::Busy { .. }), "{error}");
    next_frame(&mut first);
}

#[test]
#[ignore = "needs the cameras of cargo xtask camera-test"]
fn a_format_or_rate_that_is_not_offered_is_refused() {
    let error = open(wanted(ID, "MJPG", SIZE)).err().unwrap();
    assert_eq!(error.to_string(), format!("{ID} does not offer MJPG 640x480 px"));
    let mut capture = wanted(ID, "YUYV", [640, 360]);
    capture.frames_per_second = Some(1000.0);
    assert!(matches!(open(capture), Err(CameraError::NotOffered { .. })));
}

#[test]
#[ignore = "needs the cameras of cargo xtask camera-test"]
fn a_number_selects_nothing() {
    let error = open(wanted(node().to_str().unwrap(), "YUYV", [640, 360])).err().unwrap();
    assert_eq!(error.hint(), format!("now it is the camera {ID}: use this id"));
}

#[test]
#[ignore = "needs the cameras of cargo xtask camera-test"]
fn controls_are_locked_and_missing_ones_reported() {
    let mut capture = wanted(ID, "YUYV", [640, 360]);
    (capture.gain, capture.exposure_s) = (Some(50), Some(0.005));
    let camera = open(capture.clone()).unwrap();
    assert_eq!(camera.remarks(), ["exposure cannot be set: the camera has no such control"]);
    drop(camera);
    (capture.gain, capture.exposure_s) = (Some(5000), None);
    let camera = open(capture).unwrap();
    assert!(camera.remarks()[0].starts_with("gain is not 5000: "), "{:?}", camera.remarks());
}

#[test]
#[ignore = "needs the cameras of cargo xtask camera-test"]
fn dropped_and_damaged_frames_are_counted() {
    let mut camera = open(wanted(ID, "YUYV", [640, 360])).unwrap();
    next_frame(&mut camera);
    set("Percentage of Dropped Buffers", Some(50));
    let frames: Vec<Frame> = (0..20).map(|_| next_frame(&mut camera)).collect();
    set("Percentage of Dropped Buffers", Some(0));
    expect_growth(&frames);
    assert!(camera.counts().dropped >= 5, "{:?}", camera.counts());
    set("Inject V4L2_BUF_FLAG_ERROR", None);
    assert!(matches!(next_event(&mut camera), Event::Damaged { .. }));
    assert_eq!(camera.counts().damaged, 1);
    next_frame(&mut camera);
}

#[test]
#[ignore = "needs the cameras of cargo xtask camera-test"]
fn an_unplugged_camera_is_opened_again_when_it_is_back() {
    let mut camera = open(wanted(ID, "YUYV", [640, 360])).unwrap();
    let before = next_frame(&mut camera);
    set("Disconnect", None);
    assert_eq!(next_event(&mut camera), Event::Unplugged);
    let driver = driver();
    fs::write(driver.join("unbind"), "vivid.0").unwrap();
    assert_eq!(camera.next(std::time::Duration::from_millis(300)).unwrap(), None);
    fs::write(driver.join("bind"), "vivid.0").unwrap();
    assert_eq!(next_event(&mut camera), Event::Restarted);
    let after = next_frame(&mut camera);
    assert!(after.capture_time_s > before.capture_time_s + 0.3);
    assert!(after.sequence > before.sequence + 1, "{} after {}", after.sequence, before.sequence);
    assert_eq!(camera.counts().restarts, 1);
}

/// Runs as a user who may not open the nodes.
#[test]
#[ignore = "needs the cameras of cargo xtask camera-test"]
fn without_permission_a_camera_is_listed_but_not_opened() {
    let listed = cameras(&Video4Linux::default());
    let vivid: Vec<_> = listed.iter().filter(|camera| camera.node.id == ID).collect();
    assert_eq!(vivid.len(), 1, "{listed:?}");
    assert_eq!(vivid[0].access, Access::Denied);
    let error = open(wanted(ID, "YUYV", [640, 360])).err().unwrap();
    assert!(matches!(error, CameraError::Denied { .. }), "{error}");
}
