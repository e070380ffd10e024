//! Figure 1b: the pattern. Figure 2: the density of displaced points.

use fingervision_flow::FlowField;
use fingervision_gel::{Motion, Scene, Simulation};
use fingervision_image::{Image, Pixels};
use fingervision_plot::HeatScale;
use fingervision_touch::{DensityEstimator, DensityField, DensityParams};
use std::ops::ControlFlow;

use super::{Lab, pictures, published};
use crate::experiment::ExperimentError;
use crate::page::Section;

/// Part of the camera's image that is shown, px.
const CROP: usize = 96;
const SIZE: usize = 240;

/// Figure 1b.
pub(super) fn section(lab: &Lab) -> Result<Section, ExperimentError> {
    let mut scene = Scene::find("board")?;
    scene.set_all([("camera.rotation_rad", "[0.0, 0.0, 0.0]")])?;
    let mut simulation = Simulation::new(&scene)?;
    simulation.solve(lab.cache, &mut |_| ControlFlow::Continue(()))?;
    let mut section = Section::new("pattern", "Figure 1b: the pattern");
    section.text(format!(
        "Every cell has a random colour at least {} from those of its eight neighbours in RGB, as published. Cells are 0.1 mm \
         wide here, 1.6 px in the image; the paper prints no size.",
        published::COLOUR_DISTANCE
    ));
    if let Pixels::Rgb8(image) = simulation.frame(0)? {
        let (x, y) = ((image.width() - CROP) / 2, (image.height() - CROP) / 2);
        let crop = Image::from_fn(CROP, CROP, |column, row| image.at(x + column, y + row));
        section
            .picture(&crop, format!("The camera's image of the pattern at rest, {CROP}×{CROP} px of it, enlarged."))?;
    }
    Ok(section)
}

/// Figure 2.
pub(super) fn density_section() -> Result<Section, ExperimentError> {
    let centre_px = [0.5 * (SIZE - 1) as f64; 2];
    let motion = Motion::RadialBump { centre_px, radius_px: 40.0, amplitude_px: 8.0 };
    let truth = motion.flow(SIZE, SIZE);
    let flow = FlowField { u: truth.u.clone(), v: truth.v.clone() };
    let params = DensityParams::default();
    let mut field = DensityField::at_rest(SIZE, SIZE);
    DensityEstimator::new(SIZE, SIZE, &params)?.estimate_into(&flow, &mut field);
    let mut section = Section::new("density", "Figure 2: density of displaced points");
    section.text(format!(
        "A Gaussian with σ = {} px is placed at the moved point of every pixel; where the surface expands, their sum is smaller than \
         in the gel at rest. The feature is 1 − density: 0 at rest, positive where the surface expands. The paper cuts the Gaussian at \
         3σ; here it is splatted with cubic B-splines, which is within 0.0005 of the full sum.",
        params.sigma_px
    ));
    let scale = HeatScale::around_zero(0.5);
    let mask = Image::filled(SIZE, SIZE, 1);
    section.gallery(
        2,
        [
            (&dots(&flow), "Every eighth point of a round bump, displaced.".to_owned()),
            (
                &pictures::map(&field.feature, &mask, scale),
                format!("Its density feature, dimensionless: {}.", pictures::bar_caption(scale, "from blue to red")),
            ),
        ],
    )?;
    Ok(section)
}

/// Displaced points as dark dots.
fn dots(flow: &FlowField) -> Image<[u8; 3]> {
    const PITCH: usize = 8;
    let mut image = Image::filled(SIZE, SIZE, [255; 3]);
    for (x, y) in (0..SIZE).step_by(PITCH).flat_map(|y| (0..SIZE).step_by(PITCH).map(move |x| (x, y))) {
        let place = [x as f32 + flow.u.at(x, y), y as f32 + flow.v.at(x, y)].map(|value| value.round() as i64);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let [column, row] = [place[0] + dx, place[1] + dy].map(usize::try_from);
            if let (Ok(column @ 0..SIZE), Ok(row @ 0..SIZE)) = (column, row) {
                image.row_mut(row)[column] = [32, 33, 36];
            }
        }
    }
    image
}
