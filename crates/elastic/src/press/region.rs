//! Which part of the surface is touched, and how finely it is divided.

use crate::fem::{BlockMesh, graded_lines};
use crate::{GelBlock, Pose, Relief};
use serde::{Deserialize, Serialize};

/// How far beyond what is touched the mesh stays fine, mm.
const MARGIN_MM: f64 = 1.0;

/// How finely a block is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MeshParams {
    /// Cell size where the gel is touched; ignored where `cells` are given.
    pub resolution: Resolution,
    /// Even cells along x, y and z, as the published 99 × 99 × 10.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells: Option<[usize; 3]>,
}

/// Cell size where the gel is touched; farther away cells grow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Resolution {
    /// 0.3 mm: for figures.
    #[default]
    Fine,
    /// 0.75 mm: for tests and demonstrations.
    Draft,
}

impl MeshParams {
    /// A mesh of the block, finest on the surface within `region`, `[[from, to]; 2]` along x and y, mm.
    #[must_use]
    pub fn mesh(&self, block: &GelBlock, region: [[f64; 2]; 2]) -> BlockMesh {
        let half = block.size_mm.map(|size| 0.5 * size);
        if let Some([nx, ny, nz]) = self.cells {
            let even = |from: f64, to: f64, cells: usize| -> Vec<f64> {
                let cells = cells.max(1);
                (0..=cells).map(|line| from + (to - from) * line as f64 / cells as f64).collect()
            };
            let [x, y] = [(0, nx), (1, ny)].map(|(axis, cells)| even(-half[axis], half[axis], cells));
            return BlockMesh::new(x, y, even(0.0, block.thickness_mm, nz));
        }
        let (spacing, growth) = match self.resolution {
            Resolution::Fine => (0.3, 1.2),
            Resolution::Draft => (0.75, 1.4),
        };
        let [x, y] = [0, 1].map(|axis| graded_lines([-half[axis], half[axis]], region[axis], spacing, growth));
        let z = graded_lines([0.0, block.thickness_mm], [0.0, 2.0 * spacing], spacing, growth);
        BlockMesh::new(x, y, z)
    }
}

/// The part of the surface that an indenter may touch on its way through `poses`, `[[from, to]; 2]` along x and y, mm.
#[must_use]
pub fn swept_region(relief: &dyn Relief, centre_mm: [f64; 2], poses: &[Pose]) -> [[f64; 2]; 2] {
    let half = relief.half_extent_mm();
    let mut region = centre_mm.map(|centre| [centre, centre]);
    for pose in poses {
        let (sin, cos) = pose.twist_rad.sin_cos();
        let turned = [half[0] * cos.abs() + half[1] * sin.abs(), half[0] * sin.abs() + half[1] * cos.abs()];
        for axis in 0..2 {
            let place = centre_mm[axis] + pose.shear_mm[axis];
            let reach = turned[axis] + MARGIN_MM;
            region[axis] = [region[axis][0].min(place - reach), region[axis][1].max(place + reach)];
        }
    }
    region
}
