//! The trackability of patterns: an ideal estimator reaches the predicted bound, and the bound shows which pattern to
//! print.

use fingervision_gel::{
    Coupling, Light, Motif, Motion, Pattern, PatternError, Sheet, SheetRenderer, Trackability, View, trackability,
};
use fingervision_image::Image;

const MM_PER_PX: f64 = 0.0625;
const SIZE_PX: [usize; 2] = [240, 240];
const PATCH_PX: usize = 16;
/// Number of pairs of frames for the deviation: with 900 patches it is accurate to 2.4 %.
const PAIRS: u64 = 4;

fn view() -> View {
    View::straight_on(SIZE_PX, MM_PER_PX).unwrap()
}

fn colour(cell_mm: f64) -> Pattern {
    Pattern { motif: Motif::Colour { cell_mm }, ..Pattern::default() }
}

fn score(pattern: &Pattern) -> Trackability {
    trackability(pattern, &view()).unwrap()
}

type Colours = Image<[f32; 3]>;

fn difference(after: &Colours, before: &Colours, x: usize, y: usize) -> [f64; 3] {
    let (after, before) = (after.at(x, y), before.at(x, y));
    [0, 1, 2].map(|channel| f64::from(after[channel]) - f64::from(before[channel]))
}

/// A sheet's frames and their gradient without noise.
struct Bench {
    renderer: SheetRenderer,
    /// Moved by a tenth of a px to the right, left, down and up.
    moved: [Colours; 4],
}

impl Bench {
    fn new(cell_px: f64) -> Self {
        let [width, height] = SIZE_PX;
        let sheet = Sheet { width, height, cell_size_px: cell_px, levels: [30, 225], ..Sheet::default() };
        let renderer = SheetRenderer::new(&sheet).unwrap();
        let steps = [[0.1, 0.0], [-0.1, 0.0], [0.0, 0.1], [0.0, -0.1]];
        let moved = steps.map(|by_px| renderer.colours(&Motion::Shift { by_px }).unwrap());
        Self { renderer, moved }
    }

    fn frame(&self, seed: u64) -> Colours {
        let frame = self.renderer.render(&Motion::STILL, Light::EVEN, seed).unwrap();
        Image::from_fn(frame.width(), frame.height(), |x, y| frame.at(x, y).map(f32::from))
    }

    /// The displacement of a patch by linear least squares, px.
    fn displacement(&self, reference: &Colours, current: &Colours, [left, top]: [usize; 2]) -> [f64; 2] {
        let [right, left_moved, down, up] = &self.moved;
        let (mut xx, mut xy, mut yy, mut bx, mut by) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (y, x) in (top..top + PATCH_PX).flat_map(|y| (left..left + PATCH_PX).map(move |x| (y, x))) {
            let gradient_x = difference(right, left_moved, x, y);
            let gradient_y = difference(down, up, x, y);
            let change = difference(current, reference, x, y);
            for channel in 0..3 {
                let (gx, gy) = (gradient_x[channel] / 0.2, gradient_y[channel] / 0.2);
                (xx, xy, yy) = (xx + gx * gx, xy + gx * gy, yy + gy * gy);
                (bx, by) = (bx + gx * change[channel], by + gy * change[channel]);
            }
        }
        let determinant = xx * yy - xy * xy;
        [(yy * bx - xy * by) / determinant, (xx * by - xy * bx) / determinant]
    }

    /// Root mean square of the displacement that least squares finds between noisy frames at rest, patch by patch, px.
    /// The gradients have no noise, so only the noise of the difference has an effect.
    fn deviation(&self) -> [f64; 2] {
        let (mut squares, mut count) = ([0.0; 2], 0.0);
        for pair in 0..PAIRS {
            let (reference, current) = (self.frame(2 * pair), self.frame(2 * pair + 1));
            for patch in 0..(SIZE_PX[0] / PATCH_PX) * (SIZE_PX[1] / PATCH_PX) {
                let columns = SIZE_PX[0] / PATCH_PX;
                let corner = [patch % columns, patch / columns].map(|k| PATCH_PX * k);
                let found = self.displacement(&reference, &current, corner);
                squares = [0, 1].map(|axis| squares[axis] + found[axis] * found[axis]);
                count += 1.0;
            }
        }
        squares.map(|sum| f64::sqrt(sum / count))
    }
}

