//! The owned image: a contiguous row-major grid of values.

use crate::ImageError;

/// An owned image, row-major without padding.
#[derive(Debug, Clone, PartialEq)]
pub struct Image<T> {
    width: usize,
    height: usize,
    values: Vec<T>,
}

impl<T> Image<T> {
    /// An image that takes over `values`, row by row.
    ///
    /// # Errors
    ///
    /// [`ImageError::WrongLength`] if `values` does not hold `width · height` of them.
    pub fn from_vec(width: usize, height: usize, values: Vec<T>) -> Result<Self, ImageError> {
        if width.checked_mul(height) == Some(values.len()) {
            Ok(Self { width, height, values })
        } else {
            Err(ImageError::WrongLength { width, height, len: values.len() })
        }
    }

    /// An image whose value at `(x, y)` is `value(x, y)`.
    #[must_use]
    pub fn from_fn(width: usize, height: usize, mut value: impl FnMut(usize, usize) -> T) -> Self {
        let values = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let values = values.map(|(x, y)| value(x, y)).collect();
        Self { width, height, values }
    }

    /// Columns, px.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows, px.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Columns and rows, px.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// All values, row by row.
    #[must_use]
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// All values, row by row.
    pub fn values_mut(&mut self) -> &mut [T] {
        &mut self.values
    }

    /// Row `y`.
    #[must_use]
    pub fn row(&self, y: usize) -> &[T] {
        &self.values[y * self.width..][..self.width]
    }

    /// Row `y`.
    pub fn row_mut(&mut self, y: usize) -> &mut [T] {
        &mut self.values[y * self.width..][..self.width]
    }

    /// The rows from top to bottom.
    #[must_use]
    pub fn rows(&self) -> impl DoubleEndedIterator<Item = &[T]> + ExactSizeIterator {
        // A chunk of one keeps an image without columns from dividing by zero; it yields no row.
        self.values.chunks_exact(self.width.max(1))
    }

    /// The rows from top to bottom.
    pub fn rows_mut(&mut self) -> impl DoubleEndedIterator<Item = &mut [T]> + ExactSizeIterator {
        self.values.chunks_exact_mut(self.width.max(1))
    }
}

impl<T: Clone> Image<T> {
    /// An image filled with one value.
    #[must_use]
    pub fn filled(width: usize, height: usize, value: T) -> Self {
        Self { width, height, values: vec![value; width * height] }
    }

    /// Takes the size and values of `other`, without allocating where the sizes agree.
    pub fn copy_from(&mut self, other: &Self) {
        self.width = other.width;
        self.height = other.height;
        self.values.clone_from(&other.values);
    }
}

impl<T: Clone + Default> Image<T> {
    /// Changes the size; the values have no meaning afterwards. Allocates only if the image was never as large.
    pub fn set_size(&mut self, (width, height): (usize, usize)) {
        self.width = width;
        self.height = height;
        self.values.resize(width * height, T::default());
    }
}

impl<T: Copy> Image<T> {
    /// The value at column `x`, row `y`.
    ///
    /// # Panics
    ///
    /// If the pixel lies outside the image.
    #[must_use]
    pub fn at(&self, x: usize, y: usize) -> T {
        self.row(y)[x]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_follow_each_other() {
        let image = Image::from_fn(3, 2, |x, y| 10 * y + x);
        assert_eq!(image.row(1), [10, 11, 12]);
        assert_eq!(image.rows().len(), 2);
        assert_eq!(image.at(2, 1), 12);
    }

    #[test]
    fn memory_serves_images_of_several_sizes() {
        let mut image = Image::filled(4, 3, 1u8);
        let memory = image.values().as_ptr();
        image.set_size((2, 2));
        image.values_mut().copy_from_slice(&[1, 2, 3, 4]);
        assert_eq!((image.row(1), image.rows().len()), (&[3, 4][..], 2));
        image.set_size((3, 4));
        assert_eq!((image.values().len(), image.values().as_ptr()), (12, memory));
    }

    #[test]
    fn a_wrong_length_is_refused() {
        let error = Image::from_vec(3, 2, vec![0u8; 5]).unwrap_err();
        assert_eq!(error.to_string(), "5 values cannot fill an image of 3x2 px");
    }
}
