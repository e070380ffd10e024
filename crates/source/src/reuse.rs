//! Pixels that are written over frame after frame: they are made anew only where format or size change.

use fingervision_image::{Image, Pixels};

type Size = (usize, usize);

/// The values of 8-bit grey pixels of this size.
pub(crate) fn grey8(pixels: &mut Pixels, size: Size) -> &mut [u8] {
    values(pixels, size, Pixels::Grey8, |pixels| if let Pixels::Grey8(image) = pixels { Some(image) } else { None })
}

/// The values of 8-bit colour pixels of this size.
pub(crate) fn rgb8(pixels: &mut Pixels, size: Size) -> &mut [[u8; 3]] {
    values(pixels, size, Pixels::Rgb8, |pixels| if let Pixels::Rgb8(image) = pixels { Some(image) } else { None })
}

/// The values of 16-bit grey pixels of this size.
pub(crate) fn grey16(pixels: &mut Pixels, size: Size) -> &mut [u16] {
    values(pixels, size, Pixels::Grey16, |pixels| if let Pixels::Grey16(image) = pixels { Some(image) } else { None })
}

/// The values of 16-bit colour pixels of this size.
pub(crate) fn rgb16(pixels: &mut Pixels, size: Size) -> &mut [[u16; 3]] {
    values(pixels, size, Pixels::Rgb16, |pixels| if let Pixels::Rgb16(image) = pixels { Some(image) } else { None })
}

fn values<T: Copy + Default>(
    pixels: &mut Pixels,
    (width, height): Size,
    wrap: fn(Image<T>) -> Pixels,
    of: impl Fn(&mut Pixels) -> Option<&mut Image<T>>,
) -> &mut [T] {
    if of(pixels).is_none_or(|image| image.size() != (width, height)) {
        *pixels = wrap(Image::filled(width, height, T::default()));
    }
    of(pixels).map(Image::values_mut).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_of_the_same_format_and_size_stay_where_they_are() {
        let mut pixels = Pixels::Grey8(Image::filled(0, 0, 0));
        assert_eq!(rgb8(&mut pixels, (4, 3)).len(), 12);
        let place = rgb8(&mut pixels, (4, 3)).as_ptr();
        assert_eq!(rgb8(&mut pixels, (4, 3)).as_ptr(), place);
        assert_eq!(grey16(&mut pixels, (3, 3)), [0; 9]);
        assert_eq!(pixels, Pixels::Grey16(Image::filled(3, 3, 0)));
        assert_eq!((rgb16(&mut pixels, (1, 2)).len(), grey8(&mut pixels, (2, 2)).len()), (2, 4));
    }
}
