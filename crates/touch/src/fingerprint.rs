//! The fingerprint of a pattern: distinguishes sensors by their reference image.
//!
//! The image is divided into blocks. A block's bit says whether it is brighter than its surroundings, the mean of the
//! nine blocks around it. Exposure, shading and noise hardly change these bits, and two random patterns agree in half
//! of them. Blocks that differ little from their surroundings are not used. The comparison uses many small shifts of
//! the image, because the camera may have moved a little.
//!
//! Two sensors with the same repeating pattern, such as a regular grid of dots, cannot be distinguished.

use fingervision_image::Image;
use serde::{Deserialize, Serialize};

/// Blocks along each axis.
const BLOCKS: usize = 24;
/// The same, with the outer ring of blocks that serve only as surroundings.
const WITH_RING: usize = BLOCKS + 2;
const BITS: usize = BLOCKS * BLOCKS;
const WORDS: usize = BITS / 64;
const DIGITS: usize = 2 * BITS / 4;
/// Part of the width and height left out on each side, and the largest shift.
const MARGIN: f32 = 1.0 / 16.0;
/// Shifts that are tried per side of a block.
const SHIFTS_PER_BLOCK: f32 = 3.0;
/// A block is used if it differs from its surroundings by this part of the median difference.
const LEAST_CONTRAST: f32 = 0.5;
/// Least median difference of blocks from their surroundings, grey levels: below it there is no pattern.
const LEAST_TEXTURE: f32 = 0.5;

/// The fingerprint of a sensor's pattern. It is written as hexadecimal digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Fingerprint {
    /// Whether each block is brighter than its surroundings.
    is_bright: [u64; WORDS],
    /// Whether it differs enough from them to be compared.
    is_used: [u64; WORDS],
}

impl Fingerprint {
    /// A larger distance means another sensor. With a shift of 3 px, another exposure and noise, images of one simulated
    /// sensor differ by up to 0.01; those of 200 different ones by 0.39 and more.
    pub const MOST_DISTANCE: f32 = 0.25;

    /// The fingerprint of an image of the untouched gel; none if it shows too little texture.
    #[must_use]
    pub fn of(grey: &Image<f32>) -> Option<Self> {
        let contrasts = Sums::of(grey).contrasts([0, 0]);
        let mut sizes = contrasts.map(f32::abs);
        let (_, median, _) = sizes.select_nth_unstable_by(BITS / 2, f32::total_cmp);
        let median = *median;
        (median >= LEAST_TEXTURE).then(|| Self {
            is_bright: bits(&contrasts, |contrast| contrast > 0.0),
            is_used: bits(&contrasts, |contrast| contrast.abs() >= LEAST_CONTRAST * median),
        })
    }

    /// Distance to an image, 0 to 1: the part of the used blocks that disagree, at the best of all shifts by up to a
    /// sixteenth of the image. An image of another pattern is near one half.
    #[must_use]
    pub fn distance(&self, grey: &Image<f32>) -> f32 {
        let sums = Sums::of(grey);
        let used: u32 = self.is_used.iter().map(|word| word.count_ones()).sum();
        let [across, down] = sums.shifts();
        let distance = |shift: [isize; 2]| {
            let bright = bits(&sums.contrasts(shift), |contrast| contrast > 0.0);
            let words = self.is_bright.iter().zip(&bright).zip(&self.is_used);
            let differing: u32 = words.map(|((mine, other), used)| ((mine ^ other) & used).count_ones()).sum();
            differing as f32 / used.max(1) as f32
        };
        let shifts = down.flat_map(|y| across.clone().map(move |x| [x, y]));
        shifts.map(distance).fold(1.0, f32::min)
    }

    /// Whether an image shows the same sensor.
    #[must_use]
    pub fn matches(&self, grey: &Image<f32>) -> bool {
        self.distance(grey) <= Self::MOST_DISTANCE
    }
}

impl From<Fingerprint> for String {
    fn from(fingerprint: Fingerprint) -> Self {
        let words = fingerprint.is_bright.iter().chain(&fingerprint.is_used);
        let digits = |word: &u64| word.to_be_bytes().into_iter().flat_map(|byte| [byte >> 4, byte & 15]);
        words.flat_map(digits).filter_map(|digit| char::from_digit(u32::from(digit), 16)).collect()
    }
}

impl TryFrom<String> for Fingerprint {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let allowed =
            format!("a fingerprint has {DIGITS} hexadecimal digits: fingervision profile fingerprint writes it");
        if text.len() != DIGITS || !text.bytes().all(|digit| digit.is_ascii_hexdigit()) {
            return Err(allowed);
        }
        let mut words = [0; 2 * WORDS];
        for (word, digits) in words.iter_mut().zip(text.as_bytes().chunks_exact(16)) {
            let digits = std::str::from_utf8(digits).map_err(|_| allowed.clone())?;
            *word = u64::from_str_radix(digits, 16).map_err(|_| allowed.clone())?;
        }
        let mut fingerprint = Self { is_bright: [0; WORDS], is_used: [0; WORDS] };
        fingerprint.is_bright.copy_from_slice(&words[..WORDS]);
        fingerprint.is_used.copy_from_slice(&words[WORDS..]);
        Ok(fingerprint)
    }
}

/// A bit for every contrast.
fn bits(contrasts: &[f32; BITS], is_set: impl Fn(f32) -> bool) -> [u64; WORDS] {
    let mut words = [0; WORDS];
    for (word, contrasts) in words.iter_mut().zip(contrasts.chunks_exact(64)) {
        *word =
            contrasts.iter().enumerate().fold(0, |word, (bit, &contrast)| word | u64::from(is_set(contrast)) << bit);
    }
    words
}

