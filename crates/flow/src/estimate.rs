//! What a match gives.

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
    /// Part of the textured patches that match, 0 to 1; 0 where no patch has texture. Patches that left the image do not
    /// count unless they are the majority.
    pub matched: f32,
    /// Root mean square residual of the matching patches, grey levels per channel; not a number if none matches.
    pub residual_levels: f32,
    /// The median over the textured patches of the unexplained part of the variance, 0 to 1: caused by noise, blur or
    /// another picture over most of the image. What a contact occludes does not count.
    pub unexplained: f32,
    /// Area that was lost and not found again, px²: that of the patches with texture that fail together with their
    /// neighbours. Along a rim, where patches fail one by one, it is 0.
    pub lost_px2: f32,
}

impl Estimate {
    /// An estimate at rest over pictures of this size, nowhere valid.
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
        }
    }

    /// Takes the values of `other`, without allocating where the sizes agree.
    pub fn copy_from(&mut self, other: &Self) {
        self.flow.copy_from(&other.flow);
        self.deviation.copy_from(&other.deviation);
        self.valid.copy_from(&other.valid);
        self.matched = other.matched;
        self.residual_levels = other.residual_levels;
        self.unexplained = other.unexplained;
        self.lost_px2 = other.lost_px2;
    }
}
