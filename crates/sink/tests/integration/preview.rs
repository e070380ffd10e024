//! The picture of a run.

use crate::synthetic::Press;
use fingervision_image::{Image, Rect};
use fingervision_sink::{Preview, PreviewOptions, Sink, SinkError};
use fingervision_touch::Flag;

const PRESS: Press = Press { width: 122, height: 90, frames: 24 };
const REGION: Rect = Rect { x: 15, y: 15, width: PRESS.width, height: PRESS.height };

fn preview() -> Preview {
    Preview::new(PreviewOptions { region: Some(REGION), mm_per_px: Some(0.06) })
}

fn of_frames(frames: impl IntoIterator<Item = usize>) -> Image<[u8; 3]> {
    let mut preview = preview();
    for frame in frames {
        preview.write(&PRESS.reading(frame), &PRESS.frame(frame)).unwrap();
    }
    preview.draw().unwrap()
}

/// The part above the legends and the time plot, without title.
fn panels(picture: &Image<[u8; 3]>) -> &[[u8; 3]] {
    &picture.values()[130 * 1600..480 * 1600]
}

#[test]
fn the_strongest_frame_is_shown() {
    let (whole, strongest, weak) = (of_frames(0..24), of_frames([10]), of_frames([0]));
    assert_eq!(whole.width(), 1600);
    assert!(panels(&whole) == panels(&strongest), "the frame of full pressure is shown");
    assert!(panels(&whole) != panels(&weak), "the first frame is not");
}

#[test]
fn a_frame_that_lost_track_is_not_shown() {
    let mut preview = preview();
    let mut lost = PRESS.reading(10);
    lost.numbers.flags.raise(Flag::Lost);
    for (reading, frame) in [(PRESS.reading(0), 0), (lost, 10)] {
        preview.write(&reading, &PRESS.frame(frame)).unwrap();
    }
    assert!(panels(&preview.draw().unwrap()) == panels(&of_frames([0])));
}

#[test]
fn contact_is_outlined_and_the_force_read_out() {
    let draw = |change: fn(&mut fingervision_touch::Reading)| {
        let (mut preview, mut reading) = (preview(), PRESS.reading(10));
        change(&mut reading);
        preview.write(&reading, &PRESS.frame(10)).unwrap();
        preview.draw().unwrap()
    };
    let whole = draw(|_| {});
    assert!(panels(&whole) != panels(&draw(|reading| reading.contact = None)), "the outline is drawn");
    let without_force = draw(|reading| (reading.numbers.force_n, reading.numbers.torque_nmm) = (None, None));
    assert!(whole.values()[..130 * 1600] != without_force.values()[..130 * 1600], "the force is read out");
    assert!(panels(&whole) == panels(&without_force));
}

#[test]
fn depth_and_force_are_drawn_over_time_where_they_are_known() {
    /// Whether a column of plots below the legends contains a colour.
    fn holds(picture: &Image<[u8; 3]>, column: usize, colour: [u8; 3]) -> bool {
        let lowest = picture.height() - 230;
        (lowest..picture.height()).any(|y| (column * 533..(column + 1) * 533).any(|x| picture.at(x, y) == colour))
    }
    const BLUE: [u8; 3] = [0, 114, 178];
    const ORANGE: [u8; 3] = [213, 94, 0];
    let whole = of_frames(0..24);
    assert!((0..3).all(|column| holds(&whole, column, BLUE)), "flow, depth and normal force are lines");
    assert!(holds(&whole, 2, ORANGE) && !holds(&whole, 0, ORANGE), "shear force is a line beside the normal force");

    let mut without = preview();
    for frame in 0..24 {
        let mut reading = PRESS.reading(frame);
        (reading.numbers.force_n, reading.numbers.max_depth_mm) = (None, None);
        without.write(&reading, &PRESS.frame(frame)).unwrap();
    }
    let picture = without.draw().unwrap();
    assert!(!holds(&picture, 2, ORANGE), "no line for a force that is not known");
    assert!(holds(&picture, 2, BLUE), "the flow takes the whole width");
}

#[test]
fn nothing_seen_is_nothing_drawn() {
    assert!(matches!(preview().draw(), Err(SinkError::NoReadings)));
}

#[test]
fn odd_readings_can_be_drawn() {
    for (width, height) in [(1, 1), (300, 7), (7, 300)] {
        let press = Press { width, height, frames: 3 };
        let mut reading = press.reading(1);
        (reading.depth, reading.density) = (None, None);
        reading.flow.u.values_mut()[0] = f32::NAN;
        let mut preview =
            Preview::new(PreviewOptions { region: Some(Rect { width, height, ..REGION }), mm_per_px: None });
        preview.write(&reading, &press.frame(1)).unwrap();
        assert_eq!(preview.draw().unwrap().width(), 1600, "{width}x{height}");
        reading.valid.values_mut().fill(0);
        preview.write(&reading, &press.frame(1)).unwrap();
        preview.draw().unwrap();
    }
}

#[test]
fn a_region_of_another_size_is_refused() {
    let mut preview = Preview::new(PreviewOptions::default());
    let error = preview.write(&PRESS.reading(0), &PRESS.frame(0)).unwrap_err();
    assert_eq!(error.to_string(), "region of the camera image has 152x120 px, expected 122x90 px");
}

#[test]
fn looking_at_a_reading_allocates_nothing() {
    let mut preview = preview();
    preview.write(&PRESS.reading(0), &PRESS.frame(0)).unwrap();
    let (reading, frame) = (PRESS.reading(10), PRESS.frame(10));
    let allocations = allocation_counter::measure(|| preview.write(&reading, &frame).unwrap());
    assert_eq!(allocations.count_total, 0, "{allocations:?}");
}

#[test]
fn a_picture_is_written_as_png() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("preview.png");
    let mut preview = preview();
    preview.write(&PRESS.reading(10), &PRESS.frame(10)).unwrap();
    preview.save(&path).unwrap();
    let read = image::open(&path).unwrap().to_rgb8();
    assert_eq!(read.pixels().map(|pixel| pixel.0).collect::<Vec<_>>(), preview.draw().unwrap().values());

    let error = preview.save(folder.path()).unwrap_err();
    assert!(error.to_string().starts_with("cannot write "), "{error}");
}
