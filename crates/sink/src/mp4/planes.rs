//! A picture as luma and two chromas of half the size, as the encoder takes it.
//!
//! ITU-R BT.709 with a limited range: luma from 16 to 235, chroma from 16 to 240.

use fingervision_image::Image;
use fingervision_plot::Rgb;

/// Shares of red, green and blue in luma.
const LUMA: [f32; 3] = [0.2126, 0.7152, 0.0722];
/// Length of the luma's and half of the chroma's range, over that of a colour.
const LUMA_RANGE: f32 = 219.0 / 255.0;
const CHROMA_RANGE: f32 = 112.0 / 255.0;

/// The planes; their memory is used again.
#[derive(Debug)]
pub(super) struct Planes {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) luma: Vec<u8>,
    pub(super) blue: Vec<u8>,
    pub(super) red: Vec<u8>,
}

impl Planes {
    /// For pictures of this size, px, which is even.
    pub(super) fn new(width: usize, height: usize) -> Self {
        let chroma = vec![128; width / 2 * (height / 2)];
        Self { width, height, luma: vec![16; width * height], blue: chroma.clone(), red: chroma }
    }

    /// Takes over a picture of the same size. A chroma is the mean of four pixels.
    pub(super) fn load(&mut self, picture: &Image<Rgb>) {
        for (to, pixel) in self.luma.iter_mut().zip(picture.values()) {
            *to = (16.0 + LUMA_RANGE * luma(*pixel)).round() as u8;
        }
        let half = self.width / 2;
        for (index, (blue, red)) in self.blue.iter_mut().zip(&mut self.red).enumerate() {
            let (x, y) = (2 * (index % half), 2 * (index / half));
            let mut sums = [0.0; 2];
            for pixel in [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].map(|(x, y)| picture.at(x, y)) {
                let luma = luma(pixel);
                sums[0] += (f32::from(pixel[2]) - luma) / (1.0 - LUMA[2]);
                sums[1] += (f32::from(pixel[0]) - luma) / (1.0 - LUMA[0]);
            }
            [*blue, *red] = sums.map(|sum| (128.0 + CHROMA_RANGE * 0.25 * sum).round() as u8);
        }
    }
}

fn luma(pixel: Rgb) -> f32 {
    pixel.iter().zip(LUMA).map(|(colour, share)| share * f32::from(*colour)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_of_the_standard() {
        for (colour, expected) in [
            ([0, 0, 0], [16, 128, 128]),
            ([255, 255, 255], [235, 128, 128]),
            ([255, 0, 0], [63, 102, 240]),
            ([0, 0, 255], [32, 240, 118]),
        ] {
            let mut planes = Planes::new(4, 2);
            planes.load(&Image::filled(4, 2, colour));
            assert_eq!([planes.luma[7], planes.blue[1], planes.red[1]], expected, "{colour:?}");
        }
    }
}
