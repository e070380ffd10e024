//! Decides from the first motion of the gel whether the first image showed it at rest or pressed.
//!
//! The direction of motion along the surface does not decide: nearly incompressible gel is pushed outwards and
//! compressible gel is drawn inwards, so a press of one looks like a release of the other. Two observations decide for
//! every gel. They follow from perspective: a pressed surface comes nearer to the camera, and a point that comes nearer
//! moves away from the centre of perspective in the image.
//!
//! - **Far from contact**, all around it, a press moves the surface outwards or not at all, for any Poisson's ratio. A
//!   release moves it inwards.
//! - **The face**, where motion is largest, is scaled about the centre of perspective. A press shifts it away from the
//!   centre and magnifies it; a release shifts it back and makes it smaller by the same factor. Shear shifts it without
//!   magnification.
//!
//! Each of them can show a press or a release. If neither decides, the next frame is tested.

use fingervision_flow::Estimate;

use super::thresholds::THRESHOLDS;

/// Distance between samples along both axes, px.
const STEP: usize = 8;

/// The state of the gel in the first image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FirstImage {
    AtRest,
    Pressed,
}

/// Position and flow of one sample, px.
#[derive(Debug, Clone, Copy)]
struct Sample {
    at: [f32; 2],
    flow: [f32; 2],
}

/// Tests flows from the first image; keeps its scratch memory.
#[derive(Debug)]
pub(super) struct FirstMotion {
    /// The centre of perspective, px.
    centre_px: [f32; 2],
    samples: Vec<Sample>,
}

impl FirstMotion {
    /// For a camera with this centre of perspective, px.
    pub(super) fn new(centre_px: [f32; 2]) -> Self {
        Self { centre_px, samples: Vec::new() }
    }

    /// The state of the gel in the first image according to a flow; none if little moves or the motion does not decide.
    pub(super) fn judge(&mut self, estimate: &Estimate) -> Option<FirstImage> {
        // Most gels are at rest for many frames before anything moves.
        if count_moving(estimate) < THRESHOLDS.least_moving {
            return None;
        }
        self.take(estimate);
        let moving = || self.samples.iter().filter(|sample| moves(sample.flow));
        let weight: f32 = moving().map(Sample::length).sum();
        let middle = [0, 1].map(|axis| moving().map(|sample| sample.length() * sample.at[axis]).sum::<f32>() / weight);
        let largest = moving().map(Sample::length).fold(0.0, f32::max);
        let outwards = self.outwards();
        let far_px = far_from(&mut self.samples, middle);
        let limit_px = THRESHOLDS.least_far_px.max(THRESHOLDS.least_far * largest);
        if outwards.abs() > THRESHOLDS.certain && far_px.abs() > limit_px && (outwards > 0.0) == (far_px > 0.0) {
            return Some(if far_px > 0.0 { FirstImage::AtRest } else { FirstImage::Pressed });
        }
        let half_height = 0.5 * estimate.flow.size().1 as f32;
        let scale = self.scale_of_face(largest, THRESHOLDS.least_aside * half_height)?;
        // The surroundings must not contradict this.
        let is_denied = far_px.abs() > limit_px && (scale > 0.0) != (far_px > 0.0);
        let says = if scale > 0.0 { FirstImage::AtRest } else { FirstImage::Pressed };
        (!is_denied).then_some(says)
    }

    fn take(&mut self, Estimate { flow, valid, .. }: &Estimate) {
        let (width, height) = flow.size();
        let pixels = (0..height).step_by(STEP).flat_map(|y| (0..width).step_by(STEP).map(move |x| (x, y)));
        let measured = pixels.filter(|&(x, y)| valid.at(x, y) == 1);
        let sample =
            |(x, y): (usize, usize)| Sample { at: [x as f32, y as f32], flow: [flow.u.at(x, y), flow.v.at(x, y)] };
        self.samples.clear();
        self.samples.extend(measured.map(sample));
    }

