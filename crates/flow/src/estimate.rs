//! The result of matching a picture with a reference.

use crate::FlowField;
use fingervision_image::Image;

/// A flow with its deviation and validity. Made once and overwritten for every frame.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// Displacement of every reference pixel, px. Where it is not valid it is interpolated from the surroundings.
    pub flow: FlowField,
    /// Predicted standard deviation of the displacement (both components together), px; infinite where the patch
    /// failed or the point has left the image.
    pub deviation: Image<f32>,
    /// 1 where the flow is a valid measurement, else 0.
    pub valid: Image<u8>,
    /// Part of the textured patches that match, 0 to 1; 0 if no patch has texture. Patches outside the current image
    /// are not counted, unless they are the majority.
    pub matched: f32,
    /// Root mean square residual of the matching patches, grey levels per channel; NaN if none matches.
    pub residual_levels: f32,
    /// The residual's variance over the template's variance, 0 to 1: the median over the textured patches. Noise, blur
    /// or another picture over most of the image increase it. Because it is a median, a small occluded area hardly
    /// changes it.
    pub unexplained: f32,
    /// Area that was lost and not found again, px²: that of the textured patches that failed together with their
    /// neighbours. It is 0 if only single patches failed, as along a rim.
    pub lost_px2: f32,
    /// Whether motion blurs the picture: patches were matched with a reference blurred along their motion.
    pub is_motion_blurred: bool,
}

impl Estimate {
    /// An estimate for pictures of this size: the flow is zero, and valid nowhere.
    #[must_use]
    pub fn new(width: usize, height: usize) -> Self {
        Self {
            flow: FlowField::zero(width, height),
            deviation: Image::filled(width, height, f32::INFINITY),
            valid: Image::filled(width, height, 0),
            matched: 0.0,
            residual_levels: 0.0,
            unexplained: 0.0,
            lost_px2: 0.0,
            is_motion_blurred: false,
        }
    }

    /// Memory for an estimate of pictures of this size that is overwritten before it is read: the deviation, too, is zero. The
    /// system provides no memory for planes that nothing was written to.
    #[must_use]
    pub fn unwritten(width: usize, height: usize) -> Self {
        let (flow, valid) = (FlowField::zero(width, height), Image::filled(width, height, 0));
        Self { flow, deviation: Image::filled(width, height, 0.0), valid, ..Self::new(0, 0) }
    }

    /// Copies the values of `other`; allocates nothing if the sizes are equal.
    pub fn copy_from(&mut self, other: &Self) {
        self.flow.copy_from(&other.flow);
        self.deviation.copy_from(&other.deviation);
        self.valid.copy_from(&other.valid);
        self.matched = other.matched;
        self.residual_levels = other.residual_levels;
        self.unexplained = other.unexplained;
        self.lost_px2 = other.lost_px2;
        self.is_motion_blurred = other.is_motion_blurred;
    }
}
