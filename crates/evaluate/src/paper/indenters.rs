//! Figures 6 and 7: depth maps of four indenters, by the dense pattern and by dots, against the truth; and depth from
//! elasticity from the same flow.

use fingervision_calibrate::depth::{DepthFit, DepthFitError, Method};
use fingervision_gel::Scene;
use fingervision_image::Image;
use fingervision_plot::HeatScale;
use serde::Serialize;

use super::law::Fits;
use super::{Lab, Setting, pictures};
use crate::benchmark::with_dots;
use crate::experiment::{
    DepthScore, ElasticRun, ElasticScore, ExperimentError, Followed, Following, Recording, clipped, depth_of,
    follow_last,
};
use crate::page::{Cell, HtmlTable, Section};

/// Depth errors of one indenter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct IndenterErrors {
    /// The indenter.
    pub indenter: &'static str,
    /// Force on it, N.
    pub force_n: f64,
    /// Error of the dense pattern with the published line.
    pub dense: DepthScore,
    /// Error of 15×15 dots with the line fitted to them.
    pub dots: DepthScore,
    /// Error of the dense pattern with a line through the origin and negative depth set to 0.
    pub dense_clipped: DepthScore,
    /// The same for dots.
    pub dots_clipped: DepthScore,
    /// Error of depth 0 everywhere.
    pub nothing: DepthScore,
    /// Error of the dense pattern with the gel's elasticity, which the paper does not use.
    pub elastic: ElasticScore,
}

/// All indenters on a sensor.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Indenters {
    /// The sensor.
    pub setting: Setting,
    /// One entry per indenter.
    pub errors: Vec<IndenterErrors>,
}

/// The result of one way of tracking, and its depth maps with the published line and with negative depth set to 0.
struct Maps {
    line: Image<f32>,
    clipped: Image<f32>,
    valid: Image<u8>,
}

struct Measured {
    errors: IndenterErrors,
    truth: Image<f32>,
    seen: Image<u8>,
    dense: Maps,
    dots: Maps,
    elastic: Image<f32>,
}

pub(super) fn measure(lab: &Lab, setting: Setting, fits: &Fits) -> Result<(Indenters, [Section; 3]), ExperimentError> {
    // One after another: a fine mesh already keeps all threads busy.
    let measured =
        lab.extent.indenters().iter().map(|name| indenter(lab, setting, fits, name)).collect::<Result<Vec<_>, _>>()?;
    let sections =
        [depth_maps(setting, &measured)?, against_dots(setting, &measured)?, by_elasticity(setting, &measured)?];
    let errors = measured.into_iter().map(|measured| measured.errors).collect();
    Ok((Indenters { setting, errors }, sections))
}

fn indenter(lab: &Lab, setting: Setting, fits: &Fits, name: &'static str) -> Result<Measured, ExperimentError> {
    let scene = setting.scene(Scene::find(name)?, lab.extent)?;
    let recording = Recording::of(&scene, lab.cache)?;
    let dotted = with_dots(scene.clone())?;
    let mut elastic = ElasticRun::new(&recording)?;
    let (dense, dots) = rayon::join(
        || maps(&recording, Following::Dense, &fits.dense, |found| elastic.take(found)),
        || maps(&Recording::of(&dotted, lab.cache)?, Following::Dots, &fits.dots, |_| ()),
    );
    let (dense, dots) = (dense?, dots?);
    let scorer = recording.scorer();
    let nothing = Image::filled(dense.line.width(), dense.line.height(), 0.0);
    let (elastic_score, elastic) = elastic.score(&recording, &scorer);
    let errors = IndenterErrors {
        indenter: name,
        force_n: recording.force_n[2],
        dense: scorer.score(&dense.line, &dense.valid),
        dots: scorer.score(&dots.line, &dots.valid),
        dense_clipped: scorer.score(&dense.clipped, &dense.valid),
        dots_clipped: scorer.score(&dots.clipped, &dots.valid),
        nothing: scorer.score(&nothing, &dense.valid),
        elastic: elastic_score,
    };
    let (truth, seen) = (recording.truth.depth.clone(), recording.truth.visible.clone());
    Ok(Measured { errors, truth, seen, dense, dots, elastic })
}

