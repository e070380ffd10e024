//! Finds parts of the gel whose flow is never valid.
//!
//! The image is divided into cells. If a cell is not valid in any of many frames in which the gel is at rest and other
//! cells are valid, the gel is torn, worn or dirty there. Frames with a press are not counted, because the flow of
//! steep walls is not valid either. An area that reaches the border of the image may lie beside the gel, so it does not
//! count.

use fingervision_image::Image;

use super::thresholds::THRESHOLDS;

/// Side of a cell, px.
const CELL: usize = 16;
/// Distance between samples of a cell along both axes, px.
const STEP: usize = 8;

/// The cells of an image.
#[derive(Debug)]
pub(super) struct Damage {
    columns: usize,
    rows: usize,
    /// For each cell, number of frames at rest since it was last valid.
    missed: Vec<u16>,
    /// Cells that are damaged, without those that are connected with the border.
    is_damaged: Vec<bool>,
    /// Cells whose neighbours are still to be examined.
    pending: Vec<usize>,
    part: f32,
}

impl Damage {
    /// For images of this size, px.
    pub(super) fn new((width, height): (usize, usize)) -> Self {
        let (columns, rows) = (width / CELL, height / CELL);
        let cells = columns * rows;
        Self {
            columns,
            rows,
            missed: vec![0; cells],
            is_damaged: vec![false; cells],
            pending: Vec::with_capacity(cells),
            part: 0.0,
        }
    }

    /// Begins again with a new reference.
    pub(super) fn restart(&mut self) {
        self.missed.fill(0);
        self.part = 0.0;
    }

    /// The part of the image that is damaged, 0 to 1.
    pub(super) fn part(&self) -> f32 {
        self.part
    }

    /// Takes a frame that is not lost.
    pub(super) fn watch(&mut self, valid: &Image<u8>, is_at_rest: bool) {
        let columns = self.columns;
        for (cell, missed) in self.missed.iter_mut().enumerate() {
            let (x, y) = (cell % columns * CELL + STEP / 2, cell / columns * CELL + STEP / 2);
            let samples = [(x, y), (x + STEP, y), (x, y + STEP), (x + STEP, y + STEP)];
            let tracked: u8 = samples.into_iter().map(|(x, y)| valid.at(x, y)).sum();
            if tracked >= 2 {
                *missed = 0;
            } else if is_at_rest {
                *missed = missed.saturating_add(1);
            }
        }
        self.measure();
    }

    fn measure(&mut self) {
        let mut count = 0;
        for (damaged, &missed) in self.is_damaged.iter_mut().zip(&self.missed) {
            *damaged = missed >= THRESHOLDS.damaged_frames;
            count += usize::from(*damaged);
        }
        if count > 0 {
            count -= self.unmark_border();
        }
        let part = count as f32 / self.missed.len().max(1) as f32;
        let is_large = count >= THRESHOLDS.least_damaged && part >= THRESHOLDS.least_damaged_part;
        let is_damage = is_large && part <= THRESHOLDS.most_damaged;
        self.part = if is_damage { part } else { 0.0 };
    }

    /// Unmarks the cells that are connected with the border; returns their number.
    fn unmark_border(&mut self) -> usize {
        let Self { columns, rows, is_damaged, pending, .. } = self;
        let (columns, rows) = (*columns, *rows);
        let mut unmarked = 0;
        let mut unmark = |cell: usize, pending: &mut Vec<usize>| {
            if std::mem::take(&mut is_damaged[cell]) {
                unmarked += 1;
                pending.push(cell);
            }
        };
        for cell in 0..columns * rows {
            let (x, y) = (cell % columns, cell / columns);
            if x == 0 || y == 0 || x + 1 == columns || y + 1 == rows {
                unmark(cell, pending);
            }
        }
        while let Some(cell) = pending.pop() {
            let (x, y) = (cell % columns, cell / columns);
            for near_y in y.saturating_sub(1)..(y + 2).min(rows) {
                for near_x in x.saturating_sub(1)..(x + 2).min(columns) {
                    unmark(near_y * columns + near_x, pending);
                }
            }
        }
        unmarked
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (160, 128);

    /// Valid except in this rectangle: left, top, width, height, px.
    fn valid_but([left, top, width, height]: [usize; 4]) -> Image<u8> {
        Image::from_fn(SIZE.0, SIZE.1, |x, y| {
            u8::from(!((left..left + width).contains(&x) && (top..top + height).contains(&y)))
        })
    }

    fn part(hole: [usize; 4], is_at_rest: bool) -> f32 {
        let mut damage = Damage::new(SIZE);
        for _ in 0..40 {
            damage.watch(&valid_but(hole), is_at_rest);
        }
        damage.part()
    }

    #[test]
    fn a_part_that_never_tracks_is_measured() {
        let share = part([48, 48, 32, 32], true);
        assert!((share - 4.0 / 80.0).abs() < 1e-6, "{share}");
        assert!(part([48, 48, 32, 32], false) <= 0.0, "a press hides it");
        assert!(part([0, 48, 32, 32], true) <= 0.0, "beside the gel");
        assert!(part([16, 16, 128, 96], true) <= 0.0, "a sparse pattern");
    }

    #[test]
    fn a_part_that_tracks_once_is_not_damaged() {
        let mut damage = Damage::new(SIZE);
        for frame in 0..80 {
            let hole = if frame % 25 == 24 { [0; 4] } else { [48, 48, 32, 32] };
            damage.watch(&valid_but(hole), true);
            assert!(damage.part() <= 0.0, "frame {frame}");
        }
    }
}
