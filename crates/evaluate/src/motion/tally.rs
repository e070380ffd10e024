//! Sums over the readings of a press, by place.

use crate::run::BorderBand;
use fingervision_gel::Truth;
use fingervision_image::Image;
use fingervision_optics::Camera;
use fingervision_touch::Reading;

/// Bands of distance from the border of the contact: the largest distance of each, mm.
pub const BANDS_MM: [f64; 4] = [0.25, 0.5, 1.0, 2.0];

/// The last of the bands that count as the rim.
const RIM: usize = 2;

/// An error, px, beyond which a valid pixel is wrong.
const WRONG_PX: f32 = 0.5;

/// The region and the band of each pixel of a frame.
#[derive(Debug)]
pub(super) struct Regions {
    /// The index of the first band that contains the pixel, or the number of bands if it is farther from any border.
    band: Image<u8>,
}

impl Regions {
    pub(super) fn of(truth: &Truth, camera: &Camera) -> Self {
        let size = truth.contact.size();
        let mut band = Image::filled(size.0, size.1, BANDS_MM.len() as u8);
        for (k, reach_mm) in BANDS_MM.into_iter().enumerate().rev() {
            let mut border = BorderBand::new(camera, size, reach_mm);
            let depth = truth.depth.values();
            let near = border.find(truth.contact.values(), |pixel| depth[pixel].is_finite());
            for (band, near) in band.values_mut().iter_mut().zip(near) {
                *band = if *near { k as u8 } else { *band };
            }
        }
        Self { band }
    }
}

/// Sums over the visible pixels of one kind.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sums {
    pixels: u64,
    valid: u64,
    wrong: u64,
    error: f64,
    valid_error: f64,
    covered: [u64; 2],
}

impl Sums {
    fn add(&mut self, error: f32, deviation: f32, is_valid: bool) {
        self.pixels += 1;
        self.error += f64::from(error);
        if is_valid {
            self.valid += 1;
            self.valid_error += f64::from(error);
            self.wrong += u64::from(error > WRONG_PX);
            for (covered, factor) in self.covered.iter_mut().zip([1.0, 2.0]) {
                *covered += u64::from(error <= factor * deviation);
            }
        }
    }

    fn with(mut self, other: &Self) -> Self {
        self.pixels += other.pixels;
        self.valid += other.valid;
        self.wrong += other.wrong;
        self.error += other.error;
        self.valid_error += other.valid_error;
        for (covered, other) in self.covered.iter_mut().zip(other.covered) {
            *covered += other;
        }
        self
    }

    /// Mean error of all pixels, px.
    #[must_use]
    pub fn mean_px(&self) -> f64 {
        self.error / self.pixels as f64
    }

    /// Mean error of the valid pixels, px.
    #[must_use]
    pub fn mean_valid_px(&self) -> f64 {
        self.valid_error / self.valid as f64
    }

    /// Part of the pixels that are valid.
    #[must_use]
    pub fn valid(&self) -> f64 {
        self.valid as f64 / self.pixels as f64
    }

    /// Part of the valid pixels whose error is at most one (0) or two (1) deviations.
    #[must_use]
    pub fn covered(&self, deviations: usize) -> f64 {
        self.covered[deviations] as f64 / self.valid as f64
    }
}

/// Errors and validity of the readings of a press.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    bands: [Sums; BANDS_MM.len() + 1],
    /// In contact, at the rim, outside: every pixel belongs to one of them; the rim takes precedence.
    places: [Sums; 3],
    /// The largest part of wrong pixels among the valid pixels of a frame.
    wrong: f64,
    contact_px: f64,
    /// As `contact_px`, of the images without a flag.
    silent_px: f64,
    frames: u64,
    flagged: u64,
    force_off: f64,
    /// The largest displacement from one image to the next, px.
    pub step_px: f64,
}

