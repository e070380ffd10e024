//! Presses whose images are disturbed: blurred by motion, partly missing, too bright or dark.

use super::Tally;
use super::follow::Press;
use crate::experiment::ExperimentError;
use fingervision_gel::Truth;
use fingervision_image::{Image, Pixels};

/// A disturbance of the images of a press of 20 steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Disturbance {
    /// The shutter is open for half of the time between two images: every image is the mean of the steps in that time.
    MotionBlur {
        /// Steps between two images, an even number.
        pace: usize,
    },
    /// Ten images in the middle are missing.
    MissingImages,
    /// One image in the middle is 1.6 times as bright; values above white are clipped.
    Flash,
    /// Instead of ten images in the middle there are thirty black ones, as of a covered lens.
    Dark,
}

/// An image with the steps of the press that it shows.
#[derive(Debug)]
struct Shot {
    sequence: u64,
    pixels: Pixels,
    /// The steps that it is the mean of; none for a black one.
    steps: std::ops::Range<usize>,
    role: Role,
}

/// The role of an image in the measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// Nothing: before the disturbance, or the image right after it.
    Unmeasured,
    /// It is disturbed, or the first after missing images.
    Disturbed,
    /// Two images after the disturbance or later.
    After,
}

/// The results for the images of a disturbed press.
#[derive(Debug, Clone, Default)]
pub(super) struct Outcome {
    /// Of disturbed images that show the gel.
    pub(super) disturbed: Tally,
    /// From the second image after the disturbance on.
    pub(super) after: Tally,
    /// Black images, and those of them that are flagged.
    pub(super) black: [u64; 2],
}

impl Disturbance {
    /// Those of the table.
    pub const ALL: [Self; 6] = [
        Self::MotionBlur { pace: 4 },
        Self::MotionBlur { pace: 10 },
        Self::MotionBlur { pace: 20 },
        Self::MissingImages,
        Self::Flash,
        Self::Dark,
    ];

    /// Its description.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::MotionBlur { pace } => format!("motion blur, {pace} steps between images"),
            Self::MissingImages => "10 images missing".into(),
            Self::Flash => "flash in one image".into(),
            Self::Dark => "30 black images".into(),
        }
    }

    fn shots(self, images: &[Pixels]) -> Vec<Shot> {
        let middle = images.len() / 2;
        let as_it_is = |step: usize, sequence: usize, role: Role| Shot {
            sequence: sequence as u64,
            pixels: images[step].clone(),
            steps: step..step + 1,
            role,
        };
        // The place of an image beside the disturbed ones of a sequence.
        let role = |step: usize, disturbed: std::ops::Range<usize>| match step {
            step if disturbed.contains(&step) => Role::Disturbed,
            step if step > disturbed.end => Role::After,
            _ => Role::Unmeasured,
        };
        match self {
            Self::MotionBlur { pace } => (0..images.len())
                .step_by(pace)
                .enumerate()
                .map(|(sequence, step)| {
                    let steps = step.saturating_sub(pace / 2)..step + 1;
                    let role = if step == 0 { Role::Unmeasured } else { Role::Disturbed };
                    Shot { sequence: sequence as u64, pixels: mean(&images[steps.clone()]), steps, role }
                })
                .collect(),
            Self::MissingImages => {
                let gap = middle - 5..middle + 5;
                let seen = (0..images.len()).filter(|step| !gap.contains(step));
                seen.map(|step| as_it_is(step, step, role(step, gap.end..gap.end + 1))).collect()
            }
            Self::Flash => (0..images.len())
                .map(|step| {
                    let mut shot = as_it_is(step, step, role(step, middle..middle + 1));
                    if step == middle {
                        brighten(&mut shot.pixels, 1.6);
                    }
                    shot
                })
                .collect(),
            Self::Dark => {
                let (before, after, count) = (middle - 5, middle + 5, 30);
                let mut black = images[0].clone();
                brighten(&mut black, 0.02);
                let shots = (0..before).map(|step| as_it_is(step, step, Role::Unmeasured));
                let dark = (before..before + count).map(|sequence| Shot {
                    sequence: sequence as u64,
                    pixels: black.clone(),
                    steps: 0..0,
                    role: Role::Disturbed,
                });
                let shown = (after..images.len())
                    .map(|step| as_it_is(step, step - after + before + count, role(step, after..after + 1)));
                shots.chain(dark).chain(shown).collect()
            }
        }
    }
}

