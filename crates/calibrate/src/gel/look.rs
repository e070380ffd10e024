//! One frame of a press, cell by cell: contact, and the camera's measurement of the surface around it.

use super::thresholds::THRESHOLDS;
use fingervision_elastic::{GelBlock, SurfaceGrid};
use fingervision_touch::{Cells, CoarseGrid, Seen};

/// Error of the flow as the mean of a cell, px; it is correlated over some cells.
const NOISE_PX: f64 = 0.02;
/// Error of linear elasticity around contact, as a part of the depth.
const MODEL: f64 = 0.001;
/// The same, per factor between found and known depth: a wrong depth means that contact was not found correctly.
const BY_MISMATCH: f64 = 0.03;
/// Half the side of the square, in cells, over which the median gives the depth of contact.
const MEDIAN: usize = 2;
/// Sectors around contact whose residuals count as independent of each other.
pub(super) const SECTORS: usize = 8;

/// The data of a frame.
#[derive(Debug, Clone)]
pub(super) struct Look {
    /// Index of its press.
    pub(super) press: usize,
    /// Index among the frames of its press.
    pub(super) frame: usize,
    /// The known depth, mm.
    pub(super) depth_mm: f64,
    /// The known normal force, N.
    pub(super) force_n: Option<f64>,
    /// The largest depth as found, before it was scaled to the known one, mm.
    pub(super) found_mm: f64,
    /// One over the expected error of a cell's motion, 1/mm.
    pub(super) weight_per_mm: f64,
    pub(super) grid: SurfaceGrid,
    pub(super) seen: Vec<Seen>,
    pub(super) touches: Vec<bool>,
    /// Displacement in contact, mm.
    pub(super) held_mm: Vec<[f32; 3]>,
    /// The cells that are compared with elasticity, each with its sector.
    pub(super) around: Vec<(usize, usize)>,
}

/// Known values of a frame in addition to its cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct Known {
    pub(super) press: usize,
    pub(super) frame: usize,
    pub(super) depth_mm: f64,
    pub(super) force_n: Option<f64>,
}

impl Look {
    /// A frame from its cells; none if nothing touches the gel.
    ///
    /// The depths found in contact are scaled until the deepest is the known one.
    pub(super) fn new(cells: &Cells<'_>, known: Known, gel: &GelBlock) -> Option<Self> {
        let found_mm = f64::from(deepest_mm(cells)?);
        let scale = (known.depth_mm / found_mm) as f32;
        let Halved { grid, seen, touches, depth_mm } = Halved::of(cells);
        let held_mm = seen.iter().zip(&depth_mm).map(|(seen, &depth)| {
            let depth = scale * depth;
            let [x, y] = seen.lateral_mm(depth);
            [x, y, depth]
        });
        let held_mm = held_mm.collect();
        let around = around(grid, &seen, &touches, gel);
        let Known { press, frame, depth_mm, force_n } = known;
        let model = MODEL.hypot(BY_MISMATCH * (found_mm / depth_mm).ln());
        touches.contains(&true).then_some(Self {
            press,
            frame,
            depth_mm,
            force_n,
            found_mm,
            weight_per_mm: 1.0 / (NOISE_PX * cells.mm_per_px).hypot(model * depth_mm),
            grid,
            seen,
            touches,
            held_mm,
            around,
        })
    }

    /// Deviation of the depth that was found from the known one, as a logarithm: the quality of the search for contact.
    pub(super) fn mismatch(&self) -> f64 {
        (self.found_mm / self.depth_mm).ln().abs()
    }

    /// The radius of a circle as large as contact, mm.
    pub(super) fn radius_mm(&self) -> f64 {
        let touched = self.touches.iter().filter(|touches| **touches).count() as f64;
        (touched * self.grid.cell_area_mm2() / std::f64::consts::PI).sqrt()
    }
}

