//! Table I: the camera from a sliding board.

use fingervision_calibrate::camera::{BoardTracker, CameraFit, FitOptions, Priors, Residuals, Slide, fit_camera};
use fingervision_gel::Scene;
use fingervision_image::{Image, Rect};
use fingervision_optics::Camera;
use fingervision_plot::HeatScale;
use serde::Serialize;

use super::{Lab, pictures, published};
use crate::experiment::{ExperimentError, Recording};
use crate::page::{Cell, HtmlTable, Section};

/// The board's step from image to image, mm.
const STEP_MM: f64 = 0.5;

/// The camera's residuals, and the difference of its flow from that of the true camera.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TableOne {
    /// Residual of the camera before the fit.
    pub before: Residuals,
    /// Residual of the fitted camera.
    pub after: Residuals,
    /// Residual of the fitted camera on the test nodes, which were not used for the fit.
    pub test: Residuals,
    /// Mean distance between the flow that the fitted and the true camera predict, over the grid, px.
    pub from_truth_px: f64,
}

pub(super) fn measure(lab: &Lab) -> Result<(TableOne, Section), ExperimentError> {
    let scene = Scene::find("board")?;
    let recording = Recording::of(&scene, lab.cache)?;
    let (width, height) = recording.size();
    let mut tracker = BoardTracker::new(Rect::whole(width, height), true, &recording.profile.flow)?;
    for frame in recording.frames() {
        tracker.push(&frame)?;
    }
    let slide = Slide { step_mm: STEP_MM, direction_rad: 0.0 };
    let flow = tracker.finish(slide, None)?;
    let middle = [0.5 * (width as f64 - 1.0), 0.5 * (height as f64 - 1.0)];
    let fit = fit_camera(std::slice::from_ref(&flow), &Priors::weak(width, middle), FitOptions::default())?;
    let table = TableOne {
        before: fit.table.before,
        after: fit.table.after,
        test: fit.table.test,
        from_truth_px: from_truth_px(&scene, &fit, slide, flow.nodes.iter().map(|node| node.px)),
    };
    let section = section(&table, &fit)?;
    Ok((table, section))
}

fn from_truth_px(scene: &Scene, fit: &CameraFit, slide: Slide, pixels: impl Iterator<Item = [f64; 2]>) -> f64 {
    let (Ok(truth), Ok(fitted)) = (Camera::new(&scene.camera()), Camera::new(&fit.params)) else { return f64::NAN };
    let step = slide.step_vector_mm();
    let flow = |camera, px| fingervision_calibrate::camera::board_flow(camera, px, step);
    let distances: Vec<f64> = pixels
        .filter_map(|px| {
            let ([u, v], [true_u, true_v]) = (flow(&fitted, px)?, flow(&truth, px)?);
            Some((u - true_u).hypot(v - true_v))
        })
        .collect();
    distances.iter().sum::<f64>() / distances.len() as f64
}

fn section(table: &TableOne, fit: &CameraFit) -> Result<Section, ExperimentError> {
    let mut section = Section::new("camera", "Table I: camera calibration");
    section.text(
        "A rigid board under a slanted camera with a distorting lens slides in 20 steps of 0.5 mm; the flow from image to image is \
         averaged on a 100×100 grid, 80 % of which is fitted. “Before” is the plain camera: upright, without distortion, with the scale of \
         the mean flow. The paper does not name its unit; compare the ratios.",
    );
    let mut rows =
        HtmlTable::new("Length of the residual", ["", "before", "after", "test", "after / before", "test / after"]);
    let mut row = |name: &str, [before, after, test]: [f64; 3], decimals| {
        let figures = [before, after, test].map(|value| Cell::figure(value, decimals));
        rows.row(name, figures.into_iter().chain([Cell::figure(after / before, 2), Cell::figure(test / after, 2)]));
    };
    let all = [&table.before, &table.after, &table.test];
    row("mean, px", all.map(|residuals| residuals.mean_px), 5);
    row("standard deviation, px", all.map(|residuals| residuals.deviation_px), 5);
    row("mean, paper", published::RESIDUAL_MEAN, 5);
    row("standard deviation, paper", published::RESIDUAL_DEVIATION, 5);
    section.table(rows);
    section.text(format!(
        "The flow that the fitted camera predicts is {:.4} px from the true camera's on average. A slide in one direction does not \
         determine every unknown; the report of calibrate camera names those that it does not.",
        table.from_truth_px
    ));
    if let Some(map) = fit.maps.first() {
        let highest = map.before_px.values().iter().copied().filter(|value| value.is_finite()).fold(0.0, f32::max);
        let scale = HeatScale::from_zero((10.0 * highest).ceil().max(1.0) / 10.0);
        let mask = |values: &Image<f32>| {
            Image::from_fn(values.width(), values.height(), |x, y| u8::from(values.at(x, y).is_finite()))
        };
        let shown = [(&map.before_px, "before"), (&map.after_px, "after")]
            .map(|(values, name)| (fingervision_plot::heat_map(values, &mask(values), scale), name));
        let caption = |name| format!("Residual {name}, {}", pictures::bar_caption(scale, "px"));
        section.gallery(2, shown.iter().map(|(map, name)| (map, caption(name))))?;
    }
    Ok(section)
}
