//! Compares the fields of one frame after another.

use fingervision_image::Rect;

use super::array::FrameArray;
use super::correlation::Correlation;
use super::fields::{DEPTH_MASK, Fields};
use super::inputs::Inputs;
use super::judgement::{Judged, Judgement, bit, is_finite};
use super::tally::Tally;
use super::{Components, Errors, FieldErrors, PixelCounts, Region, Regions, RunError};

/// Adds up the errors of all frames.
#[derive(Debug)]
pub(super) struct Comparer {
    /// For each pixel of the run, its place in the truth's arrays.
    on_truth: Vec<usize>,
    /// 1 where the truth is visible, on the run's grid.
    seen: Vec<u8>,
    /// Where the flow is compared, and all other fields without a separate mask.
    judged: Judgement,
    /// Where depth, displacement and contact are compared, if the run has a separate mask for them.
    depth_judged: Option<Judgement>,
    flow: Option<[Tally; 4]>,
    depth: Option<[Tally; 4]>,
    depth_where_valid: Option<[Tally; 4]>,
    displacement: Option<[Tally; 3]>,
    overlap: Overlap,
    peaks: Correlation,
}

/// Pixels in both masks, and in either.
#[derive(Debug, Clone, Copy, Default)]
struct Overlap {
    both: u64,
    either: u64,
}

impl Overlap {
    fn part(self) -> Option<f64> {
        (self.either > 0).then(|| self.both as f64 / self.either as f64)
    }
}

impl Comparer {
    pub(super) fn new(inputs: &Inputs) -> Self {
        let Rect { x, y, width, height } = inputs.place;
        let columns = inputs.truth.size().0;
        let on_truth: Vec<_> = (y..y + height).flat_map(|y| (x..x + width).map(move |x| y * columns + x)).collect();
        let tallies = || [(); 4].map(|()| Tally::new());
        let has_own = inputs.run.depth_mask.is_some();
        Self {
            seen: vec![0; on_truth.len()],
            judged: Judgement::new(on_truth.len()),
            depth_judged: has_own.then(|| Judgement::new(on_truth.len())),
            depth_where_valid: (has_own && inputs.run.depth.is_some()).then(tallies),
            on_truth,
            flow: inputs.run.flow.is_some().then(tallies),
            depth: inputs.run.depth.is_some().then(tallies),
            displacement: inputs.run.displacement.is_some().then(|| [(); 3].map(|()| Tally::new())),
            overlap: Overlap::default(),
            peaks: Correlation::default(),
        }
    }

    /// 1 where the truth of the last frame is visible, on the run's grid.
    pub(super) fn seen(&self) -> &[u8] {
        &self.seen
    }

    /// 1 where the flow of the last frame is valid.
    pub(super) fn valid(&self) -> &[u8] {
        &self.judged.valid
    }

    /// 1 where the depth of the last frame is valid.
    pub(super) fn depth_valid(&self) -> &[u8] {
        &self.depth_judged.as_ref().unwrap_or(&self.judged).valid
    }

    /// For each pixel of the run, its place in the truth's arrays.
    pub(super) fn on_truth(&self) -> &[usize] {
        &self.on_truth
    }

    /// The errors of the frame that was just read.
    pub(super) fn compare(&mut self, inputs: &mut Inputs, frame: u64) -> Result<FieldErrors, RunError> {
        self.judge_truth(&inputs.truth);
        self.judge_estimate(&inputs.run, frame)?;
        let (pixels, depth_pixels) = self.assign_regions(inputs);
        let Inputs { run, truth, .. } = inputs;
        let overlap = self.measure_overlap(run, truth);
        let flow_px = self.compare_flow(run, truth);
        let (depth_mm, depth_where_valid_mm) = self.compare_depth(run, truth);
        let displacement_mm = self.compare_displacement(run, truth);
        if let Some(Errors { estimated_peak, true_peak, .. }) = depth_mm.and_then(|depth| depth.everywhere) {
            self.peaks.push(estimated_peak, true_peak);
        }
        let contact_overlap = overlap.part();
        Ok(FieldErrors {
            pixels,
            flow_px,
            depth_pixels,
            depth_mm,
            depth_where_valid_mm,
            displacement_mm,
            contact_overlap,
        })
    }

