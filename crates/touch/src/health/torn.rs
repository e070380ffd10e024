//! Finds images that are torn: some of their rows are those of an earlier frame.
//!
//! If a driver reads a picture while a camera overwrites it, its upper rows are from one moment and its lower rows from another. Noise
//! differs from frame to frame, so rows of the gel that are equal to those of an earlier frame, value by value, were not exposed again.
//! Two other images have such rows. A video stores blocks that hardly move only once; their border follows the motion, while that of a
//! tear is straight. Where the image is black or saturated, or without noise, rows are equal in all frames; gel is tracked in rows that
//! were torn off, and motion is continuous, so that they would have moved with the gel beside them.

use std::ops::Range;

use fingervision_flow::Estimate;
use fingervision_image::Image;

use super::thresholds::THRESHOLDS;
use super::{difference, flow_at, length2};

/// Number of earlier frames that an image is compared with: as many as drivers have buffers.
const KEPT: usize = 4;
/// Every so many rows one is compared.
const EVERY: usize = 8;
/// Number of parts of a row that are compared on their own. The border of a tear is at the same row in all of them, or one row apart.
const PARTS: usize = 4;
/// Distance between samples of the flow along both axes, px.
const STEP: usize = 16;
/// Samples farther than this from the rows that differ next to the border are not used: motion may change over a longer distance. This
/// is wide enough for one sample whose patch does not contain the border.
const FARTHEST: usize = 32;
/// The flow of equal rows is taken farther than this from their border, px: patches nearer to it see the other rows, too.
const BESIDE: usize = 16;

/// What is kept of a frame.
#[derive(Debug)]
struct Kept {
    /// A check sum of each part of each compared row.
    rows: Vec<[u32; PARTS]>,
    /// The flow at each [`place`], where it is valid.
    flow: Vec<Option<[f32; 2]>>,
}

/// The last frames. A frame allocates nothing.
#[derive(Debug)]
pub(super) struct Torn {
    /// Columns and rows of samples.
    samples: (usize, usize),
    /// The newest frame first.
    kept: [Kept; KEPT + 1],
    /// Number of earlier frames that are kept.
    count: usize,
}

impl Torn {
    /// For images of this size, px.
    pub(super) fn new((width, height): (usize, usize)) -> Self {
        let samples = (width / STEP, height / STEP);
        let kept = || Kept { rows: vec![[0; PARTS]; height.div_ceil(EVERY)], flow: vec![None; samples.0 * samples.1] };
        Self { samples, kept: std::array::from_fn(|_| kept()), count: 0 }
    }

    /// Begins again with a new reference, to which the flow of the frames before is not relative.
    pub(super) fn restart(&mut self) {
        self.count = 0;
    }

    /// Takes a frame; returns whether it is torn.
    pub(super) fn watch(&mut self, grey: &Image<f32>, estimate: &Estimate) -> bool {
        // The oldest one is overwritten.
        self.kept.rotate_right(1);
        let columns = self.samples.0;
        let now = &mut self.kept[0];
        let part = grey.width().div_ceil(PARTS).max(1);
        for (sums, row) in now.rows.iter_mut().zip(grey.rows().step_by(EVERY)) {
            for (sum, part) in sums.iter_mut().zip(row.chunks(part)) {
                *sum = check_sum(part);
            }
        }
        for (index, flow) in now.flow.iter_mut().enumerate() {
            *flow = flow_at(estimate, place(index % columns, index / columns));
        }
        let earlier = self.count;
        self.count = (earlier + 1).min(KEPT);
        (1..=earlier).any(|back| self.is_torn(back))
    }

