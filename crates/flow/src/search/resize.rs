//! Scales flow fields from one pyramid level to another.

use crate::FlowField;
use fingervision_image::Image;

/// Enlarges a field to the next finer level: bilinear between pixel centres, displacements doubled.
pub(crate) fn double_into(coarse: &FlowField, fine: &mut FlowField) {
    double_plane(&coarse.u, &mut fine.u);
    double_plane(&coarse.v, &mut fine.v);
}

fn double_plane(coarse: &Image<f32>, fine: &mut Image<f32>) {
    let (width, height) = coarse.size();
    for (y, row) in fine.rows_mut().enumerate() {
        let (near_y, far_y) = coarse_neighbours(y, height);
        let (near_row, far_row) = (coarse.row(near_y), coarse.row(far_y));
        for (x, value) in row.iter_mut().enumerate() {
            let (near, far) = coarse_neighbours(x, width);
            let across = |row: &[f32]| 0.75 * row[near] + 0.25 * row[far];
            *value = 2.0 * (0.75 * across(near_row) + 0.25 * across(far_row));
        }
    }
}

/// The nearer and the farther of the two coarse pixels, or nodes, next to the fine one `x`; the same twice at the
/// border.
pub(crate) fn coarse_neighbours(x: usize, size: usize) -> (usize, usize) {
    let near = (x / 2).min(size - 1);
    let far = if x.is_multiple_of(2) { near.saturating_sub(1) } else { (near + 1).min(size - 1) };
    (near, far)
}

/// Samples every `2^level`-th value of a full-size field, in px of that level.
pub(crate) fn shrink_into(full: &FlowField, level: usize, shrunk: &mut FlowField) {
    let (step, scale) = (1usize << level, 1.0 / (1u32 << level) as f32);
    for (plane, full) in [(&mut shrunk.u, &full.u), (&mut shrunk.v, &full.v)] {
        for (y, row) in plane.rows_mut().enumerate() {
            let from = full.row(y * step + step / 2);
            for (x, value) in row.iter_mut().enumerate() {
                *value = scale * from[x * step + step / 2];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enlarging_and_shrinking_keep_an_affine_field() {
        let affine = |step: f32| {
            let value = move |x: usize, y: usize| {
                let (x, y) = ((x as f32 + 0.5) * step, (y as f32 + 0.5) * step);
                (3.0 + 0.1 * x - 0.2 * y) / step
            };
            FlowField { u: Image::from_fn(40, 24, value), v: Image::from_fn(40, 24, value) }
        };
        let mut fine = FlowField::zero(80, 48);
        double_into(&affine(2.0), &mut fine);
        let mut coarse = FlowField::zero(20, 12);
        shrink_into(&fine, 2, &mut coarse);
        for (x, y) in [(3, 2), (10, 6), (17, 10)] {
            let expected = (3.0 + 0.4 * (x as f32 + 0.5) - 0.8 * (y as f32 + 0.5)) / 4.0;
            // Shrinking samples the pixel half a px right of the centre.
            assert!((coarse.u.at(x, y) - expected).abs() < 0.03, "{} against {expected}", coarse.u.at(x, y));
        }
    }
}
