//! A picture prepared for matching: its grey pyramid and, if needed, its colours.

use crate::Levels;
use fearless_simd::{Level, Simd, dispatch, f32x4, prelude::*, u32x4};
use fearless_simd_macros::simd;
use fingervision_image::{Image, ImageError, Pixels, Pyramid, Rect, grey_into, rgbx_into, words};

/// One image at every pyramid level. Made once per stream and reloaded for every frame.
#[derive(Debug, Clone)]
pub struct Picture {
    pub(crate) grey: Pyramid,
    pub(crate) colour: Option<Image<[f32; 4]>>,
}

impl Picture {
    /// An empty picture of this size with levels 0 to `coarsest_level`; `colour` keeps the channels at full size.
    #[must_use]
    pub fn new(width: usize, height: usize, coarsest_level: usize, colour: bool) -> Self {
        Self {
            grey: Pyramid::new(width, height, coarsest_level),
            colour: colour.then(|| Image::filled(width, height, [0.0; 4])),
        }
    }

    /// Loads a region of a frame. The region must have the picture's size.
    ///
    /// # Errors
    ///
    /// [`ImageError::RegionOutside`] if the region reaches outside the frame.
    pub fn load(&mut self, pixels: &Pixels, region: Rect) -> Result<(), ImageError> {
        grey_into(pixels, region, self.grey.base_mut())?;
        if let Some(colour) = &mut self.colour {
            match pixels {
                Pixels::Rgb8(image) if colour.size() == (region.width, region.height) => {
                    let level = Level::new();
                    dispatch!(level, simd => rgbx_of_bytes(simd, image, region, colour));
                }
                _ => rgbx_into(pixels, region, colour)?,
            }
        }
        self.grey.build();
        Ok(())
    }

    /// Copies the pixels of a picture; allocates nothing if size and channels are equal.
    pub fn copy_from(&mut self, other: &Self) {
        self.grey.copy_from(&other.grey);
        match (&mut self.colour, &other.colour) {
            (Some(mine), Some(other)) => mine.copy_from(other),
            (mine, other) => mine.clone_from(other),
        }
    }

    /// Loads a grey image of the picture's size. The colours, if any, do not change.
    pub fn load_grey(&mut self, grey: &Image<f32>) {
        self.grey.base_mut().copy_from(grey);
        self.grey.build();
    }

    /// Grey levels at full size.
    #[must_use]
    pub fn grey(&self) -> &Image<f32> {
        self.grey.level(0)
    }

    /// Mean grey level.
    #[must_use]
    pub fn mean_level(&self) -> f32 {
        let coarsest = self.grey.coarsest().values();
        coarsest.iter().sum::<f32>() / coarsest.len() as f32
    }

    /// Mean, contrast and saturation.
    #[must_use]
    pub fn levels(&self) -> Levels {
        Levels::of(self.grey(), self.colour.as_ref())
    }

    /// Sharpness of the picture, dimensionless: the mean squared difference between neighbours in a row at full size,
    /// divided by the same at a quarter of the size. It does not depend on light and contrast. Blur lowers it: twice
    /// the blur halves it. It also depends on the pattern, so compare only pictures of one sensor. 0 for a uniform
    /// picture.
    #[must_use]
    pub fn sharpness(&self) -> f32 {
        let coarse = roughness(self.grey.level(2.min(self.grey.levels() - 1)), 1);
        if coarse > 0.0 { roughness(self.grey.level(0), 4) / coarse } else { 0.0 }
    }

    /// Columns and rows at full size, px.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        self.grey.level(0).size()
    }
}

/// As [`rgbx_into`], for a region inside an image of 8 bits a channel.
#[simd]
fn rgbx_of_bytes<S: Simd>(simd: S, image: &Image<[u8; 3]>, region: Rect, rgbx: &mut Image<[f32; 4]>) {
    let masks = u32x4::from_slice(simd, &[0xff, 0xff00, 0xff_0000, 0]);
    let scales = f32x4::from_slice(simd, &[1.0, 1.0 / 256.0, 1.0 / 65536.0, 0.0]);
    for (y, to) in rgbx.rows_mut().enumerate() {
        let row = &image.row(region.y + y)[region.x..][..region.width];
        let (blocks, rest) = row.as_chunks::<4>();
        let (to_blocks, to_rest) = to.as_chunks_mut::<4>();
        for (pixels, to) in blocks.iter().zip(to_blocks) {
            for (word, to) in words(pixels).into_iter().zip(to) {
                let channels: f32x4<S> = (u32x4::splat(simd, word) & masks).to_float();
                (channels * scales).store_slice(to);
            }
        }
        for (&[red, green, blue], to) in rest.iter().zip(to_rest) {
            *to = [red, green, blue, 0].map(f32::from);
        }
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
    fn bytes_become_the_same_values_as_any_other_pixels() {
        let image = Image::from_fn(23, 9, |x, y| [(11 * x + y) as u8, (250 - 7 * x) as u8, (29 * y + 3 * x) as u8]);
        let region = Rect { x: 2, y: 1, width: 19, height: 7 };
        let pixels = Pixels::Rgb8(image);
        let mut picture = Picture::new(region.width, region.height, 0, true);
        picture.load(&pixels, region).unwrap();
        let mut expected = Image::filled(1, 1, [0.0; 4]);
        rgbx_into(&pixels, region, &mut expected).unwrap();
        assert_eq!(picture.colour, Some(expected));
        let pixels_grey = Image::from_fn(region.width, region.height, |x, y| {
            let [red, green, blue] = pixels.levels(region.x + x, region.y + y);
            0.299 * red + 0.587 * green + 0.114 * blue
        });
        assert_eq!(picture.grey(), &pixels_grey);
    }
}
