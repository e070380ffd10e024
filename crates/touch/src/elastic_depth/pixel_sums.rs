//! Sums of the flow over the pixels of each cell.

/// Marks a pixel that does not show the gel.
pub(super) const NOWHERE: u32 = u32::MAX;

/// Pixels that follow each other and show the same cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run {
    first: u32,
    end: u32,
    /// The cell.
    pub(super) cell: u32,
}

impl Run {
    /// The runs of all pixels that show a cell.
    pub(super) fn all(cell_of: &[u32]) -> Vec<Self> {
        let mut runs = Vec::new();
        let mut first = 0;
        for pixels in cell_of.chunk_by(|left, right| left == right) {
            let end = first + pixels.len() as u32;
            runs.extend((pixels[0] != NOWHERE).then_some(Self { first, end, cell: pixels[0] }));
            first = end;
        }
        runs
    }
}

/// Sums over pixels.
#[derive(Debug, Clone, Copy, Default)]
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

impl Sum {
    pub(super) fn add(&mut self, other: Self) {
        self.flow[0] += other.flow[0];
        self.flow[1] += other.flow[1];
        self.count += other.count;
        self.valid += other.valid;
        self.variance += other.variance;
    }

    /// The sums over the pixels of a run whose flow is finite.
    pub(super) fn of(pixels: &Pixels<'_>, run: Run) -> Self {
        let sum = Self::over(pixels, run, |_, _| true);
        if sum.flow[0].is_finite() && sum.flow[1].is_finite() {
            return sum;
        }
        Self::over(pixels, run, |u, v| u.is_finite() && v.is_finite())
    }

    #[inline(always)]
    fn over(pixels: &Pixels<'_>, Run { first, end, .. }: Run, passes: impl Fn(f32, f32) -> bool) -> Self {
        let range = first as usize..end as usize;
        let flow = pixels.u[range.clone()].iter().zip(&pixels.v[range.clone()]);
        let quality = pixels.deviation[range.clone()].iter().zip(&pixels.valid[range]);
        let mut sum = Self::default();
        for ((&u, &v), (&deviation, &valid)) in flow.zip(quality) {
            if passes(u, v) {
                let variance = if valid == 1 { deviation * deviation } else { 0.0 };
                sum.add(Self { flow: [u, v], count: 1.0, valid: f32::from(valid), variance });
            }
        }
        sum
    }
}

/// Flow, its deviation and its validity at every pixel.
pub(super) struct Pixels<'a> {
    pub(super) u: &'a [f32],
    pub(super) v: &'a [f32],
    pub(super) deviation: &'a [f32],
    pub(super) valid: &'a [u8],
}

/// Sets the sums of every cell over the pixels of some runs.
pub(super) fn add_up(pixels: &Pixels<'_>, runs: &[Run], sums: &mut [Sum]) {
    sums.fill(Sum::default());
    for &run in runs {
        sums[run.cell as usize].add(Sum::of(pixels, run));
    }
}
