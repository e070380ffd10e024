//! The noise of the flow, predicted for each cell size with a given camera.

use fingervision_flow::{Preset, STRONG_GRADIENT};
use fingervision_gel::{Coupling, Motif, Pattern, View, trackability};
use fingervision_optics::{Camera, CameraParams, Distortion};
use fingervision_touch::Profile;

use super::choice::Kind;
use super::table::{Row, Table};
use super::{Args, pair};
use crate::failure::Failure;

/// Sides of cells to compare, mm.
const CELLS_MM: [f64; 11] = [0.05, 0.075, 0.1, 0.125, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6];
/// Mean diameters of speckles to compare, mm.
const SPECKLES_MM: [f64; 8] = [0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6];
/// Diameters of dots to compare, relative to the distance between them.
const DOTS: [f64; 7] = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8];
/// Grey levels of black and white in a well exposed image.
const LEVELS: [u8; 2] = [16, 240];
/// Distance between the tracker's patches, px.
const STRIDE_PX: f64 = 8.0;

/// The keys of a profile that are read in addition to its camera.
const READ: [&str; 12] = [
    "name",
    "camera",
    "image.region_of_interest",
    "gel",
    "gel.size_mm",
    "gel.thickness_mm",
    "gel.poissons_ratio",
    "flow.preset",
    "flow.colour",
    "flow.noise_levels",
    "flow.affine.curvature_px",
    "flow.affine.colour_row_step",
];

/// The default simulated sensor.
const SIMULATED_SIZE_PX: [usize; 2] = [480, 480];
const SIMULATED_GEL_MM: [f64; 2] = [30.0, 30.0];

#[derive(Debug, clap::Args)]
pub(super) struct SightArgs {
    /// Score: width and height of the image; without it the profile's region of interest, or 480,480
    #[arg(long, value_name = "W,H", value_parser = image_size, requires = "score")]
    image_px: Option<[usize; 2]>,
    /// Score: assume a camera without tilt, with px of this size on the gel, instead of the profile's camera
    #[arg(long, value_name = "MM", value_parser = scale, requires = "score")]
    mm_per_px: Option<f64>,
    /// Score: standard deviation of the optics' blur, px
    #[arg(long, value_name = "PX", default_value_t = 0.7, allow_negative_numbers = true, requires = "score")]
    blur_px: f64,
    /// Score: standard deviation of the image noise, grey levels per channel; without it the profile's
    /// `flow.noise_levels`
    #[arg(long, value_name = "LEVELS", allow_negative_numbers = true, requires = "score")]
    noise_levels: Option<f64>,
    /// Score: assume a grey camera
    #[arg(long, requires = "score")]
    grey: bool,
}

/// All sizes with their predicted noise.
pub(super) fn table(args: &Args) -> Result<Table, Failure> {
    let profile = args.profile.load()?;
    if let Some(key) = args.profile.keys().find(|key| !READ.contains(key) && !key.starts_with("camera.")) {
        let message = format!("{key} has no effect: the score does not depend on it");
        let hint = format!("leave {key} out; the score reads the profile's camera and {}", READ.join(", "));
        return Err(Failure::new(message, hint));
    }
    let view = view(args, &profile)?;
    let first = args.pattern.pattern(view.gel_mm, LEVELS)?;
    let patterns: Vec<Pattern> =
        sizes(args, &first, view.gel_mm).into_iter().map(|size_mm| resized(&first, size_mm)).collect();
    let coupling = coupling(&profile, view.colour);
    if coupling.is_none() {
        args.output.note("the flow's noise is predicted for flow.preset = affine only");
    }
    let mut rows = Vec::new();
    for pattern in &patterns {
        let score = trackability(pattern, &view)?;
        let flow = coupling.and_then(|coupling| coupling.deviation_px(&score));
        rows.push(Row::new(part_mm(pattern), score, flow));
    }
    Ok(Table::new(args.pattern.kind.name(), &view, rows, asked_mm(args)))
}

