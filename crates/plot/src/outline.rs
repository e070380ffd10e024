//! The border of a mask as line segments.

use fingervision_image::Image;

use crate::canvas::{Canvas, Point};
use crate::colour::Rgb;
use crate::panel::Panel;

const LINE: Rgb = [20, 20, 20];
const HALO: Rgb = [255; 3];

/// Where a mask changes: half-way between pixel centres, corners cut (marching squares). Positions are in px of the
/// mask, integer = pixel centre.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    segments: Vec<[Point; 2]>,
}

impl Outline {
    /// The border of the pixels that are not 0.
    #[must_use]
    pub fn of(mask: &Image<u8>) -> Self {
        let (width, height) = mask.size();
        let cells = (1..height).flat_map(|y| (1..width).map(move |x| (x - 1, y - 1)));
        Self { segments: cells.flat_map(|(x, y)| of_cell(mask, x, y)).collect() }
    }

    /// Moves every end of a segment by a function of its position.
    #[must_use]
    pub fn moved(self, by: impl Fn(Point) -> Point) -> Self {
        let moved = |(x, y): Point| {
            let (u, v) = by((x, y));
            (x + u, y + v)
        };
        Self { segments: self.segments.into_iter().map(|segment| segment.map(moved)).collect() }
    }

    /// Draws it onto the image of a panel.
    pub fn draw(&self, canvas: &mut Canvas, panel: Panel) {
        let place = |(x, y): Point| (panel.image.x + (x + 0.5) * panel.scale, panel.image.y + (y + 0.5) * panel.scale);
        for (width, colour) in [(2.6, HALO), (1.3, LINE)] {
            for segment in &self.segments {
                canvas.line(&segment.map(place), width, colour);
            }
        }
    }
}

/// The symbol of the outline in a legend; its text starts at the returned x.
pub fn draw_outline_key(canvas: &mut Canvas, (x, y): Point) -> f32 {
    for (width, colour) in [(2.6, HALO), (1.3, LINE)] {
        canvas.line(&[(x + 1.0, y - 5.0), (x + 21.0, y - 5.0)], width, colour);
    }
    x + 32.0
}

/// The segments between the four pixel centres below and right of a pixel.
fn of_cell(mask: &Image<u8>, x: usize, y: usize) -> impl Iterator<Item = [Point; 2]> {
    let corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)];
    let inside = corners.map(|(x, y)| mask.at(x, y) != 0);
    let (left, top) = (x as f32, y as f32);
    let middles = [(left + 0.5, top), (left + 1.0, top + 0.5), (left + 0.5, top + 1.0), (left, top + 0.5)];
    let mut ends = (0..4).filter(move |&side| inside[side] != inside[(side + 1) % 4]).map(move |side| middles[side]);
    std::iter::from_fn(move || Some([ends.next()?, ends.next()?]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segments(rows: [[u8; 3]; 3]) -> Vec<[Point; 2]> {
        Outline::of(&Image::from_vec(3, 3, rows.concat()).unwrap()).segments
    }

    #[test]
    fn a_lone_pixel_has_a_diamond_around_it() {
        let mut found = segments([[0, 0, 0], [0, 1, 0], [0, 0, 0]]);
        for segment in &mut found {
            segment.sort_by(|a, b| a.partial_cmp(b).unwrap());
        }
        let (left, top, right, bottom) = ((0.5, 1.0), (1.0, 0.5), (1.5, 1.0), (1.0, 1.5));
        assert_eq!(found, [[left, top], [top, right], [left, bottom], [bottom, right]]);
    }

    #[test]
    fn an_even_mask_has_none() {
        assert!(segments([[1; 3]; 3]).is_empty() && segments([[0; 3]; 3]).is_empty());
    }

    #[test]
    fn pixels_that_touch_at_a_corner_give_two_segments_there() {
        let found = segments([[1, 0, 0], [0, 1, 0], [0, 0, 0]]);
        let in_first_cell = found.iter().filter(|segment| segment.iter().all(|&(x, y)| x <= 1.0 && y <= 1.0));
        assert_eq!(in_first_cell.count(), 2);
    }
}
