//! The motion of the gel in a cell and around it.

use fingervision_flow::{Estimate, FlowField};

use super::CELL;
use crate::health::{difference, flow_at, length2, thresholds::THRESHOLDS};

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

/// A cell whose flow is much smaller than the motion of the gel around it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Suspicion {
    /// The motion around it, px.
    pub(super) motion: [f32; 2],
    /// Whether its flow is valid. Gel whose flow is not valid, beside a wall, may rest between parts that move.
    pub(super) is_valid: bool,
}

/// Compares the flow in a cell, valid or not, with that around it.
pub(super) fn suspicion(estimate: &Estimate, cell: (usize, usize)) -> Option<Suspicion> {
    let own_px2 = least_motion(&estimate.flow, cell);
    // A cell seldom passes the first test, so that the others take no time.
    let motion = may_be_suspicious(&estimate.flow, cell, own_px2).then(|| motion_around(estimate, cell))??;
    let least_px2 = (THRESHOLDS.still_motion.powi(2) * length2(motion)).min(THRESHOLDS.still_px.powi(2));
    let stands_still = |place: &&(usize, usize)| length2(any_flow_at(&estimate.flow, **place)) < least_px2;
    let is_valid = samples(cell).iter().filter(stands_still).any(|&place| flow_at(estimate, place).is_some());
    (own_px2 < least_px2).then_some(Suspicion { motion, is_valid })
}

/// Centre of the cell at an offset from a cell, px.
fn centre((column, row): (usize, usize), (dx, dy): (usize, usize)) -> (usize, usize) {
    ((column + dx - AROUND) * CELL + CELL / 2, (row + dy - AROUND) * CELL + CELL / 2)
}

/// Four places in a cell, px.
fn samples((column, row): (usize, usize)) -> [(usize, usize); 4] {
    let [near, far] = [CELL / 4, CELL - 1 - CELL / 4];
    [(near, near), (far, near), (near, far), (far, far)].map(|(dx, dy)| (column * CELL + dx, row * CELL + dy))
}

/// Square of the smallest flow in a cell, valid or not, px².
fn least_motion(flow: &FlowField, cell: (usize, usize)) -> f32 {
    let lengths2 = samples(cell).map(|place| length2(any_flow_at(flow, place)));
    lengths2.into_iter().fold(f32::INFINITY, f32::min)
}

/// Whether the motion around a cell can be so much larger than in it that the cell is suspicious, decided by the first four places.
fn may_be_suspicious(flow: &FlowField, cell: (usize, usize), own_px2: f32) -> bool {
    let least_px2 = (own_px2 / THRESHOLDS.still_motion.powi(2)).max(THRESHOLDS.moves_px.powi(2));
    let least_px2 = (1.0 - THRESHOLDS.similar_motion).powi(2) * least_px2;
    let moving = PLACES[..4].iter().filter(|&&place| length2(any_flow_at(flow, centre(cell, place))) >= least_px2);
    moving.count() + PLACES[4..].len() >= THRESHOLDS.similar_places
}

/// The flow at a pixel, px, valid or not.
fn any_flow_at(flow: &FlowField, (x, y): (usize, usize)) -> [f32; 2] {
    [flow.u.at(x, y), flow.v.at(x, y)]
}

/// Motion of the gel around a cell, px, if it is large enough and about the same on all sides.
fn motion_around(estimate: &Estimate, cell: (usize, usize)) -> Option<[f32; 2]> {
    let flows = PLACES.map(|place| flow_at(estimate, centre(cell, place)));
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
