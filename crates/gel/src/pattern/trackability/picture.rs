//! The pattern in the camera's image, without noise, and its gradient.

use fingervision_image::Image;

use super::View;
use super::patches::{PATCH_PX, Patch};
use crate::Texture;
use crate::blur::{Blur, SUB_PIXELS};
use crate::coverage::mean_colours;

/// Half the step of the finite difference for the gradient, px: exact to 0.2 % for waves of 6 px.
const HALF_STEP_PX: f64 = 0.1;

/// Adjacent patches at places all over the image, those on the gel.
pub(super) fn patches(texture: &Texture, view: &View, places: usize, across: usize) -> Vec<Patch> {
    let blur = Blur::new(view.blur_px);
    let side = across * PATCH_PX;
    let mut patches = Vec::new();
    for place in 0..places * places {
        let share = [place % places, place / places].map(|k| (k as f64 + 0.5) / places as f64);
        let middle = [0, 1].map(|axis| share[axis] * view.size_px[axis] as f64 - 0.5);
        let Some(mm_per_px) = view.camera.mm_per_px(middle) else { continue };
        let corner = middle.map(|middle| middle - 0.5 * side as f64);
        let Some(gradients) = gradients(texture, view, &blur, corner, side) else { continue };
        for patch in 0..across * across {
            let corner = [patch % across, patch / across].map(|k| k * PATCH_PX);
            patches.push(Patch::at(corner, &gradients, view.colour, mm_per_px));
        }
    }
    patches
}

/// Derivatives to the right and downwards of a square of the image, grey levels per px; none if it extends beyond the
/// gel.
/// gel.
fn gradients(
    texture: &Texture,
    view: &View,
    blur: &Blur,
    corner_px: [f64; 2],
    side: usize,
) -> Option<[Image<[f32; 3]>; 2]> {
    let along = |step: [f64; 2]| {
        let at = |sign: f64| {
            let corner = [0, 1].map(|axis| corner_px[axis] + sign * step[axis]);
            picture(texture, view, blur, corner, side)
        };
        let (before, after) = (at(-1.0)?, at(1.0)?);
        let slope = |after: f32, before: f32| (after - before) / (2.0 * HALF_STEP_PX) as f32;
        Some(Image::from_fn(side, side, |x, y| {
            let (after, before) = (after.at(x, y), before.at(x, y));
            [0, 1, 2].map(|channel| slope(after[channel], before[channel]))
        }))
    };
    Some([along([HALF_STEP_PX, 0.0])?, along([0.0, HALF_STEP_PX])?])
}

/// A square of the image whose first pixel's upper left corner lies at `corner_px`.
fn picture(texture: &Texture, view: &View, blur: &Blur, corner_px: [f64; 2], side: usize) -> Option<Image<[f32; 3]>> {
    let margin = blur.margin();
    let count = side * SUB_PIXELS + 2 * margin + 1;
    let mut is_seen = true;
    let corners = Image::from_fn(count, count, |x, y| {
        let px = [0, 1].map(|axis| {
            let part = [x, y][axis] as f64 - margin as f64;
            corner_px[axis] + part / SUB_PIXELS as f64
        });
        let point = view.camera.surface_point(px, 0.0);
        let on_gel = point.filter(|point| (0..2).all(|axis| 2.0 * point[axis].abs() <= view.gel_mm[axis]));
        is_seen &= on_gel.is_some();
        texture.cell_coordinates(on_gel.unwrap_or_default())
    });
    is_seen.then(|| blur.apply(&mean_colours(&corners, texture)))
}
