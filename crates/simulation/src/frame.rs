//! One frame of a simulated press, with its truth.

use fingervision_gel::{Simulation, Truth};
use fingervision_image::Pixels;
use fingervision_source::FrameTruth;

/// One frame of a simulated press.
#[derive(Debug, Clone, Copy)]
pub struct SimulatedFrame<'a> {
    /// Indentation depth of the indenter, mm.
    pub depth_mm: f64,
    /// The camera image; absent if only the truth is wanted.
    pub pixels: Option<&'a Pixels>,
    /// Its truth.
    pub truth: &'a Truth,
    /// Force of the indenter on the gel, N.
    pub force_n: [f64; 3],
    /// Torque on the gel about z through the centre of contact, N mm.
    pub torque_z_nmm: f64,
}

/// The truth of a solved frame in numbers, or `None` if there is no frame of this number.
pub(crate) fn frame_truth(simulation: &Simulation, index: usize) -> Option<FrameTruth> {
    let (pose, state) = (simulation.poses().get(index)?, simulation.states().get(index)?);
    Some(FrameTruth { depth_mm: pose.depth_mm, force_n: state.force_n, torque_nmm: state.torque_nmm[2] })
}
