//! Finds what stands still while the gel moves behind it: dirt, hairs, scratches and reflections on the optics.
//!
//! They match the reference if they were there when it was taken, so their flow is too small and looks right. The image is divided
//! into cells. A cell is suspicious if its flow is much smaller than that around it, which is about the same on all sides.
//! No gel moves like this. Then its pixels are compared with the reference: a pixel stands still if its level is that of the
//! reference at the same place, and not that at the place from which the gel around it has come. A cell is dirty if many pixels stand
//! still, or some do so again after the gel has moved further.
//!
//! A cell remains dirty until there is a new reference. Its flow and that of the cells around it are not valid; their flow is
//! interpolated between the cells beside them.

use fingervision_flow::{Estimate, FlowField};
use fingervision_image::{Between, Image};

use super::thresholds::THRESHOLDS;

/// Side of a cell, px.
const CELL: usize = 8;
/// Distance along both axes of the places around a cell, in cells.
const AROUND: usize = 2;
/// In how many frames a cell is compared at most.
const LOOKS: usize = 6;
/// The count of a pixel that has clearly changed: it is never counted again.
const HAS_CHANGED: u8 = 0x80;

/// A cell of the image.
#[derive(Debug, Clone, Copy, Default)]
struct Cell {
    /// Motion of the gel around it in the frames in which it was compared, px; the first `looks` count.
    motions: [[f32; 2]; LOOKS],
    looks: usize,
    is_dirty: bool,
}

/// A cell without flow, and where flow is known beside it.
#[derive(Debug, Clone, Copy)]
struct Hidden {
    left: usize,
    top: usize,
    /// The nearest columns to the left and right that are not hidden, px; absent beyond the cells.
    columns: [Option<usize>; 2],
    /// The nearest rows above and below that are not hidden, px.
    rows: [Option<usize>; 2],
}

/// The cells of an image.
#[derive(Debug)]
pub(super) struct Dirt {
    columns: usize,
    rows: usize,
    /// Two levels that differ by less are the same, grey levels.
    same_levels: f32,
    /// Grey levels of the reference.
    reference: Image<f32>,
    /// In how many comparisons each pixel stood still, or [`HAS_CHANGED`].
    still: Image<u8>,
    cells: Vec<Cell>,
    /// Dirty cells and those around them.
    is_hidden: Vec<bool>,
    hidden: Vec<Hidden>,
}

impl Dirt {
    /// For images of this size, px, with noise of this standard deviation, grey levels.
    pub(super) fn new((width, height): (usize, usize), noise_levels: f32) -> Self {
        let (columns, rows) = (width / CELL, height / CELL);
        Self {
            columns,
            rows,
            same_levels: THRESHOLDS.same_noise * noise_levels,
            reference: Image::filled(width, height, 0.0),
            still: Image::filled(width, height, 0),
            cells: vec![Cell::default(); columns * rows],
            is_hidden: vec![false; columns * rows],
            hidden: Vec::with_capacity(columns * rows),
        }
    }

    /// Begins again with this reference, to which the flow of the frames that follow is relative.
    pub(super) fn restart(&mut self, grey: &Image<f32>) {
        self.reference.copy_from(grey);
        self.still.values_mut().fill(0);
        self.cells.fill(Cell::default());
        self.is_hidden.fill(false);
        self.hidden.clear();
    }

    /// The part of the image that dirt hides, 0 to 1.
    pub(super) fn part(&self) -> f32 {
        self.hidden.len() as f32 / self.cells.len().max(1) as f32
    }

    /// Takes a frame that is neither lost nor blurred and has the reference's light.
    pub(super) fn watch(&mut self, grey: &Image<f32>, estimate: &Estimate) {
        let mut is_new = false;
        for row in AROUND..self.rows.saturating_sub(AROUND) {
            for column in AROUND..self.columns.saturating_sub(AROUND) {
                let cell = self.cells[row * self.columns + column];
                if cell.looks == LOOKS || cell.is_dirty {
                    continue;
                }
                let Some(motion) = motion_around(estimate, (column, row)) else { continue };
                let is_further = |before: &[f32; 2]| distance(*before, motion) >= THRESHOLDS.further_px;
                let is_suspicious = stands_still(&estimate.flow, (column, row), motion);
                if is_suspicious && cell.motions[..cell.looks].iter().all(is_further) {
                    is_new |= self.look(grey, (column, row), motion);
                }
            }
        }
        if is_new {
            self.hide_around();
        }
    }

