//! The result of the elastic inverse for one frame.

use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use fingervision_elastic::{GelBlock, SurfaceGrid};
use fingervision_image::Image;

use super::thresholds::THRESHOLDS;

/// Everything that elasticity determines for one frame.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "each is a flag of its own")]
pub struct ElasticFields {
    /// Depth at every pixel of the reference grid, mm, positive pressed in.
    pub depth_mm: Image<f32>,
    /// Expected error of the depth (one standard deviation), mm.
    pub deviation_mm: Image<f32>,
    /// 1 where the gel touches something, on the reference grid.
    pub contact: Image<u8>,
    /// 1 where the pixel shows the gel's surface.
    pub on_gel: Image<u8>,
    /// Traction on the gel, `MPa`, on a grid of cells over its surface; none without Young's modulus.
    pub traction_mpa: Option<TractionGrid>,
    /// Area of contact in the undeformed surface, mm².
    pub contact_area_mm2: f32,
    /// Force on the gel `(x, y, z)`, N; none without Young's modulus.
    pub force_n: Option<[f32; 3]>,
    /// Torque on the gel about the z axis through the centre of contact, N mm; none without Young's modulus.
    pub torque_nmm: Option<f32>,
    /// Difference between measured motion along the surface and the motion that the tractions predict, at distances of
    /// at least a quarter of the thickness from contact: root mean square over the largest depth plus 0.3 of the motion of
    /// contact along the surface, dimensionless; none if the motion is too small.
    pub unexplained: Option<f32>,
    /// Whether the gel is strained beyond the linear range: by depth, or by shear that is large relative to the depth.
    pub is_beyond_linear: bool,
    /// Whether contact reaches the border of the visible part of the gel.
    pub is_cut: bool,
    /// Whether the tractions do not explain the motion; if so, the fields are not valid.
    pub is_unexplained: bool,
    /// Whether they do not explain it although the deviation of the flow is small: the flow cannot be that of this gel
    /// and camera.
    pub is_misfit: bool,
    /// Whether the gel moves, the network is switched on, and gel and camera are outside its training range.
    pub is_outside_training: bool,
    /// Whether the flow is valid in less than a tenth of contact, or nowhere within 24 px of a place in it.
    pub is_untracked: bool,
    /// Whether the flow's deviation is more than 1.8 times that of the network's training images.
    pub is_flow_uncertain: bool,
    /// Whether the gel is at rest: its depth is 0 everywhere, and it has no contact.
    pub(crate) is_at_rest: bool,
    /// Deviation of depth at rest in images of the usual noise, mm.
    rest_deviation_mm: f32,
}

/// A field of tractions over the gel's surface, row by row, with the surface's centre in the grid's middle.
#[derive(Debug, Clone, PartialEq)]
pub struct TractionGrid {
    /// Cells along x.
    pub columns: usize,
    /// Cells along y.
    pub rows: usize,
    /// Side of a cell, mm.
    pub cell_mm: f64,
    /// Traction `(x, y, z)` of each cell, `MPa`.
    pub traction_mpa: Vec<[f32; 3]>,
}

impl ElasticFields {
    /// An untouched gel.
    pub(crate) fn at_rest(
        gel: &GelBlock,
        grid: SurfaceGrid,
        (width, height): (usize, usize),
        shows: impl Fn(usize) -> bool,
    ) -> Self {
        let SurfaceGrid { columns, rows, cell_mm } = grid;
        let has_force = gel.youngs_modulus_mpa.is_some();
        let mut fields = Self {
            depth_mm: Image::filled(width, height, 0.0),
            deviation_mm: Image::filled(width, height, 0.0),
            contact: Image::filled(width, height, 0),
            on_gel: Image::from_fn(width, height, |x, y| u8::from(shows(y * width + x))),
            traction_mpa: has_force.then(|| TractionGrid {
                columns,
                rows,
                cell_mm,
                traction_mpa: vec![[0.0; 3]; columns * rows],
            }),
            contact_area_mm2: 0.0,
            force_n: has_force.then_some([0.0; 3]),
            torque_nmm: has_force.then_some(0.0),
            unexplained: None,
            is_beyond_linear: false,
            is_cut: false,
            is_unexplained: false,
            is_misfit: false,
            is_outside_training: false,
            is_untracked: false,
            is_flow_uncertain: false,
            is_at_rest: true,
            rest_deviation_mm: (THRESHOLDS.rest_deviation * gel.thickness_mm) as f32,
        };
        fields.rest(1.0);
        fields
    }

    /// Sets everything to the values of an untouched gel; `motion` is the smallest motion that is detected in this
    /// image, relative to the usual one.
    pub(crate) fn rest(&mut self, motion: f64) {
        let rest_deviation_mm = self.rest_deviation_mm * motion as f32;
        let Self { depth_mm, deviation_mm, contact, on_gel, .. } = self;
        let planes = (depth_mm.values_mut(), deviation_mm.values_mut(), contact.values_mut());
        dispatch!(Level::new(), simd => fill_at_rest(simd, rest_deviation_mm, on_gel.values(), planes));
        self.contact_area_mm2 = 0.0;
        // Readings take the planes above in exchange for others, but not the tractions.
        if !std::mem::replace(&mut self.is_at_rest, true) {
            self.traction_mpa.iter_mut().for_each(|grid| grid.traction_mpa.fill([0.0; 3]));
        }
        self.force_n = self.force_n.map(|_| [0.0; 3]);
        self.torque_nmm = self.torque_nmm.map(|_| 0.0);
        self.unexplained = None;
        (self.is_beyond_linear, self.is_cut) = (false, false);
        (self.is_unexplained, self.is_misfit) = (false, false);
        (self.is_outside_training, self.is_untracked, self.is_flow_uncertain) = (false, false, false);
    }
}

/// Sets depth, deviation and contact of all pixels to those of a gel at rest; beside the gel the deviation is infinite.
#[simd]
fn fill_at_rest<S: Simd>(
    simd: S,
    rest_deviation_mm: f32,
    on_gel: &[u8],
    (depth_mm, deviation_mm, contact): (&mut [f32], &mut [f32], &mut [u8]),
) {
    let _ = simd;
    let planes = depth_mm.iter_mut().zip(deviation_mm).zip(contact).zip(on_gel);
    for (((depth_mm, deviation_mm), contact), &on_gel) in planes {
        *deviation_mm = if on_gel == 1 { rest_deviation_mm } else { f32::INFINITY };
        (*depth_mm, *contact) = (0.0, 0);
    }
}
