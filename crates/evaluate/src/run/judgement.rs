//! The pixels of a frame that are compared, and their regions.

use super::array::FrameArray;
use super::{PixelCounts, Region, Regions, RunError};

/// The valid pixels of an estimate, frame by frame, and the regions in which they are compared.
#[derive(Debug)]
pub(super) struct Judgement {
    /// 1 where the estimate is valid.
    pub(super) valid: Vec<u8>,
    /// For each pixel of the run, a bit for each region that it lies in; 0 where it is not compared.
    pub(super) regions: Vec<u8>,
    pixels: [PixelCounts; 4],
}

/// A mask of a run and the arrays that it applies to, each with its number of channels.
pub(super) struct Judged<'a> {
    pub(super) mask: Option<&'a FrameArray<u8>>,
    pub(super) mask_name: &'static str,
    pub(super) arrays: &'a [(Option<&'a FrameArray<f32>>, usize)],
}

impl Judgement {
    /// A judgement of grids with this number of pixels.
    pub(super) fn new(pixels: usize) -> Self {
        Self { valid: vec![0; pixels], regions: vec![0; pixels], pixels: [PixelCounts::default(); 4] }
    }

    /// Determines where the frame's estimate is valid.
    ///
    /// # Errors
    ///
    /// [`RunError::NotFinite`] if a value is not finite where the mask marks it as valid.
    pub(super) fn judge(&mut self, judged: &Judged, frame: u64) -> Result<(), RunError> {
        match judged.mask {
            Some(mask) => self.valid.copy_from_slice(mask.values()),
            None => self.valid.fill(1),
        }
        for &(array, channels) in judged.arrays {
            let Some(array) = array else { continue };
            for (at, valid) in self.valid.iter_mut().enumerate().filter(|(_, valid)| **valid != 0) {
                if is_finite(Some(array.values()), channels, at) {
                    continue;
                }
                if judged.mask.is_some() {
                    let (file, mask, width) = (array.path().to_owned(), judged.mask_name, array.size().0);
                    return Err(RunError::NotFinite { file, mask, frame, x: at % width, y: at / width });
                }
                *valid = 0;
            }
        }
        Ok(())
    }

    /// Sets the regions of each pixel that is compared, and counts the others. `regions_of` has a bit for each
    /// region of a pixel, visible or not.
    pub(super) fn assign(&mut self, seen: &[u8], regions_of: impl Fn(usize) -> u8) -> Regions<PixelCounts> {
        let mut pixels = [PixelCounts::default(); 4];
        for (i, regions) in self.regions.iter_mut().enumerate() {
            let all = regions_of(i);
            for region in Region::ALL.into_iter().filter(|region| all & bit(*region) != 0) {
                let PixelCounts { compared, hidden, not_valid } = &mut pixels[region as usize];
                match (seen[i], self.valid[i]) {
                    (0, _) => *hidden += 1,
                    (_, 0) => *not_valid += 1,
                    _ => *compared += 1,
                }
            }
            *regions = if seen[i] != 0 && self.valid[i] != 0 { all } else { 0 };
        }
        self.pixels.iter_mut().zip(&pixels).for_each(|(sum, pixels)| sum.add(pixels));
        by_region(&pixels)
    }

    /// The pixel counts of all frames.
    pub(super) fn pixels(&self) -> Regions<PixelCounts> {
        by_region(&self.pixels)
    }
}

/// The bit of a region.
pub(super) fn bit(region: Region) -> u8 {
    1 << region as u8
}

/// Whether an array, if there is one, is finite at a pixel.
pub(super) fn is_finite(values: Option<&[f32]>, channels: usize, at: usize) -> bool {
    values.is_none_or(|values| values[channels * at..][..channels].iter().all(|value| value.is_finite()))
}

fn by_region(pixels: &[PixelCounts; 4]) -> Regions<PixelCounts> {
    Regions::from_fn(|region| Some(pixels[region as usize]).filter(|pixels| pixels.all() > 0))
}
