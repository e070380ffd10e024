//! One frame of a simulated press with what is known about it.

use fingervision_gel::Truth;
use fingervision_image::Pixels;

/// One frame of a simulated press.
#[derive(Debug, Clone, Copy)]
pub struct SimulatedFrame<'a> {
    /// How deep the indenter is pressed in, mm.
    pub depth_mm: f64,
    /// What the camera sees; absent where only the truth is wanted.
    pub pixels: Option<&'a Pixels>,
    /// What that shows.
    pub truth: &'a Truth,
    /// Force of the indenter on the gel, N.
    pub force_n: [f64; 3],
    /// Torque on the gel about z through the centre of contact, N mm.
    pub torque_z_nmm: f64,
}
