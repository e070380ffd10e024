//! `fingervision calibrate camera`: fits the camera to a sliding board.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use fingervision_calibrate::camera::{
    BoardError, BoardFlow, BoardTracker, CameraReport, CornerFit, FitOptions, Prior, Priors, Slide, Start, Unknown,
    board_flow, fit_camera, fit_corners, read_corners,
};
use fingervision_calibrate::update_profile;
use fingervision_image::Rect;
use fingervision_optics::{Camera, Radial};
use fingervision_simulation::open;
use fingervision_sink::write_png;
use fingervision_source::Options;
use fingervision_touch::Profile;
use serde::Serialize;

use super::beside;
use super::repeated::refuse_repeated;
use crate::failure::Failure;
use crate::output::OutputArgs;

/// Relative standard deviation of the profile's own distance as a prior.
const PROFILE_DISTANCE_PART: f64 = 0.1;

/// Find pose and lens of the camera, using a patterned board that slides in known steps
///
/// Put a flat board with a dense random pattern where the gel's surface will be, slide it along x by equal steps and
/// take an image after each: 21 images. The flow from image to image, averaged, gives position, tilt, distortion, focal
/// length and principal point, and the profile's `[camera]` is written. One slide does not distinguish focal length
/// from distance: measure the distance from the lens to the board and give it with `--prior distance_mm=25±0.5`, or add
/// a second slide perpendicular to the first, with the board tilted by 15° or more.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The images of the board, in order: a folder, a video or sim:board; further slides of the same board follow
    #[arg(required_unless_present = "corners", value_name = "BOARD")]
    boards: Vec<PathBuf>,
    /// Step of the board between consecutive images, mm; one value for all slides or one for each
    #[arg(long, required_unless_present = "corners", value_delimiter = ',', value_name = "MM,...", value_parser = positive)]
    step_mm: Vec<f64>,
    /// Direction of each slide in the image: x, y, or degrees from x towards y; without it x, then y
    #[arg(long, value_delimiter = ',', value_name = "x|y|DEG,...", value_parser = direction, allow_negative_numbers = true)]
    direction: Vec<f64>,
    /// The sensor's profile: its region of interest and flow are used, its `[camera]` is written; created if there is
    /// none
    #[arg(long, value_name = "FILE")]
    profile: PathBuf,
    /// Prior knowledge, as in `distance_mm=25±0.5` or `focal_length_px=400+-4`; may be repeated
    ///
    /// Names: `rotation_x_rad`, `rotation_y_rad`, `rotation_z_rad`, `translation_x_mm`, `translation_y_mm`,
    /// `distance_mm`, `k1`, `k2`, `p1`, `p2`, `focal_length_px`, `principal_x_px`, `principal_y_px`. Without one for
    /// distance or focal length, the distance of the profile's `[camera]` is used with a deviation of 10 %; without
    /// that, 50±25 mm.
    #[arg(long = "prior", value_name = "NAME=VALUE±SD", value_parser = Prior::parse)]
    priors: Vec<(Unknown, Prior)>,
    /// Instead of a slide, corners of a checkerboard in 3 or more poses: a table with the columns image, `x_mm`,
    /// `y_mm`, `u_px`, `v_px`
    ///
    /// It has a row for each corner: the number of the image, the position of the corner on the board, x right and y
    /// down, and its detected position in the region of interest. In the first image the board lies where the gel's
    /// surface will be, upright; in the others it is tilted by 15° to 40° to different sides. No priors are needed.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["boards", "step_mm", "direction", "priors", "start", "picture"])]
    corners: Option<PathBuf>,
    /// The form of radial distortion
    #[arg(long, value_enum, default_value_t = RadialName::Brown)]
    radial: RadialName,
    /// Where the fit begins
    #[arg(long, value_enum, default_value_t = StartName::Plain)]
    start: StartName,
    /// The picture of residuals to write; without it beside the profile, its name with -camera.png
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    output: OutputArgs,
}

/// The values of `--radial`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum RadialName {
    /// 1 + k1 r² + k2 r⁴
    Brown,
    /// 1 + k1 r² + k2 r, as Du et al. 2021 print it
    Printed,
}

/// The values of `--start`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum StartName {
    /// Upright, without distortion, with the scale of the mean flow
    Plain,
    /// All zero, a distance of 50 mm and a focal length of 50 px
    Published,
}