fn maps(
    recording: &Recording,
    following: Following,
    fit: &DepthFit,
    each: impl FnMut(Followed<'_>),
) -> Result<Maps, ExperimentError> {
    let maps = follow_last(recording, &recording.profile, following, each, |found| {
        let of = |method| depth_of(found.feature, fit, method, recording);
        Ok(Maps { line: of(Method::Line)?, clipped: clipped(of(Method::Origin)?), valid: found.valid.clone() })
    })?;
    maps.map_err(DepthFitError::into)
}

/// Figure 6.
fn depth_maps(setting: Setting, measured: &[Measured]) -> Result<Section, ExperimentError> {
    let mut section =
        Section::new(&format!("depth-{}", setting.word()), format!("Figure 6: depth maps, {}", setting.name()));
    section.text(
        "Depth from the density feature by the pooled line through the origin, with negative depth set to 0, beside the truth. The \
         published line adds its intercept to every untouched pixel; figure 7 shows its errors.",
    );
    let scale = HeatScale::around_zero(2.0);
    for Measured { errors, truth, seen, dense, .. } in measured {
        let shown = [
            (pictures::map(truth, seen, scale), "truth"),
            (pictures::map(&dense.clipped, seen, scale), "estimate"),
            (pictures::map(&pictures::difference(&dense.clipped, truth), seen, scale), "estimate − truth"),
        ];
        let caption = |name| format!("{}: {name}, {}", errors.indenter, pictures::bar_caption(scale, "mm"));
        section.gallery(3, shown.iter().map(|(map, name)| (map, caption(name))))?;
    }
    section.picture(
        &pictures::bar(scale),
        format!("The scale: {}, red is pressed in.", pictures::bar_caption(scale, "mm")),
    )?;
    Ok(section)
}

/// Figure 7.
fn against_dots(setting: Setting, measured: &[Measured]) -> Result<Section, ExperimentError> {
    let title = format!("Figure 7: dense pattern against 15×15 dots, {}", setting.name());
    let mut section = Section::new(&format!("dots-{}", setting.word()), title);
    section.text(
        "Both are tracked from rendered images and calibrated with their own nine presses. Dots are located by sub-pixel centroids \
         and their displacement is interpolated smoothly: their errors come from the gaps between dots, not from tracking.",
    );
    let better = |score: fn(&IndenterErrors) -> [f64; 2]| {
        measured.iter().filter(|measured| score(&measured.errors)[0] < score(&measured.errors)[1]).count()
    };
    let line = better(|errors| [errors.dense.everywhere_mm, errors.dots.everywhere_mm]);
    let clipped = better(|errors| [errors.dense_clipped.everywhere_mm, errors.dots_clipped.everywhere_mm]);
    section.text(format!(
        "Over the whole image the dense pattern has a smaller error than the dots on {line} of {count} indenters with the published line, \
         and on {clipped} of {count} if negative depth is set to 0 (“clipped”). The dense pattern resolves the compression at the rim, \
         which the published line turns into negative depth; dots smooth out both the compression and the border of contact. The paper \
         prints no numbers for this figure and finds the dense pattern better throughout.",
        count = measured.len()
    ));
    for (caption, figure) in REGIONS {
        let mut table = HtmlTable::new(
            format!("Mean absolute error of depth {caption}, mm"),
            ["indenter", "dense, line", "dots, line", "dense, clipped", "dots, clipped", "depth 0 everywhere"],
        );
        for Measured { errors, .. } in measured {
            let scores = [errors.dense, errors.dots, errors.dense_clipped, errors.dots_clipped, errors.nothing];
            table.row(errors.indenter, scores.map(|score| Cell::figure(figure(&score), 3)));
        }
        section.table(table);
    }
    let scale = HeatScale::around_zero(2.0);
    for Measured { errors, truth, seen, dense, dots, .. } in measured {
        let shown = [
            (pictures::map(&dense.line, seen, scale), "dense, line"),
            (pictures::map(&pictures::difference(&dense.line, truth), seen, scale), "dense − truth"),
            (pictures::map(&dots.line, seen, scale), "dots, line"),
            (pictures::map(&pictures::difference(&dots.line, truth), seen, scale), "dots − truth"),
        ];
        let caption = |name| format!("{}: {name}", errors.indenter);
        section.gallery(4, shown.iter().map(|(map, name)| (map, caption(name))))?;
    }
    Ok(section)
}

/// A section that the paper does not have: depth from elasticity, and with it contact and force.
fn by_elasticity(setting: Setting, measured: &[Measured]) -> Result<Section, ExperimentError> {
    let title = format!("Beyond the paper: depth from elasticity, {}", setting.name());
    let mut section = Section::new(&format!("elastic-{}", setting.word()), title);
    section.text(
        "Depth from the same flow by perspective and the gel's elasticity instead of density. Camera and gel are those of the scene, and \
         no calibration press is used. Contact and force are estimated as well.",
    );
    for (caption, figure) in REGIONS {
        let mut table = HtmlTable::new(
            format!("Mean absolute error of depth {caption}, mm"),
            ["indenter", "density, line", "density, clipped", "elasticity", "depth 0 everywhere"],
        );
        for Measured { errors, .. } in measured {
            let scores = [errors.dense, errors.dense_clipped, errors.elastic.depth, errors.nothing];
            table.row(errors.indenter, scores.map(|score| Cell::figure(figure(&score), 3)));
        }
        section.table(table);
    }
    let mut table = HtmlTable::new(
        "Contact and normal force by elasticity",
        ["indenter", "contact, intersection over union", "true force, N", "error of force, %"],
    );
    for Measured { errors: IndenterErrors { indenter, force_n, elastic, .. }, .. } in measured {
        let error = elastic.normal_force.map_or(f64::NAN, |part| 100.0 * part.abs());
        let cells = [(elastic.contact_overlap, 2), (*force_n, 2), (error, 1)];
        table.row(*indenter, cells.map(|(value, digits)| Cell::figure(value, digits)));
    }
    section.table(table);
    let scale = HeatScale::around_zero(2.0);
    for Measured { errors, truth, seen, dense, elastic, .. } in measured {
        let shown = [
            (pictures::map(truth, seen, scale), "truth"),
            (pictures::map(elastic, seen, scale), "elasticity"),
            (pictures::map(&pictures::difference(elastic, truth), seen, scale), "elasticity − truth"),
            (pictures::map(&pictures::difference(&dense.clipped, truth), seen, scale), "density, clipped − truth"),
        ];
        let caption = |name| format!("{}: {name}", errors.indenter);
        section.gallery(4, shown.iter().map(|(map, name)| (map, caption(name))))?;
    }
    Ok(section)
}

type Figure = fn(&DepthScore) -> f64;

const REGIONS: [(&str, Figure); 4] = [
    ("over the whole image", |score| score.everywhere_mm),
    ("inside contact", |score| score.inside_mm),
    ("within 1 mm of the contact's border", |score| score.border_mm),
    ("outside", |score| score.outside_mm),
];
