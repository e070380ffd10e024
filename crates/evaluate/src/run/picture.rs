//! The picture of a comparison: the fields of its deepest frame and the errors over all frames.

use fingervision_flow::FlowField;
use fingervision_image::Image;
use fingervision_plot::{Comparison, FramePlot, Pair};

use super::compare::Comparer;
use super::inputs::Inputs;
use super::report::{Errors, FieldErrors, Region, Regions, Report};
use super::text::{percent, region_name};

/// Copies of one frame's fields, all on the run's grid.
#[derive(Debug)]
pub(super) struct Shown {
    flow: Option<Compared<FlowField>>,
    depth: Option<Compared<Image<f32>>>,
    seen: Image<u8>,
    valid: Image<u8>,
    depth_valid: Image<u8>,
    contact: Option<Image<u8>>,
}

#[derive(Debug)]
struct Compared<T> {
    truth: T,
    estimate: T,
}

impl<T> Compared<T> {
    fn pair(&self) -> Pair<'_, T> {
        Pair { truth: &self.truth, estimate: &self.estimate }
    }
}

impl Shown {
    /// Allocates memory for the fields that are compared.
    pub(super) fn new(inputs: &Inputs) -> Self {
        let (width, height) = (inputs.place.width, inputs.place.height);
        let (run, truth) = (&inputs.run, &inputs.truth);
        let mask = || Image::filled(width, height, 0);
        let flow = || FlowField::zero(width, height);
        let depth = || Image::filled(width, height, 0.0);
        Self {
            flow: run.flow.is_some().then(|| Compared { truth: flow(), estimate: flow() }),
            depth: run.depth.is_some().then(|| Compared { truth: depth(), estimate: depth() }),
            seen: mask(),
            valid: mask(),
            depth_valid: mask(),
            contact: truth.contact.is_some().then(mask),
        }
    }

    /// Copies the fields of the frame that was just compared.
    pub(super) fn copy_from(&mut self, inputs: &Inputs, comparer: &Comparer) {
        let on_truth = comparer.on_truth();
        let (run, truth) = (&inputs.run, &inputs.truth);
        if let (Some(shown), Some(run), Some(truth)) = (&mut self.flow, &run.flow, &truth.flow) {
            copy_flow(&mut shown.truth, truth.values(), |i| on_truth[i]);
            copy_flow(&mut shown.estimate, run.values(), |i| i);
        }
        if let (Some(shown), Some(run), Some(truth)) = (&mut self.depth, &run.depth, &truth.depth) {
            fill(&mut shown.truth, |i| truth.values()[on_truth[i]]);
            shown.estimate.values_mut().copy_from_slice(run.values());
        }
        if let (Some(shown), Some(truth)) = (&mut self.contact, &truth.contact) {
            fill(shown, |i| truth.values()[on_truth[i]]);
        }
        self.seen.values_mut().copy_from_slice(comparer.seen());
        self.valid.values_mut().copy_from_slice(comparer.valid());
        self.depth_valid.values_mut().copy_from_slice(comparer.depth_valid());
    }

    pub(super) fn draw(&self, report: &Report) -> Image<[u8; 3]> {
        let comparison = Comparison {
            title: &title(report),
            facts: &facts(report),
            depth_mm: self.depth.as_ref().map(Compared::pair),
            flow_px: self.flow.as_ref().map(Compared::pair),
            seen: &self.seen,
            valid: &self.valid,
            depth_valid: &self.depth_valid,
            contact: self.contact.as_ref(),
            shown_frame: report.deepest_frame as usize,
            plots: &plots(report),
        };
        comparison.draw()
    }
}

fn fill<T>(image: &mut Image<T>, value: impl Fn(usize) -> T) {
    for (i, pixel) in image.values_mut().iter_mut().enumerate() {
        *pixel = value(i);
    }
}

fn copy_flow(flow: &mut FlowField, values: &[f32], at: impl Fn(usize) -> usize) {
    fill(&mut flow.u, |i| values[2 * at(i)]);
    fill(&mut flow.v, |i| values[2 * at(i) + 1]);
}

fn title(report: &Report) -> String {
    let frame = report.deepest_frame;
    let deepest = report.deepest();
    match deepest.and_then(|deepest| deepest.true_depth_mm) {
        Some(depth) => format!("Frame {frame}, the deepest: {depth:.2} mm"),
        None => match deepest.and_then(|deepest| deepest.true_flow_px) {
            Some(flow) => format!("Frame {frame}, the farthest moved: {flow:.1} px"),
            None => format!("Frame {frame}: no truth is seen"),
        },
    }
}

/// The deepest frame's results in one line.
fn facts(report: &Report) -> String {
    let Some(deepest) = report.deepest() else { return String::new() };
    let FieldErrors { pixels, depth_pixels, flow_px, depth_mm, .. } = deepest.errors;
    let pixels = depth_pixels.unwrap_or(pixels);
    let by_region = Region::ALL.into_iter().filter_map(|region| {
        let error = depth_mm.as_ref()?.get(region)?.mean;
        let name = if region == Region::Everywhere { "of depth".into() } else { region_name(region, report.border_mm) };
        Some(format!("{name} {error:.3} mm"))
    });
    let depth: Vec<String> = by_region.collect();
    let flow = flow_px.and_then(|flow| flow.everywhere).map(|errors| format!("of flow {:.3} px", errors.mean));
    let means: Vec<String> = (!depth.is_empty()).then(|| depth.join(", ")).into_iter().chain(flow).collect();
    let compared = [(Region::Everywhere, "the pixels"), (Region::Border, "those near the border")];
    let compared = compared.into_iter().filter_map(|(region, name)| {
        let pixels = pixels.get(region)?;
        Some(format!("{} of {name}", percent(pixels.compared, pixels.all())))
    });
    let compared: Vec<String> = compared.collect();
    format!("Mean error {}  ·  compared {}", means.join("  ·  "), compared.join(", "))
}

fn plots(report: &Report) -> Vec<FramePlot> {
    let line = |name: String, value: &dyn Fn(&FieldErrors) -> Option<f64>| {
        // One value for each number up to the last one: a run may have gaps.
        let count = report.per_frame.last().map_or(0, |last| last.frame + 1);
        let mut values = vec![f32::NAN; usize::try_from(count).unwrap_or_default()];
        for frame in &report.per_frame {
            values[frame.frame as usize] = value(&frame.errors).map_or(f32::NAN, |value| value as f32);
        }
        (name, values)
    };
    let of = |regions: Option<Regions>, region| regions.as_ref().and_then(|regions| regions.get(region)).copied();
    let has_values = |(_, values): &(String, Vec<f32>)| values.iter().any(|value| value.is_finite());
    let depth_lines = [Region::Inside, Region::Border, Region::Outside, Region::Everywhere]
        .map(|region| line(region_name(region, report.border_mm), &|errors| Some(of(errors.depth_mm, region)?.mean)));
    let flow_line = |name: &str, figure: fn(&Errors) -> f64| {
        line(name.into(), &|errors| Some(figure(&of(errors.flow_px, Region::Everywhere)?)))
    };
    let flow_lines =
        [flow_line("mean", |errors| errors.mean), flow_line("95th percentile", |errors| errors.percentile_95)];
    let plot = |heading: &str, lines: Vec<_>| (!lines.is_empty()).then(|| FramePlot { heading: heading.into(), lines });
    let depth = plot("Mean error of depth, mm", depth_lines.into_iter().filter(has_values).collect());
    let flow = plot("Error of flow, px", flow_lines.into_iter().filter(has_values).collect());
    depth.into_iter().chain(flow).collect()
}
