//! A picture prepared for matching: its grey pyramid and, if needed, its colours.

use crate::Levels;
use crate::light::Light;
use fingervision_image::{Image, ImageError, Pixels, Pyramid, Rect, grey_and_channels_into, grey_into};

/// One image at every pyramid level. Made once per stream and reloaded for every frame.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Grey levels, corrected if the light was.
    pub(crate) grey: Pyramid,
    /// Red, green and blue at full size, corrected if the light was.
    pub(crate) colour: Option<[Image<f32>; 3]>,
    /// Of the grey levels, then of the colours.
    pub(crate) light: Light,
    /// Grey levels as they were loaded, if they were corrected.
    loaded: Image<f32>,
    is_corrected: bool,
    measured: Measured,
}

/// What is measured of the levels as they were loaded.
#[derive(Debug, Clone, Copy, Default)]
struct Measured {
    levels: Levels,
    mean_level: f32,
    sharpness: f32,
}

impl Picture {
    /// An empty picture of this size with levels 0 to `coarsest_level`; `colour` keeps the channels at full size.
    #[must_use]
    pub fn new(width: usize, height: usize, coarsest_level: usize, colour: bool) -> Self {
        Self {
            grey: Pyramid::new(width, height, coarsest_level),
            colour: colour.then(|| [(); 3].map(|()| Image::filled(width, height, 0.0))),
            light: Light::new(width, height, colour),
            // The system provides no memory until the first correction writes to it.
            loaded: Image::filled(width, height, 0.0),
            is_corrected: false,
            measured: Measured::default(),
        }
    }

    /// Loads a region of a frame. The region must have the picture's size.
    ///
    /// # Errors
    ///
    /// [`ImageError::RegionOutside`] if the region reaches outside the frame.
    pub fn load(&mut self, pixels: &Pixels, region: Rect) -> Result<(), ImageError> {
        let grey = self.grey.base_mut();
        match &mut self.colour {
            Some(colour) => grey_and_channels_into(pixels, region, grey, colour)?,
            None => grey_into(pixels, region, grey)?,
        }
        self.complete();
        Ok(())
    }

    /// Computes what follows from the loaded levels.
    fn complete(&mut self) {
        self.grey.build();
        self.measured = Measured {
            levels: Levels::of(self.grey.level(0), self.channels()),
            mean_level: self.matched_mean(),
            sharpness: self.measure_sharpness(),
        };
        self.is_corrected = false;
        self.light.measure(0, self.grey.level(0));
        for (channel, image) in self.colour.iter().flatten().enumerate() {
            self.light.measure(1 + channel, image);
        }
    }

    /// Corrects the light to that of a reference, if it differs; `flow` is the last displacement from the reference at the nodes of the
    /// patches, px.
    pub(crate) fn correct_light(&mut self, reference: &Light, flow: [&[f32]; 2]) {
        if self.is_corrected || !self.light.find_change(reference, flow) {
            return;
        }
        self.is_corrected = true;
        self.loaded.copy_from(self.grey.level(0));
        self.light.correct(0, self.grey.base_mut());
        self.grey.build();
        for (channel, image) in self.colour.iter_mut().flatten().enumerate() {
            self.light.correct(1 + channel, image);
        }
    }

    /// Copies the pixels of a picture; allocates nothing if size and channels are equal.
    pub fn copy_from(&mut self, other: &Self) {
        self.grey.copy_from(&other.grey);
        self.light.copy_from(&other.light);
        (self.measured, self.is_corrected) = (other.measured, other.is_corrected);
        if other.is_corrected {
            self.loaded.copy_from(&other.loaded);
        }
        match (&mut self.colour, &other.colour) {
            (Some(mine), Some(other)) => mine.iter_mut().zip(other).for_each(|(mine, other)| mine.copy_from(other)),
            (mine, other) => mine.clone_from(other),
        }
    }

    /// Loads a grey image of the picture's size. The colours, if any, do not change.
    pub fn load_grey(&mut self, grey: &Image<f32>) {
        self.grey.base_mut().copy_from(grey);
        self.complete();
    }

    /// Grey levels at full size, as they were loaded.
    #[must_use]
    pub fn grey(&self) -> &Image<f32> {
        if self.is_corrected { &self.loaded } else { self.grey.level(0) }
    }

    /// All that is matched at full size: red, green and blue, or the grey levels.
    pub(crate) fn channels(&self) -> &[Image<f32>] {
        self.colour.as_ref().map_or_else(|| std::slice::from_ref(self.grey.level(0)), |colour| colour.as_slice())
    }

    /// Mean grey level, as it was loaded.
    #[must_use]
    pub fn mean_level(&self) -> f32 {
        self.measured.mean_level
    }

    /// Mean of the grey levels that are matched.
    pub(crate) fn matched_mean(&self) -> f32 {
        let coarsest = self.grey.coarsest().values();
        coarsest.iter().sum::<f32>() / coarsest.len() as f32
    }

    /// Mean, contrast and saturation, as they were loaded.
    #[must_use]
    pub fn levels(&self) -> Levels {
        self.measured.levels
    }

    /// Sharpness of the picture, dimensionless: the mean squared difference between neighbours in a row at full size,
    /// divided by the same at a quarter of the size. It does not depend on light and contrast. Blur lowers it: twice
    /// the blur halves it. It also depends on the pattern, so compare only pictures of one sensor. 0 for a uniform
    /// picture.
    #[must_use]
    pub fn sharpness(&self) -> f32 {
        self.measured.sharpness
    }

    fn measure_sharpness(&self) -> f32 {
        let coarse = roughness(self.grey.level(2.min(self.grey.levels() - 1)), 1);
        if coarse > 0.0 { roughness(self.grey.level(0), 4) / coarse } else { 0.0 }
    }

    /// Columns and rows at full size, px.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        self.grey.level(0).size()
    }
}

/// Mean squared difference between neighbours in every `step`-th row, grey levels².
fn roughness(image: &Image<f32>, step: usize) -> f32 {
    let rows = image.rows().step_by(step);
    let (sum, count) = rows.fold((0.0, 0), |(sum, count), row| {
        let differences = row.iter().zip(&row[1..]).map(|(left, right)| (right - left).powi(2));
        (sum + differences.sum::<f32>(), count + row.len() - 1)
    });
    sum / count as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_region_of_a_frame_becomes_grey_and_colour() {
        let image = Image::from_fn(23, 9, |x, y| [(11 * x + y) as u8, (250 - 7 * x) as u8, (29 * y + 3 * x) as u8]);
        let region = Rect { x: 2, y: 1, width: 19, height: 7 };
        let pixels = Pixels::Rgb8(image);
        let levels = |x: usize, y: usize| pixels.levels(region.x + x, region.y + y);
        let expected = |of: fn([f32; 3]) -> f32| Image::from_fn(region.width, region.height, |x, y| of(levels(x, y)));
        let grey = expected(|[red, green, blue]| 0.299 * red + 0.587 * green + 0.114 * blue);
        for has_colour in [false, true] {
            let mut picture = Picture::new(region.width, region.height, 0, has_colour);
            picture.load(&pixels, region).unwrap();
            assert_eq!(picture.grey(), &grey);
            let colours = [expected(|levels| levels[0]), expected(|levels| levels[1]), expected(|levels| levels[2])];
            let channels: &[_] = if has_colour { &colours } else { std::slice::from_ref(&grey) };
            assert_eq!(picture.channels(), channels);
        }
    }
}
