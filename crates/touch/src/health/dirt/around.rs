//! The motion of the gel in a cell and around it.

use fingervision_flow::{Estimate, FlowField};

use super::CELL;
use crate::health::thresholds::THRESHOLDS;

/// Distance along both axes of the places around a cell, in cells.
pub(super) const AROUND: usize = 2;
/// The places around a cell, as offsets in cells from the one to the upper left.
const PLACES: [(usize, usize); 8] = [
    (0, AROUND),
    (2 * AROUND, AROUND),
    (AROUND, 0),
    (AROUND, 2 * AROUND),
    (0, 0),
    (2 * AROUND, 2 * AROUND),
    (0, 2 * AROUND),
    (2 * AROUND, 0),
];
/// The motion of the gel around a cell, px, if the flow in the cell, valid or not, is much smaller.
pub(super) fn suspicious_motion(estimate: &Estimate, cell: (usize, usize)) -> Option<[f32; 2]> {
    let own_px2 = least_motion(&estimate.flow, cell);
    // A cell seldom passes the first test, so that the others take no time.
    let motion = may_be_suspicious(&estimate.flow, cell, own_px2).then(|| motion_around(estimate, cell))??;
    (own_px2 < THRESHOLDS.still_motion.powi(2) * length2(motion)).then_some(motion)
}

pub(super) fn difference(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// Square of the length.
pub(super) fn length2([u, v]: [f32; 2]) -> f32 {
    u * u + v * v
}

/// Centre of the cell at an offset from a cell, px.
fn centre((column, row): (usize, usize), (dx, dy): (usize, usize)) -> (usize, usize) {
    ((column + dx - AROUND) * CELL + CELL / 2, (row + dy - AROUND) * CELL + CELL / 2)
}

/// Square of the smallest flow in a cell, valid or not, px².
fn least_motion(flow: &FlowField, (column, row): (usize, usize)) -> f32 {
    let (left, top) = (column * CELL, row * CELL);
    let [near, far] = [CELL / 4, CELL - 1 - CELL / 4];
    [(near, near), (far, near), (near, far), (far, far)].into_iter().fold(f32::INFINITY, |least, (dx, dy)| {
        least.min(length2([flow.u.at(left + dx, top + dy), flow.v.at(left + dx, top + dy)]))
    })
}

/// Whether the motion around a cell can be so much larger than in it that the cell is suspicious. It is only if at least two of the
/// first four places move in a similar way as their mean.
fn may_be_suspicious(flow: &FlowField, cell: (usize, usize), own_px2: f32) -> bool {
    let least_px2 = (own_px2 / THRESHOLDS.still_motion.powi(2)).max(THRESHOLDS.moves_px.powi(2));
    let least_px2 = (1.0 - THRESHOLDS.similar_motion).powi(2) * least_px2;
    let moving = PLACES[..4].iter().filter(|&&place| {
        let (x, y) = centre(cell, place);
        length2([flow.u.at(x, y), flow.v.at(x, y)]) >= least_px2
    });
    moving.count() >= 2
}

/// The flow at a pixel, px, if it is valid.
fn flow_at(estimate: &Estimate, x: usize, y: usize) -> Option<[f32; 2]> {
    (estimate.valid.at(x, y) == 1).then(|| [estimate.flow.u.at(x, y), estimate.flow.v.at(x, y)])
}

/// Motion of the gel around a cell, px, if it is large enough and about the same on all sides.
fn motion_around(estimate: &Estimate, cell: (usize, usize)) -> Option<[f32; 2]> {
    let flows = PLACES.map(|place| {
        let (x, y) = centre(cell, place);
        flow_at(estimate, x, y)
    });
    let mut motion = mean(flows.into_iter().flatten())?;
    // The second mean is without the places that stand still themselves.
    for _ in 0..2 {
        let most_px2 = THRESHOLDS.similar_motion.powi(2) * length2(motion);
        let similar = flows.into_iter().flatten().filter(|flow| length2(difference(*flow, motion)) < most_px2);
        if similar.clone().count() < THRESHOLDS.similar_places {
            return None;
        }
        motion = mean(similar)?;
    }
    (length2(motion) >= THRESHOLDS.moves_px.powi(2)).then_some(motion)
}

fn mean(flows: impl Iterator<Item = [f32; 2]>) -> Option<[f32; 2]> {
    let (sum, count) = flows.fold(([0.0; 2], 0.0), |([su, sv], count), [u, v]| ([su + u, sv + v], count + 1.0));
    (count > 0.0).then(|| sum.map(|sum| sum / count))
}
