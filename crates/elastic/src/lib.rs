//! Mechanics of the gel: the deformation of a block bonded at its base when a rigid body presses its surface.
//!
//! Gel space: mm, origin at the centre of the undeformed surface, x right, y down in the camera image, **z towards the
//! camera**. The gel fills `0 ≤ z ≤ thickness`; its base at `z = thickness` is bonded to the window, its sides are free,
//! and the indenter comes from `z < 0`. Forces are those of the indenter on the gel: pressing is +z.

mod block;
mod contact;
mod fem;
mod layer;
mod press;
mod solver;

pub use block::{BlockError, GelBlock, Law};
pub use contact::{ContactLaw, Pose, Relief, ReliefPoint, SurfaceState};
pub use fem::{BlockMesh, graded_lines};
pub use layer::{BlockOperator, Layer, LayerError, LayerOperator, SurfaceGrid, WaveCompliance};
pub use press::{
    ContinueCheck, MeshParams, Press, PressError, PressSetup, Resolution, StepReport, SweptRegion, swept_region,
};
