//! Correction of the light of a picture to that of the reference: a flat-field correction from the pictures themselves.
//!
//! A patch eliminates one change of light for all its pixels. A change that differs within a patch looks like motion, and so does one
//! that differs from colour to colour. Light on a gel does change so: with the depth of a press, with the white balance, and, behind a
//! rolling shutter, from row to row.
//!
//! The brightness of a picture is its mean over some 40 px around the middle of each block of 8 px, in each channel. That of the reference is
//! read where the gel was, by the flow of the last frame: around the same piece of gel the pattern has the same mean, and what differs
//! is the light.

use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use fingervision_image::Image;

/// Side of a block, px: the middle of each is a node of the patches.
pub(crate) const BLOCK: usize = 8;
/// Blocks of each of the two boxes whose convolution weights those around a node along one axis.
const BOX: usize = 5;
/// A light that differs by less than this part everywhere is not corrected: the patches eliminate it.
const LEAST_CHANGE: f32 = 0.02;
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
    /// Factors along a row of pixels.
    line: Vec<f32>,
}

impl Light {
    /// For pictures of this size with so many channels.
    pub(crate) fn new(width: usize, height: usize, channels: usize) -> Self {
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
            line: vec![1.0; columns],
        };
        let pixels = |place: usize, length: usize| BLOCK.min(length - BLOCK * place) as f32;
        for node in 0..nodes {
            light.sums[0][node] = pixels(node % columns, width) * pixels(node / columns, height);
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

    /// Sums the pixels of each block; those at the right and at the bottom may be smaller.
    #[simd]
    fn sum_blocks<S: Simd>(&mut self, simd: S, image: &Image<f32>) {
        let _ = simd;
        let (width, height) = image.size();
        let pixels = image.values();
        for (row, blocks) in self.sums[0].chunks_exact_mut(self.columns).enumerate() {
            let (top, bottom) = (row * BLOCK, ((row + 1) * BLOCK).min(height));
            let sums = &mut self.column_sums[..width];
            sums.copy_from_slice(&pixels[top * width..][..width]);
            for y in top + 1..bottom {
                let line = &pixels[y * width..][..width];
                for x in 0..width {
                    sums[x] += line[x];
                }
            }
            for (block, sums) in blocks.iter_mut().zip(sums.chunks(BLOCK)) {
                *block = sums.iter().sum();
            }
        }
    }

    /// Sets the factors that give a picture the light of a reference; `u` and `v` are the last displacement from the reference in the
    /// middle of each block, px. Returns whether they change anything.
    pub(crate) fn find_change(&mut self, reference: &Self, [u, v]: [&[f32]; 2]) -> bool {
        let mut most = 0.0_f32;
        for row in 0..self.rows {
            for column in 0..self.columns {
                let node = row * self.columns + column;
                // In nodes.
                let place = [column as f32 - u[node] / BLOCK as f32, row as f32 - v[node] / BLOCK as f32];
                for (channel, factors) in self.factors.iter_mut().enumerate() {
                    let (then, now) = (reference.at(channel, place), self.brightness[channel][node]);
                    let factor = (then.max(DARK) / now.max(DARK)).clamp(1.0 / MOST_CHANGE, MOST_CHANGE);
                    most = most.max((factor - 1.0).abs());
                    factors[node] = factor;
                }
            }
        }
        most > LEAST_CHANGE
    }

    /// The brightness between the nodes; beyond the outermost ones it is theirs.
    fn at(&self, channel: usize, [x, y]: [f32; 2]) -> f32 {
        let plane = &self.brightness[channel];
        let split = |place: f32, count: usize| {
            let place = place.clamp(0.0, (count - 1) as f32);
            let whole = (place as usize).min(count.saturating_sub(2));
            (whole, (whole + 1).min(count - 1), place - whole as f32)
        };
        let ((left, right, dx), (upper, lower, dy)) = (split(x, self.columns), split(y, self.rows));
        let along = |row: usize| {
            let row = &plane[row * self.columns..][..self.columns];
            row[left] + dx * (row[right] - row[left])
        };
        along(upper) + dy * (along(lower) - along(upper))
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
            let (upper, lower) = (&factors[upper * columns..][..columns], &factors[lower * columns..][..columns]);
            let line = &mut self.line[..columns];
            for i in 0..columns {
                line[i] = upper[i] + down * (lower[i] - upper[i]);
            }
            let (first, inner) = pixels.split_at_mut(BLOCK / 2);
            for pixel in first {
                *pixel *= line[0];
            }
            let (cells, rest) = inner.as_chunks_mut::<BLOCK>();
            let last = cells.len();
            for (cell, factors) in cells.iter_mut().zip(line.windows(2)) {
                let (left, change) = (factors[0], factors[1] - factors[0]);
                for k in 0..BLOCK {
                    cell[k] *= left + weights[k] * change;
                }
            }
            let (left, right) = (line[last], line[(last + 1).min(columns - 1)]);
            for (pixel, weight) in rest.iter_mut().zip(weights) {
                *pixel *= left + weight * (right - left);
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
            let mut light = Light::new(width, height, 1);
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
    fn a_steady_light_is_not_corrected() {
        for size in SIZES {
            let reference = picture(size, 0, |_, _| 1.0);
            assert_eq!(corrected(&reference, &reference, 0.0), None);
        }
    }
}