impl Press {
    /// Tracks the press with disturbed images.
    pub(super) fn follow_disturbed(&self, disturbance: Disturbance) -> Result<Outcome, ExperimentError> {
        let mut tracker = self.tracker()?;
        let mut outcome = Outcome::default();
        let mut before = self.truths[0].clone();
        for shot in disturbance.shots(&self.images) {
            let reading = tracker.track(&Self::frame(shot.sequence, &shot.pixels))?;
            let Some(last) = shot.steps.clone().last() else {
                outcome.black[0] += 1;
                outcome.black[1] += u64::from(reading.flags.iter().next().is_some());
                continue;
            };
            let truth = mean_truth(&self.truths[shot.steps.clone()]);
            let tally = match shot.role {
                Role::Disturbed => Some(&mut outcome.disturbed),
                Role::After => Some(&mut outcome.after),
                Role::Unmeasured => None,
            };
            if let Some(tally) = tally {
                tally.add(reading, &truth, &before, &self.regions[last], self.forces_n[last]);
            }
            before = truth;
        }
        Ok(outcome)
    }
}

/// The mean flow of some steps. A pixel is visible if it is visible in all of them; other fields are those of the last
/// step.
fn mean_truth(truths: &[Truth]) -> Truth {
    let mut mean = truths.last().expect("an image shows a step").clone();
    let share = 1.0 / truths.len() as f32;
    for (index, flow) in mean.flow.values_mut().iter_mut().enumerate() {
        *flow = [0, 1].map(|axis| truths.iter().map(|truth| truth.flow.values()[index][axis] * share).sum());
    }
    for (index, visible) in mean.visible.values_mut().iter_mut().enumerate() {
        *visible = truths.iter().map(|truth| truth.visible.values()[index]).min().unwrap_or(0);
    }
    mean
}

/// The mean of some images of one kind.
fn mean(images: &[Pixels]) -> Pixels {
    let levels: Vec<&Image<[u8; 3]>> = images.iter().filter_map(rgb8).collect();
    let mut mean = images.last().expect("an image shows a step").clone();
    if let Pixels::Rgb8(image) = &mut mean {
        for (index, pixel) in image.values_mut().iter_mut().enumerate() {
            for (channel, value) in pixel.iter_mut().enumerate() {
                let sum: usize = levels.iter().map(|image| usize::from(image.values()[index][channel])).sum();
                *value = ((sum + levels.len() / 2) / levels.len()) as u8;
            }
        }
    }
    mean
}

fn rgb8(pixels: &Pixels) -> Option<&Image<[u8; 3]>> {
    match pixels {
        Pixels::Rgb8(image) => Some(image),
        _ => None,
    }
}

/// Multiplies an 8-bit image by a factor.
fn brighten(pixels: &mut Pixels, factor: f32) {
    if let Pixels::Rgb8(image) = pixels {
        for value in image.values_mut().as_flattened_mut() {
            *value = (f32::from(*value) * factor).min(255.0).round() as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn images() -> Vec<Pixels> {
        (0..21).map(|step| Pixels::Rgb8(Image::filled(2, 1, [10 * step as u8, 100, 200]))).collect()
    }

    /// The first pixel's levels.
    fn levels(shot: &Shot) -> [u8; 3] {
        rgb8(&shot.pixels).unwrap().at(0, 0)
    }

    fn sequence(disturbance: Disturbance) -> Vec<u64> {
        disturbance.shots(&images()).iter().map(|shot| shot.sequence).collect()
    }

    #[test]
    fn an_image_blurred_by_motion_is_the_mean_of_half_the_time_between_two() {
        let shots = Disturbance::MotionBlur { pace: 4 }.shots(&images());
        assert_eq!(shots.len(), 6);
        assert_eq!(shots[0].pixels, images()[0]);
        assert_eq!(levels(&shots[1]), [30, 100, 200]);
        assert_eq!((shots[1].steps.clone(), shots[1].role), (2..5, Role::Disturbed));
    }

    #[test]
    fn missing_images_leave_a_gap_in_the_numbers() {
        assert_eq!(sequence(Disturbance::MissingImages), [0, 1, 2, 3, 4, 15, 16, 17, 18, 19, 20]);
        let shots = Disturbance::MissingImages.shots(&images());
        let roles: Vec<Role> = shots[4..8].iter().map(|shot| shot.role).collect();
        assert_eq!(roles, [Role::Unmeasured, Role::Disturbed, Role::Unmeasured, Role::After]);
    }

    #[test]
    fn a_flash_saturates_one_image_and_a_covered_lens_blackens_thirty() {
        let flash = Disturbance::Flash.shots(&images());
        assert_eq!(levels(&flash[10]), [160, 160, 255]);
        assert_eq!(flash[9].pixels, images()[9]);
        let dark = Disturbance::Dark.shots(&images());
        assert_eq!(sequence(Disturbance::Dark), (0..41).collect::<Vec<u64>>());
        assert!(dark[5..35].iter().all(|shot| shot.steps.is_empty() && levels(shot) == [0, 2, 4]));
        assert_eq!((dark[35].steps.clone(), dark[35].role, dark[37].role), (15..16, Role::Disturbed, Role::After));
    }
}
