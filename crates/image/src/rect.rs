//! A part of an image.

/// A rectangle of whole pixels: `[x, x + width) × [y, y + height)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rect {
    /// Left column, px.
    pub x: usize,
    /// Top row, px.
    pub y: usize,
    /// Columns, px.
    pub width: usize,
    /// Rows, px.
    pub height: usize,
}

impl Rect {
    /// The whole of an image of this size.
    #[must_use]
    pub fn whole(width: usize, height: usize) -> Self {
        Self { x: 0, y: 0, width, height }
    }

    /// Whether the rectangle has pixels and all of them lie in an image of this size.
    #[must_use]
    pub fn is_inside(&self, width: usize, height: usize) -> bool {
        let right = self.x.checked_add(self.width).is_some_and(|right| right <= width);
        let bottom = self.y.checked_add(self.height).is_some_and(|bottom| bottom <= height);
        self.width > 0 && self.height > 0 && right && bottom
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_knows_whether_it_fits() {
        assert!(Rect { x: 1, y: 2, width: 3, height: 4 }.is_inside(4, 6));
        assert!(!Rect { x: 1, y: 2, width: 4, height: 4 }.is_inside(4, 6));
        assert!(!Rect { x: usize::MAX, y: 0, width: 2, height: 1 }.is_inside(4, 6));
        assert!(!Rect { x: 0, y: 0, width: 0, height: 1 }.is_inside(4, 6));
    }
}