    /// `Σ f·(x − p) / Σ |f| |x − p|` over the moving samples, about the centre of perspective `p`.
    fn outwards(&self) -> f32 {
        let moving = self.samples.iter().filter(|sample| moves(sample.flow));
        let (along, all) = moving.fold((0.0, 0.0), |(along, all), sample| {
            let [x, y] = sample.from(self.centre_px);
            (along + sample.flow[0] * x + sample.flow[1] * y, all + sample.length() * x.hypot(y))
        });
        if all > 0.0 { along / all } else { 0.0 }
    }

    /// Magnification minus 1 of a face that is scaled about the centre of perspective; none if its motion is not such a
    /// scaling.
    fn scale_of_face(&self, largest: f32, least_aside: f32) -> Option<f32> {
        let least = THRESHOLDS.motion_px.max(THRESHOLDS.face * largest);
        let face = || self.samples.iter().filter(|sample| sample.length() > least);
        let count = face().count() as f32;
        let mean = |value: &dyn Fn(&Sample) -> f32| face().map(value).sum::<f32>() / count;
        let middle = [0, 1].map(|axis| mean(&|sample| sample.at[axis]));
        let shift = [0, 1].map(|axis| mean(&|sample| sample.flow[axis]));
        let spread = mean(&|sample| sample.from(middle).iter().map(|x| x * x).sum());
        let scale = mean(&|sample| dot(sample.from(middle), sample.flow)) / spread;
        let left = mean(&|sample| {
            let [x, y] = sample.from(middle);
            (sample.flow[0] - shift[0] - scale * x).powi(2) + (sample.flow[1] - shift[1] - scale * y).powi(2)
        });
        let aside = [middle[0] - self.centre_px[0], middle[1] - self.centre_px[1]];
        let distance = aside[0].hypot(aside[1]);
        let outwards = dot(shift, aside) / distance;
        let is_scaled = distance > least_aside
            && left.sqrt() < THRESHOLDS.most_unexplained * largest
            && outwards.abs() > THRESHOLDS.least_aligned * shift[0].hypot(shift[1])
            && (THRESHOLDS.shift_by_scale[0]..THRESHOLDS.shift_by_scale[1]).contains(&(outwards / (scale * distance)));
        is_scaled.then_some(scale)
    }
}

impl Sample {
    fn length(&self) -> f32 {
        self.flow[0].hypot(self.flow[1])
    }

    fn from(&self, place: [f32; 2]) -> [f32; 2] {
        [self.at[0] - place[0], self.at[1] - place[1]]
    }
}

fn dot(a: [f32; 2], b: [f32; 2]) -> f32 {
    a[0] * b[0] + a[1] * b[1]
}

/// Whether a flow, px, counts as motion.
fn moves([u, v]: [f32; 2]) -> bool {
    u * u + v * v > THRESHOLDS.motion_px.powi(2)
}

/// The number of samples that move.
fn count_moving(Estimate { flow, valid, .. }: &Estimate) -> usize {
    let mut count = 0;
    for y in (0..flow.size().1).step_by(STEP) {
        let row = flow.u.row(y).iter().zip(flow.v.row(y)).zip(valid.row(y)).step_by(STEP);
        count += row.filter(|((u, v), valid)| **valid == 1 && moves([**u, **v])).count();
    }
    count
}

/// Mean motion away from a point, px, over the farther half of the samples.
fn far_from(samples: &mut [Sample], place: [f32; 2]) -> f32 {
    let distance = |sample: &Sample| {
        let [x, y] = sample.from(place);
        x.hypot(y)
    };
    let half = samples.len() / 2;
    let (_, _, farther) = samples.select_nth_unstable_by(half, |a, b| distance(a).total_cmp(&distance(b)));
    let outwards = |sample: &Sample| dot(sample.from(place), sample.flow) / distance(sample);
    farther.iter().map(outwards).sum::<f32>() / farther.len().max(1) as f32
}

#[cfg(test)]
mod tests;
