//! Torn images: some of their rows are those of an earlier frame.

use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Frame, Image, Pixels};
use fingervision_touch::{Fields, Flag, Profile, Tracker};

use crate::elastic_tracking::Press;

const SIZE: (usize, usize) = (240, 400);

/// An image whose rows in this range are those of an earlier one.
fn torn(mut image: Image<[u8; 3]>, earlier: &Image<[u8; 3]>, rows: std::ops::Range<usize>) -> Image<[u8; 3]> {
    for row in rows {
        image.row_mut(row).copy_from_slice(earlier.row(row));
    }
    image
}

/// Images of a sheet that is stretched near its upper end, by 1 px more in each. The noise differs.
fn images() -> Vec<Image<[u8; 3]>> {
    let sheet = Sheet { width: SIZE.0, height: SIZE.1, ..Sheet::default() };
    let renderer = SheetRenderer::new(&sheet).unwrap();
    let motion = |frame: u32| Motion::radial_bump([119.5, 50.0], f64::from(frame));
    (0..8).map(|frame| renderer.render(&motion(frame), Light::EVEN, u64::from(frame)).unwrap()).collect()
}

/// For each image, whether it is flagged as torn.
fn flagged(images: Vec<Image<[u8; 3]>>) -> Vec<bool> {
    let mut tracker = Tracker::new(&Profile::default(), SIZE, true, Fields::NONE).unwrap();
    let mut show = |(sequence, image)| {
        let frame = Frame { sequence, capture_time_s: sequence as f64 / 90.0, pixels: Pixels::Rgb8(image) };
        tracker.track(&frame).unwrap().flags.has(Flag::TornImage)
    };
    (0..).zip(images).map(&mut show).collect()
}

#[test]
fn upper_or_lower_rows_of_an_earlier_frame_are_flagged() {
    for (back, rows) in [(1, 100..400), (1, 40..400), (2, 100..400), (4, 200..400), (1, 0..80), (3, 0..150)] {
        let mut shown = images();
        shown[5] = torn(shown[5].clone(), &shown[5 - back], rows.clone());
        let flagged = flagged(shown);
        let only_the_sixth: Vec<bool> = (0..8).map(|frame| frame == 5).collect();
        assert_eq!(flagged, only_the_sixth, "{rows:?}, {back} before");
    }
}

/// Its driver was slower than the camera: the next image begins with the same rows, or ends with them.
#[test]
fn after_an_image_with_rows_of_a_later_frame_that_one_is_flagged() {
    let mut shown = images();
    shown[5] = torn(shown[5].clone(), &shown[6], 100..400);
    let flagged = flagged(shown);
    assert_eq!((0..8).filter(|&frame| flagged[frame]).collect::<Vec<_>>(), [6]);
}

#[test]
fn rows_that_repeat_where_nothing_moves_are_not_flagged() {
    let mut shown = images();
    assert!(!flagged(shown.clone()).contains(&true));
    for frame in 1..8 {
        // The gel beside these four compared rows moves by up to 0.06 px in four frames.
        shown[frame] = torn(shown[frame].clone(), &shown[0], 368..400);
    }
    assert!(!flagged(shown.clone()).contains(&true), "as in a video, which stores what does not move only once");
    let whole: Vec<_> = shown.iter().flat_map(|image| [image.clone(), image.clone()]).collect();
    assert!(!flagged(whole).contains(&true), "every image twice");
}

#[test]
fn rows_that_repeat_up_to_a_border_that_is_not_straight_are_not_flagged() {
    let mut shown = images();
    for frame in 1..8 {
        let (left, right) = (140, 180);
        let earlier = shown[frame - 1].clone();
        for (row, columns) in (left..400).map(|row| (row, 0..120)).chain((right..400).map(|row| (row, 120..240))) {
            shown[frame].row_mut(row)[columns.clone()].copy_from_slice(&earlier.row(row)[columns]);
        }
    }
    assert!(!flagged(shown).contains(&true), "blocks of a video");
}

#[test]
fn black_rows_beside_gel_that_moves_are_not_flagged() {
    for rows in [0..64, 0..48] {
        let mut shown = images();
        for image in &mut shown {
            rows.clone().for_each(|row| image.row_mut(row).fill([0; 3]));
        }
        assert!(!flagged(shown).contains(&true), "{rows:?}");
    }
}

/// Its unexplained motion is large, and that of the letter is moderate: the next image must not have to fit better than without it.
#[test]
fn a_torn_image_does_not_end_the_measurement_of_a_press() {
    let mut press = Press::new(
        "[indenter]\nshape = 'letter'\ntext = 'R'\nheight_mm = 10.0\n\
         [motion]\nframes = 6\nkeyframes = [{ at = 5, depth_mm = 1.5 }]",
    );
    let (mut whole, mut tracker) = (press.tracker(), press.tracker());
    for pose in 0..6 {
        let mut frame = press.frame(pose);
        whole.track(&frame).unwrap();
        if pose == 3 {
            let (Pixels::Rgb8(image), Pixels::Rgb8(earlier)) = (&frame.pixels, press.frame(1).pixels) else {
                panic!("simulated images have colour")
            };
            frame.pixels = Pixels::Rgb8(torn(image.clone(), &earlier, 300..480));
        }
        let reading = tracker.track(&frame).unwrap();
        assert_eq!(reading.flags.has(Flag::TornImage), pose == 3, "pose {pose}: {}", reading.flags);
        if pose == 3 {
            assert!(reading.flags.has(Flag::GelMisfit), "this tear does not test what follows a misfit");
        } else {
            let [(force_n, flags), (expected_n, expected)] =
                [reading, whole.reading()].map(|reading| (reading.force_n.unwrap()[2], reading.flags));
            assert!((force_n - expected_n).abs() <= 0.01 * expected_n, "pose {pose}: {force_n}, not {expected_n} N");
            assert_eq!(flags, expected, "pose {pose}");
        }
    }
}