#[derive(Debug, Serialize)]
struct CameraResult {
    #[serde(flatten)]
    report: CameraReport,
    picture: PathBuf,
    profile: PathBuf,
}

#[derive(Debug, Serialize)]
struct CornerResult {
    #[serde(flatten)]
    fit: CornerFit,
    profile: PathBuf,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    match &args.corners {
        Some(file) => from_corners(args, file, out),
        None => from_slides(args, out),
    }
}

fn from_corners(args: &Args, file: &Path, out: &mut impl Write) -> Result<(), Failure> {
    let named = |what: String, hint: &str| Failure::new(format!("{}: {what}", file.display()), hint);
    let text = fs::read_to_string(file)
        .map_err(|error| named(error.to_string(), "name a file with the corners, see calibrate camera --help"))?;
    let fit = read_corners(&text).and_then(|images| fit_corners(&images, args.radial.into()));
    let fit = fit.map_err(|error| named(error.to_string(), error.hint()))?;
    update_profile(&args.profile, "camera", &fit.params)?;
    let text = format!("{fit}\nprofile   {}", args.profile.display());
    args.output.result(out, &CornerResult { fit, profile: args.profile.clone() }, &text)
}

fn from_slides(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let (report, picture) = fit(args)?;
    let text = format!("{report}\npicture   {}\nprofile   {}", picture.display(), args.profile.display());
    args.output.result(out, &CameraResult { report, picture, profile: args.profile.clone() }, &text)
}

/// Fits the camera to the slides and writes the picture of residuals and the profile; returns the report and the
/// picture's file.
pub(super) fn fit(args: &Args) -> Result<(CameraReport, PathBuf), Failure> {
    let profile = if args.profile.exists() { super::load(&args.profile)? } else { Profile::default() };
    let slides = args.slides()?;
    refuse_repeated("slide", &args.boards)?;
    let mut flows: Vec<BoardFlow> = Vec::new();
    let mut known = None;
    for (board, slide) in args.boards.iter().zip(slides) {
        let (flow, priors) = args.follow(board, slide, &profile)?;
        if let Some(first) = flows.first().filter(|first| first.size != flow.size) {
            return Err(other_size(board, flow.size, first.size));
        }
        flows.push(flow);
        known.get_or_insert(priors);
    }
    let priors = known.ok_or(BoardError::TooFewImages { images: 0 })?;
    let options = FitOptions { radial: args.radial.into(), start: args.start.into() };
    let fit = fit_camera(&flows, &priors, options)?;
    let report = CameraReport::new(fit, &flows, &priors);
    report.check()?;
    if let Some(remark) = report.remark() {
        args.output.note(&remark);
    }
    let picture = args.picture.clone().unwrap_or_else(|| beside(&args.profile, "camera"));
    write_png(&report.draw(), &picture)?;
    update_profile(&args.profile, "camera", &report.camera)?;
    Ok((report, picture))
}

impl Args {
    /// One slide, and the prior of the camera's distance.
    pub(super) fn slide(
        board: PathBuf,
        slide: Slide,
        distance: Prior,
        (profile, picture): (PathBuf, PathBuf),
        output: OutputArgs,
    ) -> Self {
        Self {
            boards: vec![board],
            step_mm: vec![slide.step_mm],
            direction: vec![slide.direction_rad.to_degrees()],
            profile,
            priors: vec![(Unknown::Distance, distance)],
            corners: None,
            radial: RadialName::Brown,
            start: StartName::Plain,
            picture: Some(picture),
            output,
        }
    }

    /// Each board's slide.
    fn slides(&self) -> Result<Vec<Slide>, Failure> {
        let count = self.boards.len();
        let fits = |given: usize, least: usize| given == count || given == least;
        if !fits(self.step_mm.len(), 1) || !fits(self.direction.len(), 0) {
            return Err(Failure::new(
                format!("{count} slides, {} steps and {} directions", self.step_mm.len(), self.direction.len()),
                "give one --step-mm for all slides or one for each, and one --direction for each, as in --direction x,y",
            ));
        }
        let slide = |index: usize| Slide {
            step_mm: self.step_mm.get(index).copied().unwrap_or(self.step_mm[0]),
            direction_rad: self
                .direction
                .get(index)
                .copied()
                .unwrap_or(if index == 0 { 0.0 } else { 90.0 })
                .to_radians(),
        };
        Ok((0..count).map(slide).collect())
    }