    /// Compares a cell with the reference; returns whether it turns out to be dirty. `motion` is that of the gel around it, px.
    fn look(&mut self, grey: &Image<f32>, (column, row): (usize, usize), motion: [f32; 2]) -> bool {
        let (left, top) = (column * CELL, row * CELL);
        let (mut once, mut twice) = (0, 0);
        for y in top..top + CELL {
            for x in left..left + CELL {
                let level = grey.at(x, y);
                let change = (level - self.reference.at(x, y)).abs();
                let still = &mut self.still.row_mut(y)[x];
                if change > THRESHOLDS.other_levels * self.same_levels {
                    *still = HAS_CHANGED;
                } else if *still != HAS_CHANGED && change <= self.same_levels {
                    let from = (x as f32 - motion[0], y as f32 - motion[1]);
                    let least = THRESHOLDS.moved_levels * self.same_levels;
                    *still += u8::from(is_other(
                        &self.reference,
                        from,
                        level,
                        least,
                        (0.25 * motion[0].hypot(motion[1])).min(0.3),
                    ));
                }
                once += usize::from(matches!(*still, 1..HAS_CHANGED));
                twice += usize::from(matches!(*still, 2..HAS_CHANGED));
            }
        }
        let cell = &mut self.cells[row * self.columns + column];
        cell.motions[cell.looks] = motion;
        cell.looks += 1;
        let is_fast = motion[0].hypot(motion[1]) >= THRESHOLDS.clear_px;
        cell.is_dirty = is_fast && once >= THRESHOLDS.still_once || twice >= THRESHOLDS.still_twice;
        cell.is_dirty
    }

    /// Hides the dirty cells and those around them.
    fn hide_around(&mut self) {
        let Self { columns, rows, cells, is_hidden, hidden, .. } = self;
        let (columns, rows) = (*columns, *rows);
        for cell in (0..cells.len()).filter(|&cell| cells[cell].is_dirty) {
            let (x, y) = (cell % columns, cell / columns);
            for near_y in y.saturating_sub(1)..(y + 2).min(rows) {
                is_hidden[near_y * columns..][x.saturating_sub(1)..(x + 2).min(columns)].fill(true);
            }
        }
        hidden.clear();
        for cell in (0..cells.len()).filter(|&cell| is_hidden[cell]) {
            let (x, y) = (cell % columns, cell / columns);
            let is_known = |x: usize, y: usize| !is_hidden[y * columns + x];
            let before = |x: usize| (x + 1) * CELL - 1;
            hidden.push(Hidden {
                left: x * CELL,
                top: y * CELL,
                columns: [
                    (0..x).rev().find(|&x| is_known(x, y)).map(before),
                    (x + 1..columns).find(|&x| is_known(x, y)).map(|x| x * CELL),
                ],
                rows: [
                    (0..y).rev().find(|&y| is_known(x, y)).map(before),
                    (y + 1..rows).find(|&y| is_known(x, y)).map(|y| y * CELL),
                ],
            });
        }
    }

    /// Replaces the flow that dirt hides by one between those beside it, and marks it as not valid.
    pub(super) fn hide(&self, estimate: &mut Estimate) {
        for hidden in &self.hidden {
            for y in hidden.top..hidden.top + CELL {
                let cell = hidden.left..hidden.left + CELL;
                estimate.valid.row_mut(y)[cell.clone()].fill(0);
                estimate.deviation.row_mut(y)[cell.clone()].fill(f32::INFINITY);
                for x in cell {
                    if let Some([u, v]) = hidden.between(&estimate.flow, x, y) {
                        (estimate.flow.u.row_mut(y)[x], estimate.flow.v.row_mut(y)[x]) = (u, v);
                    }
                }
            }
        }
    }
}

impl Hidden {
    /// The flow at a pixel, px, from the nearest known one to the left and right, above and below, weighted by one over the distance.
    fn between(&self, flow: &FlowField, x: usize, y: usize) -> Option<[f32; 2]> {
        let beside = self.columns.map(|column| column.map(|column| (column.abs_diff(x), (column, y))));
        let along = self.rows.map(|row| row.map(|row| (row.abs_diff(y), (x, row))));
        let (mut sum, mut weights) = ([0.0; 2], 0.0);
        for (distance, (x, y)) in beside.into_iter().chain(along).flatten() {
            let weight = 1.0 / distance as f32;
            sum = [sum[0] + weight * flow.u.at(x, y), sum[1] + weight * flow.v.at(x, y)];
            weights += weight;
        }
        (weights > 0.0).then(|| sum.map(|sum| sum / weights))
    }
}

