//! Sums of the flow over the pixels of each cell.

use fearless_simd::{Level, Simd, dispatch, f32x8, prelude::*};
use fearless_simd_macros::simd;

/// Marks a pixel that does not show the gel.
pub(super) const NOWHERE: u32 = u32::MAX;

/// Most pixels of a run.
const LANES: usize = 8;

/// One in each of the first bytes, by their number.
const ONES: [u64; LANES + 1] = [
    0,
    0x01,
    0x0101,
    0x01_0101,
    0x0101_0101,
    0x01_0101_0101,
    0x0101_0101_0101,
    0x01_0101_0101_0101,
    0x0101_0101_0101_0101,
];

/// Pixels of a cell that follow each other in a row.
#[derive(Debug, Clone, Copy)]
struct Run {
    first: u32,
    length: u32,
}

/// The pixels that show each cell.
#[derive(Debug, Clone)]
pub(super) struct CellPixels {
    level: Level,
    /// The runs of all cells, one cell after the other.
    runs: Vec<Run>,
    /// Where the runs of each cell begin, and where those of the last one end.
    begins: Vec<u32>,
}

/// Sums over the pixels of a cell.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Sum {
    /// The flow, px.
    pub(super) flow: [f32; 2],
    /// The number of pixels.
    pub(super) count: f32,
    /// The number of those with valid flow.
    pub(super) valid: f32,
    /// Variance of the flow where it is valid, px².
    pub(super) variance: f32,
}

/// Flow, its deviation and its validity at every pixel.
pub(super) struct Pixels<'a> {
    pub(super) u: &'a [f32],
    pub(super) v: &'a [f32],
    pub(super) deviation: &'a [f32],
    pub(super) valid: &'a [u8],
}

impl CellPixels {
    /// The pixels of each of some cells, from the cell that each pixel shows.
    pub(super) fn new(level: Level, cell_of: &[u32], cells: usize) -> Self {
        let mut of_cells = vec![Vec::new(); cells];
        let mut first = 0;
        for pixels in cell_of.chunk_by(|left, right| left == right) {
            if pixels[0] != NOWHERE {
                let parts = pixels.chunks(LANES).enumerate();
                let run = |(part, pixels): (usize, &[u32])| Run {
                    first: (first + part * LANES) as u32,
                    length: pixels.len() as u32,
                };
                of_cells[pixels[0] as usize].extend(parts.map(run));
            }
            first += pixels.len();
        }
        let mut end = 0;
        let ends = of_cells.iter().map(|runs| {
            end += runs.len() as u32;
            end
        });
        let begins = std::iter::once(0).chain(ends).collect();
        Self { level, runs: of_cells.concat(), begins }
    }

    /// Sets the sums of the cells from `first` on, over their pixels with finite flow.
    pub(super) fn add_up(&self, pixels: &Pixels<'_>, first: usize, sums: &mut [Sum]) {
        dispatch!(self.level, simd => self.fill(simd, pixels, first, sums));
    }

    #[simd]
    fn fill<S: Simd>(&self, simd: S, pixels: &Pixels<'_>, first: usize, sums: &mut [Sum]) {
        let begins = &self.begins[first..=first + sums.len()];
        for (sum, begin) in sums.iter_mut().zip(begins.windows(2)) {
            let runs = &self.runs[begin[0] as usize..begin[1] as usize];
            *sum = over(simd, pixels, runs);
            if !(sum.flow[0].is_finite() && sum.flow[1].is_finite()) {
                *sum = over_finite(pixels, runs);
            }
        }
    }
}

