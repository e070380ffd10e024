//! The noise for which patches are coupled.
//!
//! How strongly a patch is held by its neighbours depends on the noise of its pixels relative to their gradients, and so does its
//! predicted error. The noise in the parameters belongs to a strong texture. With a weaker one the coupling would flatten what the
//! pictures show, so the noise is reduced in proportion: the contrast of a picture then changes nothing. Where pictures differ from the
//! reference by much more than this noise, the coupling would be too weak to hold the patches together, so it is increased.

/// The noise that a reference is prepared for, standard deviations, grey levels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Noise {
    /// That which the coupling of the patches is for.
    pub(crate) coupling: f32,
    /// That of the pixels, which looks like texture.
    pub(crate) pixels: f32,
}

impl Noise {
    /// The same noise in both roles.
    pub(crate) fn of(levels: f32) -> Self {
        Self { coupling: levels, pixels: levels }
    }

    /// Variance of the noise of two pictures together for the coupling, grey levels².
    pub(crate) fn variance(self) -> f32 {
        2.0 * self.coupling * self.coupling
    }

    /// Most variance of the residual that noise alone explains, for each standard deviation squared, grey levels².
    pub(crate) fn residual_variance(self) -> f32 {
        2.0 * self.coupling.max(self.pixels).powi(2)
    }
}

/// Root mean square of the gradient, over all channels together and all rows that are matched, of a texture that is strong enough for
/// the noise in the parameters, grey levels per px.
pub const STRONG_GRADIENT: f32 = 29.0;

/// The same as it is summed over a patch: `Σ w (∂T/∂x)²` and the same of y, mean of both, grey levels² per px². On the colour pattern of
/// the simulated sensor it is 1.9 times as large, on its brightness 0.6 times. Measured on simulated presses: with less noise in the
/// coupling smooth flow is noisier, with more a light touch is flattened.
const STRONG: f32 = 2e4;

/// Part of the textured patches that have less texture than the one that counts.
const RANK: f32 = 0.75;

/// Least noise, relative to the residual. With less, noise breaks the bonds between patches as a rim does. Measured on images with
/// noise of 5 and 10 levels, of a Bayer sensor, and with the colours of strong JPEG compression.
const LEAST_OVER_RESIDUAL: f32 = 0.45;

/// Least noise, grey levels: that of rounding to whole levels.
const LEAST_LEVELS: f32 = 0.1;

/// Number of frames whose median residual counts.
const FRAMES: usize = 9;

/// A reference is adapted if the noise is above its own by more than this factor.
const RAISED: f32 = 1.1;
/// The same if it is below its own.
const LOWERED: f32 = 0.8;

/// The noise, grey levels, that fits the texture of a reference, from the squared gradients of its textured patches; `levels` is that of a
/// strong texture.
pub(super) fn for_texture(levels: f32, squares: impl Iterator<Item = f32>) -> f32 {
    let mut found: Vec<f32> = squares.collect();
    if found.is_empty() {
        return levels;
    }
    let rank = ((RANK * found.len() as f32) as usize).min(found.len() - 1);
    let texture = *found.select_nth_unstable_by(rank, f32::total_cmp).1;
    (levels * (texture / STRONG).sqrt().min(1.0)).max(LEAST_LEVELS.min(levels))
}

/// The residuals of the last frames.
#[derive(Debug, Clone, Default)]
pub(super) struct Residuals {
    last: [f32; FRAMES],
    /// Number of residuals since the start.
    count: usize,
}

impl Residuals {
    /// Adds that of a frame, grey levels.
    pub(super) fn push(&mut self, levels: f32) {
        self.last[self.count % FRAMES] = levels;
        self.count += 1;
    }

    /// Forgets all frames.
    pub(super) fn restart(&mut self) {
        *self = Self::default();
    }

    /// The noise that these residuals require if the texture requires `levels`.
    pub(super) fn noise(&self, levels: f32) -> f32 {
        let mut known = self.last;
        let known = &mut known[..self.count.min(FRAMES)];
        if known.is_empty() {
            return levels;
        }
        let median = *known.select_nth_unstable_by(known.len() / 2, f32::total_cmp).1;
        levels.max(LEAST_OVER_RESIDUAL * median)
    }
}

/// Whether a reference that was prepared for one noise has to be adapted to another.
pub(super) fn is_different(prepared: f32, levels: f32) -> bool {
    levels > RAISED * prepared || levels < LOWERED * prepared
}
