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
    /// The levels of a picture, from a sample of its pixels.
    pub(crate) fn of(grey: &Image<f32>, colour: Option<&Image<[f32; 4]>>) -> Self {
        let [row_step, column_step] = STEPS;
        let (mut sum, mut square, mut count) = (0.0_f32, 0.0_f32, 0.0_f32);
        for row in grey.rows().step_by(row_step) {
            for &level in row.iter().step_by(column_step) {
                sum += level;
                square += level * level;
                count += 1.0;
            }
        }
        let saturated = match colour {
            Some(colour) => count_where(colour, |[red, green, blue, _]| red.max(green).max(blue) >= SATURATED),
            None => count_where(grey, |level| level >= SATURATED),
        };
        let count = count.max(1.0);
        let mean = sum / count;
        Self { mean, contrast: (square / count - mean * mean).max(0.0).sqrt(), saturated: saturated as f32 / count }
    }
}

fn count_where<T: Copy>(image: &Image<T>, holds: impl Fn(T) -> bool) -> usize {
    let [row_step, column_step] = STEPS;
    let rows = image.rows().step_by(row_step);
    rows.map(|row| row.iter().step_by(column_step).filter(|&&value| holds(value)).count()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_of_known_pictures() {
        let flat = Levels::of(&Image::filled(64, 48, 40.0), None);
        assert_eq!((flat.mean, flat.contrast, flat.saturated), (40.0, 0.0, 0.0));
        let half = Image::from_fn(64, 48, |x, _| if x < 32 { 0.0 } else { 255.0 });
        let half = Levels::of(&half, None);
        assert_eq!((half.mean, half.contrast, half.saturated), (127.5, 127.5, 0.5));
    }

    #[test]
    fn a_pixel_with_one_saturated_channel_is_saturated() {
        let grey = Image::filled(64, 48, 90.0);
        let colour = Image::from_fn(64, 48, |_, y| if y < 24 { [255.0, 10.0, 10.0, 0.0] } else { [90.0; 4] });
        let expected = Levels { mean: 90.0, contrast: 0.0, saturated: 0.5 };
        assert_eq!(Levels::of(&grey, Some(&colour)), expected);
    }
}