/// Sums over all rectangles of an image that begin at its corner.
struct Sums {
    width: usize,
    height: usize,
    /// One column and one row more than the image; those at the beginning are zero.
    values: Vec<f64>,
}

impl Sums {
    fn of(grey: &Image<f32>) -> Self {
        let (width, height) = grey.size();
        let columns = width + 1;
        let mut values = vec![0.0; columns * (height + 1)];
        for (y, row) in grey.rows().enumerate() {
            let mut sum = 0.0;
            for (x, &level) in row.iter().enumerate() {
                sum += f64::from(level);
                values[(y + 1) * columns + x + 1] = values[y * columns + x + 1] + sum;
            }
        }
        Self { width, height, values }
    }

    /// First column or row of block `k`, px, for a shift, px; within the image.
    fn edge(length: usize, k: usize, shift: isize) -> usize {
        let length_px = length as f32;
        let at = length_px * (MARGIN + (1.0 - 2.0 * MARGIN) * k as f32 / WITH_RING as f32);
        (at.round() as usize).saturating_add_signed(shift).min(length)
    }

    /// The shifts to try along both axes, px.
    fn shifts(&self) -> [impl Iterator<Item = isize> + Clone; 2] {
        [self.width, self.height].map(|length| {
            let block_px = length as f32 * (1.0 - 2.0 * MARGIN) / WITH_RING as f32;
            let step = (block_px / SHIFTS_PER_BLOCK).max(1.0) as isize;
            let count = (length as f32 * MARGIN) as isize / step;
            (-count..=count).map(move |k| k * step)
        })
    }

    /// How much brighter each block is than its surroundings, grey levels, with all blocks shifted, px.
    fn contrasts(&self, [shift_x, shift_y]: [isize; 2]) -> [f32; BITS] {
        let columns = self.width + 1;
        let x = |k: usize| Self::edge(self.width, k, shift_x);
        let y = |k: usize| Self::edge(self.height, k, shift_y);
        let mean = |left: usize, top: usize, right: usize, bottom: usize| {
            let sum = |x: usize, y: usize| self.values[y * columns + x];
            let area = (right.saturating_sub(left) * bottom.saturating_sub(top)).max(1);
            (sum(right, bottom) - sum(left, bottom) - sum(right, top) + sum(left, top)) / area as f64
        };
        let mut contrasts = [0.0; BITS];
        for (block, contrast) in contrasts.iter_mut().enumerate() {
            let (i, j) = (block % BLOCKS, block / BLOCKS);
            let own = mean(x(i + 1), y(j + 1), x(i + 2), y(j + 2));
            *contrast = (own - mean(x(i), y(j), x(i + 3), y(j + 3))) as f32;
        }
        contrasts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
    use fingervision_image::{Pixels, Rect, grey_into};

    const SIZE: (usize, usize) = (320, 240);

    fn grey(pattern_seed: u64, motion: &Motion, light: Light, noise: (f32, u64)) -> Image<f32> {
        let noise_levels = f64::from(noise.0);
        let sheet = Sheet { width: SIZE.0, height: SIZE.1, pattern_seed, noise_levels, ..Sheet::default() };
        let image = SheetRenderer::new(&sheet).unwrap().render(motion, light, noise.1).unwrap();
        let mut grey = Image::filled(SIZE.0, SIZE.1, 0.0);
        grey_into(&Pixels::Rgb8(image), Rect::whole(SIZE.0, SIZE.1), &mut grey).unwrap();
        grey
    }

    fn still(seed: u64) -> Image<f32> {
        grey(seed, &Motion::STILL, Light::EVEN, (0.0, 0))
    }

    #[test]
    fn the_same_pattern_is_recognised_in_noise_other_light_and_shifted() {
        let mut largest = 0.0_f32;
        for seed in 1..6 {
            let fingerprint = Fingerprint::of(&still(seed)).unwrap();
            for gain in [0.8, 1.2] {
                for shift_px in [0.0, 3.0] {
                    let image = grey(seed, &Motion::shift(shift_px), Light::uniform(gain), (5.0, seed));
                    largest = largest.max(fingerprint.distance(&image));
                }
            }
        }
        assert!(largest < 0.1, "{largest}");
    }

    #[test]
    fn other_patterns_are_far_away() {
        let fingerprint = Fingerprint::of(&still(0)).unwrap();
        let distances: Vec<f32> = (1..=200).map(|seed| fingerprint.distance(&still(seed))).collect();
        let nearest = distances.iter().copied().fold(1.0, f32::min);
        assert!(nearest > 0.35, "{nearest}");
        assert!(distances.iter().all(|distance| *distance > Fingerprint::MOST_DISTANCE));
    }

    #[test]
    fn a_fingerprint_survives_its_text_and_another_text_is_refused() {
        let fingerprint = Fingerprint::of(&still(3)).unwrap();
        let text = String::from(fingerprint);
        assert_eq!(text.len(), DIGITS);
        assert_eq!(Fingerprint::try_from(text.clone()), Ok(fingerprint));
        for other in [text[1..].to_owned(), text.replace(|_: char| true, "g"), "ä".repeat(DIGITS / 2)] {
            assert!(Fingerprint::try_from(other).unwrap_err().contains("288"));
        }
    }

    #[test]
    fn an_image_without_texture_has_no_fingerprint() {
        assert_eq!(Fingerprint::of(&Image::filled(64, 48, 90.0)), None);
        let shaded = Image::from_fn(64, 48, |x, y| 0.7 * x as f32 + y as f32);
        assert_eq!(Fingerprint::of(&shaded), None);
        assert!(Fingerprint::of(&still(1)).is_some());
    }
}
