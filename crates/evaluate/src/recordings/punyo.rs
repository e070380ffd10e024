//! A recorded press on a Punyo sensor.
//!
//! 150 grey frames of 640×480 px at 30 a second: at rest up to 60, pressed from 62 to 110, at rest again from 115.
//! Depth images and forces lie beside them. Everything is measured inside the membrane's mask.

use super::{Recordings, files};
use crate::matcher::Matcher;
use crate::{Asked, EvaluateError, Table, mean};
use fingervision_flow::{FlowField, FlowParams, Preset};
use fingervision_image::{Between, Image, Pixels};
use rayon::prelude::*;

/// Frames of the recording.
pub(super) const FRAMES: usize = 150;
/// Frames over which the force at rest is averaged.
const REST_FRAMES: usize = 55;
/// Frames at rest that are matched with the first, and the mean error of `OpenCV`'s inverse search, preset medium, px.
const AT_REST: [(usize, f64); 3] = [(10, 0.019), (30, 0.019), (50, 0.018)];
/// The same after the press, when the membrane may still creep.
const AFTER_PRESS: [(usize, f64); 3] = [(130, 0.056), (140, 0.050), (149, 0.043)];
/// Frames of the press for which the flow is computed forwards and backwards.
const PRESSED: [usize; 4] = [70, 80, 90, 100];
/// The error of forward and backward flow for `OpenCV`'s inverse search, preset medium, px.
const OPENCV_ROUND_TRIP_PX: f64 = 0.09;

/// The recording, opened for measuring.
#[derive(Debug)]
pub struct Punyo<'a> {
    recordings: &'a Recordings,
    pub(super) mask: Image<bool>,
    /// Length of the force beyond that at rest, N, by frame.
    pub(super) force_n: Vec<f64>,
}

impl<'a> Punyo<'a> {
    /// Opens the recording.
    ///
    /// # Errors
    ///
    /// [`EvaluateError::File`] if the mask or the forces are missing or cannot be read.
    pub fn open(recordings: &'a Recordings) -> Result<Self, EvaluateError> {
        let mask = files::mask(&recordings.path("punyo/mask.png"))?;
        Ok(Self { recordings, mask, force_n: force_lengths_n(recordings)? })
    }

    /// A frame's image.
    pub(super) fn frame(&self, index: usize) -> Result<Pixels, EvaluateError> {
        files::pixels(&self.recordings.path(&format!("punyo/gray/{index:03}.png")))
    }

    /// A frame's distances from the depth camera, in its own steps; 0 where it measured nothing.
    pub(super) fn distances(&self, index: usize) -> Result<Image<u16>, EvaluateError> {
        files::values_16(&self.recordings.path(&format!("punyo/depth/{index:03}.png")))
    }

    /// The pixels of the membrane.
    pub(super) fn membrane(&self) -> impl Iterator<Item = (usize, usize)> {
        let (width, height) = self.mask.size();
        let pixels = (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)));
        pixels.filter(|&(x, y)| self.mask.at(x, y))
    }

    /// Mean length of a flow over the membrane, px.
    pub(super) fn mean_length_px(&self, flow: &FlowField) -> f64 {
        mean(self.membrane().map(|(x, y)| flow.u.at(x, y).hypot(flow.v.at(x, y))))
    }

    /// The table of single pairs, each searched without a start: flow at rest, flow after the press, and the error of
    /// forward and backward flow.
    ///
    /// # Errors
    ///
    /// [`EvaluateError::File`] if a file is missing or cannot be read.
    pub fn measure_pairs(&self) -> Result<Table, EvaluateError> {
        let first = self.frame(0)?;
        let mut table = Table::new("Recorded press (Punyo): px unless stated", &["default", "medium", "OpenCV medium"]);
        let mut matchers = [matcher(&first, Preset::Affine)?, matcher(&first, Preset::Medium)?];
        let at_rest = AT_REST.map(|frame| ("at rest", frame, Some(Asked::AtMost(0.012))));
        let after = AFTER_PRESS.map(|frame| ("after the press", frame, None));
        for (when, (index, opencv_px), asked) in at_rest.into_iter().chain(after) {
            let current = self.frame(index)?;
            let mut values = Vec::new();
            for matcher in &mut matchers {
                values.push(self.mean_length_px(&matcher.find(&current)?.flow));
            }
            values.push(opencv_px);
            table.push(format!("{when}, 0 to {index}"), asked, values);
        }
        let trips = [Preset::Affine, Preset::Medium].into_par_iter();
        let trips = trips.map(|preset| self.round_trips_px(&first, preset)).collect::<Result<Vec<_>, _>>()?;
        let mut row = |name: &str, asked, figure: fn(&[f64]) -> f64, opencv_px| {
            table.push(name, asked, vec![figure(&trips[0]), figure(&trips[1]), opencv_px]);
        };
        let mean_of = |trips: &[f64]| trips.iter().sum::<f64>() / trips.len() as f64;
        row("forward and backward flow of the press", Some(Asked::AtMost(0.05)), mean_of, OPENCV_ROUND_TRIP_PX);
        row("the same, worst frame", None, |trips| trips.iter().copied().fold(0.0, f64::max), f64::NAN);
        Ok(table)
    }

    /// Mean of `|f(x) + b(x + f(x))|` for the flow `f` to a frame of the press and `b` back, both searched without a
    /// start.
    fn round_trips_px(&self, first: &Pixels, preset: Preset) -> Result<Vec<f64>, EvaluateError> {
        let mut matcher = matcher(first, preset)?;
        let trip = |index| {
            let pressed = self.frame(index)?;
            matcher.set_reference(first)?;
            let there = matcher.find(&pressed)?.flow.clone();
            matcher.set_reference(&pressed)?;
            let back = &matcher.find(first)?.flow;
            let misses = self.membrane().filter_map(|(x, y)| {
                let (u, v) = (there.u.at(x, y), there.v.at(x, y));
                let place = Between::inside((x as f32 + u, y as f32 + v), back.size())?;
                Some((u + place.sample(&back.u)).hypot(v + place.sample(&back.v)))
            });
            Ok(mean(misses))
        };
        PRESSED.into_iter().map(trip).collect()
    }
}

fn matcher(reference: &Pixels, preset: Preset) -> Result<Matcher, EvaluateError> {
    Matcher::new(reference, &FlowParams { preset, ..FlowParams::default() })
}

fn force_lengths_n(recordings: &Recordings) -> Result<Vec<f64>, EvaluateError> {
    let file = recordings.path("punyo/wrench.csv");
    let rows = files::numbers(&file)?;
    let forces: Option<Vec<[f64; 3]>> = rows.iter().map(|row| row.get(3..6)?.try_into().ok()).collect();
    let forces = forces.filter(|forces| forces.len() == FRAMES);
    let forces = forces.ok_or_else(|| EvaluateError::file(&file, format!("not {FRAMES} rows of forces")))?;
    let rest =
        [0, 1, 2].map(|axis| forces[..REST_FRAMES].iter().map(|force| force[axis]).sum::<f64>() / REST_FRAMES as f64);
    let length = |force: &[f64; 3]| force.iter().zip(rest).map(|(f, rest)| (f - rest).powi(2)).sum::<f64>().sqrt();
    Ok(forces.iter().map(length).collect())
}
