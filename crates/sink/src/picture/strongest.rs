//! The frame that a picture shows; of a whole run, the one with the largest mean flow.

use fingervision_flow::FlowField;
use fingervision_image::{Frame, Image, Rect, grey_into};
use fingervision_plot::round_up;
use fingervision_touch::{Flag, Reading, ReadingNumbers};

use crate::SinkError;

/// Mean and largest length of the flow over valid pixels, px; NaN where no pixel is valid or tracking is lost.
#[derive(Debug, Clone, Copy)]
pub(super) struct Strength {
    pub(super) mean_px: f32,
    pub(super) max_px: f32,
}

impl Strength {
    pub(super) fn of(reading: &Reading) -> Self {
        if reading.flags.has(Flag::Lost) {
            return Self { mean_px: f32::NAN, max_px: f32::NAN };
        }
        let (mut sum, mut count, mut max_px) = (0.0, 0.0, f32::NAN);
        let flow = reading.flow.u.values().iter().zip(reading.flow.v.values());
        for ((u, v), _) in flow.zip(reading.valid.values()).filter(|&(_, &valid)| valid != 0) {
            let length = (u * u + v * v).sqrt();
            sum += f64::from(length);
            count += 1.0;
            max_px = max_px.max(length);
        }
        Self { mean_px: (sum / count) as f32, max_px }
    }

    /// Whether this frame is shown rather than another; a frame without strength never is.
    pub(super) fn exceeds(self, other: Self) -> bool {
        self.mean_px > other.mean_px || (other.mean_px.is_nan() && !self.mean_px.is_nan())
    }
}

/// The quantity of the third panel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    /// Depth, mm.
    Depth,
    /// Density feature, dimensionless.
    Density,
    /// Length of the flow, px.
    FlowLength,
}

impl Quantity {
    /// Least end of the colour scale: noise must not look like touch.
    fn least_end(self) -> f32 {
        match self {
            Self::Depth => 0.1,
            Self::Density => 0.02,
            Self::FlowLength => 0.5,
        }
    }
}

/// A copy of the data for a picture of one frame.
#[derive(Debug)]
pub(super) struct Strongest {
    pub(super) numbers: ReadingNumbers,
    /// Place in the run, from 0.
    pub(super) frame: u64,
    pub(super) strength: Strength,
    pub(super) flow: FlowField,
    pub(super) valid: Image<u8>,
    /// The camera image in the region of interest, grey levels.
    pub(super) grey: Image<f32>,
    pub(super) quantity: Quantity,
    /// The third panel's values, in the quantity's unit.
    pub(super) values: Image<f32>,
    /// 1 where these are valid.
    pub(super) values_valid: Image<u8>,
    /// 1 where the gel touches something, if that is known.
    pub(super) contact: Option<Image<u8>>,
}

impl Strongest {
    /// A frame without pixels, weaker than any other.
    pub(super) fn none() -> Self {
        Self {
            numbers: ReadingNumbers::default(),
            frame: 0,
            strength: Strength { mean_px: f32::NAN, max_px: f32::NAN },
            flow: FlowField::zero(0, 0),
            valid: Image::filled(0, 0, 0),
            grey: Image::filled(0, 0, 0.0),
            quantity: Quantity::FlowLength,
            values: Image::filled(0, 0, 0.0),
            values_valid: Image::filled(0, 0, 0),
            contact: None,
        }
    }