    /// Whether the upper or the lower rows, but not all, are those of the frame so many before, and should have moved.
    fn is_torn(&self, back: usize) -> bool {
        let (now, then) = (&self.kept[0], &self.kept[back]);
        let height = now.rows.len() * EVERY;
        let pairs = || now.rows.iter().zip(&then.rows);
        // The border is above the first row that differs, or below the last one.
        if let Some(upper) = equal_rows(pairs()) {
            let first = upper * EVERY;
            let (equal, below) = (0..first.saturating_sub(BESIDE), first..first + FARTHEST);
            if self.is_gel(now, then, &equal) && self.moves(now, then, &below) {
                return true;
            }
        }
        equal_rows(pairs().rev()).is_some_and(|lower| {
            let begin = height - lower * EVERY;
            let last = begin.saturating_sub(EVERY);
            let above = last.saturating_sub(FARTHEST)..last;
            self.is_gel(now, then, &(begin + BESIDE..height)) && self.moves(now, then, &above)
        })
    }

    /// Whether the gel is tracked in both frames in these rows.
    fn is_gel(&self, now: &Kept, then: &Kept, within: &Range<usize>) -> bool {
        let tracked = self.within(within).filter(|&index| now.flow[index].is_some() && then.flow[index].is_some());
        tracked.count() >= THRESHOLDS.least_torn_samples
    }

    /// Whether the gel has moved between two frames in these rows.
    fn moves(&self, now: &Kept, then: &Kept, within: &Range<usize>) -> bool {
        let moved = self.within(within).filter(|&index| {
            let flows = now.flow[index].zip(then.flow[index]);
            flows.is_some_and(|(now, then)| length2(difference(now, then)) > THRESHOLDS.torn_px.powi(2))
        });
        moved.count() >= THRESHOLDS.least_torn_samples
    }

    /// The samples in these rows of the image.
    fn within(&self, rows: &Range<usize>) -> impl Iterator<Item = usize> + use<'_> {
        let (columns, count) = self.samples;
        let rows = rows.clone();
        let is_inside = move |row: &usize| rows.contains(&place(0, *row).1);
        (0..count).filter(is_inside).flat_map(move |row| row * columns..(row + 1) * columns)
    }
}

/// How many rows, from the first pair on, are equal: in all parts of the row about the same number, but in parts that never
/// change. None if there are too few, or the border is not straight.
fn equal_rows<'a>(pairs: impl Iterator<Item = (&'a [u32; PARTS], &'a [u32; PARTS])>) -> Option<usize> {
    let (mut is_equal, mut rows, mut count) = ([true; PARTS], [0; PARTS], 0);
    for (now, then) in pairs {
        for part in 0..PARTS {
            is_equal[part] &= now[part] == then[part];
            rows[part] += usize::from(is_equal[part]);
        }
        count += 1;
    }
    let changing = || rows.into_iter().filter(|&rows| rows < count);
    let (least, most) = (changing().min()?, changing().max()?);
    (least * EVERY >= THRESHOLDS.least_torn_rows && most - least <= 1).then_some(least)
}

/// The pixel of a sample of the flow.
fn place(column: usize, row: usize) -> (usize, usize) {
    (column * STEP + STEP / 2, row * STEP + STEP / 2)
}

/// A number that differs, but for one case in billions, where the values of two parts of rows differ: Fletcher's sums, in which each value
/// counts by its place.
fn check_sum(row: &[f32]) -> u32 {
    /// Odd, so that no bit is lost: 2³² divided by the golden ratio.
    const FACTOR: u32 = 0x9e37_79b1;
    let (blocks, rest) = row.as_chunks::<8>();
    let (mut sums, mut sums_of_sums) = ([0_u32; 8], [0_u32; 8]);
    for block in blocks {
        for lane in 0..8 {
            sums[lane] = sums[lane].wrapping_add(block[lane].to_bits());
            sums_of_sums[lane] = sums_of_sums[lane].wrapping_add(sums[lane]);
        }
    }
    let parts = sums.into_iter().chain(sums_of_sums).chain(rest.iter().map(|value| value.to_bits()));
    parts.fold(0, |sum, part| (sum.rotate_left(5) ^ part).wrapping_mul(FACTOR))
}
