//! Frames whose colour has less resolution than their brightness are tracked by their brightness.

use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Frame, Image, LUMA_WEIGHTS, Pixels};
use fingervision_touch::{Fields, Profile, Tracker};

const SIZE: (usize, usize) = (200, 160);

fn brightness(levels: [f32; 3]) -> f32 {
    LUMA_WEIGHTS.iter().zip(levels).map(|(weight, level)| weight * level).sum()
}

/// Frame `number` of a growing bump; `is_coarse` stores colour for blocks of 2×2 px, as most cameras and videos do.
fn frame(number: u32, is_coarse: bool) -> Frame {
    let sheet = Sheet { width: SIZE.0, height: SIZE.1, cell_size_px: 2.5, ..Sheet::default() };
    let motion = Motion::radial_bump(sheet.centre_px(), 0.3 * f64::from(number % 5));
    let image = SheetRenderer::new(&sheet).unwrap().render(&motion, Light::EVEN, u64::from(number)).unwrap();
    let levels = |x: usize, y: usize| image.at(x, y).map(f32::from);
    let coarse = Image::from_fn(SIZE.0, SIZE.1, |x, y| {
        let (left, top) = (x / 2 * 2, y / 2 * 2);
        let places = [(left, top), (left + 1, top), (left, top + 1), (left + 1, top + 1)];
        let own = brightness(levels(x, y));
        std::array::from_fn(|channel| {
            let colour = |(x, y): (usize, usize)| levels(x, y)[channel] - brightness(levels(x, y));
            (own + places.map(colour).iter().sum::<f32>() / 4.0).round().clamp(0.0, 255.0) as u8
        })
    });
    let pixels = Pixels::Rgb8(if is_coarse { coarse } else { image });
    Frame { sequence: u64::from(number), capture_time_s: f64::from(number) / 90.0, pixels }
}

fn tracker(is_colour: bool) -> Tracker {
    Tracker::new(&Profile::default(), SIZE, is_colour, Fields::NONE).unwrap()
}

#[test]
fn coarse_colour_is_tracked_as_grey_bit_for_bit() {
    let (mut found, mut grey) = (tracker(true), tracker(false));
    for number in 0..4 {
        let frame = frame(number, true);
        let (found, grey) = (found.track(&frame).unwrap(), grey.track(&frame).unwrap());
        assert_eq!((&found.flow, &found.valid), (&grey.flow, &grey.valid), "frame {number}");
    }
    assert!(!found.uses_colour());
}

#[test]
fn every_reference_decides_anew() {
    let mut found = tracker(true);
    found.track(&frame(0, true)).unwrap();
    assert!(!found.uses_colour());
    found.rezero();
    let mut new = tracker(true);
    for number in 5..8 {
        let frame = frame(number, false);
        let (found, new) = (found.track(&frame).unwrap(), new.track(&frame).unwrap());
        assert_eq!((&found.flow, &found.valid), (&new.flow, &new.valid), "frame {number}");
    }
    assert!(found.uses_colour());
}
