//! The brightness and the noise of the images of a recording.

use fingervision_image::{Frame, Rect};

use super::fault::{Fault, RecordingCheck, What};
use super::thresholds::THRESHOLDS;

/// Distance between the tested pixels along both axes.
const STEP: usize = 2;

/// Whether a value is at the bottom of the range, 0 to 255.
pub(super) fn is_black(value: f32) -> bool {
    value < 0.5
}

/// Whether a value is at the top of the range, 0 to 255.
pub(super) fn is_saturated(value: f32) -> bool {
    value > 254.5
}

/// The brightness statistics so far.
#[derive(Debug)]
pub(super) struct Exposure {
    region: Rect,
    /// Largest parts at the bottom and at the top of the range, and their image, from 1.
    clipped: [(f64, usize); 2],
    /// Mean grey level of every image.
    means: Vec<f64>,
    /// The values of the previous image; kept only if the noise is requested.
    before: Option<Vec<[f32; 3]>>,
    /// Sum and count of the absolute differences between consecutive images' values, grey levels.
    differences: (f64, usize),
}

impl Exposure {
    pub(super) fn new(region: Rect, with_noise: bool) -> Self {
        Self {
            region,
            clipped: [(0.0, 0); 2],
            means: Vec::new(),
            before: with_noise.then(Vec::new),
            differences: (0.0, 0),
        }
    }

    /// Takes the next image; one that the region does not fit is skipped.
    pub(super) fn push(&mut self, frame: &Frame) {
        let Rect { x, y, width, height } = self.region;
        let (columns, rows) = frame.pixels.size();
        if !self.region.is_inside(columns, rows) {
            return;
        }
        let places = (y..y + height).step_by(STEP).flat_map(|y| (x..x + width).step_by(STEP).map(move |x| (x, y)));
        let values: Vec<[f32; 3]> = places.map(|(x, y)| frame.pixels.levels(x, y)).collect();
        let count = 3.0 * values.len() as f64;
        let part =
            |is: fn(f32) -> bool| values.as_flattened().iter().filter(|&&value| is(value)).count() as f64 / count;
        self.means.push(values.as_flattened().iter().map(|&value| f64::from(value)).sum::<f64>() / count);
        let image = self.means.len();
        for (worst, now) in self.clipped.iter_mut().zip([part(is_black), part(is_saturated)]) {
            if now > worst.0 {
                *worst = (now, image);
            }
        }
        if let Some(before) = &mut self.before {
            for (now, before) in values.as_flattened().iter().zip(before.as_flattened()) {
                self.differences.0 += f64::from((now - before).abs());
                self.differences.1 += 1;
            }
            *before = values;
        }
    }

    /// Number of images.
    pub(super) fn images(&self) -> usize {
        self.means.len()
    }

    /// Mean grey level of all images.
    fn mean(&self) -> f64 {
        self.means.iter().sum::<f64>() / self.means.len().max(1) as f64
    }

    /// Standard deviation of a channel's noise, grey levels; none if it was not requested. Normal noise differs between
    /// two images by 2/√π deviations on average.
    pub(super) fn noise_levels(&self) -> Option<f64> {
        let (sum, count) = self.differences;
        (count > 0).then(|| 0.5 * std::f64::consts::PI.sqrt() * sum / count as f64)
    }

    /// Range of the images' mean levels over their mean, dimensionless.
    pub(super) fn flicker(&self) -> f64 {
        let (least, most) =
            self.means.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), &mean| (least.min(mean), most.max(mean)));
        if most > 0.0 { (most - least) / self.mean() } else { 0.0 }
    }

    /// The statistics of the brightness.
    pub(super) fn figures(&self) -> RecordingCheck {
        let [(black, _), (saturated, _)] = self.clipped;
        let (images, mean_level) = (self.images(), self.mean());
        let noise_levels = self.noise_levels();
        RecordingCheck { images, mean_level, saturated, black, noise_levels, ..RecordingCheck::default() }
    }

    /// What is wrong with the brightness, if anything.
    pub(super) fn fault(&self) -> Option<Fault> {
        let mean = self.mean();
        let [(black, dark_image), (saturated, bright_image)] = self.clipped;
        let brighter = "more light, a longer exposure or a wider aperture, all fixed; where the image shows more than the gel, set \
             image.region_of_interest in sensor.toml";
        let darker = "a shorter exposure, less light or less gain, all fixed; where the image shows a lamp or a reflection, set \
             image.region_of_interest in sensor.toml";
        let clipped = |part: f64, image: usize, end: &str| {
            format!("{:.1} % of the values of image {image} are at the {end} of their range", 100.0 * part)
        };
        let least_clipped = format!("at most {:.0} %", 100.0 * THRESHOLDS.most_clipped);
        let level = format!("the mean grey level is {mean:.0}");
        let [least, most] = THRESHOLDS.mean_levels;
        let levels = format!("{least:.0} to {most:.0} of 255");
        match () {
            () if self.means.is_empty() => None,
            () if saturated > THRESHOLDS.most_clipped => {
                Some(Fault::new(What::TooBright, clipped(saturated, bright_image, "top"), least_clipped, darker))
            }
            () if mean > most => Some(Fault::new(What::TooBright, level, levels, darker)),
            () if mean < least => Some(Fault::new(What::TooDark, level, levels, brighter)),
            () if black > THRESHOLDS.most_clipped => {
                Some(Fault::new(What::TooDark, clipped(black, dark_image, "bottom"), least_clipped, brighter))
            }
            () => None,
        }
    }
}