    /// The flow of one board, and the prior of the camera.
    fn follow(&self, board: &Path, slide: Slide, profile: &Profile) -> Result<(BoardFlow, Priors), Failure> {
        let mut source = open(board, &Options::default())?;
        let region = profile.region(source.size())?;
        let (priors, known_px) = self.known(profile, source.size(), region, slide)?;
        let progress = self.output.progress("following", source.frame_count());
        let named = |error: BoardError| {
            let message = format!("{}: {error}", board.display());
            Failure::Stated { message, hint: error.hint() }
        };
        let mut tracker = None;
        while let Some(frame) = source.next_frame()? {
            let tracker = match &mut tracker {
                Some(tracker) => tracker,
                none => {
                    let is_colour = source.tracks_in_colour(&frame.pixels);
                    none.insert(BoardTracker::new(region, is_colour, &profile.flow).map_err(named)?)
                }
            };
            tracker.push(&frame).map_err(named)?;
            progress.inc(1);
        }
        progress.finish_and_clear();
        let tracker = tracker.ok_or_else(|| named(BoardError::TooFewImages { images: 0 }))?;
        Ok((tracker.finish(slide, known_px).map_err(named)?, priors))
    }

    /// The camera before the fit, and its flow for a step, px, if it determines the size of a pixel.
    fn known(
        &self,
        profile: &Profile,
        frame_size: (usize, usize),
        region: Rect,
        slide: Slide,
    ) -> Result<(Priors, Option<[f64; 2]>), Failure> {
        let middle = |size: usize, begin: usize| 0.5 * (size as f64 - 1.0) - begin as f64;
        let frame_middle = [middle(frame_size.0, region.x), middle(frame_size.1, region.y)];
        let mut priors = Priors::weak(frame_size.0, frame_middle);
        for (unknown, prior) in &self.priors {
            priors.give(*unknown, *prior);
        }
        let [distance, focal] = [Unknown::Distance, Unknown::FocalLength];
        let scale = (priors.is_given(distance) && priors.is_given(focal))
            .then(|| priors.of(focal).value / priors.of(distance).value);
        if let Some(px_per_mm) = scale {
            return Ok((priors, Some(slide.step_vector_mm().map(|step| step * px_per_mm))));
        }
        let Some(params) = profile.camera else { return Ok((priors, None)) };
        let [x, y] = params.principal_point_px;
        let (width, height) = (region.width as f64, region.height as f64);
        if !(0.0..width).contains(&x) || !(0.0..height).contains(&y) {
            return Err(Failure::new(
                format!(
                    "camera.principal_point_px = [{x}, {y}] lies outside the images' region of {width}x{height} px"
                ),
                "the profile is for another image size: use the right one, or remove its [camera]",
            ));
        }
        if !priors.is_given(distance) && !priors.is_given(focal) {
            let value = params.translation_mm[2];
            priors.give(distance, Prior { value, deviation: PROFILE_DISTANCE_PART * value });
        }
        let flow = Camera::new(&params).ok().and_then(|camera| {
            board_flow(&camera, [middle(region.width, 0), middle(region.height, 0)], slide.step_vector_mm())
        });
        Ok((priors, flow))
    }
}

impl From<RadialName> for Radial {
    fn from(name: RadialName) -> Self {
        match name {
            RadialName::Brown => Self::Brown,
            RadialName::Printed => Self::Printed,
        }
    }
}

impl From<StartName> for Start {
    fn from(name: StartName) -> Self {
        match name {
            StartName::Plain => Self::Plain,
            StartName::Published => Self::Published,
        }
    }
}

fn other_size(board: &Path, (width, height): (usize, usize), first: (usize, usize)) -> Failure {
    let message =
        format!("{}: images of {width}x{height} px after a slide of {}x{} px", board.display(), first.0, first.1);
    Failure::new(message, "take all slides with the same camera at the same size")
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("a step is a length above 0 mm; for a slide in the opposite direction see --direction".into()),
    }
}

/// Degrees from x towards y.
pub(super) fn direction(text: &str) -> Result<f64, String> {
    match text {
        "x" => Ok(0.0),
        "y" => Ok(90.0),
        _ => text.parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| "expected x, y or degrees".into()),
    }
}
