//! How much detail the colours of an image have.
//!
//! Many cameras and file formats keep colour at half the resolution of the brightness, and convert it back when the image is read.
//! The format of the pixels does not say so. But neighbouring pixels then differ less in colour than in brightness.
//!
//! A Bayer sensor has one colour in each pixel, green in every second one, as the black squares of a chess board. The others are interpolated
//! from their neighbours, so green differs less from the mean of its neighbours in every second pixel.

use crate::colour::LUMA_WEIGHTS;
use crate::{Image, Pixels, Rect};

/// Distance of pixels that differ in both, px: further than colour is spread.
const FAR: usize = 4;

/// The colours of an image count only if they vary by more than this part of its brightness, root mean squares.
const LEAST_COLOUR: f64 = 0.1;

impl Pixels {
    /// Detail of the colours in a region relative to that of the brightness, dimensionless: 1 if both have the same, as where a sensor
    /// has all colours in each pixel; 0.3 and less if colour is stored at half the resolution along an axis, or interpolated from that of a
    /// Bayer sensor, unless the image was changed or compressed after it. 0 if the image is grey, if its colours vary by less than a tenth of
    /// its brightness, or if the region is smaller than 8 px.
    ///
    /// # Panics
    ///
    /// If the region reaches outside the image.
    #[must_use]
    pub fn colour_detail(&self, region: Rect) -> f32 {
        if !self.is_colour() || region.width < 2 * FAR || region.height < 2 * FAR {
            return 0.0;
        }
        let plane = |of: &dyn Fn([f32; 3]) -> f32| {
            Image::from_fn(region.width, region.height, |x, y| of(self.levels(region.x + x, region.y + y)))
        };
        let brightness =
            |levels: [f32; 3]| LUMA_WEIGHTS.iter().zip(levels).map(|(weight, level)| weight * level).sum::<f32>();
        let grey = Differences::of(&plane(&brightness));
        let colours = [0, 2].map(|channel| Differences::of(&plane(&|levels| levels[channel] - brightness(levels))));
        let is_coloured = |colour: &&Differences| {
            colour.far.iter().zip(grey.far).all(|(colour, grey)| *colour > LEAST_COLOUR.powi(2) * grey)
        };
        let relative = |colour: &Differences| {
            let axis = |axis: usize| colour.near[axis] / colour.far[axis] * grey.far[axis] / grey.near[axis];
            axis(0).min(axis(1))
        };
        let least = colours.iter().filter(is_coloured).map(relative).fold(f64::INFINITY, f64::min);
        let green = plane(&|levels| levels[1]);
        if least.is_finite() { least.min(chess_detail(&green)) as f32 } else { 0.0 }
    }
}

/// How much every second pixel of an image differs from the mean of its four neighbours, relative to the pixels between them: the mean squares,
/// the smaller over the larger. 1 if no pixel differs.
fn chess_detail(image: &Image<f32>) -> f64 {
    let (width, height) = image.size();
    let mut squares = [0.0_f64; 2];
    for y in 1..height - 1 {
        let [above, here, below] = [y - 1, y, y + 1].map(|y| &image.row(y)[..width]);
        let mut sums = [0.0_f32; 2];
        for first in [1, 2] {
            let near = here[first - 1..].windows(3).zip(above[first..].iter().zip(&below[first..])).step_by(2);
            sums[first - 1] = near
                .map(|(beside, (above, below))| (beside[1] - 0.25 * (beside[0] + beside[2] + above + below)).powi(2))
                .sum();
        }
        squares[y % 2] += f64::from(sums[0]);
        squares[(y + 1) % 2] += f64::from(sums[1]);
    }
    let [even, odd] = squares;
    if even.max(odd) > 0.0 { even.min(odd) / even.max(odd) } else { 1.0 }
}

/// Mean squared differences between pixels, along rows and along columns.
#[derive(Debug, Clone, Copy)]
struct Differences {
    /// Between neighbours, of which each pixel has one: colour that is stored for pairs of pixels does not differ within a pair.
    near: [f64; 2],
    /// Between pixels at a distance of [`FAR`].
    far: [f64; 2],
}

