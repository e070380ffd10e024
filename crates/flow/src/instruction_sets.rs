//! Compares the flow of all instruction sets of the processor: only rounding may differ.

use fearless_simd::Level;
use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Pixels, Rect};

use crate::{Estimate, FlowEstimator, FlowField, FlowParams, Picture, Preset, Start, ValidityParams};

/// Width and height are no multiples of the number of lanes in a register.
const SIZE: (usize, usize) = (163, 117);

/// Largest allowed [`differences`] between instruction sets. Some fuse multiply and add, others do not, and every step
/// starts from the rounding errors of the one before. Measured: 3e-5 px for the flow, 1.4e-4 for the deviation. A pixel
/// close to a limit may be valid with one set only.
const TOLERANCES: [f32; 3] = [1e-4, 5e-4, 1e-3];

/// The processor's instruction sets, the lowest first.
pub(crate) fn levels() -> Vec<Level> {
    let mut levels = vec![Level::baseline()];
    #[cfg(target_arch = "x86_64")]
    {
        levels.extend(Level::new().as_sse4_2().map(Level::Sse4_2));
        levels.extend(Level::new().as_avx2().map(Level::Avx2));
    }
    levels.push(Level::new());
    levels
}

fn load(estimator: &FlowEstimator, motion: &Motion, seed: u64) -> Picture {
    let sheet = Sheet { width: SIZE.0, height: SIZE.1, ..Sheet::default() };
    let image = SheetRenderer::new(&sheet).unwrap().render(motion, Light::EVEN, seed).unwrap();
    let mut picture = estimator.picture();
    picture.load(&Pixels::Rgb8(image), Rect::whole(SIZE.0, SIZE.1)).unwrap();
    picture
}

/// The flow of a bump of 3 px, with a cold start or starting from zero flow.
fn flow(params: &FlowParams, level: Level, is_cold: bool) -> Estimate {
    let mut estimator = FlowEstimator::with_level(SIZE.0, SIZE.1, params, level).unwrap();
    let mut reference = estimator.reference();
    estimator.prepare(&load(&estimator, &Motion::STILL, 1), &mut reference);
    let current = load(&estimator, &Motion::radial_bump([80.0, 60.0], 3.0), 2);
    let rest = FlowField::zero(SIZE.0, SIZE.1);
    let start = if is_cold { Start::Search(None) } else { Start::Flow(&rest) };
    let mut estimate = Estimate::new(SIZE.0, SIZE.1);
    estimator.estimate(&reference, &current, start, &mut estimate);
    estimate
}

/// The largest difference of the flow where either is valid, px; the largest relative difference of the deviation, where both
/// are valid; and the part of the pixels where only one is valid.
fn differences(a: &Estimate, b: &Estimate) -> [f32; 3] {
    let (mut flow_px, mut deviation, mut validity) = (0.0_f32, 0.0_f32, 0.0);
    for (x, y) in (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y))) {
        let difference = (a.flow.u.at(x, y) - b.flow.u.at(x, y)).hypot(a.flow.v.at(x, y) - b.flow.v.at(x, y));
        assert!(difference.is_finite(), "({x}, {y})");
        let is_valid = a.valid.at(x, y) == 1 || b.valid.at(x, y) == 1;
        assert!(is_valid || difference < 1e-3, "({x}, {y}): {difference} px where the flow is not valid");
        if is_valid {
            flow_px = flow_px.max(difference);
        }
        match (a.valid.at(x, y), b.valid.at(x, y)) {
            (1, 1) => deviation = deviation.max((a.deviation.at(x, y) / b.deviation.at(x, y) - 1.0).abs()),
            (0, 0) => {}
            _ => validity += 1.0 / (SIZE.0 * SIZE.1) as f32,
        }
    }
    [flow_px, deviation, validity]
}

fn assert_equal_flow(params: &FlowParams, is_cold: bool) {
    let best = flow(params, Level::new(), is_cold);
    let largest_px = best.flow.u.values().iter().fold(0.0_f32, |largest, u| largest.max(u.abs()));
    assert!(largest_px > 2.0, "the largest flow of a bump of 3 px is {largest_px} px");
    for level in levels() {
        let found = differences(&flow(params, level, is_cold), &best);
        let is_within = found.iter().zip(TOLERANCES).all(|(found, tolerance)| *found <= tolerance);
        assert!(is_within, "{:?} with {level:?}: differences {found:?}, allowed {TOLERANCES:?}", params.preset);
    }
}

#[test]
fn coupled_patches_do_not_depend_on_the_instruction_set() {
    for colour in [false, true] {
        let params = FlowParams { colour, ..FlowParams::default() };
        assert_equal_flow(&params, false);
        assert_equal_flow(&params, true);
    }
}

#[test]
fn the_search_alone_does_not_depend_on_the_instruction_set() {
    for preset in [Preset::Ultrafast, Preset::Fast, Preset::Medium] {
        let params = FlowParams { preset, ..FlowParams::default() };
        assert_equal_flow(&params, true);
    }
}

#[test]
fn the_round_trip_does_not_depend_on_the_instruction_set() {
    let validity = ValidityParams { max_round_trip_px: Some(0.5), ..ValidityParams::default() };
    assert_equal_flow(&FlowParams { validity, ..FlowParams::default() }, true);
}
