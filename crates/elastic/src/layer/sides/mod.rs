//! The effect of the free sides of a block.
//!
//! An infinite layer is a convolution, a block is not. The displacement of a block's surface under traction is computed
//! as
//!
//! ```text
//! u = C_near t + Bᵀ (G − G_∞ + C_far) B t
//! ```
//!
//! with `C_near + C_far` the compliance of the layer, `G` the compliance of the block's surface in a coarse mesh of
//! finite elements (small strain, mean dilatation, [Nagtegaal1974], up to 24×24×8), `G_∞` that of the **same mesh
//! extended to infinity**, and `B` the transfer of tractions to the coarse nodes: each cell's force is distributed
//! bilinearly to the four nodes around it; displacements are interpolated by the transpose. Far from the sides, the
//! errors of the mesh are the same in both and cancel; the difference is smooth and can be represented on a coarse
//! mesh. The sum is symmetric by construction.
//!
//! The layer's influence is split smoothly by distance (`near`). The near part is computed on the grid of cells, by
//! Fourier transform; the far part is smooth as well and is included in the correction of the sides without additional
//! cost. So the transform needs little padding.
//!
//! A block has two mirror planes. Fields are split into four parities about them (`parity`), each a problem on a
//! quarter of the block, eliminated level by level from the base to the surface (`quarter`). The infinite mesh is a
//! chain of 3×3 matrices for each wave, by the theorem of Floquet and Bloch (`waves`).
//!
//! Assumptions: linear elasticity, small strain, equal bricks. Their error was measured against elements half as wide,
//! on 30×25×10 mm at ν 0.48, for smooth loads with a radius of 4 mm. Farther than 5 mm from the load, the error is
//! below 3 % of the largest displacement, even for a load beside a side. Within the load, it grows to about 5 % in the
//! half coarse cell next to a side, whose edge the coarse mesh does not resolve.

mod correction;
mod inverse;
mod lattice;
mod mesh;
mod near;
mod operator;
mod parity;
mod quarter;
#[cfg(test)]
mod tests;
mod waves;

pub use operator::BlockOperator;