/// Sums over all pixels of some runs.
#[inline(always)]
fn over<S: Simd>(simd: S, pixels: &Pixels<'_>, runs: &[Run]) -> Sum {
    let zero = f32x8::splat(simd, 0.0);
    let places = f32x8::from_slice(simd, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    let mut lanes = [zero; 3];
    let (mut rest, mut count, mut valid) = (Sum::default(), 0, 0);
    // Of one length: the others need no check of their own.
    let planes = [pixels.u, pixels.v, pixels.deviation].map(|plane| &plane[..pixels.valid.len()]);
    for run in runs {
        let first = run.first as usize;
        let Some(marks) = pixels.valid.get(first..first + LANES).and_then(<[u8]>::first_chunk) else {
            // At the end of the image there are not as many pixels as lanes.
            add(&mut rest, pixels, *run, |_, _| true);
            continue;
        };
        let load = |plane: &[f32]| f32x8::from_slice(simd, &plane[first..first + LANES]);
        let is_inside = places.simd_lt(run.length as f32);
        let ones = ONES[run.length as usize];
        let marks = u64::from_le_bytes(*marks) & ones;
        lanes[0] += is_inside.select(load(planes[0]), zero);
        lanes[1] += is_inside.select(load(planes[1]), zero);
        count += run.length;
        valid += marks.count_ones();
        if marks == ones {
            let deviation = is_inside.select(load(planes[2]), zero);
            lanes[2] = deviation.mul_add(deviation, lanes[2]);
        } else {
            let deviations = &pixels.deviation[first..first + LANES];
            let marked = deviations.iter().enumerate().filter(|(lane, _)| marks >> (8 * lane) & 1 == 1);
            rest.variance += marked.map(|(_, deviation)| deviation * deviation).sum::<f32>();
        }
    }
    let [u, v, variance] = lanes.map(f32x8::reduce_sum);
    Sum {
        flow: [rest.flow[0] + u, rest.flow[1] + v],
        count: rest.count + count as f32,
        valid: rest.valid + valid as f32,
        variance: rest.variance + variance,
    }
}

/// Sums over the pixels of some runs whose flow is finite.
fn over_finite(pixels: &Pixels<'_>, runs: &[Run]) -> Sum {
    let mut sum = Sum::default();
    for &run in runs {
        add(&mut sum, pixels, run, |u, v| u.is_finite() && v.is_finite());
    }
    sum
}

/// Adds the pixels of a run whose flow passes.
#[inline(always)]
fn add(sum: &mut Sum, pixels: &Pixels<'_>, Run { first, length }: Run, passes: impl Fn(f32, f32) -> bool) {
    for pixel in first as usize..(first + length) as usize {
        let (u, v) = (pixels.u[pixel], pixels.v[pixel]);
        if passes(u, v) {
            sum.flow[0] += u;
            sum.flow[1] += v;
            sum.count += 1.0;
            if pixels.valid[pixel] == 1 {
                sum.valid += 1.0;
                sum.variance += pixels.deviation[pixel] * pixels.deviation[pixel];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PIXELS: usize = 203;
    const CELLS: usize = 12;

    /// Cells of 1 to 13 pixels in irregular order, some pixels nowhere.
    fn cells() -> Vec<u32> {
        let runs = (0..40).flat_map(|run: u32| {
            let cell = if run % 7 == 3 { NOWHERE } else { (5 * run) % CELLS as u32 };
            std::iter::repeat_n(cell, 1 + (run * run) as usize % 13)
        });
        runs.chain(std::iter::repeat(3)).take(PIXELS).collect()
    }

    fn sums(change: impl Fn(usize, &mut [f32; 3], &mut u8)) -> Vec<[Sum; 2]> {
        let (mut u, mut v, mut deviation, mut valid) = (vec![], vec![], vec![], vec![]);
        for pixel in 0..PIXELS {
            let mut values = [0.3, 0.7, 0.01].map(|scale| scale * (pixel as f32 + scale).sin());
            let mut mark = u8::from(pixel % 11 != 0);
            change(pixel, &mut values, &mut mark);
            u.push(values[0]);
            v.push(values[1]);
            deviation.push(values[2]);
            valid.push(mark);
        }
        let pixels = Pixels { u: &u, v: &v, deviation: &deviation, valid: &valid };
        let cell_of = cells();
        let mut found = vec![Sum::default(); CELLS];
        let cells = CellPixels::new(Level::new(), &cell_of, CELLS);
        let (upper, lower) = found.split_at_mut(5);
        cells.add_up(&pixels, 0, upper);
        cells.add_up(&pixels, 5, lower);
        let expected = |cell: usize| {
            let mut sum = Sum::default();
            for pixel in (0..PIXELS).filter(|&pixel| cell_of[pixel] as usize == cell) {
                add(&mut sum, &pixels, Run { first: pixel as u32, length: 1 }, |u, v| u.is_finite() && v.is_finite());
            }
            sum
        };
        found.into_iter().enumerate().map(|(cell, sum)| [sum, expected(cell)]).collect()
    }

    fn assert_near(sums: &[[Sum; 2]]) {
        for (cell, [found, expected]) in sums.iter().enumerate() {
            assert_eq!((found.count, found.valid), (expected.count, expected.valid), "cell {cell}");
            let pairs = found.flow.iter().zip(&expected.flow).chain([(&found.variance, &expected.variance)]);
            for (found, expected) in pairs {
                assert!((found - expected).abs() < 1e-5, "cell {cell}: {found} instead of {expected}");
            }
        }
    }

    #[test]
    fn every_cell_has_the_sums_over_its_pixels() {
        let sums = sums(|_, _, _| ());
        assert_near(&sums);
        assert!(sums.iter().all(|[sum, _]| sum.count > 0.0));
    }

    #[test]
    fn what_is_not_finite_is_left_out_and_changes_no_other_cell() {
        let change = |pixel: usize, values: &mut [f32; 3], mark: &mut u8| match pixel {
            17 => *values = [f32::NAN, 0.0, 0.0],
            50 | 51 => *values = [0.0, f32::INFINITY, 0.1],
            80..90 => (values[2], *mark) = (f32::INFINITY, 0),
            _ => {}
        };
        assert_near(&sums(change));
    }
}
