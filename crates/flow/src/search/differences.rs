//! Gradients of images: central differences, one-sided at the border.

use fingervision_image::Image;

/// The gradient at every pixel.
pub(super) fn differentiate(image: &Image<f32>, gradient_x: &mut Image<f32>, gradient_y: &mut Image<f32>) {
    for y in 0..image.height() {
        differentiate_row(image, y, 0, gradient_x.row_mut(y), gradient_y.row_mut(y));
    }
}

/// The gradient at pixels of row `y`, from column `left` on, as many as the targets have; an image has at least two columns.
#[inline(always)]
pub(super) fn differentiate_row(
    image: &Image<f32>,
    y: usize,
    left: usize,
    gradient_x: &mut [f32],
    gradient_y: &mut [f32],
) {
    let (width, height) = image.size();
    let [above, row, below] = [y.saturating_sub(1), y, (y + 1).min(height - 1)].map(|y| image.row(y));
    let span = if y == 0 || y + 1 == height { 1.0 } else { 0.5 };
    let end = left + gradient_x.len();
    for (gradient, (below, above)) in gradient_y.iter_mut().zip(below[left..end].iter().zip(&above[left..end])) {
        *gradient = span * (below - above);
    }
    let first = left.max(1);
    for (gradient, sides) in gradient_x[first - left..].iter_mut().zip(row[first - 1..].windows(3)) {
        *gradient = 0.5 * (sides[2] - sides[0]);
    }
    if left == 0 {
        gradient_x[0] = row[1] - row[0];
    }
    if end == width {
        gradient_x[end - 1 - left] = row[width - 1] - row[width - 2];
    }
}