impl Differences {
    fn of(image: &Image<f32>) -> Self {
        let (width, height) = image.size();
        let mean = |distance: (usize, usize), first: (usize, usize), step: (usize, usize)| {
            let (mut sum, mut count) = (0.0, 0);
            for y in (first.1..height - distance.1).step_by(step.1) {
                for x in (first.0..width - distance.0).step_by(step.0) {
                    sum += f64::from(image.at(x + distance.0, y + distance.1) - image.at(x, y)).powi(2);
                    count += 1;
                }
            }
            sum / f64::from(count.max(1))
        };
        let along_rows = |first| mean((1, 0), (first, 0), (2, 1));
        let along_columns = |first| mean((0, 1), (0, first), (1, 2));
        Self {
            near: [along_rows(0).min(along_rows(1)), along_columns(0).min(along_columns(1))],
            far: [mean((FAR, 0), (0, 0), (1, 1)), mean((0, FAR), (0, 0), (1, 1))],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (64, 48);

    /// A random pattern, smooth over about two pixels, in three independent channels.
    fn pattern(x: usize, y: usize) -> [f32; 3] {
        let value = |x: usize, y: usize, channel: usize| {
            let mixed = (x as u32).wrapping_mul(0x9E37_79B1)
                ^ (y as u32).wrapping_mul(0x85EB_CA77)
                ^ (channel as u32 + 1).wrapping_mul(0xC2B2_AE3D);
            let mixed = (mixed ^ mixed >> 15).wrapping_mul(0x2C1B_3C6D);
            ((mixed ^ mixed >> 12) & 255) as f32
        };
        [0, 1, 2].map(|channel| {
            (value(x, y, channel) + value(x + 1, y, channel) + value(x, y + 1, channel) + value(x + 1, y + 1, channel))
                / 4.0
        })
    }

    /// The detail of an image whose colour, apart from its brightness, is the mean over blocks of pixels.
    fn detail(block: (usize, usize), saturation: f32) -> f32 {
        let brightness =
            |levels: [f32; 3]| LUMA_WEIGHTS.iter().zip(levels).map(|(weight, level)| weight * level).sum::<f32>();
        let colour = |x: usize, y: usize| pattern(x, y).map(|level| saturation * (level - brightness(pattern(x, y))));
        let image = Image::from_fn(SIZE.0, SIZE.1, |x, y| {
            let (left, top) = (x / block.0 * block.0, y / block.1 * block.1);
            let mut levels = [brightness(pattern(x, y)); 3];
            for (dx, dy) in (0..block.0).flat_map(|dx| (0..block.1).map(move |dy| (dx, dy))) {
                for (level, colour) in levels.iter_mut().zip(colour(left + dx, top + dy)) {
                    *level += colour / (block.0 * block.1) as f32;
                }
            }
            levels.map(|level| level.round().clamp(0.0, 255.0) as u8)
        });
        Pixels::Rgb8(image).colour_detail(Rect { x: 3, y: 2, width: SIZE.0 - 5, height: SIZE.1 - 4 })
    }

    #[test]
    fn colour_of_each_pixel_has_as_much_detail_as_the_brightness() {
        for saturation in [1.0, 0.5, 0.2] {
            let found = detail((1, 1), saturation);
            assert!((0.85..1.2).contains(&found), "{found} at a saturation of {saturation}");
        }
    }

    #[test]
    fn colour_of_several_pixels_has_less() {
        for block in [(2, 1), (1, 2), (2, 2)] {
            let found = detail(block, 1.0);
            assert!(found < 0.1, "{found} with blocks of {block:?} pixels");
        }
    }

    #[test]
    fn colour_of_a_bayer_sensor_has_less() {
        // Red in every second pixel of every second row, blue diagonally beside it, green elsewhere.
        let has = |x: usize, y: usize, channel: usize| match channel {
            0 => x.is_multiple_of(2) && y.is_multiple_of(2),
            1 => (x + y) % 2 == 1,
            _ => x % 2 == 1 && y % 2 == 1,
        };
        let image = Image::from_fn(SIZE.0, SIZE.1, |x, y| {
            [0, 1, 2].map(|channel| {
                let near =
                    (x.saturating_sub(1)..=x + 1).flat_map(|x| (y.saturating_sub(1)..=y + 1).map(move |y| (x, y)));
                let known: Vec<f32> = if has(x, y, channel) {
                    vec![pattern(x, y)[channel]]
                } else {
                    near.filter(|&(x, y)| has(x, y, channel)).map(|(x, y)| pattern(x, y)[channel]).collect()
                };
                (known.iter().sum::<f32>() / known.len() as f32).round() as u8
            })
        });
        let found = Pixels::Rgb8(image).colour_detail(Rect { x: 3, y: 2, width: SIZE.0 - 5, height: SIZE.1 - 4 });
        assert!(found < 0.3, "{found}");
    }

    #[test]
    fn without_colour_there_is_no_detail() {
        assert!(detail((1, 1), 0.0) <= 0.0);
        for pixels in [Pixels::Grey8(Image::filled(40, 40, 7)), Pixels::Rgb8(Image::filled(40, 40, [9, 8, 7]))] {
            assert!(pixels.colour_detail(Rect::whole(40, 40)) <= 0.0);
        }
    }
}