    /// The errors over all pixels of all frames.
    pub(super) fn pooled(&self) -> FieldErrors {
        let pooled = |tallies: &[Tally; 4]| Regions::from_fn(|region| tallies[region as usize].pooled());
        FieldErrors {
            pixels: self.judged.pixels(),
            flow_px: self.flow.as_ref().map(pooled),
            depth_pixels: self.depth_judged.as_ref().map(Judgement::pixels),
            depth_mm: self.depth.as_ref().map(pooled),
            depth_where_valid_mm: self.depth_where_valid.as_ref().map(pooled),
            displacement_mm: self.displacement.as_ref().map(|tallies| {
                let [x, y, z] = [0, 1, 2].map(|axis: usize| tallies[axis].pooled());
                Components { x, y, z }
            }),
            contact_overlap: self.overlap.part(),
        }
    }

    /// Correlation of the largest estimated with the largest true depth over the frames.
    pub(super) fn peak_depth_correlation(&self) -> Option<f64> {
        self.peaks.coefficient()
    }

    fn judge_truth(&mut self, truth: &Fields) {
        let visible = truth.mask.as_ref().map(FrameArray::values);
        let (flow, depth) = (truth.flow.as_ref().map(FrameArray::values), truth.depth.as_ref().map(FrameArray::values));
        let displacement = truth.displacement.as_ref().map(FrameArray::values);
        for (seen, &at) in self.seen.iter_mut().zip(&self.on_truth) {
            let is_seen = visible.is_none_or(|visible| visible[at] != 0)
                && is_finite(flow, 2, at)
                && is_finite(depth, 1, at)
                && is_finite(displacement, 3, at);
            *seen = u8::from(is_seen);
        }
    }

    fn judge_estimate(&mut self, run: &Fields, frame: u64) -> Result<(), RunError> {
        let (flow, depth) = ((run.flow.as_ref(), 2), [(run.depth.as_ref(), 1), (run.displacement.as_ref(), 3)]);
        let (mask, mask_name) = (run.mask.as_ref(), "valid.npy");
        let Some(depth_judged) = &mut self.depth_judged else {
            let [depth, displacement] = depth;
            return self.judged.judge(&Judged { mask, mask_name, arrays: &[flow, depth, displacement] }, frame);
        };
        self.judged.judge(&Judged { mask, mask_name, arrays: &[flow] }, frame)?;
        let (mask, mask_name) = (run.depth_mask.as_ref(), DEPTH_MASK);
        depth_judged.judge(&Judged { mask, mask_name, arrays: &depth }, frame)
    }

    /// Sets the regions of each pixel that is compared, and counts the others: for the mask of the flow, and for that
    /// of depth if there is a separate one.
    fn assign_regions(&mut self, inputs: &mut Inputs) -> (Regions<PixelCounts>, Option<Regions<PixelCounts>>) {
        let Inputs { truth, band, .. } = inputs;
        let contact = truth.contact.as_ref().map(FrameArray::values);
        let (flow, depth) = (truth.flow.as_ref().map(FrameArray::values), truth.depth.as_ref().map(FrameArray::values));
        let is_gel = |at| is_finite(flow, 2, at) && is_finite(depth, 1, at);
        let near = contact.zip(band.as_mut()).map(|(contact, band)| band.find(contact, is_gel));
        let Self { on_truth, seen, judged, depth_judged, .. } = self;
        let regions = |i: usize| {
            let at = on_truth[i];
            regions_of(contact.map(|contact| contact[at] != 0), near.map(|near| near[at]))
        };
        (judged.assign(seen, regions), depth_judged.as_mut().map(|judged| judged.assign(seen, regions)))
    }

    /// The regions of the pixels where depth, displacement and contact are compared.
    fn depth_regions(&self) -> &[u8] {
        &self.depth_judged.as_ref().unwrap_or(&self.judged).regions
    }

