//! Which patches of a picture are blurred, and the reference that they are matched with.

use super::exposures::Trial;
use crate::affine::nodes::NodeField;
use crate::affine::noise::Noise;
use crate::affine::refinement::Refinement;
use crate::affine::template::{BlurredTemplate, Template};

/// Least motion of a blurred patch since the last frame, px.
const LEAST_MOTION_PX: f32 = 1.0;

/// Least error of a blurred patch, px.
const LEAST_ERROR_PX: f32 = 0.05;

/// Least number of blurred patches.
const LEAST_BLURRED: usize = 10;

/// The blurred patches must be more than this part of those that move about as fast: along a rim, patches fail in sharp
/// pictures, too.
const LEAST_PART: f32 = 0.6;

/// Least error of a patch that may be slightly blurred, px. In a sharp picture, a patch that matches has an error of zero, or hardly
/// more.
const SLIGHT_ERROR_PX: f32 = 0.005;

/// Of the patches that move as fast, the part that may be slightly blurred: up to the first value, low contrast with a large
/// residual belongs to a rim; from the second on it is taken for blur.
const BLUR_IS_LIKELY: [f32; 2] = [0.3, 0.5];

/// A patch moves about as fast as the blurred ones if it has this part of their mean motion.
const AS_FAST: f32 = 0.75;

/// Square of the error of a patch that fails, px², where the blurred reference is compared with the sharp one.
const FAILED_PX2: f32 = 1.0;

/// Error of a patch relative to its path during the exposure, times the root of the part of the texture's variance that is
/// left unexplained: a motion that gets faster or turns is not blurred along a line. Measured on simulated presses.
const PATH_ERROR: f32 = 0.25;

/// The same where the motion has become much faster since the last frame, so that its path is not known well.
const PATH_ERROR_AT_START: f32 = 1.0;

/// Longest exposure of a steady motion, relative to the time between two frames.
const LONGEST_STEADY: f32 = 1.2;

/// The blurred reference and scratch memory.
#[derive(Debug, Clone)]
pub(in crate::affine::patches) struct MotionBlur {
    pub(super) reference: BlurredTemplate,
    /// Whether the picture is matched with the blurred reference.
    pub(super) is_used: bool,
    /// Whether the next picture is taken as sharp, because the last search found nothing.
    pub(super) skips_next: bool,
    /// The part of the patches that move about as fast as the blurred ones and may be blurred, too, if it is known.
    part: Option<f32>,
    /// The best exposure of the last blurred picture.
    pub(super) exposure: Option<Trial>,
    /// Motion of each patch since the last frame, px.
    motion: Vec<f32>,
    /// The blurred patches.
    blurred: Vec<usize>,
    /// Square of the error that a patch has because its path is not a line, px².
    path_error: Vec<f32>,
    /// The field that was found with the sharp reference.
    pub(super) sharp: NodeField,
    /// The best field so far.
    pub(super) best: NodeField,
}

impl MotionBlur {
    /// For references like this empty one.
    pub(in crate::affine::patches) fn new(empty: Template, refinement: &Refinement, noise: Noise) -> Self {
        let grid = empty.grid;
        let nodes = grid.nodes();
        let mut reference = BlurredTemplate::new(empty);
        // Allocates what depends on the refinement.
        refinement.complete(&mut reference.template, noise);
        Self {
            reference,
            is_used: false,
            skips_next: false,
            part: None,
            exposure: None,
            motion: vec![0.0; nodes],
            blurred: Vec::with_capacity(nodes),
            path_error: vec![0.0; nodes],
            sharp: NodeField::zero(grid),
            best: NodeField::zero(grid),
        }
    }

    /// Begins a picture that is not known to be blurred.
    pub(in crate::affine::patches) fn begin(&mut self) {
        (self.is_used, self.part) = (false, None);
    }

    /// Forgets the previous frames.
    pub(in crate::affine::patches) fn restart(&mut self) {
        (self.is_used, self.skips_next, self.exposure) = (false, false, None);
    }

    /// The template that the patches are matched with, given that of the reference.
    pub(in crate::affine::patches) fn template<'a>(&'a self, sharp: &'a Template) -> &'a Template {
        if self.is_used { &self.reference.template } else { sharp }
    }

    /// Whether a patch is matched with a blurred template.
    pub(in crate::affine::patches) fn is_blurred(&self, node: usize) -> bool {
        self.is_used && self.motion[node] > LEAST_MOTION_PX
    }

    /// Square of the error of a patch that its path during the exposure causes, px².
    pub(in crate::affine::patches) fn path_error(&self, node: usize) -> f32 {
        if self.is_used { self.path_error[node] } else { 0.0 }
    }

