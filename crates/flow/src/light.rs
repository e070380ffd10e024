//! Correction of the light of a picture to that of the reference: a flat-field correction from the pictures themselves.
//!
//! A patch eliminates one change of light for all its pixels. A change that differs within a patch looks like motion, and so does one
//! that differs from colour to colour. Light on a gel does change so: with the depth of a press, with the white balance, and, behind a
//! rolling shutter, from row to row.
//!
//! The brightness of a picture is its mean over some 40 px around the middle of each block of 8 px, in each channel. That of the reference is
//! read where the gel was, by the flow of the last frame: around the same piece of gel the pattern has the same mean, and what differs
//! is the light. Only places around which it differs are corrected.

use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use fingervision_image::Image;

/// Side of a block, px: the middle of each is a node of the patches.
pub(crate) const BLOCK: usize = 8;
/// Blocks of each of the two boxes whose convolution weights those around a node along one axis.
const BOX: usize = 5;
/// A light that differs by less than the first part is not corrected, because the patches eliminate it; from the second part on it is
/// corrected wholly.
const CHANGE: [f32; 2] = [0.02, 0.03];
/// Around a changed node the correction is whole where the weight of its brightness is at least this, up to two nodes away along an axis, and
/// fades out beyond. At a corner of the image two changed nodes have this weight.
const WHOLE: f32 = 15.0;
/// Every second row of pixels is enough for the brightness.
const ROW_STEP: usize = 2;
/// Largest factor on the levels, and one over the smallest.
const MOST_CHANGE: f32 = 4.0;
/// Least brightness that counts, grey levels.
const DARK: f32 = 1.0;

/// Brightness around the nodes of the patches, and the factors that correct it.
#[derive(Debug, Clone)]
pub(crate) struct Light {
    columns: usize,
    rows: usize,
    /// One plane over the nodes for each channel, grey levels.
    brightness: Vec<Vec<f32>>,
    /// The same of the factors of the last correction.
    factors: Vec<Vec<f32>>,
    /// One over the weights of all pixels around each node.
    per_weight: Vec<f32>,
    /// Scratch memory over the nodes.
    sums: [Vec<f32>; 2],
    /// The same over a row of nodes, with room for half a box at either end.
    row: Vec<f32>,
    column_sums: Vec<f32>,
    /// First and last node of each row whose factors differ from 1, if any do.
    spans: Vec<Option<(usize, usize)>>,
    /// Factors along a row of pixels.
    line: Vec<f32>,
}

impl Light {
    /// For pictures of this size, with grey levels alone or also with colours.
    pub(crate) fn new(width: usize, height: usize, colour: bool) -> Self {
        let channels = if colour { 4 } else { 1 };
        let (columns, rows) = (width.div_ceil(BLOCK), height.div_ceil(BLOCK));
        let nodes = columns * rows;
        let mut light = Self {
            columns,
            rows,
            brightness: vec![vec![0.0; nodes]; channels],
            factors: vec![vec![1.0; nodes]; channels],
            per_weight: vec![0.0; nodes],
            sums: std::array::from_fn(|_| vec![0.0; nodes]),
            row: vec![0.0; columns + BOX - 1],
            column_sums: vec![0.0; width],
            spans: vec![None; rows],
            line: vec![1.0; columns],
        };
        let pixels = |place: usize, length: usize| BLOCK.min(length - BLOCK * place);
        for node in 0..nodes {
            let summed = pixels(node % columns, width) * pixels(node / columns, height).div_ceil(ROW_STEP);
            light.sums[0][node] = summed as f32;
        }
        dispatch!(Level::new(), simd => light.smooth(simd));
        for (per_weight, weight) in light.per_weight.iter_mut().zip(&light.sums[0]) {
            *per_weight = 1.0 / weight;
        }
        light
    }