impl Tally {
    /// Adds a reading, given the truth of its frame and of the one before.
    pub(super) fn add(&mut self, reading: &Reading, truth: &Truth, before: &Truth, regions: &Regions, force_n: f64) {
        let (width, height) = truth.depth.size();
        let (mut contact, mut all) = (Sums::default(), Sums::default());
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let [u, v] = truth.flow.at(x, y);
            if truth.visible.at(x, y) != 1 || !u.is_finite() {
                continue;
            }
            let [was_u, was_v] = before.flow.at(x, y);
            let step = f64::from((u - was_u).hypot(v - was_v));
            self.step_px = if step > self.step_px { step } else { self.step_px };
            let error = (reading.flow.u.at(x, y) - u).hypot(reading.flow.v.at(x, y) - v);
            let (deviation, is_valid) = (reading.deviation.at(x, y), reading.valid.at(x, y) == 1);
            let (band, is_contact) = (usize::from(regions.band.at(x, y)), truth.contact.at(x, y) == 1);
            let place = if band <= RIM { 1 } else { 2 * usize::from(!is_contact) };
            self.bands[band].add(error, deviation, is_valid);
            self.places[place].add(error, deviation, is_valid);
            all.add(error, deviation, is_valid);
            if is_contact {
                contact.add(error, deviation, is_valid);
            }
        }
        let is_flagged = reading.flags.iter().next().is_some();
        if contact.pixels > 0 {
            self.contact_px = self.contact_px.max(contact.mean_px());
            self.silent_px = if is_flagged { self.silent_px } else { self.silent_px.max(contact.mean_px()) };
        }
        if all.valid > 0 {
            self.wrong = self.wrong.max(all.wrong as f64 / all.valid as f64);
        }
        self.frames += 1;
        self.flagged += u64::from(is_flagged);
        let found_n = reading.force_n.map_or(0.0, |force_n| force_n[2]);
        self.force_off = (f64::from(found_n) - force_n).abs() / force_n.abs().max(f64::MIN_POSITIVE);
    }

    /// The sums of two presses, without the largest figures of each.
    #[must_use]
    pub fn with(mut self, other: &Self) -> Self {
        for (band, other) in self.bands.iter_mut().zip(&other.bands) {
            *band = band.with(other);
        }
        for (place, other) in self.places.iter_mut().zip(&other.places) {
            *place = place.with(other);
        }
        self
    }

    /// By distance from the border, [`BANDS_MM`] and farther.
    pub fn bands(&self) -> impl Iterator<Item = &Sums> {
        self.bands.iter()
    }

    /// In contact, at the rim (within 1 mm of the border, on both sides) and outside.
    pub fn places(&self) -> impl Iterator<Item = &Sums> {
        self.places.iter()
    }

    /// The largest mean error in contact of an image, px.
    #[must_use]
    pub fn contact_px(&self) -> f64 {
        self.contact_px
    }

    /// The largest mean error in contact of an image without a flag, px.
    #[must_use]
    pub fn silent_px(&self) -> f64 {
        self.silent_px
    }

    /// The largest part of wrong pixels among the valid pixels of an image.
    #[must_use]
    pub fn wrong(&self) -> f64 {
        self.wrong
    }

    /// Part of the visible pixels that are valid.
    #[must_use]
    pub fn valid(&self) -> f64 {
        self.places.iter().fold(Sums::default(), Sums::with).valid()
    }

    /// Mean error at the rim, px.
    #[must_use]
    pub fn rim_px(&self) -> f64 {
        self.places[1].mean_px()
    }

    /// Part of the pixels at the rim that are valid.
    #[must_use]
    pub fn rim_valid(&self) -> f64 {
        self.places[1].valid()
    }

    /// Part of the images that are flagged.
    #[must_use]
    pub fn flagged(&self) -> f64 {
        self.flagged as f64 / self.frames as f64
    }

    /// Relative error of the normal force in the last image; 1 if no force is estimated.
    #[must_use]
    pub fn force_off(&self) -> f64 {
        self.force_off
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fingervision_optics::{CameraParams, Distortion};

    const SIZE: (usize, usize) = (96, 64);

    /// A contact in the left half of the frame; everything has moved to the right by 2 px.
    fn truth() -> Truth {
        Truth {
            flow: Image::filled(SIZE.0, SIZE.1, [2.0, 0.0]),
            depth: Image::filled(SIZE.0, SIZE.1, 1.0),
            displacement: Image::filled(SIZE.0, SIZE.1, [0.0; 3]),
            contact: Image::from_fn(SIZE.0, SIZE.1, |x, _| u8::from(x < 48)),
            visible: Image::from_fn(SIZE.0, SIZE.1, |_, y| u8::from(y > 0)),
        }
    }

    fn at_rest() -> Truth {
        Truth { flow: Image::filled(SIZE.0, SIZE.1, [0.0; 2]), ..truth() }
    }

    #[test]
    fn pixels_are_sorted_by_their_distance_from_the_border() {
        // 10 px to a mm.
        let camera = CameraParams {
            focal_length_px: [250.0; 2],
            principal_point_px: [47.5, 31.5],
            translation_mm: [0.0, 0.0, 25.0],
            rotation_rad: [0.0; 3],
            distortion: Distortion::default(),
        };
        let regions = Regions::of(&truth(), &Camera::new(&camera).unwrap());
        let bands: Vec<u8> = [47, 48, 45, 50, 43, 52, 38, 57, 28, 67].map(|x| regions.band.at(x, 30)).to_vec();
        assert_eq!(bands, [0, 0, 0, 0, 1, 1, 2, 2, 3, 3]);
        assert_eq!(regions.band.at(20, 30), 4);
    }

    #[test]
    fn errors_are_counted_where_they_are() {
        let mut reading = Reading::new(SIZE.0, SIZE.1);
        reading.valid.values_mut().fill(1);
        reading.deviation.values_mut().fill(0.2);
        for y in 0..SIZE.1 {
            for x in 0..SIZE.0 {
                // Off by 0.3 px in contact and by 0.1 outside; by 50 px in the hidden row.
                let off = if y == 0 {
                    50.0
                } else if x < 48 {
                    0.3
                } else {
                    0.1
                };
                reading.flow.u.row_mut(y)[x] = 2.0 + off;
            }
        }
        reading.flow.u.row_mut(9)[5] = 3.0;
        reading.valid.row_mut(8)[5] = 0;
        let regions = Regions { band: Image::filled(SIZE.0, SIZE.1, 4) };
        let mut tally = Tally::default();
        tally.add(&reading, &truth(), &at_rest(), &regions, 4.0);
        let contact = 48.0 * 63.0;
        assert!((tally.contact_px() - (0.3 + 0.7 / contact)).abs() < 1e-5, "{}", tally.contact_px());
        assert!((tally.wrong() - 1.0 / (2.0 * contact - 1.0)).abs() < 1e-9);
        assert!((tally.valid() - (1.0 - 0.5 / contact)).abs() < 1e-9);
        assert!((tally.step_px - 2.0).abs() < 1e-6 && (tally.force_off() - 1.0).abs() < 1e-12);
        let [in_contact, _, outside] = tally.places;
        assert!((in_contact.covered(1) - (1.0 - 1.0 / (contact - 1.0))).abs() < 1e-9);
        assert!(in_contact.covered(0) == 0.0 && (outside.covered(0) - 1.0).abs() < 1e-12);
    }
}