/// The largest median depth over squares of cells in contact, mm: not affected by a rim or an outlier.
fn deepest_mm(cells: &Cells<'_>) -> Option<f32> {
    let SurfaceGrid { columns, rows, .. } = cells.grid;
    let mut near = Vec::new();
    let mut deepest: Option<f32> = None;
    for cell in (0..cells.touches.len()).filter(|&cell| cells.touches[cell]) {
        let (x, y) = (cell % columns, cell / columns);
        near.clear();
        for row in y.saturating_sub(MEDIAN)..=(y + MEDIAN).min(rows - 1) {
            let from = row * columns;
            let line = from + x.saturating_sub(MEDIAN)..=from + (x + MEDIAN).min(columns - 1);
            near.extend(line.filter(|&other| cells.touches[other]).map(|other| cells.depth_mm[other]));
        }
        let middle = near.len() / 2;
        let median = *near.select_nth_unstable_by(middle, f32::total_cmp).1;
        deepest = Some(deepest.map_or(median, |most| most.max(median)));
    }
    deepest.filter(|depth| *depth > 0.0)
}

/// The surface in cells of twice the width, where their number is even: the motion around contact is smooth, and a fit
/// takes a quarter of the time.
struct Halved {
    grid: SurfaceGrid,
    seen: Vec<Seen>,
    touches: Vec<bool>,
    depth_mm: Vec<f32>,
}

impl Halved {
    fn of(cells: &Cells<'_>) -> Self {
        let SurfaceGrid { columns, rows, .. } = cells.grid;
        let part = if columns.is_multiple_of(2) && rows.is_multiple_of(2) { 2 } else { 1 };
        let coarse = CoarseGrid::new(cells.grid, part);
        let seen = coarse.around().map(|around| Seen {
            apparent_mm: [0, 1].map(|axis| around.mean(|cell| cells.seen[cell].apparent_mm[axis])),
            slope: [0, 1].map(|axis| around.mean(|cell| cells.seen[cell].slope[axis])),
            trust: around.mean(|cell| cells.seen[cell].trust),
            deviation_mm: around.mean(|cell| cells.seen[cell].deviation_mm),
        });
        let touched = |cell: usize| f32::from(u8::from(cells.touches[cell]));
        Self {
            seen: seen.collect(),
            touches: coarse.around().map(|around| around.mean(touched) >= 0.5).collect(),
            depth_mm: coarse.around().map(|around| around.mean(|cell| cells.depth_mm[cell])).collect(),
            grid: coarse.grid,
        }
    }
}

/// The cells with valid flow, far enough from contact and from the gel's sides, each with its sector about contact.
fn around(grid: SurfaceGrid, seen: &[Seen], touches: &[bool], gel: &GelBlock) -> Vec<(usize, usize)> {
    let centres: Vec<[f64; 2]> = grid.centres_mm().collect();
    let touched: Vec<[f64; 2]> =
        centres.iter().zip(touches).filter(|(_, touches)| **touches).map(|(c, _)| *c).collect();
    let middle = [0, 1].map(|axis| touched.iter().map(|centre| centre[axis]).sum::<f64>() / touched.len() as f64);
    let away = (THRESHOLDS.away * gel.thickness_mm).powi(2);
    let inner = gel.size_mm.map(|size| 0.5 * size - THRESHOLDS.from_side * gel.thickness_mm);
    let counts = |&cell: &usize| {
        let [x, y] = centres[cell];
        let is_far = || touched.iter().all(|[i, j]| (x - i).powi(2) + (y - j).powi(2) > away);
        seen[cell].trust > 0.5 && x.abs() < inner[0] && y.abs() < inner[1] && is_far()
    };
    let sector = |cell: usize| {
        let [x, y] = centres[cell];
        let turn = (y - middle[1]).atan2(x - middle[0]) / std::f64::consts::TAU + 0.5;
        ((turn * SECTORS as f64) as usize).min(SECTORS - 1)
    };
    (0..grid.len()).filter(counts).map(|cell| (cell, sector(cell))).collect()
}
