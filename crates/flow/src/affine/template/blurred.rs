//! A template blurred by motion.

use super::{PatchSums, Template};
use crate::FlowField;
use crate::affine::grid::{MARGIN, STRIDE};
use fearless_simd::{Level, Simd, dispatch, f32x8, prelude::*};
use fearless_simd_macros::simd;
use std::sync::Arc;

/// Shortest path of a pixel that changes it, px.
const SHORTEST_PX: f32 = 0.25;
/// Largest number of samples along a path; longer ones are sampled at larger distances than a pixel.
const MOST_SAMPLES: f32 = 32.0;
/// Neighbouring pixels of a row that move together.
const BLOCK: usize = 8;

/// The template of a reference as an image shows it while the gel moves, with its scratch memory.
///
/// While the shutter is open, a point of the gel moves from `u − s d/2` to `u + s d/2`, where `d` is its displacement since the
/// last frame and `s` the time that the shutter is open, relative to the time between two frames. The image at `x + u` is
/// the mean of the reference along the path from `x − s d/2` to `x + s d/2`.
#[derive(Debug, Clone)]
pub(crate) struct BlurredTemplate {
    pub(crate) template: Template,
    sums: PatchSums,
}

impl BlurredTemplate {
    /// For references like this empty one.
    pub(crate) fn new(empty: Template) -> Self {
        Self { sums: PatchSums::new(empty.grid), template: empty }
    }

    /// Sets the mean of `sharp` along paths that have `part` of the way from `last` to `now`.
    pub(crate) fn set(&mut self, level: Level, sharp: &Template, motion: (&FlowField, &FlowField), part: f32) {
        let Self { template, sums } = self;
        template.copy_from(sharp);
        let lines = Arc::make_mut(&mut template.lines);
        let grid = sharp.grid;
        let (mut first, mut last) = (grid.height, 0);
        for y in 0..grid.height {
            if dispatch!(level, simd => blur_row(simd, lines, sharp, y, motion, part)) {
                (first, last) = (first.min(y), y);
            }
        }
        // A row of patches covers the padded rows of two rows of cells.
        let rows = ((first + MARGIN) / STRIDE).saturating_sub(1)..((last + MARGIN) / STRIDE + 1).min(grid.rows);
        dispatch!(level, simd => sums.fill(simd, template, rows.clone()));
        for node in rows.start * grid.columns..rows.end.max(rows.start) * grid.columns {
            template.assemble(node, &sums.planes);
        }
    }
}

/// Blurs row `y` of the image. Returns whether anything in it moves.
#[simd]
fn blur_row<S: Simd>(
    simd: S,
    lines: &mut [f32],
    sharp: &Template,
    y: usize,
    (last, now): (&FlowField, &FlowField),
    part: f32,
) -> bool {
    let width = sharp.grid.width;
    let [last_u, last_v, u, v] = [&last.u, &last.v, &now.u, &now.v].map(|plane| plane.row(y));
    let mut is_moving = false;
    for start in (0..width).step_by(BLOCK) {
        let start = start.min(width - BLOCK);
        let mean = |now: &[f32], last: &[f32]| {
            let difference =
                f32x8::from_slice(simd, &now[start..][..BLOCK]) - f32x8::from_slice(simd, &last[start..][..BLOCK]);
            difference.reduce_sum() * (part / BLOCK as f32)
        };
        let path = [mean(u, last_u), mean(v, last_v)];
        if path[0] * path[0] + path[1] * path[1] > SHORTEST_PX * SHORTEST_PX {
            is_moving = true;
            blur_block(simd, lines, sharp, (start, y), path);
        }
    }
    is_moving
}