fn distance(a: [f32; 2], b: [f32; 2]) -> f32 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The flow at a pixel, px, if it is valid.
fn flow_at(estimate: &Estimate, x: usize, y: usize) -> Option<[f32; 2]> {
    (estimate.valid.at(x, y) == 1).then(|| [estimate.flow.u.at(x, y), estimate.flow.v.at(x, y)])
}

/// Motion of the gel around a cell, px, if it is large enough and about the same on all sides.
fn motion_around(estimate: &Estimate, (column, row): (usize, usize)) -> Option<[f32; 2]> {
    const FAR: usize = 2 * AROUND;
    const PLACES: [(usize, usize); 8] =
        [(0, AROUND), (FAR, AROUND), (AROUND, 0), (AROUND, FAR), (0, 0), (FAR, FAR), (0, FAR), (FAR, 0)];
    let centre = |cell: usize, offset: usize| (cell + offset - AROUND) * CELL + CELL / 2;
    let flows = PLACES.map(|(dx, dy)| flow_at(estimate, centre(column, dx), centre(row, dy)));
    let mut motion = mean(flows.into_iter().flatten())?;
    // The second mean is without the places that stand still themselves.
    for _ in 0..2 {
        let difference = THRESHOLDS.similar_motion * motion[0].hypot(motion[1]);
        let similar = flows.into_iter().flatten().filter(|flow| distance(*flow, motion) < difference);
        if similar.clone().count() < THRESHOLDS.similar_places {
            return None;
        }
        motion = mean(similar)?;
    }
    (motion[0].hypot(motion[1]) >= THRESHOLDS.moves_px).then_some(motion)
}

fn mean(flows: impl Iterator<Item = [f32; 2]>) -> Option<[f32; 2]> {
    let (sum, count) = flows.fold(([0.0; 2], 0.0), |([su, sv], count), [u, v]| ([su + u, sv + v], count + 1.0));
    (count > 0.0).then(|| sum.map(|sum| sum / count))
}

/// Whether the flow in a part of a cell, valid or not, is much smaller than the motion around it, px.
fn stands_still(flow: &FlowField, (column, row): (usize, usize), motion: [f32; 2]) -> bool {
    let least = THRESHOLDS.still_motion * motion[0].hypot(motion[1]);
    let quarters = [CELL / 4, CELL - 1 - CELL / 4];
    let places = quarters.into_iter().flat_map(|dy| quarters.map(|dx| (column * CELL + dx, row * CELL + dy)));
    places.into_iter().any(|(x, y)| flow.u.at(x, y).hypot(flow.v.at(x, y)) < least)
}