/// The profile's camera and gel; without a camera the default simulated ones.
fn view(args: &Args, profile: &Profile) -> Result<View, Failure> {
    let sight = &args.sight;
    let region = profile.image.map(|image| [image.region_of_interest[2], image.region_of_interest[3]]);
    let size_px = sight.image_px.or(region).unwrap_or(SIMULATED_SIZE_PX);
    let mut view = match (sight.mm_per_px, profile.camera) {
        (Some(mm_per_px), _) => View::straight_on(size_px, mm_per_px)?,
        (None, camera) => {
            if camera.is_none() {
                args.output.note("no camera in the profile: predicted for the default simulated sensor");
            }
            let params = camera.unwrap_or(simulated_camera(size_px));
            let camera = Camera::new(&params)
                .map_err(|error| Failure::new(format!("camera.{error}"), "correct the profile's [camera]"))?;
            let gel_mm = profile.gel.map_or(SIMULATED_GEL_MM, |gel| gel.size_mm);
            View { camera, gel_mm, ..View::straight_on(size_px, 1.0)? }
        }
    };
    view.gel_mm = args.pattern.size_mm.unwrap_or(view.gel_mm);
    view.blur_px = sight.blur_px;
    view.noise_levels = sight.noise_levels.unwrap_or(f64::from(profile.flow.noise_levels));
    view.colour = !sight.grey && profile.flow.colour;
    Ok(view)
}

/// 25 mm from the gel, with a px of 1/16 mm.
pub(crate) fn simulated_camera(size_px: [usize; 2]) -> CameraParams {
    CameraParams {
        focal_length_px: [400.0; 2],
        principal_point_px: size_px.map(|size| 0.5 * (size as f64 - 1.0)),
        distortion: Distortion::default(),
        rotation_rad: [0.0; 3],
        translation_mm: [0.0, 0.0, 25.0],
    }
}

/// Coupling of the patches in the profile's tracker; not known for the other presets.
fn coupling(profile: &Profile, colour: bool) -> Option<Coupling> {
    let affine = profile.flow.affine;
    (profile.flow.preset == Preset::Affine).then(|| Coupling {
        stride_px: STRIDE_PX,
        curvature_px: f64::from(affine.curvature_px),
        row_step: if colour { affine.colour_row_step } else { 1 },
        strong_gradient: f64::from(STRONG_GRADIENT),
    })
}

/// The sizes to compare, mm, from small to large, including the requested one.
fn sizes(args: &Args, pattern: &Pattern, gel_mm: [f64; 2]) -> Vec<f64> {
    let pitch_mm = match pattern.motif {
        Motif::Dots { count, .. } => (gel_mm[0] / count[0] as f64).min(gel_mm[1] / count[1] as f64),
        _ => 0.0,
    };
    let mut sizes = match args.pattern.kind {
        Kind::Colour => CELLS_MM.to_vec(),
        Kind::Speckle => SPECKLES_MM.to_vec(),
        Kind::Dots => DOTS.map(|share| share * pitch_mm).to_vec(),
    };
    sizes.extend(asked_mm(args));
    sizes.sort_by(f64::total_cmp);
    sizes.dedup();
    sizes
}

/// The requested size, mm.
fn asked_mm(args: &Args) -> Option<f64> {
    let choice = &args.pattern;
    match choice.kind {
        Kind::Colour => choice.cell_mm,
        Kind::Speckle => choice.speckle_diameter_mm,
        Kind::Dots => choice.dot_diameter_mm,
    }
}

fn part_mm(pattern: &Pattern) -> f64 {
    match pattern.motif {
        Motif::Colour { cell_mm } => cell_mm,
        Motif::Dots { diameter_mm, .. } | Motif::Speckle { diameter_mm, .. } => diameter_mm,
    }
}

fn resized(pattern: &Pattern, size_mm: f64) -> Pattern {
    let motif = match pattern.motif {
        Motif::Colour { .. } => Motif::Colour { cell_mm: size_mm },
        Motif::Dots { count, .. } => Motif::Dots { count, diameter_mm: size_mm },
        Motif::Speckle { coverage, .. } => Motif::Speckle { diameter_mm: size_mm, coverage },
    };
    Pattern { motif, ..pattern.clone() }
}

fn image_size(text: &str) -> Result<[usize; 2], String> {
    let size: [usize; 2] = pair(text, "640,480")?;
    let is_size = size.into_iter().all(|side| (64..=16_384).contains(&side));
    if is_size { Ok(size) } else { Err("an image is 64 to 16384 px wide and high".into()) }
}

fn scale(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(scale) if scale.is_finite() && scale > 0.0 => Ok(scale),
        _ => Err("the size of a px is a length above 0 mm".into()),
    }
}
