//! The distribution of the grey levels of a picture.

use fingervision_image::Image;

/// A pixel is saturated from this level on. White is 255, but conversion and compression can change it.
const SATURATED: f32 = 250.0;
/// Distance between the sampled rows and columns, px: some thousand samples in a usual picture.
const STEPS: [usize; 2] = [8, 4];

/// What the grey levels of a picture show about its exposure.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Levels {
    /// Mean, grey levels.
    pub mean: f32,
    /// Standard deviation, grey levels: texture, shading and noise together.
    pub contrast: f32,
    /// Part of the pixels of which a channel is saturated, 0 to 1.
    pub saturated: f32,
}

impl Levels {
    /// The levels of a picture with these channels, from a sample of its pixels.
    pub(crate) fn of(grey: &Image<f32>, channels: &[Image<f32>]) -> Self {
        let [row_step, column_step] = STEPS;
        let (mut sum, mut square, mut count) = (0.0_f32, 0.0_f32, 0.0_f32);
        for row in grey.rows().step_by(row_step) {
            for &level in row.iter().step_by(column_step) {
                sum += level;
                square += level * level;
                count += 1.0;
            }
        }
        let count = count.max(1.0);
        let mean = sum / count;
        Self {
            mean,
            contrast: (square / count - mean * mean).max(0.0).sqrt(),
            saturated: count_saturated(channels) as f32 / count,
        }
    }
}

/// The sampled pixels of which a channel is saturated.
fn count_saturated(channels: &[Image<f32>]) -> usize {
    let [row_step, column_step] = STEPS;
    let Some(first) = channels.first() else { return 0 };
    let mut count = 0;
    for y in (0..first.height()).step_by(row_step) {
        let others = &channels[1..];
        for (x, &level) in first.row(y).iter().enumerate().step_by(column_step) {
            let largest = others.iter().fold(level, |largest, channel| largest.max(channel.row(y)[x]));
            count += usize::from(largest >= SATURATED);
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_of_known_pictures() {
        let of = |grey: Image<f32>| Levels::of(&grey, std::slice::from_ref(&grey));
        let flat = of(Image::filled(64, 48, 40.0));
        assert_eq!((flat.mean, flat.contrast, flat.saturated), (40.0, 0.0, 0.0));
        let half = of(Image::from_fn(64, 48, |x, _| if x < 32 { 0.0 } else { 255.0 }));
        assert_eq!((half.mean, half.contrast, half.saturated), (127.5, 127.5, 0.5));
    }

    #[test]
    fn a_pixel_with_one_saturated_channel_is_saturated() {
        let grey = Image::filled(64, 48, 90.0);
        let half = |level: f32| Image::from_fn(64, 48, |_, y| if y < 24 { level } else { 90.0 });
        let channels = [half(255.0), half(10.0), half(10.0)];
        let expected = Levels { mean: 90.0, contrast: 0.0, saturated: 0.5 };
        assert_eq!(Levels::of(&grey, &channels), expected);
    }
}
