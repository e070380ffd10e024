//! Figure 4: the flow with and without adaptive references.

use fingervision_flow::FlowField;
use fingervision_gel::Scene;
use fingervision_image::Image;
use fingervision_plot::HeatScale;
use fingervision_touch::Policy;
use rayon::prelude::*;
use serde::Serialize;

use super::{Lab, Setting, pictures};
use crate::end_point::{mean, quantile};
use crate::experiment::{ExperimentError, Following, Recording, follow_last};
use crate::page::{Cell, HtmlTable, Section};

const POLICIES: [(Policy, &str); 3] =
    [(Policy::Single, "one reference"), (Policy::Stack, "stack, as published"), (Policy::Anchored, "anchored")];

/// Errors of the flow in the last frame of a press.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReferenceErrors {
    /// The indenter.
    pub indenter: &'static str,
    /// Largest true displacement, px.
    pub true_peak_px: f64,
    /// One entry per policy.
    pub policies: Vec<PolicyErrors>,
}

/// Errors under one policy.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PolicyErrors {
    /// The policy.
    pub policy: &'static str,
    /// Mean end-point error over all visible pixels, px.
    pub mean_px: f64,
    /// 95th percentile of the end-point error, px.
    pub percentile_95_px: f64,
    /// Part of the pixels that are valid, 0 to 1.
    pub trusted: f64,
}

struct Measured {
    errors: ReferenceErrors,
    flows: Vec<Image<f32>>,
    truth: Image<f32>,
}

pub(super) fn measure(lab: &Lab) -> Result<(Vec<ReferenceErrors>, Section), ExperimentError> {
    let measured = lab.extent.indenters().par_iter().map(|name| indenter(lab, name)).collect::<Result<Vec<_>, _>>()?;
    let mut section = Section::new("references", "Figure 4: flow with and without adaptive references");
    section.text(
        "Length of the displacement in the last frame on the default sensor. The paper adds a new reference whenever the photometric \
         error of the coarse flow exceeds 10 grey levels, and shows that tracking with a single reference fails in a strong press. Here \
         a single reference is sufficient, because the flow starts from that of the previous frame and affine patches follow the \
         strain. A stack adds the errors of all references on it, which the paper does not measure. The default policy, anchored, \
         matches every frame with the first image.",
    );
    let mut table = HtmlTable::new(
        "Error of the displacement in the last frame over every visible pixel, px",
        ["indenter", "largest motion", "policy", "mean", "95 %", "valid"],
    );
    for Measured { errors, .. } in &measured {
        for (number, policy) in errors.policies.iter().enumerate() {
            let is_first = number == 0;
            let name = if is_first { errors.indenter } else { "" };
            let peak = if is_first { Cell::figure(errors.true_peak_px, 1) } else { Cell::text("") };
            let trusted = Cell::text(format!("{:.1} %", 100.0 * policy.trusted));
            let figures = [Cell::figure(policy.mean_px, 4), Cell::figure(policy.percentile_95_px, 4), trusted];
            table.row(name, [peak, Cell::text(policy.policy)].into_iter().chain(figures));
        }
    }
    section.table(table);
    for Measured { errors, flows, truth } in &measured {
        let scale = HeatScale::from_zero((errors.true_peak_px as f32).max(1.0).ceil());
        let mask = Image::filled(truth.width(), truth.height(), 1);
        let caption = |name: &str| format!("{}: {name}, {}", errors.indenter, pictures::bar_caption(scale, "px"));
        let maps: Vec<_> = flows.iter().chain([truth]).map(|flow| pictures::map(flow, &mask, scale)).collect();
        let names = POLICIES.iter().map(|(_, name)| *name).chain(["truth"]);
        section.gallery(4, maps.iter().zip(names.map(caption)))?;
    }
    Ok((measured.into_iter().map(|measured| measured.errors).collect(), section))
}

fn indenter(lab: &Lab, name: &'static str) -> Result<Measured, ExperimentError> {
    let recording = Recording::of(&Setting::Realistic.scene(Scene::find(name)?, lab.extent)?, lab.cache)?;
    let truth = &recording.truth.flow;
    let length = |x: usize, y: usize| {
        let [u, v] = truth.at(x, y);
        u.hypot(v)
    };
    let true_length = Image::from_fn(truth.width(), truth.height(), length);
    let peaks = true_length.values().iter().zip(recording.truth.visible.values()).filter(|(_, seen)| **seen != 0);
    let true_peak_px = f64::from(peaks.map(|(length, _)| *length).fold(0.0, f32::max));
    let (mut policies, mut flows) = (Vec::new(), Vec::new());
    for (policy, name) in POLICIES {
        let (errors, flow) = with_policy(&recording, policy, name)?;
        policies.push(errors);
        flows.push(flow);
    }
    Ok(Measured { errors: ReferenceErrors { indenter: name, true_peak_px, policies }, flows, truth: true_length })
}

fn with_policy(
    recording: &Recording,
    policy: Policy,
    name: &'static str,
) -> Result<(PolicyErrors, Image<f32>), ExperimentError> {
    let mut profile = recording.profile.clone();
    profile.references.policy = policy;
    follow_last(
        recording,
        &profile,
        Following::Dense,
        |_| (),
        |found| (errors(found.flow, found.valid, recording, name), lengths(found.flow)),
    )
}

fn errors(flow: &FlowField, valid: &Image<u8>, recording: &Recording, policy: &'static str) -> PolicyErrors {
    let truth = &recording.truth;
    let mut errors = Vec::new();
    let mut trusted = 0.0;
    for pixel in 0..valid.values().len() {
        let [u, v] = truth.flow.values()[pixel];
        if truth.visible.values()[pixel] != 0 && u.is_finite() {
            errors.push((flow.u.values()[pixel] - u).hypot(flow.v.values()[pixel] - v));
            trusted += f64::from(valid.values()[pixel]);
        }
    }
    PolicyErrors {
        policy,
        mean_px: mean(errors.iter().copied()),
        percentile_95_px: quantile(errors.iter().copied(), 0.95),
        trusted: trusted / errors.len() as f64,
    }
}

fn lengths(flow: &FlowField) -> Image<f32> {
    Image::from_fn(flow.u.width(), flow.u.height(), |x, y| flow.u.at(x, y).hypot(flow.v.at(x, y)))
}
