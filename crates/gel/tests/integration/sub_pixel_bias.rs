//! The shift measured in rendered images is the requested one: no sub-pixel bias.

use crate::lanczos::{REACH, weights};
use fingervision_gel::{Motion, Sheet, SheetRenderer};
use fingervision_image::Image;

/// Half the step of the difference quotient that is used as gradient, px.
const HALF_STEP: f64 = 1e-3;

type Colours = Image<[f32; 3]>;

/// All channels of the image moved by `shift`, without the border that moving leaves undefined.
fn moved(image: &Colours, shift: [f64; 2], border: usize) -> Vec<f64> {
    let [(whole_x, across), (whole_y, down)] = shift.map(|shift| {
        let whole = (-shift).floor();
        (whole as isize, weights(-shift - whole))
    });
    let (width, height) = image.size();
    let place = |index: usize, whole: isize, k: usize| index.strict_add_signed(whole + 1) + k - REACH;
    let mut rows = Vec::new();
    for y in border..height - border {
        for x in border..width - border {
            for channel in 0..3 {
                let row = |y: usize| -> f64 {
                    let values = across.iter().enumerate();
                    values.map(|(k, w)| w * f64::from(image.at(place(x, whole_x, k), y)[channel])).sum()
                };
                rows.push(down.iter().enumerate().map(|(k, w)| w * row(place(y, whole_y, k))).sum());
            }
        }
    }
    rows
}

/// The shift from `reference` to `current` that least squares finds, by Gauss–Newton steps from `start`.
fn measured_shift(reference: &Colours, current: &Colours, start: [f64; 2], border: usize) -> [f64; 2] {
    let target = moved(current, [0.0; 2], border);
    let mut shift = start;
    for _ in 0..3 {
        let model = moved(reference, shift, border);
        let [gx, gy] = [0, 1].map(|axis| {
            let at = |step: f64| {
                let mut stepped = shift;
                stepped[axis] += step;
                moved(reference, stepped, border)
            };
            let (after, before) = (at(HALF_STEP), at(-HALF_STEP));
            after.iter().zip(before).map(|(a, b)| (a - b) / (2.0 * HALF_STEP)).collect::<Vec<_>>()
        });
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let residual: Vec<_> = target.iter().zip(model).map(|(target, model)| target - model).collect();
        let (xx, xy, yy) = (dot(&gx, &gx), dot(&gx, &gy), dot(&gy, &gy));
        let (bx, by) = (dot(&gx, &residual), dot(&gy, &residual));
        let determinant = xx * yy - xy * xy;
        shift[0] += (yy * bx - xy * by) / determinant;
        shift[1] += (xx * by - xy * bx) / determinant;
    }
    shift
}

#[test]
fn a_shift_is_rendered_without_sub_pixel_bias() {
    let renderer = SheetRenderer::new(&Sheet { width: 72, height: 64, ..Sheet::default() }).unwrap();
    let reference = renderer.colours(&Motion::STILL).unwrap();
    for distance in [0.1, 0.25, 0.5, 0.9, 2.3] {
        let motion = Motion::shift(distance);
        let current = renderer.colours(&motion).unwrap();
        let truth = <[f64; 2]>::from(motion.displacement(0.0, 0.0));
        let found = measured_shift(&reference, &current, truth.map(|shift| shift + 0.05), 14);
        let bias = [found[0] - truth[0], found[1] - truth[1]];
        // The part of the image above the Nyquist frequency cannot be interpolated. Measured: 0.0004 px.
        assert!(bias.iter().all(|bias| bias.abs() < 0.001), "shift {truth:?} px, found {found:?} px");
    }
}
