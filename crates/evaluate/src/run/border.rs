//! The pixels near the border of the contact, by distance on the undeformed gel.
//!
//! The border runs between a pixel that is in contact and a neighbour that is not, half-way between their centres. Its
//! points and the pixels are projected onto the undeformed surface, and a pixel belongs to the band if some border
//! point is no farther than the band's reach. This is exact for any camera, tilted or distorted. The edge of the image
//! and the edge of the visible gel do not count as a border, because contact beyond them is unknown.
//!
//! Around each border point only the pixels that can be within reach are examined. For contacts with some thousand
//! border pixels this is cheaper than a distance transform of the whole image, which would be exact only for an upright
//! pinhole camera.

use fingervision_image::Rect;
use fingervision_optics::Camera;

/// Rounding must not leave out a pixel that lies exactly at the reach, mm.
const ROUNDING_MM: f64 = 1e-9;

/// Finds the pixels near the border of a contact, frame by frame.
#[derive(Debug)]
pub(crate) struct BorderBand {
    size: (usize, usize),
    reach_mm: f64,
    reach_px: usize,
    /// The point of the undeformed surface that each pixel sees, mm; NaN where it sees none.
    places_mm: Vec<[f64; 2]>,
    near: Vec<bool>,
}

impl BorderBand {
    /// A band of `reach_mm` on both sides of the border, on a grid of this size whose first pixel is the camera's.
    pub(crate) fn new(camera: &Camera, size: (usize, usize), reach_mm: f64) -> Self {
        let (width, height) = size;
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x as f64, y as f64]));
        let places_mm = pixels.map(|px| camera.surface_point(px, 0.0).unwrap_or([f64::NAN; 2])).collect();
        let mut band = Self { size, reach_mm, reach_px: 0, places_mm, near: vec![false; width * height] };
        let finest_mm = band.finest_mm();
        // A tenth more, because the scale changes within the reach, and one pixel more, because the border lies between
        // two pixels.
        band.reach_px = ((1.1 * reach_mm / finest_mm).ceil() as usize).saturating_add(1);
        band
    }

    /// Whether each pixel lies in the band of this contact. `is_gel` returns whether a pixel sees the gel.
    pub(crate) fn find(&mut self, contact: &[u8], is_gel: impl Fn(usize) -> bool) -> &[bool] {
        self.near.fill(false);
        let (width, height) = self.size;
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let here = y * width + x;
            let right = (x + 1 < width).then_some(here + 1);
            let below = (y + 1 < height).then_some(here + width);
            for there in [right, below].into_iter().flatten() {
                if contact[here] != contact[there] && is_gel(here) && is_gel(there) {
                    self.mark_around((x, y), self.between(here, there));
                }
            }
        }
        &self.near
    }

    fn between(&self, a: usize, b: usize) -> [f64; 2] {
        let (a, b) = (self.places_mm[a], self.places_mm[b]);
        [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
    }

    /// Marks the pixels within reach of a border point that lies beside a pixel.
    fn mark_around(&mut self, (x, y): (usize, usize), [from_x, from_y]: [f64; 2]) {
        let window = self.window((x, y));
        let reach_squared = (self.reach_mm + ROUNDING_MM).powi(2);
        for row in window.y..window.y + window.height {
            let start = row * self.size.0 + window.x;
            let places = &self.places_mm[start..start + window.width];
            for (near, [x, y]) in self.near[start..start + window.width].iter_mut().zip(places) {
                *near |= (x - from_x).powi(2) + (y - from_y).powi(2) <= reach_squared;
            }
        }
    }

    fn window(&self, (x, y): (usize, usize)) -> Rect {
        let along = |centre: usize, size: usize| {
            let start = centre.saturating_sub(self.reach_px);
            (start, centre.saturating_add(self.reach_px + 1).min(size) - start)
        };
        let ((x, width), (y, height)) = (along(x, self.size.0), along(y, self.size.1));
        Rect { x, y, width, height }
    }

    /// The shortest distance on the gel of a step of one pixel, over all directions and pixels, mm: the smallest
    /// singular value of the map from px to mm.
    fn finest_mm(&self) -> f64 {
        let (width, height) = self.size;
        let step = |a: usize, b: usize| {
            let (a, b) = (self.places_mm[a], self.places_mm[b]);
            [b[0] - a[0], b[1] - a[1]]
        };
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let pixels = (1..height).flat_map(|y| (1..width).map(move |x| y * width + x));
        let finest = pixels.map(|here| {
            let (right, down) = (step(here - 1, here), step(here - width, here));
            let (a, b, c) = (dot(right, right), dot(right, down), dot(down, down));
            (0.5 * (a + c) - (0.25 * (a - c).powi(2) + b * b).sqrt()).max(0.0).sqrt()
        });
        finest.filter(|finest| *finest > 0.0).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fingervision_optics::{CameraParams, Distortion};

    const SIZE: (usize, usize) = (48, 36);

    fn camera(rotation_rad: [f64; 3], distortion: Distortion) -> Camera {
        Camera::new(&CameraParams {
            focal_length_px: [100.0, 90.0],
            principal_point_px: [23.5, 17.5],
            distortion,
            rotation_rad,
            translation_mm: [0.0, 0.0, 25.0],
        })
        .unwrap()
    }

    fn contact() -> Vec<u8> {
        let is_touched = |x: usize, y: usize| {
            (10..26).contains(&x) && (8..20).contains(&y) && !(x + y).is_multiple_of(13) || (x, y) == (40, 30)
        };
        (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| u8::from(is_touched(x, y)))).collect()
    }

    /// The definition: compares every pixel with every border point.
    fn by_definition(camera: &Camera, contact: &[u8], reach_mm: f64) -> Vec<bool> {
        let (width, height) = SIZE;
        let place = |i: usize| camera.surface_point([(i % width) as f64, (i / width) as f64], 0.0).unwrap();
        let right = (0..width * height).filter(|i| i % width + 1 < width).map(|i| (i, i + 1));
        let below = (0..width * (height - 1)).map(|i| (i, i + width));
        let crossed = right.chain(below).filter(|&(a, b)| contact[a] != contact[b]);
        let border: Vec<_> =
            crossed.map(|(a, b)| [0, 1].map(|axis: usize| 0.5 * (place(a)[axis] + place(b)[axis]))).collect();
        let near = |i: usize| {
            let [x, y] = place(i);
            border.iter().any(|point| (point[0] - x).hypot(point[1] - y) <= reach_mm + ROUNDING_MM)
        };
        (0..width * height).map(near).collect()
    }

    #[test]
    fn the_band_is_that_of_the_definition_for_any_camera() {
        let lens = Distortion { k1: -0.4, k2: 0.3, p1: 0.02, p2: -0.01, ..Distortion::default() };
        for (rotation, distortion) in
            [([0.0; 3], Distortion::default()), ([0.5, -0.3, 0.8], Distortion::default()), ([0.3, 0.2, -1.0], lens)]
        {
            let (camera, contact) = (camera(rotation, distortion), contact());
            for reach_mm in [0.1, 1.0, 2.5] {
                let expected = by_definition(&camera, &contact, reach_mm);
                let mut band = BorderBand::new(&camera, SIZE, reach_mm);
                let found = band.find(&contact, |_| true);
                let differ = found.iter().zip(&expected).filter(|(found, expected)| found != expected).count();
                assert_eq!(differ, 0, "pixels at {rotation:?} within {reach_mm} mm");
            }
        }
    }

    #[test]
    fn the_edge_of_the_gel_and_of_the_image_is_no_border() {
        let camera = camera([0.0; 3], Distortion::default());
        let mut band = BorderBand::new(&camera, SIZE, 1.0);
        assert!(!band.find(&[1; 48 * 36], |_| true).contains(&true));
        let half: Vec<u8> = (0..48 * 36).map(|i| u8::from(i % 48 < 24)).collect();
        assert!(!band.find(&half, |i| i % 48 < 24).contains(&true), "what does not see the gel is not in contact");
        assert!(band.find(&half, |_| true).contains(&true));
    }

    #[test]
    fn both_sides_count_alike() {
        // 0.25 mm a pixel along x: four pixels on each side of the border between columns 23 and 24.
        let mut band = BorderBand::new(&camera([0.0; 3], Distortion::default()), SIZE, 1.0);
        let half: Vec<u8> = (0..48 * 36).map(|i| u8::from(i % 48 < 24)).collect();
        let row = &band.find(&half, |_| true)[10 * 48..11 * 48];
        let columns: Vec<usize> = (0..48).filter(|&x| row[x]).collect();
        assert_eq!(columns, [20, 21, 22, 23, 24, 25, 26, 27]);
    }
}
