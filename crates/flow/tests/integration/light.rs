//! A light that changes, and not everywhere alike, does not look like motion.

use fingervision_flow::{Estimate, FlowEstimator, FlowHistory, FlowParams, Start};
use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Image, Pixels, Rect};

const SIZE: (usize, usize) = (320, 240);
const FRAMES: u32 = 8;

/// A factor on the levels of a channel in frame `number`.
type Change = fn(number: u32, channel: usize, x: f32, y: f32) -> f32;

const EVEN: Change = |_, _, _, _| 1.0;
/// A lamp on the left that fades.
const SIDE: Change = |number, _, x, _| 1.0 + 0.03 * number as f32 * (x / 320.0 - 0.5);
/// Lamps that flicker behind a rolling shutter.
const ROWS: Change = |number, _, _, y| 1.0 + 0.12 * (y / 25.0 + 2.3 * number as f32).sin();
/// A white balance that is not locked.
const BALANCE: Change = |number, channel, _, _| 1.0 + 0.02 * number as f32 * (channel as f32 - 1.0);

fn motion(number: u32) -> Motion {
    Motion::RadialBump { centre_px: [160.0, 120.0], radius_px: 40.0, amplitude_px: 0.4 * f64::from(number) }
}

/// Mean error of the flow in the last frame, px, and part of the pixels that are valid.
fn judge(colour: bool, change: Change, corrects: bool) -> (f32, f32) {
    let sheet = Sheet { width: SIZE.0, height: SIZE.1, ..Sheet::default() };
    let renderer = SheetRenderer::new(&sheet).unwrap();
    let mut estimator = FlowEstimator::new(SIZE.0, SIZE.1, &FlowParams { colour, ..FlowParams::default() }).unwrap();
    let (mut picture, mut reference) = (estimator.picture(), estimator.reference());
    let mut history = FlowHistory::at_rest(SIZE.0, SIZE.1);
    let mut estimate = Estimate::new(SIZE.0, SIZE.1);
    for number in 0..FRAMES {
        let image = renderer.render(&motion(number), Light::EVEN, u64::from(number)).unwrap();
        let lit = Image::from_fn(SIZE.0, SIZE.1, |x, y| {
            let levels = image.at(x, y);
            [0, 1, 2].map(|channel| {
                let factor = change(number, channel, x as f32, y as f32);
                (factor * f32::from(levels[channel])).round().clamp(0.0, 255.0) as u8
            })
        });
        picture.load(&Pixels::Rgb8(lit), Rect::whole(SIZE.0, SIZE.1)).unwrap();
        if number == 0 {
            estimator.prepare(&picture, &mut reference);
        }
        if corrects {
            estimator.correct_light(&reference, &mut picture, &history);
        }
        estimator.estimate(&reference, &picture, Start::History(&history), &mut estimate);
        history.push(&estimate.flow);
    }
    let truth = motion(FRAMES - 1).flow(SIZE.0, SIZE.1);
    let places = (20..SIZE.1 - 20).flat_map(|y| (20..SIZE.0 - 20).map(move |x| (x, y)));
    let (mut error, mut valid, mut count) = (0.0, 0.0, 0.0);
    for (x, y) in places {
        error += (estimate.flow.u.at(x, y) - truth.u.at(x, y)).hypot(estimate.flow.v.at(x, y) - truth.v.at(x, y));
        valid += f32::from(estimate.valid.at(x, y));
        count += 1.0;
    }
    (error / count, valid / count)
}

#[test]
fn a_change_of_light_is_no_motion() {
    for colour in [true, false] {
        let (even, _) = judge(colour, EVEN, true);
        // The balance of the colours changes the pattern of grey levels.
        let by_colour = colour.then_some(("balance", BALANCE));
        for (name, change) in [("side", SIDE), ("rows", ROWS)].into_iter().chain(by_colour) {
            let (found, valid) = judge(colour, change, true);
            assert!(found < 1.1 * even && valid > 0.99, "{name}: {found} px, in even light {even} px, {valid} valid");
        }
    }
    for (name, change) in [("rows", ROWS), ("balance", BALANCE)] {
        let [(found, _), (before, _)] = [true, false].map(|corrects| judge(true, change, corrects));
        assert!(before > 1.15 * found, "{name}: {before} px without the correction, {found} px with it");
    }
}

#[test]
fn a_steady_light_changes_no_bit() {
    for colour in [true, false] {
        assert_eq!(judge(colour, EVEN, true), judge(colour, EVEN, false));
    }
}
