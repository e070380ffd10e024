//! The coarse mesh of a block.

use crate::fem::{Material, Stiffness, stiffness};
use crate::{GelBlock, Law};

/// Elements through the thickness if the block is not wide.
const LAYERS: f64 = 8.0;
/// Most elements along a side.
const MOST: usize = 24;
/// Fewest elements along a side, and through the thickness.
const LEAST: [usize; 2] = [8, 4];

/// Equal bricks that fill a block, an even number along x and y.
pub(super) struct CoarseMesh {
    /// Elements along x, y and z.
    pub(super) cells: [usize; 3],
    /// Their sides, mm.
    pub(super) cell_mm: [f64; 3],
    /// Stiffness of an element of shear modulus 1.
    pub(super) element: Stiffness,
}

impl CoarseMesh {
    /// Elements that are nearly cubes, an eighth of the thickness wide, or more if the block is wide.
    pub(super) fn new(block: &GelBlock) -> Self {
        let GelBlock { size_mm: [width, height], thickness_mm, poissons_ratio, .. } = *block;
        let edge = (thickness_mm / LAYERS).max(width.max(height) / MOST as f64);
        let across = |size: f64| (2 * (0.5 * size / edge).round() as usize).clamp(LEAST[0], MOST);
        let down = ((thickness_mm / edge).round() as usize).clamp(LEAST[1], LAYERS as usize);
        let cells = [across(width), across(height), down];
        let size = [width, height, thickness_mm];
        let cell_mm = [0, 1, 2].map(|axis| size[axis] / cells[axis] as f64);
        Self { cells, cell_mm, element: element_of(cell_mm, poissons_ratio) }
    }

    /// Elements from the centre of the block to its sides.
    pub(super) fn half(&self) -> [usize; 2] {
        [self.cells[0] / 2, self.cells[1] / 2]
    }

    /// Nodes of the surface along x and y.
    pub(super) fn nodes(&self) -> [usize; 2] {
        [self.cells[0] + 1, self.cells[1] + 1]
    }
}

fn element_of(cell_mm: [f64; 3], poissons_ratio: f64) -> Stiffness {
    let corner = |node: usize| [0, 1, 2].map(|axis| if node >> axis & 1 == 1 { cell_mm[axis] } else { 0.0 });
    let material = Material::new(Law::Linear, 2.0 * (1.0 + poissons_ratio), poissons_ratio);
    let mut element = [[[[0.0; 8]; 8]; 3]; 3];
    stiffness(&std::array::from_fn(corner), &[[0.0; 3]; 8], &material, &mut element).expect("a brick has a volume");
    element
}