#[test]
fn least_squares_on_noisy_frames_reaches_the_bound() {
    for cell_px in [1.6, 2.4, 4.0] {
        let pattern = Pattern { levels: [30, 225], ..colour(cell_px * MM_PER_PX) };
        let bound = score(&pattern).deviation_px;
        let found = Bench::new(cell_px).deviation();
        for axis in 0..2 {
            let ratio = found[axis] / bound[axis];
            println!("cells of {cell_px} px: {ratio:.3} times the bound");
            assert!((0.93..1.07).contains(&ratio), "cells of {cell_px} px: {found:?} px, bound {bound:?} px");
        }
    }
}

#[test]
fn cells_of_two_to_four_px_are_the_best() {
    let deviation = |cell_px: f64| score(&colour(cell_px * MM_PER_PX)).deviation_px[0];
    let best = [2.0, 2.5, 3.2].map(deviation).into_iter().fold(f64::INFINITY, f64::min);
    assert!(deviation(0.8) > 1.4 * best && deviation(8.0) > 1.4 * best);
}

#[test]
fn noise_and_contrast_scale_the_deviation() {
    let pattern = colour(0.2);
    let base = score(&pattern);
    let noisy = trackability(&pattern, &View { noise_levels: 6.0, ..view() }).unwrap();
    let expected = ((36.0 + 1.0 / 12.0_f64) / (4.0 + 1.0 / 12.0)).sqrt();
    let ratio = noisy.deviation_px[1] / base.deviation_px[1];
    assert!((ratio / expected - 1.0).abs() < 1e-9, "{ratio}, expected {expected}");
    // The bound of three channels is at least √3 times lower than that of their weighted mean.
    let grey = trackability(&pattern, &View { colour: false, ..view() }).unwrap();
    assert!(grey.deviation_px[0] > 1.7 * base.deviation_px[0]);
}

#[test]
fn deviations_in_mm_are_those_in_px_at_their_scale() {
    let score = score(&colour(0.2));
    for axis in 0..2 {
        assert!((score.deviation_mm[axis] / score.deviation_px[axis] - MM_PER_PX).abs() < 1e-9);
    }
}

#[test]
fn sparse_dots_leave_patches_without_structure() {
    let dots = Pattern { motif: Motif::Dots { count: [7, 7], diameter_mm: 0.6 }, ..Pattern::default() };
    let speckle = Pattern { motif: Motif::Speckle { diameter_mm: 0.25, coverage: 0.5 }, ..Pattern::default() };
    assert!(score(&dots).poor > 0.3, "{:?}", score(&dots));
    let coupling = Coupling { stride_px: 8.0, curvature_px: 0.012, row_step: 1, strong_gradient: 29.0 };
    assert_eq!(coupling.deviation_px(&score(&dots)), None, "a texture with gaps is not even");
    assert!(score(&speckle).poor < 0.02, "{:?}", score(&speckle));
}

#[test]
fn a_coupled_tracker_profits_where_texture_is_poor() {
    let coupling = Coupling { stride_px: 8.0, curvature_px: 0.012, row_step: 1, strong_gradient: 29.0 };
    let gain = |cell_mm: f64| {
        let score = score(&colour(cell_mm));
        score.deviation_px[0] / coupling.deviation_px(&score).unwrap()[0]
    };
    assert!(gain(0.8) > 1.2 * gain(0.2), "{} and {}", gain(0.8), gain(0.2));
}

#[test]
fn a_camera_that_sees_no_gel_is_reported() {
    let error = trackability(&colour(0.2), &View { gel_mm: [1.0, 1.0], ..view() }).unwrap_err();
    assert_eq!(error, PatternError::NotSeen);
    assert!(View::straight_on(SIZE_PX, 0.0).is_err() && View::straight_on(SIZE_PX, f64::NAN).is_err());
    assert!(trackability(&colour(0.2), &View { blur_px: -1.0, ..view() }).is_err());
}
