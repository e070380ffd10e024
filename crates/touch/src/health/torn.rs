//! Finds images that are torn: some of their rows are those of an earlier frame.
//!
//! A camera or a driver that overwrites a picture while it is read delivers its upper rows from one moment and its lower rows from
//! another. Noise differs from frame to frame, so rows that are equal to those of an earlier frame, value by value, were not exposed
//! again. Parts of a video that do not move may be equal, too, as may images without noise. An image therefore counts as torn only if
//! the gel beside the border of the equal rows has moved since that frame: motion is continuous, so these rows would have moved
//! with it.

use std::ops::Range;

use fingervision_flow::Estimate;
use fingervision_image::Image;

use super::flow_at;
use super::thresholds::THRESHOLDS;

/// Number of earlier frames that an image is compared with: as many as drivers have buffers.
const KEPT: usize = 4;
/// Every so many rows one is compared.
const EVERY: usize = 8;
/// Distance between samples of the flow along both axes, px.
const STEP: usize = 16;
/// Samples farther than this from the rows that differ next to the border are not used: motion may change over a longer distance. This
/// is wide enough for one sample whose patch does not contain the border.
const FARTHEST: usize = 32;

/// What is kept of a frame.
#[derive(Debug)]
struct Kept {
    /// A check sum of each compared row.
    rows: Vec<u32>,
    /// The flow at each [`place`], where it is valid.
    flow: Vec<Option<[f32; 2]>>,
}

/// The last frames. A frame allocates nothing.
#[derive(Debug)]
pub(super) struct Torn {
    /// Columns and rows of samples.
    samples: (usize, usize),
    /// The newest frame is at `newest`, the one before it at `newest` − 1, and so on around.
    kept: [Kept; KEPT + 1],
    newest: usize,
    count: usize,
}

impl Torn {
    /// For images of this size, px.
    pub(super) fn new((width, height): (usize, usize)) -> Self {
        let samples = (width / STEP, height / STEP);
        let kept = || Kept { rows: vec![0; height.div_ceil(EVERY)], flow: vec![None; samples.0 * samples.1] };
        Self { samples, kept: std::array::from_fn(|_| kept()), newest: 0, count: 0 }
    }

    /// Begins again with a new reference, to which the flow of the frames before is not relative.
    pub(super) fn restart(&mut self) {
        self.count = 0;
    }

    /// Takes a frame; returns whether it is torn.
    pub(super) fn watch(&mut self, grey: &Image<f32>, estimate: &Estimate) -> bool {
        self.newest = (self.newest + 1) % self.kept.len();
        let columns = self.samples.0;
        let now = &mut self.kept[self.newest];
        for (sum, row) in now.rows.iter_mut().zip(grey.rows().step_by(EVERY)) {
            *sum = check_sum(row);
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
        let now = &self.kept[self.newest];
        let then = &self.kept[(self.newest + self.kept.len() - back) % self.kept.len()];
        let is_same = |(now, then): &(&u32, &u32)| now == then;
        let pairs = || now.rows.iter().zip(&then.rows);
        let (upper, lower) =
            (pairs().take_while(is_same).count() * EVERY, pairs().rev().take_while(is_same).count() * EVERY);
        // The border is above the first row that differs, or below the last one.
        let below = upper..upper + FARTHEST;
        let last = (now.rows.len() * EVERY).saturating_sub(lower + EVERY);
        let above = last.saturating_sub(FARTHEST)..last;
        (upper >= THRESHOLDS.least_torn_rows && self.moves(now, then, &below))
            || (lower >= THRESHOLDS.least_torn_rows && self.moves(now, then, &above))
    }

    /// Whether the gel has moved between two frames in these rows.
    fn moves(&self, now: &Kept, then: &Kept, within: &Range<usize>) -> bool {
        let (columns, rows) = self.samples;
        let is_inside = |row: &usize| within.contains(&place(0, *row).1);
        let moved = (0..rows).filter(is_inside).flat_map(|row| row * columns..(row + 1) * columns).filter(|&index| {
            now.flow[index].zip(then.flow[index]).is_some_and(|(now, then)| {
                let [x, y] = [now[0] - then[0], now[1] - then[1]];
                x * x + y * y > THRESHOLDS.torn_px * THRESHOLDS.torn_px
            })
        });
        moved.count() >= THRESHOLDS.least_torn_samples
    }
}

/// The pixel of a sample of the flow.
fn place(column: usize, row: usize) -> (usize, usize) {
    (column * STEP + STEP / 2, row * STEP + STEP / 2)
}

/// A number that differs, but for one case in billions, where the values of two rows differ: Fletcher's sums, in which each value counts
/// by its place.
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
