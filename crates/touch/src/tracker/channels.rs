//! Whether the flow uses the colours of the frames or their brightness alone.

use super::Tracker;
use crate::TrackError;
use fingervision_flow::{FlowEstimator, FlowParams};
use fingervision_image::Pixels;

/// Least detail of the colours relative to that of the brightness with which the flow uses colour. Colour at half the resolution has 0.3
/// and less, or 0.9 where cells of the pattern are so large that this hardly matters; colour of a Bayer sensor 0.3 and less, or 0.9 if it was
/// compressed after a soft lens, where colour is as good as brightness alone.
const LEAST_DETAIL: f32 = 0.7;

impl Tracker {
    /// Decides by the frame that will be the first reference. Matched in colours of less detail than the brightness, patches fail,
    /// and flow has several times the error of flow from brightness alone.
    pub(super) fn choose_channels(&mut self, pixels: &Pixels) -> Result<(), TrackError> {
        let colour = self.flow.colour && pixels.colour_detail(self.region) >= LEAST_DETAIL;
        if colour != self.estimator.params().colour {
            let flow = FlowParams { colour, ..self.flow };
            self.estimator = FlowEstimator::new(self.region.width, self.region.height, &flow)?;
            self.estimator.share(&self.team);
            self.picture = self.estimator.picture();
        }
        Ok(())
    }

    /// Whether the flow uses the colours of the frames, and not their brightness alone. Decided by each frame that becomes the first
    /// reference; before the first one, by the profile and the kind of frames.
    #[must_use]
    pub fn uses_colour(&self) -> bool {
        self.estimator.params().colour
    }
}
