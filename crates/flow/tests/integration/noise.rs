//! The coupling of patches fits the contrast of the pattern and the noise of the pictures.

use fingervision_flow::{Estimate, FlowEstimator, FlowHistory, FlowParams, Start};
use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Image, Pixels, Rect};

const SIZE: (usize, usize) = (320, 240);

/// A bump in frame `number`; it grows by 0.1 px a frame.
fn bump(number: u32) -> Motion {
    Motion::RadialBump { centre_px: [160.0, 120.0], radius_px: 24.0, amplitude_px: 0.1 * f64::from(number) }
}

/// Mean error of the flow around the bump in the last of ten frames, px, on images whose contrast, with their noise, is scaled.
fn error_px(contrast: f32, noise_levels: f64, adapts: bool) -> f32 {
    let scaled = |level: u8| (128.0 + contrast * (f32::from(level) - 128.0)).round() as u8;
    let sheet = Sheet { width: SIZE.0, height: SIZE.1, cell_size_px: 2.5, noise_levels, ..Sheet::default() };
    let renderer = SheetRenderer::new(&sheet).unwrap();
    let mut estimator = FlowEstimator::new(SIZE.0, SIZE.1, &FlowParams::default()).unwrap();
    let (mut picture, mut reference) = (estimator.picture(), estimator.reference());
    let mut history = FlowHistory::at_rest(SIZE.0, SIZE.1);
    let mut estimate = Estimate::new(SIZE.0, SIZE.1);
    for number in 0..10 {
        let image = renderer.render(&bump(number), Light::EVEN, u64::from(number)).unwrap();
        let image = Image::from_fn(SIZE.0, SIZE.1, |x, y| image.at(x, y).map(scaled));
        picture.load(&Pixels::Rgb8(image), Rect::whole(SIZE.0, SIZE.1)).unwrap();
        if number == 0 {
            estimator.prepare(&picture, &mut reference);
        } else if adapts {
            estimator.adapt(&mut reference);
        }
        estimator.estimate(&reference, &picture, Start::History(&history), &mut estimate);
        history.push(&estimate.flow);
    }
    let truth = bump(9).flow(SIZE.0, SIZE.1);
    let (mut sum, mut count) = (0.0, 0.0);
    for y in 60..180 {
        for x in 100..220 {
            sum += (estimate.flow.u.at(x, y) - truth.u.at(x, y)).hypot(estimate.flow.v.at(x, y) - truth.v.at(x, y));
            count += 1.0;
        }
    }
    sum / count
}

#[test]
fn a_weak_contrast_does_not_flatten_the_flow() {
    let strong = error_px(1.0, 2.0, true);
    for contrast in [0.4, 0.2] {
        let weak = error_px(contrast, 2.0, true);
        assert!(weak < 1.7 * strong, "{weak} px at a contrast of {contrast}, {strong} px at the full one");
    }
}

#[test]
fn noise_does_not_break_the_bonds_between_patches() {
    let [adapted, fixed] = [true, false].map(|adapts| error_px(1.0, 20.0, adapts));
    assert!(adapted < 0.15 && fixed > 1.5 * adapted, "{adapted} px with the reference adapted, {fixed} px without");
}

#[test]
fn noise_alone_is_no_texture() {
    let mut state = 1_u32;
    let mut uniform = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state) / f64::from(u32::MAX) - 0.5
    };
    // Standard deviation 2.
    let mut level = || (90.0 + 4.0 * (uniform() + uniform() + uniform())).round() as u8;
    let image = Image::from_fn(SIZE.0, SIZE.1, |_, _| [level(), level(), level()]);
    for colour in [true, false] {
        let estimator = FlowEstimator::new(SIZE.0, SIZE.1, &FlowParams { colour, ..FlowParams::default() }).unwrap();
        let (mut picture, mut reference) = (estimator.picture(), estimator.reference());
        picture.load(&Pixels::Rgb8(image.clone()), Rect::whole(SIZE.0, SIZE.1)).unwrap();
        estimator.prepare(&picture, &mut reference);
        assert!(
            reference.textured() < 0.02,
            "{} of an image of noise has texture, colour {colour}",
            reference.textured()
        );
    }
}
