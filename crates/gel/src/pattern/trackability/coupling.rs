use std::f64::consts::PI;

use super::Trackability;
use super::patches::PATCH_PX;

/// Part of the patches that may be poor in an even texture.
const MOST_POOR: f64 = 0.05;

/// The coupling of neighbouring patches in a tracker: what is needed to predict its noise.
///
/// Nodes are `stride_px` apart. The displacement of a node from the pixels around it alone has the variance `n²`, the
/// bound of a patch of one stride. The flow's gradient may change by `s = curvature_px` from node to node, px per stride;
/// a wave of the flow with wavenumber q, rad per stride, then costs `q⁴/s²`, and of the noise in it the share `1/(1 + q⁴
/// n²/s²)` remains. Summed over all waves that the nodes can represent,
///
/// ```text
/// σ² = n s / 8π · (atan S + S/(1 + S²)),   S = 4π n / s
/// ```
///
/// Rich texture (n ≪ s) gives σ = n, poor texture σ = √(n s)/4: four times the noise in the image gives twice the noise
/// in the flow.
///
/// If only one in r rows is matched, the tracker assumes a texture that is √r times poorer. The actual loss is smaller:
/// images are sampled with cubic B-splines, which average a row with its neighbours by ⅙, ⅔, ⅙, so that on smooth texture
/// the variance grows by 10/9 for r = 2 and by r/2 beyond.
///
/// Where the gradient of the texture is `g` times the one that the tracker considers strong, and g < 1, the tracker couples the nodes
/// for a noise that is g times as large as in the parameters. It then believes that a node alone has the variance `g² n²`, holds it
/// less, and the noise in the flow is 1/g times that of the equation above with `g n`.
///
/// This is regularised correlation (Hild and Roux 2012) on an even texture; nothing in it is fitted. It does not include
/// that the coupling of nodes weakens where the flow is rough, and errors of a tracker that are not caused by noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// Distance between neighbouring nodes, px.
    pub stride_px: f64,
    /// Expected change of the flow's gradient from a node to its neighbour, px per stride.
    pub curvature_px: f64,
    /// Only one in this many rows is matched.
    pub row_step: usize,
    /// Root mean square of the gradient, over all channels together and all rows that are matched, of a texture that the tracker
    /// considers strong, grey levels per px.
    pub strong_gradient: f64,
}

impl Coupling {
    /// Predicted standard deviation of a tracker's flow to the right and downwards, px.
    ///
    /// None if more than one patch in twenty is poor: with gaps in the texture the waves are not independent.
    #[must_use]
    pub fn deviation_px(&self, score: &Trackability) -> Option<[f64; 2]> {
        if score.poor > MOST_POOR {
            return None;
        }
        let rows = self.row_step as f64;
        let loss = [1.0, 1.0, 10.0 / 9.0].get(self.row_step).copied().unwrap_or(0.5 * rows);
        let believed = PATCH_PX as f64 / self.stride_px * rows.sqrt();
        let strength = (score.gradient_levels_per_px / (rows.sqrt() * self.strong_gradient)).min(1.0);
        let of_own = |own| (loss / rows).sqrt() * smoothed(believed * strength * own, self.curvature_px) / strength;
        Some(score.pooled_deviation_px.map(of_own))
    }
}

/// `σ` from `n` and `s`.
fn smoothed(n: f64, s: f64) -> f64 {
    let reach = 4.0 * PI * n / s;
    if reach.is_finite() { (n * s / (8.0 * PI) * (reach.atan() + reach / (1.0 + reach * reach))).sqrt() } else { n }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rich_texture_needs_no_neighbours_and_poor_texture_many() {
        assert!((smoothed(1e-6, 0.01) / 1e-6 - 1.0).abs() < 1e-4);
        assert!((smoothed(1.0, 0.01) / (0.25 * 0.1) - 1.0).abs() < 1e-2);
    }

    #[test]
    fn the_sum_over_all_waves_is_the_integral() {
        let (n, s) = (0.01, 0.012);
        // Over a disc as large as the square of all waves, by rings.
        let rings = 100_000;
        let step = (4.0 * PI).sqrt() / f64::from(rings);
        let ring = |k: i32| {
            let q = (f64::from(k) + 0.5) * step;
            let share = 1.0 / (1.0 + (q * q * n / s).powi(2));
            q * step / (2.0 * PI) * n * n * share * share
        };
        let variance: f64 = (0..rings).map(ring).sum();
        assert!((smoothed(n, s) / variance.sqrt() - 1.0).abs() < 1e-6);
    }
}
