//! Properties of the composition of flows, tested on random flows.

use fingervision_flow::Estimate;
use fingervision_image::Image;
use proptest::prelude::*;

use super::compose::compose_into;

const SIZE: (usize, usize) = (64, 56);
/// A point at this distance from the border, px, stays in the image when it moves by both flows.
const MARGIN: usize = 12;
/// Largest rounding error, px: a few operations on coordinates of up to 64 px.
const TOLERANCE_PX: f32 = 1e-4;

/// A flow `u = a + b x + c y` for each component: bilinear interpolation is exact on it.
type Affine = [[f32; 3]; 2];

fn affine() -> impl Strategy<Value = Affine> {
    let component = (-2.0_f32..2.0, -0.02_f32..0.02, -0.02_f32..0.02).prop_map(|(a, b, c)| [a, b, c]);
    [component.clone(), component]
}

fn at(flow: &Affine, [x, y]: [f32; 2]) -> [f32; 2] {
    flow.map(|[a, b, c]| a + b * x + c * y)
}

fn moved(flow: &Affine, place: [f32; 2]) -> [f32; 2] {
    let by = at(flow, place);
    [place[0] + by[0], place[1] + by[1]]
}

fn estimate(flow: &Affine) -> Estimate {
    let mut estimate = Estimate::new(SIZE.0, SIZE.1);
    let plane = |axis: usize| Image::from_fn(SIZE.0, SIZE.1, |x, y| at(flow, [x as f32, y as f32])[axis]);
    (estimate.flow.u, estimate.flow.v) = (plane(0), plane(1));
    estimate.valid = Image::filled(SIZE.0, SIZE.1, 1);
    estimate.deviation = Image::filled(SIZE.0, SIZE.1, 0.01);
    estimate
}

fn composed(a: &Estimate, b: &Estimate) -> Estimate {
    let mut out = Estimate::new(SIZE.0, SIZE.1);
    compose_into(a, b, &mut out);
    out
}

fn places() -> impl Iterator<Item = (usize, usize)> {
    (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y)))
}

/// The largest difference between two flows in the middle of the image, px.
///
/// At the border, valid flows are interpolated with neighbours that are not valid.
fn apart_px(a: &Estimate, b: &Estimate, margin: usize) -> f32 {
    let is_within = |at: usize, side: usize| (margin..side - margin).contains(&at);
    let middle = places().filter(|&(x, y)| is_within(x, SIZE.0) && is_within(y, SIZE.1));
    let apart = middle.map(|(x, y)| {
        assert_eq!((a.valid.at(x, y), b.valid.at(x, y)), (1, 1), "({x}, {y})");
        (a.flow.u.at(x, y) - b.flow.u.at(x, y)).abs().max((a.flow.v.at(x, y) - b.flow.v.at(x, y)).abs())
    });
    apart.fold(0.0, f32::max)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn affine_flows_compose_to_the_product_of_their_maps(a in affine(), b in affine()) {
        let found = composed(&estimate(&a), &estimate(&b));
        for (x, y) in places() {
            let start = [x as f32, y as f32];
            let between = moved(&a, start);
            // Within rounding of the border either answer is right.
            let inside_px = (0..2).map(|i| between[i].min([SIZE.0, SIZE.1][i] as f32 - 1.0 - between[i]));
            let inside_px = inside_px.fold(f32::INFINITY, f32::min);
            if inside_px.abs() > TOLERANCE_PX {
                prop_assert_eq!(found.valid.at(x, y) == 1, inside_px > 0.0, "at ({}, {})", x, y);
            }
            if found.valid.at(x, y) == 1 {
                let end = moved(&b, between);
                let off = [found.flow.u.at(x, y) + start[0] - end[0], found.flow.v.at(x, y) + start[1] - end[1]];
                prop_assert!(off.iter().all(|off| off.abs() < TOLERANCE_PX), "at ({x}, {y}): off by {off:?} px");
            }
        }
    }

    #[test]
    fn composition_is_associative(a in affine(), b in affine(), c in affine()) {
        let [a, b, c] = [a, b, c].map(|flow| estimate(&flow));
        let apart = apart_px(&composed(&composed(&a, &b), &c), &composed(&a, &composed(&b, &c)), MARGIN);
        prop_assert!(apart < TOLERANCE_PX, "{apart} px apart");
    }

    #[test]
    fn no_motion_before_or_after_changes_nothing(flow in affine()) {
        let (flow, still) = (estimate(&flow), estimate(&[[0.0; 3]; 2]));
        let before = apart_px(&composed(&still, &flow), &flow, 0);
        let after = apart_px(&composed(&flow, &still), &flow, MARGIN);
        prop_assert!(before.max(after) < TOLERANCE_PX, "{before} and {after} px apart");
    }

    #[test]
    fn deviations_add_as_variances(flow in affine(), first in 0.0_f32..1.0, second in 0.0_f32..1.0) {
        let (mut a, mut b) = (estimate(&flow), estimate(&flow));
        a.deviation.values_mut().fill(first);
        b.deviation.values_mut().fill(second);
        let found = composed(&a, &b);
        for (x, y) in places() {
            let expected = if found.valid.at(x, y) == 1 { first.hypot(second) } else { f32::INFINITY };
            prop_assert_eq!(found.deviation.at(x, y).to_bits(), expected.to_bits(), "at ({}, {})", x, y);
        }
    }
}