/// Sets [`BLOCK`] pixels to the means of `sharp` along a path around each.
#[inline(always)]
fn blur_block<S: Simd>(simd: S, lines: &mut [f32], sharp: &Template, (x, y): (usize, usize), path: [f32; 2]) {
    let grid = sharp.grid;
    let padded = grid.padded_width();
    // A path that leaves the image is shortened on both sides: its middle stays where it is.
    let within = |path: f32, place: usize, end: usize| {
        let most = 2.0 * place.min(end - place) as f32;
        path.clamp(-most, most)
    };
    let path = [within(path[0], x, grid.width - BLOCK), within(path[1], y, grid.height - 1)];
    let count = (path[0].hypot(path[1]).ceil() + 1.0).min(MOST_SAMPLES);
    let mut sums = [[f32x8::splat(simd, 0.0); 3]; 3];
    for k in 0..count as usize {
        let along = (k as f32 + 0.5) / count - 0.5;
        let (px, py) = (x as f32 + along * path[0], y as f32 + along * path[1]);
        let (left, top) = (px.floor(), py.floor());
        let (fx, fy) = (px - left, py - top);
        let weights = [(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy];
        let (column, row) = (left as usize + MARGIN, top as usize + MARGIN);
        for (channel, sums) in sums.iter_mut().enumerate().take(sharp.channels) {
            let [upper, lower] = [row, row + 1].map(|row| &sharp.lines[sharp.line(row, channel) + column..]);
            for (line, sum) in sums.iter_mut().enumerate() {
                let load = |row: &[f32], right: usize| f32x8::from_slice(simd, &row[line * padded + right..][..BLOCK]);
                *sum = load(upper, 0).mul_add(weights[0], *sum);
                *sum = load(upper, 1).mul_add(weights[1], *sum);
                *sum = load(lower, 0).mul_add(weights[2], *sum);
                *sum = load(lower, 1).mul_add(weights[3], *sum);
            }
        }
    }
    for (channel, sums) in sums.into_iter().enumerate().take(sharp.channels) {
        let place = sharp.line(y + MARGIN, channel) + x + MARGIN;
        for (line, sum) in sums.into_iter().enumerate() {
            (sum * (1.0 / count)).store_slice(&mut lines[place + line * padded..][..BLOCK]);
        }
    }
}

impl Template {
    /// Copies a template for pictures of the same size and channels.
    fn copy_from(&mut self, other: &Self) {
        let Self {
            grid: _,
            channels: _,
            row_step: _,
            stored: _,
            lines,
            normal,
            coarse,
            light_gain,
            light_inverse,
            samples,
            variance,
            signal,
            own_variance,
            noise,
        } = self;
        *noise = other.noise;
        Arc::make_mut(lines).copy_from_slice(&other.lines);
        coarse.clone_from(&other.coarse);
        let light_gain = light_gain.as_flattened_mut().iter_mut().zip(other.light_gain.as_flattened());
        let planes = normal.iter_mut().zip(&other.normal).chain(light_gain);
        let planes = planes.chain(light_inverse.iter_mut().zip(&other.light_inverse));
        let others = [
            (samples, &other.samples),
            (variance, &other.variance),
            (signal, &other.signal),
            (own_variance, &other.own_variance),
        ];
        for (plane, other) in planes.chain(others) {
            plane.copy_from_slice(other);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::affine::grid::PatchGrid;
    use crate::instruction_sets::levels;
    use fingervision_image::Image;
    use std::f32::consts::PI;

    const SIZE: (usize, usize) = (99, 70);
    const WAVE_PX: f32 = 16.0;

    /// Grey levels of a wave along x around 100.
    fn sharp() -> Template {
        let wave = |x: usize, _| 100.0 + 50.0 * (2.0 * PI * x as f32 / WAVE_PX).cos();
        let mut template = Template::new(PatchGrid::over(SIZE.0, SIZE.1), 1, 1);
        template.prepare(Level::new(), &[Image::from_fn(SIZE.0, SIZE.1, wave)]);
        template
    }

    fn value(template: &Template, line: usize, (x, y): (usize, usize)) -> f32 {
        template.lines[template.line(y + MARGIN, 0) + line * template.grid.padded_width() + x + MARGIN]
    }

    /// A flow in which everything right of column 48 moves.
    fn flow(u: f32, v: f32) -> FlowField {
        let mut flow = FlowField::zero(SIZE.0, SIZE.1);
        for y in 0..SIZE.1 {
            flow.u.row_mut(y)[48..].fill(u);
            flow.v.row_mut(y)[48..].fill(v);
        }
        flow
    }

    #[test]
    fn a_wave_loses_contrast_where_it_moves_along() {
        let sharp = sharp();
        let still = FlowField::zero(SIZE.0, SIZE.1);
        for level in levels() {
            for (u, v, part) in [(12.0, 0.0, 0.5), (-6.0, 3.0, 1.0), (0.0, 9.0, 1.0)] {
                let mut blurred = BlurredTemplate::new(sharp.clone());
                blurred.set(level, &sharp, (&still, &flow(u, v)), part);
                // The mean of a wave along a path is the wave times the sine cardinal of half the path's phase.
                let phase = PI * part * u / WAVE_PX;
                let contrast = if phase == 0.0 { 1.0 } else { phase.sin() / phase };
                for (x, y) in [(60, 20), (64, 40), (71, 41), (85, 33)] {
                    for (line, middle) in [(0, 100.0), (1, 0.0)] {
                        let expected = middle + contrast * (value(&sharp, line, (x, y)) - middle);
                        let found = value(&blurred.template, line, (x, y));
                        assert!(
                            (found - expected).abs() < 1.0,
                            "{level:?}, line {line}: {found} instead of {expected}"
                        );
                    }
                }
                for place in [(0, 0), (20, 30), (39, 69)] {
                    let [moved, still] =
                        [&blurred.template, &sharp].map(|template| value(template, 0, place).to_bits());
                    assert_eq!(moved, still, "what does not move");
                }
            }
        }
    }

    #[test]
    fn without_motion_the_template_is_the_sharp_one() {
        let sharp = sharp();
        let mut blurred = BlurredTemplate::new(sharp.clone());
        blurred.set(Level::new(), &sharp, (&flow(0.0, 0.0), &flow(9.0, 0.0)), 1.0);
        assert_ne!(blurred.template.normal, sharp.normal);
        blurred.set(Level::new(), &sharp, (&flow(3.0, 1.0), &flow(3.0, 1.0)), 1.0);
        assert_eq!(blurred.template.lines, sharp.lines);
        assert_eq!(blurred.template.normal, sharp.normal);
    }
}