    /// Copies a reading and the region of its frame, without allocating where the sizes agree.
    ///
    /// # Errors
    ///
    /// [`SinkError::SizeMismatch`] if the region is not in the frame or differs in size from the reading's fields.
    pub(super) fn copy_from(&mut self, reading: &Reading, frame: &Frame, region: Rect) -> Result<(), SinkError> {
        let (expected, actual) = (reading.flow.size(), (region.width, region.height));
        if expected != actual {
            return Err(SinkError::SizeMismatch { field: "region of the camera image", expected, actual });
        }
        grey_into(&frame.pixels, region, &mut self.grey).map_err(|_| outside(region, frame))?;
        self.numbers = reading.numbers;
        self.flow.copy_from(&reading.flow);
        self.valid.copy_from(&reading.valid);
        match (&reading.depth, &reading.density) {
            (Some(depth), _) => self.show(Quantity::Depth, depth),
            (None, Some(density)) => self.show(Quantity::Density, density),
            (None, None) => self.show_flow_length(),
        }
        self.copy_masks(reading);
        Ok(())
    }

    /// The validity of the third panel's values, and the contact. Elastic depth is valid where its deviation is finite.
    fn copy_masks(&mut self, reading: &Reading) {
        self.values_valid.copy_from(&reading.valid);
        if let (Some(deviation), Some(_)) = (&reading.depth_deviation, &reading.depth) {
            for (valid, deviation) in self.values_valid.values_mut().iter_mut().zip(deviation.values()) {
                *valid = u8::from(deviation.is_finite());
            }
        }
        match (&mut self.contact, &reading.contact) {
            (Some(contact), Some(found)) => contact.copy_from(found),
            (contact, found) => contact.clone_from(found),
        }
    }

    fn show(&mut self, quantity: Quantity, values: &Image<f32>) {
        self.quantity = quantity;
        self.values.copy_from(values);
    }

    fn show_flow_length(&mut self) {
        self.quantity = Quantity::FlowLength;
        self.values.copy_from(&self.flow.u);
        for (length, v) in self.values.values_mut().iter_mut().zip(self.flow.v.values()) {
            *length = length.hypot(*v);
        }
    }

    /// The length that 999 of 1000 valid flows do not exceed, px: for scales, not affected by a few outliers.
    pub(super) fn typical_flow_px(&self) -> f32 {
        let flow = self.flow.u.values().iter().zip(self.flow.v.values());
        typical(flow.map(|(u, v)| u.hypot(*v)), &self.valid)
    }

    /// The end of the third panel's colours, in the quantity's unit: 999 of 1000 valid values do not exceed it.
    pub(super) fn colour_end(&self) -> f32 {
        let typical = typical(self.values.values().iter().map(|value| value.abs()), &self.values_valid);
        round_up(typical.max(self.quantity.least_end()))
    }
}

fn typical(sizes: impl Iterator<Item = f32>, valid: &Image<u8>) -> f32 {
    let valid = sizes.zip(valid.values()).filter(|&(size, &valid)| valid != 0 && size.is_finite());
    let mut sizes: Vec<f32> = valid.map(|(size, _)| size).collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let place = (sizes.len() - 1) * 999 / 1000;
    *sizes.select_nth_unstable_by(place, f32::total_cmp).1
}

fn outside(region: Rect, frame: &Frame) -> SinkError {
    let expected = (region.x + region.width, region.y + region.height);
    SinkError::SizeMismatch { field: "camera image", expected, actual: frame.pixels.size() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_without_strength_never_replaces_another() {
        let strength = |mean_px| Strength { mean_px, max_px: mean_px };
        assert!(strength(2.0).exceeds(strength(1.0)));
        assert!(strength(0.0).exceeds(strength(f32::NAN)));
        assert!(!strength(f32::NAN).exceeds(strength(0.0)));
        assert!(!strength(1.0).exceeds(strength(1.0)));
    }

    #[test]
    fn the_noise_of_an_untouched_gel_is_pale() {
        let mut shown = Strongest::none();
        (shown.quantity, shown.values_valid) = (Quantity::Density, Image::filled(8, 6, 1));
        for (value, end) in [(1e-5, 0.02), (0.18, 0.2)] {
            shown.values = Image::filled(8, 6, value);
            assert!((shown.colour_end() - end).abs() < 1e-6, "{value}: {}", shown.colour_end());
        }
    }
}
