use crate::bench::{Bench, SIZE};
use fingervision_image::Pixels;
use fingervision_source::{CameraCoding, CameraFrameDecoder, CameraLayout};

fn u32_at(bytes: &[u8], at: usize) -> usize {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize
}

#[test]
fn a_page_learns_about_the_sensors_and_gets_their_numbers() {
    let bench = Bench::start();
    let mut page = bench.open();
    let hello = page.text("hello");
    assert_eq!(hello["sensors"][0]["name"], "finger");
    assert_eq!(hello["sensors"][0]["size"], serde_json::json!([96, 80]));
    let readings = page.text("readings");
    assert!(readings[0]["ready_s"].as_f64() >= readings[0]["captured_s"].as_f64(), "{readings}");
    let state = page.text("state");
    assert!(state["sensors"][0]["tracked"].as_u64() > Some(0) && state["recording"].is_null(), "{state}");
}

#[test]
fn fields_have_the_documented_layout() {
    let bench = Bench::start();
    let mut page = bench.open();
    // A frame that is moved by 2 px, with its picture.
    let message = (0..200).map(|_| page.fields()).find(|message| {
        let middle = i16::from_le_bytes(message[64 + 2 * (40 * 96 + 48)..][..2].try_into().unwrap());
        middle > 100 && u32_at(message, 56) > 0
    });
    let message = message.unwrap();
    let (columns, rows) = (u32_at(&message, 32), u32_at(&message, 36));
    assert_eq!((u32_at(&message, 0), u32_at(&message, 4), (columns, rows)), (1, 0, SIZE));
    // Without a depth the field is the length of the displacement, in hundredths of a pixel.
    assert_eq!(u32_at(&message, 44), 1);
    let step = f32::from_le_bytes(message[40..44].try_into().unwrap());
    let cells = message[64..64 + 2 * columns * rows].chunks(2);
    let lengths: Vec<f32> = cells.map(|cell| f32::from(i16::from_le_bytes([cell[0], cell[1]])) * step).collect();
    let valid: Vec<f32> = lengths.iter().copied().filter(|length| *length >= 0.0).collect();
    let mean = valid.iter().sum::<f32>() / valid.len() as f32;
    assert!(valid.len() > lengths.len() / 2 && (mean - 2.0).abs() < 0.1, "{mean} px, {} valid", valid.len());
    let arrows = u32_at(&message, 48) * u32_at(&message, 52);
    let picture = 64 + 2 * columns * rows + columns * rows + 20 * arrows;
    assert_eq!(picture + u32_at(&message, 56), message.len());
    let layout = CameraLayout { coding: CameraCoding::MotionJpeg, width: SIZE.0, height: SIZE.1, row_bytes: 0 };
    assert!(matches!(CameraFrameDecoder::new(layout).decode(&message[picture..]), Ok(Pixels::Rgb8(_))));
}

#[test]
fn requests_reach_the_program_and_refusals_the_page() {
    let bench = Bench::start();
    let mut page = bench.open();
    page.text("hello");
    page.send("{\"record\":true}");
    while page.text("state")["recording"].is_null() {}
    page.send("{\"record\":false}");
    while !page.text("state")["recording"].is_null() {}
    *bench.actions.refusal.lock().unwrap() = Some("the disk is full".into());
    page.send("{\"record\":true}");
    assert_eq!(page.text("refused"), "the disk is full");
    page.send("{\"rezero\":7}");
    assert_eq!(page.text("refused"), "there is no sensor 7");
    page.send("nonsense");
    assert!(page.text("refused").as_str().unwrap().starts_with("not a request"));
    page.send("{\"ping\":1.25}");
    assert_eq!(page.text("pong")["sent"], 1.25);
}

#[test]
fn a_page_that_reads_nothing_slows_neither_tracking_nor_other_pages() {
    let bench = Bench::start();
    let _asleep: Vec<_> = (0..3).map(|_| bench.open()).collect();
    let mut awake = bench.open();
    let first = awake.text("readings")[0]["sequence"].as_u64().unwrap();
    while awake.text("readings")[0]["sequence"].as_u64().unwrap() < first + 100 {}
    let counts = bench.running.handles()[0].counts();
    assert!(counts.dropped * 20 <= counts.captured, "{counts:?}");
}

#[test]
fn a_page_that_was_closed_can_be_opened_again() {
    let bench = Bench::start();
    let mut page = bench.open();
    page.fields();
    drop(page);
    let mut again = bench.open();
    again.fields();
    again.text("readings");
}

#[test]
fn a_stop_ends_the_connections() {
    let bench = Bench::start();
    let mut page = bench.open();
    page.text("hello");
    bench.page.stop();
    page.until_closed();
    bench.running.stop();
}