/// Whether the reference differs from a level by more than `least` at a position and close to it: the flow around a cell is not
/// exactly that in it.
fn is_other(reference: &Image<f32>, (x, y): (f32, f32), level: f32, least: f32, near: f32) -> bool {
    [(0.0, 0.0), (near, 0.0), (-near, 0.0), (0.0, near), (0.0, -near)].into_iter().all(|(dx, dy)| {
        let from = Between::clamped((x + dx, y + dy), reference.size());
        (from.sample(reference) - level).abs() > least
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (160, 128);
    const SPECK: [f32; 2] = [80.0, 64.0];

    /// Random levels 4 px apart, linear in between.
    fn texture(x: f32, y: f32) -> f32 {
        let level = |column: i32, row: i32| {
            let mixed = (column.wrapping_mul(73_856_093) ^ row.wrapping_mul(19_349_663)).wrapping_mul(83_492_791);
            (mixed >> 8 & 0xff) as f32
        };
        let (x, y) = (x / 4.0 + 100.0, y / 4.0 + 100.0);
        let (column, row) = (x as i32, y as i32);
        let across = |row: i32| {
            let (left, right) = (level(column, row), level(column + 1, row));
            left + (x - column as f32) * (right - left)
        };
        across(row) + (y - row as f32) * (across(row + 1) - across(row))
    }

    fn is_speck(x: usize, y: usize, radius_px: f32) -> bool {
        distance([x as f32, y as f32], SPECK) < radius_px
    }

    /// The image of a gel that has moved by `motion`, behind an opaque speck.
    fn image(motion: [f32; 2], radius_px: f32) -> Image<f32> {
        Image::from_fn(SIZE.0, SIZE.1, |x, y| {
            if is_speck(x, y, radius_px) { 20.0 } else { texture(x as f32 - motion[0], y as f32 - motion[1]) }
        })
    }

    /// The estimate of a flow.
    fn estimate(flow: impl Fn(usize, usize) -> [f32; 2]) -> Estimate {
        let mut estimate = Estimate::new(SIZE.0, SIZE.1);
        for y in 0..SIZE.1 {
            for x in 0..SIZE.0 {
                [estimate.flow.u.row_mut(y)[x], estimate.flow.v.row_mut(y)[x]] = flow(x, y);
            }
            estimate.valid.row_mut(y).fill(1);
            estimate.deviation.row_mut(y).fill(0.01);
        }
        estimate
    }

    /// Watches a gel that moves behind a speck, whose flow is zero.
    fn watch(radius_px: f32, path: &[[f32; 2]]) -> (Dirt, Estimate) {
        let mut dirt = Dirt::new(SIZE, 2.0);
        dirt.restart(&image([0.0; 2], radius_px));
        let mut last = estimate(|_, _| [0.0; 2]);
        for &motion in path {
            last = estimate(|x, y| if is_speck(x, y, radius_px + 3.0) { [0.0; 2] } else { motion });
            dirt.watch(&image(motion, radius_px), &last);
        }
        (dirt, last)
    }

    #[test]
    fn a_speck_in_front_of_moving_gel_is_hidden_and_the_flow_behind_it_interpolated() {
        let motion = [4.0, 1.5];
        let (dirt, mut seen) = watch(5.0, &[[1.5, 0.5], [2.5, 1.0], motion]);
        assert!((0.02..0.1).contains(&dirt.part()), "{}", dirt.part());
        dirt.hide(&mut seen);
        for y in 0..SIZE.1 {
            for x in 0..SIZE.0 {
                let flow = [seen.flow.u.at(x, y), seen.flow.v.at(x, y)];
                assert!(distance(flow, motion) < 1e-3, "({x}, {y}) moves by {flow:?}");
                let is_far = !is_speck(x, y, 30.0);
                assert!(is_far || !is_speck(x, y, 8.0) || seen.valid.at(x, y) == 0, "({x}, {y}) is valid");
                assert!(!is_far || seen.valid.at(x, y) == 1, "({x}, {y}) is not valid");
            }
        }
    }

    #[test]
    fn nothing_is_dirty_where_the_gel_is_at_rest_or_moves_everywhere() {
        assert!(watch(5.0, &[[0.0; 2], [0.4, 0.3], [0.0; 2]]).0.part() <= 0.0, "at rest");
        let mut dirt = Dirt::new(SIZE, 2.0);
        dirt.restart(&image([0.0; 2], 0.0));
        for motion in [[1.5, 0.5], [2.5, 1.0], [4.0, 1.5]] {
            dirt.watch(&image(motion, 0.0), &estimate(|_, _| motion));
        }
        assert!(dirt.part() <= 0.0, "moving everywhere");
    }

    #[test]
    fn gel_that_moves_away_from_a_point_is_not_dirty_there() {
        let radial = |x: usize, y: usize| [0.15 * (x as f32 - SPECK[0]), 0.15 * (y as f32 - SPECK[1])];
        let mut dirt = Dirt::new(SIZE, 2.0);
        dirt.restart(&image([0.0; 2], 0.0));
        let stretched = Image::from_fn(SIZE.0, SIZE.1, |x, y| {
            texture(SPECK[0] + (x as f32 - SPECK[0]) / 1.15, SPECK[1] + (y as f32 - SPECK[1]) / 1.15)
        });
        dirt.watch(&stretched, &estimate(radial));
        assert!(dirt.part() <= 0.0, "{}", dirt.part());
    }

    #[test]
    fn a_new_reference_begins_without_dirt() {
        let (mut dirt, _) = watch(5.0, &[[1.5, 0.5], [2.5, 1.0]]);
        assert!(dirt.part() > 0.0);
        dirt.restart(&image([0.0; 2], 5.0));
        assert!(dirt.part() <= 0.0);
        let mut still = estimate(|_, _| [0.0; 2]);
        dirt.hide(&mut still);
        assert!(still.valid.values().iter().all(|&valid| valid == 1));
    }
}
