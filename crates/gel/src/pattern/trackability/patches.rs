//! A patch of the image and the bound of its displacement.

use fingervision_image::{Image, LUMA_WEIGHTS};

/// Width and height of a patch, px: the tracker's.
pub(super) const PATCH_PX: usize = 16;

/// A patch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    /// `Σ ∇I ∇Iᵀ` over pixels and channels: its entries xx, xy and yy, grey levels² per px².
    pub(super) structure: [f64; 3],
    /// Size of a pixel on the gel here, mm.
    pub(super) mm_per_px: f64,
}

impl Patch {
    /// The patch with its upper left corner at `(left, top)` in two gradient images.
    pub(super) fn at(
        [left, top]: [usize; 2],
        [gradient_x, gradient_y]: &[Image<[f32; 3]>; 2],
        colour: bool,
        mm_per_px: f64,
    ) -> Self {
        let mut structure = [0.0; 3];
        for y in top..top + PATCH_PX {
            for x in left..left + PATCH_PX {
                let [gx, gy] = [gradient_x, gradient_y].map(|gradient| channels(gradient.at(x, y), colour));
                for channel in 0..3 {
                    structure[0] += gx[channel] * gx[channel];
                    structure[1] += gx[channel] * gy[channel];
                    structure[2] += gy[channel] * gy[channel];
                }
            }
        }
        Self { structure, mm_per_px }
    }

    /// The patch whose structure and scale are the mean of all.
    pub(super) fn mean(patches: &[Self]) -> Self {
        let count = patches.len() as f64;
        let mean = |value: &dyn Fn(&Self) -> f64| patches.iter().map(value).sum::<f64>() / count;
        Self {
            structure: [0, 1, 2].map(|entry| mean(&|patch| patch.structure[entry])),
            mm_per_px: mean(&|patch| patch.mm_per_px),
        }
    }

    /// Diagonal of the inverse of `structure`; infinite without structure.
    pub(super) fn inverse(&self) -> [f64; 2] {
        let [xx, xy, yy] = self.structure;
        let determinant = xx * yy - xy * xy;
        if determinant > 1e-12 * (xx + yy).powi(2) { [yy / determinant, xx / determinant] } else { [f64::INFINITY; 2] }
    }

    /// The variance along the worst direction.
    pub(super) fn least_eigenvalue(&self) -> f64 {
        let [xx, xy, yy] = self.structure;
        0.5 * (xx + yy) - (0.25 * (xx - yy).powi(2) + xy * xy).sqrt()
    }
}

/// The channels that are matched.
fn channels(rgb: [f32; 3], colour: bool) -> [f64; 3] {
    let rgb = rgb.map(f64::from);
    if colour {
        return rgb;
    }
    let grey = rgb.iter().zip(LUMA_WEIGHTS).map(|(level, weight)| level * f64::from(weight)).sum();
    [grey, 0.0, 0.0]
}