    fn measure_overlap(&mut self, run: &Fields, truth: &Fields) -> Overlap {
        let mut overlap = Overlap::default();
        if let (Some(run), Some(truth)) = (&run.contact, &truth.contact) {
            let compared = self
                .depth_regions()
                .iter()
                .zip(&self.on_truth)
                .zip(run.values())
                .filter(|((region, _), _)| **region != 0);
            for ((_, &at), &estimate) in compared {
                let (estimate, truth) = (estimate != 0, truth.values()[at] != 0);
                overlap.both += u64::from(estimate && truth);
                overlap.either += u64::from(estimate || truth);
            }
        }
        self.overlap.both += overlap.both;
        self.overlap.either += overlap.either;
        overlap
    }

    fn compare_flow(&mut self, run: &Fields, truth: &Fields) -> Option<Regions> {
        let (run, truth) = (run.flow.as_ref()?.values(), truth.flow.as_ref()?.values());
        let tallies = self.flow.as_mut()?;
        let vector = |values: &[f32], at: usize| [f64::from(values[2 * at]), f64::from(values[2 * at + 1])];
        for (i, (&regions, &at)) in self.judged.regions.iter().zip(&self.on_truth).enumerate() {
            if regions != 0 {
                let ([u, v], [true_u, true_v]) = (vector(run, i), vector(truth, at));
                push(tallies, regions, u.hypot(v), true_u.hypot(true_v), (u - true_u).hypot(v - true_v));
            }
        }
        Some(end_frame(tallies))
    }

    /// The errors over all pixels with valid depth, and over those of them whose flow is also valid.
    fn compare_depth(&mut self, run: &Fields, truth: &Fields) -> (Option<Regions>, Option<Regions>) {
        let (Some(run), Some(truth), Some(tallies)) = (&run.depth, &truth.depth, &mut self.depth) else {
            return (None, None);
        };
        let (run, truth) = (run.values(), truth.values());
        let judged = self.depth_judged.as_ref().unwrap_or(&self.judged);
        for (i, (&regions, &at)) in judged.regions.iter().zip(&self.on_truth).enumerate() {
            if regions == 0 {
                continue;
            }
            let (depth, true_depth) = (f64::from(run[i]), f64::from(truth[at]));
            push(tallies, regions, depth, true_depth, (depth - true_depth).abs());
            if let Some(tallies) = self.depth_where_valid.as_mut().filter(|_| self.judged.valid[i] != 0) {
                push(tallies, regions, depth, true_depth, (depth - true_depth).abs());
            }
        }
        (Some(end_frame(tallies)), self.depth_where_valid.as_mut().map(end_frame))
    }

    fn compare_displacement(&mut self, run: &Fields, truth: &Fields) -> Option<Components> {
        let (run, truth) = (run.displacement.as_ref()?.values(), truth.displacement.as_ref()?.values());
        let tallies = self.displacement.as_mut()?;
        let judged = self.depth_judged.as_ref().unwrap_or(&self.judged);
        for (i, (&regions, &at)) in judged.regions.iter().zip(&self.on_truth).enumerate() {
            if regions != 0 {
                for (axis, tally) in tallies.iter_mut().enumerate() {
                    let (value, true_value) = (f64::from(run[3 * i + axis]), f64::from(truth[3 * at + axis]));
                    tally.push(value, true_value, (value - true_value).abs());
                }
            }
        }
        let [x, y, z] = tallies.each_mut().map(Tally::end_frame);
        Some(Components { x, y, z })
    }
}

/// The regions of a pixel that is in contact or not, near its border or not, if that is known.
fn regions_of(contact: Option<bool>, near: Option<bool>) -> u8 {
    let region = |region, is_there: bool| if is_there { bit(region) } else { 0 };
    bit(Region::Everywhere)
        | region(Region::Inside, contact == Some(true))
        | region(Region::Border, near == Some(true))
        | region(Region::Outside, contact == Some(false) && near == Some(false))
}

/// Adds a pixel to the statistics of its regions.
fn push(tallies: &mut [Tally; 4], regions: u8, estimate: f64, truth: f64, error: f64) {
    for (region, tally) in Region::ALL.into_iter().zip(tallies) {
        if regions & bit(region) != 0 {
            tally.push(estimate, truth, error);
        }
    }
}

fn end_frame(tallies: &mut [Tally; 4]) -> Regions {
    let mut tallies = tallies.iter_mut();
    Regions::from_fn(|_| tallies.next()?.end_frame())
}