    /// Takes the brightness of another picture, without allocating where sizes and channels agree.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        if (self.columns, self.rows) != (other.columns, other.rows) || self.brightness.len() != other.brightness.len() {
            self.clone_from(other);
            return;
        }
        for (plane, other) in self.brightness.iter_mut().zip(&other.brightness) {
            plane.copy_from_slice(other);
        }
    }

    /// Measures the brightness of a channel.
    pub(crate) fn measure(&mut self, channel: usize, image: &Image<f32>) {
        dispatch!(Level::new(), simd => {
            self.sum_blocks(simd, image);
            self.smooth(simd);
        });
        let sums = self.sums[0].iter().zip(&self.per_weight);
        for (brightness, (sum, per_weight)) in self.brightness[channel].iter_mut().zip(sums) {
            *brightness = sum * per_weight;
        }
    }

    /// Sums over the blocks around each node, weighted.
    #[simd]
    fn smooth<S: Simd>(&mut self, simd: S) {
        let _ = simd;
        let (columns, rows, half) = (self.columns, self.rows, BOX / 2);
        let [sums, other] = &mut self.sums;
        for _ in 0..2 {
            let padded = &mut self.row[..columns + BOX - 1];
            for row in sums.chunks_exact_mut(columns) {
                padded[half..half + columns].copy_from_slice(row);
                row.copy_from_slice(&padded[..columns]);
                for shift in 1..BOX {
                    let shifted = &padded[shift..shift + columns];
                    for i in 0..columns {
                        row[i] += shifted[i];
                    }
                }
            }
            other.copy_from_slice(sums);
            for (place, row) in sums.chunks_exact_mut(columns).enumerate() {
                let (first, last) = (place.saturating_sub(half), (place + half).min(rows - 1));
                row.copy_from_slice(&other[first * columns..][..columns]);
                for place in first + 1..=last {
                    let beside = &other[place * columns..][..columns];
                    for i in 0..columns {
                        row[i] += beside[i];
                    }
                }
            }
        }
    }

    /// Sums the pixels of each block, in some of its rows; blocks at the right and at the bottom may be smaller.
    #[simd]
    fn sum_blocks<S: Simd>(&mut self, simd: S, image: &Image<f32>) {
        let _ = simd;
        let (width, height) = image.size();
        let pixels = image.values();
        for (row, blocks) in self.sums[0].chunks_exact_mut(self.columns).enumerate() {
            let (top, bottom) = (row * BLOCK, ((row + 1) * BLOCK).min(height));
            let sums = &mut self.column_sums[..width];
            sums.copy_from_slice(&pixels[top * width..][..width]);
            for y in (top + ROW_STEP..bottom).step_by(ROW_STEP) {
                let line = &pixels[y * width..][..width];
                for x in 0..width {
                    sums[x] += line[x];
                }
            }
            let (whole, rest) = sums.as_chunks::<BLOCK>();
            for (block, [a, b, c, d, e, f, g, h]) in blocks.iter_mut().zip(whole) {
                *block = ((a + e) + (c + g)) + ((b + f) + (d + h));
            }
            if !rest.is_empty() {
                blocks[whole.len()] = rest.iter().sum();
            }
        }
    }

    /// Sets the factors that give a picture the light of a reference where it differs; `u` and `v` are the last displacement from the
    /// reference in the middle of each block, px. Returns whether they change anything.
    pub(crate) fn find_change(&mut self, reference: &Self, flow: [&[f32]; 2]) -> bool {
        dispatch!(Level::new(), simd => self.compare(simd, reference, flow));
        let [least, most] = CHANGE;
        let mut is_changed = false;
        for node in 0..self.columns * self.rows {
            let change = self.factors.iter().fold(0.0_f32, |change, plane| change.max((plane[node] - 1.0).abs()));
            is_changed |= change > least;
            self.sums[0][node] = ((change - least) / (most - least)).clamp(0.0, 1.0) / WHOLE;
        }
        if is_changed {
            dispatch!(Level::new(), simd => self.smooth(simd));
            for factors in &mut self.factors {
                for (factor, weight) in factors.iter_mut().zip(&self.sums[0]) {
                    *factor = 1.0 + weight.min(1.0) * (*factor - 1.0);
                }
            }
            for (span, weights) in self.spans.iter_mut().zip(self.sums[0].chunks_exact(self.columns)) {
                let changed = |weight: &f32| *weight > 0.0;
                let (first, last) = (weights.iter().position(changed), weights.iter().rposition(changed));
                *span = first.zip(last);
            }
        }
        is_changed
    }

    /// The light of the reference over that of the picture.
    #[simd]
    fn compare<S: Simd>(&mut self, simd: S, reference: &Self, [u, v]: [&[f32]; 2]) {
        let _ = simd;
        let (columns, rows) = (self.columns, self.rows);
        for row in 0..rows {
            for column in 0..columns {
                let node = row * columns + column;
                // In nodes; beyond the outermost ones the brightness is theirs.
                let x = (column as f32 - u[node] / BLOCK as f32).clamp(0.0, (columns - 1) as f32);
                let y = (row as f32 - v[node] / BLOCK as f32).clamp(0.0, (rows - 1) as f32);
                let (left, upper) = (x as usize, y as usize);
                let (dx, dy) = (x - left as f32, y - upper as f32);
                let (right, down) = (usize::from(left + 1 < columns), if upper + 1 < rows { columns } else { 0 });
                let first = upper * columns + left;
                for (factors, (then, now)) in
                    self.factors.iter_mut().zip(reference.brightness.iter().zip(&self.brightness))
                {
                    let [a, b, c, d] =
                        [then[first], then[first + right], then[first + down], then[first + down + right]];
                    let (upper, lower) = (a + dx * (b - a), c + dx * (d - c));
                    let then = upper + dy * (lower - upper);
                    factors[node] = (then.max(DARK) / now[node].max(DARK)).clamp(1.0 / MOST_CHANGE, MOST_CHANGE);
                }
            }
        }
    }

    /// Corrects a channel by the factors that were found.
    pub(crate) fn correct(&mut self, channel: usize, image: &mut Image<f32>) {
        dispatch!(Level::new(), simd => self.scale(simd, channel, image));
        for (brightness, factor) in self.brightness[channel].iter_mut().zip(&self.factors[channel]) {
            *brightness *= factor;
        }
    }

    /// Multiplies the pixels by the factors, linear between the nodes.
    #[simd]
    fn scale<S: Simd>(&mut self, simd: S, channel: usize, image: &mut Image<f32>) {
        let _ = simd;
        let (columns, rows) = (self.columns, self.rows);
        let weights: [f32; BLOCK] = std::array::from_fn(|k| (k as f32 + 0.5) / BLOCK as f32);
        let factors = &self.factors[channel];
        for (y, pixels) in image.rows_mut().enumerate() {
            let place = ((y as f32 + 0.5) / BLOCK as f32 - 0.5).clamp(0.0, (rows - 1) as f32);
            let upper = place as usize;
            let (lower, down) = ((upper + 1).min(rows - 1), place - upper as f32);
            let (first, last) = match (self.spans[upper], self.spans[lower]) {
                (Some((a, b)), Some((c, d))) => (a.min(c), b.max(d)),
                (Some(span), None) | (None, Some(span)) => span,
                (None, None) => continue,
            };
            // Between the middle of the node before the first and that of the node after the last.
            let (first, last) = (first.saturating_sub(1), (last + 1).min(columns - 1));
            let (upper, lower) = (&factors[upper * columns..][..columns], &factors[lower * columns..][..columns]);
            let line = &mut self.line[..columns];
            for i in first..=last {
                line[i] = upper[i] + down * (lower[i] - upper[i]);
            }
            if first == 0 {
                for pixel in &mut pixels[..BLOCK / 2] {
                    *pixel *= line[0];
                }
            }
            let inner = &mut pixels[first * BLOCK + BLOCK / 2..];
            let (cells, rest) = inner.as_chunks_mut::<BLOCK>();
            for (cell, factors) in cells.iter_mut().zip(line[first..=last].windows(2)) {
                let (left, change) = (factors[0], factors[1] - factors[0]);
                for k in 0..BLOCK {
                    cell[k] *= left + weights[k] * change;
                }
            }
            if last == columns - 1 {
                let last = first + cells.len();
                let (left, right) = (line[last], line[(last + 1).min(columns - 1)]);
                for (pixel, weight) in rest.iter_mut().zip(weights) {
                    *pixel *= left + weight * (right - left);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZES: [(usize, usize); 4] = [(96, 64), (97, 71), (100, 68), (103, 65)];

    /// A coarse pattern of mean 100, displaced by some pixels, in a light.
    fn picture((width, height): (usize, usize), right: usize, light: fn(f32, f32) -> f32) -> Image<f32> {
        Image::from_fn(width, height, |x, y| {
            let (column, row) = ((x + 96 - right) / 6, y / 6);
            let mixed = (column as u32).wrapping_mul(0x9E37_79B1) ^ (row as u32).wrapping_mul(0x85EB_CA77);
            let level = 60.0 + ((mixed ^ mixed >> 13).wrapping_mul(0xC2B2_AE35) >> 25) as f32 * 0.63;
            level * light(x as f32, y as f32)
        })
    }

    fn corrected(reference: &Image<f32>, current: &Image<f32>, right: f32) -> Option<Image<f32>> {
        let (width, height) = reference.size();
        let [then, mut now] = [reference, current].map(|image| {
            let mut light = Light::new(width, height, false);
            light.measure(0, image);
            light
        });
        let u = vec![right; now.columns * now.rows];
        let zero = vec![0.0; u.len()];
        assert!(!then.clone().find_change(&then, [&zero, &zero]), "a picture has its own light");
        let mut image = current.clone();
        now.find_change(&then, [&u, &zero]).then(|| {
            now.correct(0, &mut image);
            image
        })
    }

    /// Mean difference where both show the same part of the pattern.
    fn difference(a: &Image<f32>, b: &Image<f32>) -> f32 {
        let inner = |x: usize, y: usize| (a.at(x, y) - b.at(x, y)).abs();
        let (width, height) = a.size();
        let (xs, ys) = (16..width - 16, 8..height - 8);
        let sum: f32 = ys.clone().flat_map(|y| xs.clone().map(move |x| (x, y))).map(|(x, y)| inner(x, y)).sum();
        sum / (xs.len() * ys.len()) as f32
    }

    #[test]
    fn a_change_of_light_is_corrected_where_the_gel_moved() {
        let lights: [fn(f32, f32) -> f32; 3] =
            [|_, _| 0.6, |x, _| 0.8 + 0.004 * x, |_, y| 1.0 + 0.15 * (y / 25.0).sin()];
        for size in SIZES {
            let reference = picture(size, 0, |_, _| 1.0);
            for (number, light) in lights.into_iter().enumerate() {
                for right in [0, 3, 8] {
                    let (even, current) = (picture(size, right, |_, _| 1.0), picture(size, right, light));
                    let found = corrected(&reference, &current, right as f32).unwrap();
                    let (left, before) = (difference(&found, &even), difference(&current, &even));
                    assert!(left < 0.2 * before, "{left} of {before} levels: light {number}, {right} px, {size:?}");
                }
            }
        }
    }

    #[test]
    fn light_that_changes_at_one_place_is_corrected_only_around_it() {
        let size = (200, 64);
        let reference = picture(size, 0, |_, _| 1.0);
        let current = picture(size, 0, |x, _| if x < 8.0 { 0.7 } else { 1.0 });
        let found = corrected(&reference, &current, 0.0).unwrap();
        let changed = |x: usize| (0..size.1).any(|y| found.at(x, y).to_bits() != current.at(x, y).to_bits());
        assert!((0..16).all(changed), "around the change");
        assert!(!(96..size.0).any(changed), "far from it");
    }

    #[test]
    fn a_steady_light_is_not_corrected() {
        for size in SIZES {
            let reference = picture(size, 0, |_, _| 1.0);
            assert_eq!(corrected(&reference, &reference, 0.0), None);
        }
    }
}