    /// Sets the motion of every patch from the flow `last` to `now`.
    pub(super) fn set_motion(&mut self, now: &NodeField, last: &NodeField) {
        let [[u, v], [last_u, last_v]] = [now, last].map(|field| [&field.planes[0], &field.planes[3]]);
        let changes =
            u.iter().zip(last_u).zip(v.iter().zip(last_v)).map(|((u, last_u), (v, last_v))| [u - last_u, v - last_v]);
        for (motion, [right, down]) in self.motion.iter_mut().zip(changes) {
            *motion = (right * right + down * down).sqrt();
        }
    }

    /// Finds the blurred patches; returns whether there are enough.
    pub(super) fn find_blurred(&mut self, refinement: &Refinement, sharp: &Template, most_variance: f32) -> bool {
        let Self { motion, blurred, .. } = self;
        let is_textured = |node: usize| sharp.own_variance[node] <= most_variance && refinement.is_inside[node];
        let looks_blurred =
            |node: usize, px: f32| refinement.trust()[node] <= 0.0 || refinement.blur_error(sharp, node) > px * px;
        blurred.clear();
        blurred.extend((0..motion.len()).filter(|&node| {
            motion[node] > LEAST_MOTION_PX && is_textured(node) && looks_blurred(node, LEAST_ERROR_PX)
        }));
        // A picture without such patches does not show how long the shutter was open.
        if blurred.is_empty() {
            self.part = None;
            return false;
        }
        let least = AS_FAST * blurred.iter().map(|&node| motion[node]).sum::<f32>() / blurred.len() as f32;
        let as_fast = motion.iter().filter(|motion| **motion > least).count();
        let (mut all, mut slightly) = (0_u32, 0_u32);
        for node in (0..motion.len()).filter(|&node| motion[node] > least && is_textured(node)) {
            all += 1;
            slightly += u32::from(looks_blurred(node, SLIGHT_ERROR_PX));
        }
        self.part = (all > 0).then(|| slightly as f32 / all as f32);
        blurred.len() >= LEAST_BLURRED && blurred.len() as f32 > LEAST_PART * as_fast as f32
    }

    /// How likely it is that a patch with low contrast and a large residual is blurred, 0 to 1.
    pub(in crate::affine::patches) fn likelihood(&self) -> f32 {
        let [from, to] = BLUR_IS_LIKELY;
        self.part.map_or(1.0, |part| ((part - from) / (to - from)).clamp(0.0, 1.0))
    }

    /// Sets the errors that the paths of the patches cause.
    pub(super) fn set_path_error(&mut self, refinement: &Refinement, exposure: f32) {
        let Self { reference, motion, path_error, .. } = self;
        let part = if exposure > LONGEST_STEADY { PATH_ERROR_AT_START } else { PATH_ERROR };
        for (node, (error, motion)) in path_error.iter_mut().zip(motion).enumerate() {
            *error = (part * exposure * *motion).powi(2) * unexplained(refinement, &reference.template, node);
        }
    }

    /// Part of the texture's variance in the blurred patches that is left unexplained, on average, 0 to 1.
    pub(super) fn mean_unexplained(&self, refinement: &Refinement, template: &Template) -> f32 {
        let sum: f32 = self.blurred.iter().map(|&node| unexplained(refinement, template, node)).sum();
        sum / self.blurred.len() as f32
    }

    /// Mean square of the error of the blurred patches, px²: that of blur, and with a blurred template that of the path.
    pub(super) fn mean_error(&self, refinement: &Refinement, template: &Template, is_blurred: bool) -> f32 {
        let error = |&node: &usize| {
            if refinement.trust()[node] <= 0.0 {
                return FAILED_PX2;
            }
            let by_path = if is_blurred { self.path_error[node] } else { 0.0 };
            (refinement.blur_error(template, node) + by_path).min(FAILED_PX2)
        };
        self.blurred.iter().map(error).sum::<f32>() / self.blurred.len() as f32
    }
}

/// Part of the texture's variance in a patch that is left unexplained, 0 to 1.
fn unexplained(refinement: &Refinement, template: &Template, node: usize) -> f32 {
    (refinement.mean_energy[node] / template.variance[node].max(1.0)).min(1.0)
}

#[cfg(test)]
mod tests {
    use crate::FlowParams;
    use crate::affine::patches::AffinePatches;
    use fearless_simd::Level;

    #[test]
    fn blur_is_likely_if_most_of_what_moves_as_fast_looks_blurred() {
        let mut blur = AffinePatches::new(64, 48, &FlowParams::default(), Level::new()).blur;
        for (part, expected) in [(None, 1.0), (Some(0.1), 0.0), (Some(0.4), 0.5), (Some(0.9), 1.0)] {
            blur.part = part;
            assert!((blur.likelihood() - expected).abs() < 1e-6, "{part:?}: {}", blur.likelihood());
        }
        blur.begin();
        assert!((blur.likelihood() - 1.0).abs() < 1e-6, "a new picture may be blurred");
    }
}
