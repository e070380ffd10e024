//! Renders and tracks solved presses with random cameras: the training data of the network.
//!
//! `cargo run --release -p fingervision-cli --example look_at_presses -- presses`
//!
//! Reads `presses/*/press.toml` and `displacement.npy` as `learn/presses.py` writes them; puts `seen.npy` beside them where
//! there is none: float32 `[camera, frame, 4, row, column]`, the apparent displacement (x, y), mm, and the slope of the ray; and
//! `dragged.npy`: float32 `[camera, frame, 5, row, column]`, the same without the displacement by shear and twist, and the vertical
//! part of that displacement, mm; all of it NaN in frames where nothing was subtracted.

use std::error::Error;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;

use fingervision_elastic::{GelBlock, SurfaceState};
use fingervision_gel::{FrameRenderer, Motif, Pattern, RenderParams};
use fingervision_image::Frame;
use fingervision_optics::{Camera, CameraParams, Distortion};
use fingervision_touch::{
    Cells, ElasticDepth, ElasticMode, ElasticParams, Fields, Profile, Seen, Tracker, WithoutDrag,
};
use npyz::{NpyFile, WriterBuilder};
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use serde::Deserialize;

const CELLS: usize = 120;
const PIXELS: usize = 480;
/// In which the shear of contact is found, for each camera.
const MODES: [ElasticMode; 2] = [ElasticMode::Exact, ElasticMode::Live];
/// Side of the gel that all lengths are drawn for, mm.
const SIZE_MM: f64 = 30.0;
/// Range of the farthest that a point moves from one frame to the next, mm: 1 to 16 px of the usual camera.
const STEP_MM: [f64; 2] = [0.06, 1.0];

type Fault = Box<dyn Error>;
type Displacement = Vec<[f64; 3]>;

/// A press: the gel alone is of interest here.
#[derive(Debug, Deserialize)]
struct Press {
    gel: GelBlock,
}

/// A camera over a gel, all of it drawn at random.
#[derive(Debug)]
struct Sensor {
    camera: CameraParams,
    pattern: Pattern,
    render: RenderParams,
    step_mm: f64,
}

impl Sensor {
    /// Every speed is as likely as twice that speed. Place and blur, noise, and the pattern's cells are each as in the ready-made scenes in half of all sensors or a little more,
    /// and drawn at random in the others.
    fn draw(size_mm: f64, rng: &mut Pcg64Mcg) -> Result<Self, Fault> {
        let mut between = |low: f64, high: f64| Ok::<_, Fault>(Uniform::new(low, high)?.sample(rng));
        let scale = size_mm / SIZE_MM;
        let mut usual_or = |default: f64, low: f64, high: f64, is_usual: bool| {
            let drawn = between(low, high)?;
            Ok::<_, Fault>(if is_usual { default } else { drawn })
        };
        let [is_usual, has_usual_noise, has_usual_cells] =
            [0.5, 0.5, 0.6].map(|share| usual_or(0.0, 0.0, 1.0, false).map(|at| at < share));
        let (is_usual, has_usual_noise, has_usual_cells) = (is_usual?, has_usual_noise?, has_usual_cells?);
        let distance = scale * usual_or(25.0, 14.0, 38.0, is_usual)?;
        let place = [scale * usual_or(0.0, -1.5, 1.5, is_usual)?, scale * usual_or(0.0, -1.5, 1.5, is_usual)?];
        let px_per_mm = usual_or(4.0, 3.4, 4.6, is_usual)? * CELLS as f64 / size_mm;
        let middle = 0.5 * (PIXELS as f64 - 1.0);
        let camera = CameraParams {
            focal_length_px: [distance * px_per_mm; 2],
            principal_point_px: place.map(|along| middle + along * px_per_mm),
            distortion: Distortion::default(),
            rotation_rad: [0.0; 3],
            translation_mm: [-place[0], -place[1], distance],
        };
        let cell_mm = scale * usual_or(0.1, 0.08, 0.2, has_usual_cells)?;
        let pattern_seed = usual_or(0.0, 1.0, 1e6, false)? as u64;
        let render = RenderParams {
            width: PIXELS,
            height: PIXELS,
            blur_px: usual_or(0.7, 0.5, 1.2, is_usual)?,
            noise_levels: usual_or(2.0, 0.5, 4.0, has_usual_noise)?,
            seed: usual_or(0.0, 1.0, 1e6, false)? as u64,
            ..RenderParams::default()
        };
        let [slow, fast] = STEP_MM.map(f64::ln);
        let step_mm = scale * usual_or(0.0, slow, fast, false)?.exp();
        Ok(Self {
            camera,
            pattern: Pattern { motif: Motif::Colour { cell_mm }, seed: pattern_seed, ..Pattern::default() },
            render,
            step_mm,
        })
    }

    /// Renders and tracks the press from rest through all its poses, and appends the measurement of each.
    fn look(&self, gel: &GelBlock, mode: ElasticMode, poses: &[Displacement], target: &mut Views) -> Result<(), Fault> {
        let camera = Camera::new(&self.camera)?;
        let mut renderer = FrameRenderer::new(&self.render, &camera, &self.pattern.texture(gel.size_mm)?)?;
        let mut tracker = Tracker::new(&Profile::default(), (PIXELS, PIXELS), true, Fields::NONE)?;
        // The network finds the contact whose shear is subtracted.
        let params = ElasticParams { mode, network: true };
        let mut depth = ElasticDepth::new(&camera, gel, (PIXELS, PIXELS), &params)?;
        let mut sequence = 0;
        let mut show = |tracker: &mut Tracker, displacement_mm: Displacement| {
            let pixels = renderer.render(&surface(gel, displacement_mm), sequence)?.clone();
            tracker.track(&Frame { sequence, capture_time_s: sequence as f64 / 30.0, pixels })?;
            sequence += 1;
            Ok::<_, Fault>(())
        };
        let rest = vec![[0.0; 3]; (CELLS + 2).pow(2)];
        show(&mut tracker, rest.clone())?;
        let mut before = &rest;
        for pose in poses {
            let farthest_mm = before.iter().zip(pose).map(|(from, to)| distance(from, to)).fold(0.0, f64::max);
            let steps = (farthest_mm / self.step_mm).ceil().max(1.0) as usize;
            for step in 1..=steps {
                let share = step as f64 / steps as f64;
                let between = |(from, to): (&[f64; 3], &[f64; 3])| {
                    [0, 1, 2].map(|axis| from[axis] + share * (to[axis] - from[axis]))
                };
                show(&mut tracker, before.iter().zip(pose).map(between).collect())?;
            }
            before = pose;
            let reading = tracker.reading();
            depth.solve(&reading.flow, &reading.deviation, &reading.valid);
            let Cells { seen, without_drag, .. } = depth.cells();
            push_planes(&mut target.seen, seen);
            if let Some(WithoutDrag { seen, dragged_mm, .. }) = without_drag {
                push_planes(&mut target.dragged, seen);
                target.dragged.extend(dragged_mm.iter().map(|dragged_mm| dragged_mm[2]));
            } else {
                target.dragged.extend(std::iter::repeat_n(f32::NAN, 5 * seen.len()));
            }
        }
        Ok(())
    }
}

fn is_seen(folder: &Path) -> bool {
    ["seen.npy", "dragged.npy"].into_iter().all(|name| folder.join(name).exists())
}

/// What all cameras saw of a press.
#[derive(Debug, Default)]
struct Views {
    seen: Vec<f32>,
    dragged: Vec<f32>,
}

impl Views {
    /// Writes the frames of all cameras; `seen.npy` last, by which the training finds a press.
    fn write(self, folder: &Path, frames: usize) -> Result<(), Fault> {
        write_planes(folder, "dragged", self.dragged, frames, 5)?;
        write_planes(folder, "seen", self.seen, frames, 4)
    }
}

/// Appends the apparent displacement and the slopes of the rays, one plane after the other.
fn push_planes(target: &mut Vec<f32>, seen: &[Seen]) {
    for plane in 0..4 {
        target.extend(seen.iter().map(|seen| [seen.apparent_mm, seen.slope].as_flattened()[plane]));
    }
}

fn write_planes(folder: &Path, name: &str, values: Vec<f32>, frames: usize, planes: usize) -> Result<(), Fault> {
    // Written under another name first: a file that is there is whole.
    let part = folder.join(format!("{name}.part"));
    let shape = [MODES.len(), frames, planes, CELLS, CELLS].map(|count| count as u64);
    let file = BufWriter::new(File::create(&part)?);
    let mut writer = npyz::WriteOptions::new().default_dtype().shape(&shape).writer(file).begin_nd()?;
    writer.extend(values)?;
    writer.finish()?;
    Ok(fs::rename(part, folder.join(format!("{name}.npy")))?)
}

fn distance(from: &[f64; 3], to: &[f64; 3]) -> f64 {
    from.iter().zip(to).map(|(from, to)| (to - from).powi(2)).sum::<f64>().sqrt()
}

/// A surface that is linear between the centres of the cells and constant beyond the outer ones.
fn surface(gel: &GelBlock, displacement_mm: Displacement) -> SurfaceState {
    let lines = |side_mm: f64| {
        let cell_mm = side_mm / CELLS as f64;
        let centres = (0..CELLS).map(|cell| (cell as f64 + 0.5) * cell_mm - 0.5 * side_mm);
        std::iter::once(-0.5 * side_mm).chain(centres).chain([0.5 * side_mm]).collect()
    };
    let nodes = displacement_mm.len();
    let [x_mm, y_mm] = gel.size_mm.map(lines);
    SurfaceState { x_mm, y_mm, displacement_mm, in_contact: vec![false; nodes], ..SurfaceState::default() }
}

/// The nodes of the surface whose means over the cells are those of one frame, `[row][column][axis]`.
fn nodes(means: &[f32]) -> Displacement {
    let mut planes =
        [0, 1, 2].map(|axis| means.iter().skip(axis).step_by(3).map(|&mean| f64::from(mean)).collect::<Vec<_>>());
    for plane in &mut planes {
        for row in 0..CELLS {
            sharpen(plane, row * CELLS, 1);
        }
        for column in 0..CELLS {
            sharpen(plane, column, CELLS);
        }
    }
    let inner = |line: usize| line.saturating_sub(1).min(CELLS - 1);
    let places = (0..CELLS + 2).flat_map(|row| (0..CELLS + 2).map(move |column| inner(row) * CELLS + inner(column)));
    places.map(|cell| [0, 1, 2].map(|axis| planes[axis][cell])).collect()
}

/// From means over the cells of a line to its values at their centres, linear in between. The mean is ¾ of a centre's value
/// and ⅛ of those beside it; at the ends ⅞ and ⅛. Solved by elimination.
fn sharpen(plane: &mut [f64], first: usize, stride: usize) {
    let mut upper = [0.0; CELLS];
    for cell in 0..CELLS {
        let (before, own) = (cell.checked_sub(1), if cell == 0 || cell == CELLS - 1 { 0.875 } else { 0.75 });
        let pivot = own - before.map_or(0.0, |before| 0.125 * upper[before]);
        let known = before.map_or(0.0, |before| 0.125 * plane[first + before * stride]);
        upper[cell] = 0.125 / pivot;
        plane[first + cell * stride] = (plane[first + cell * stride] - known) / pivot;
    }
    for cell in (0..CELLS - 1).rev() {
        plane[first + cell * stride] -= upper[cell] * plane[first + (cell + 1) * stride];
    }
}

fn see(folder: &Path, seed: u64) -> Result<(), Fault> {
    let Press { gel } = toml::from_str(&fs::read_to_string(folder.join("press.toml"))?)?;
    let displacement_mm = NpyFile::new(File::open(folder.join("displacement.npy"))?)?.into_vec::<f32>()?;
    let poses: Vec<_> = displacement_mm.chunks_exact(3 * CELLS * CELLS).map(nodes).collect();
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut views = Views::default();
    for mode in MODES {
        Sensor::draw(gel.size_mm[0], &mut rng)?.look(&gel, mode, &poses, &mut views)?;
    }
    views.write(folder, poses.len())
}

fn main() -> Result<(), Fault> {
    let presses = std::env::args().nth(1).ok_or("name the folder of the presses")?;
    let mut folders = fs::read_dir(&presses)?.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>, Fault>>()?;
    folders.retain(|folder| folder.join("press.toml").is_file() && !is_seen(folder));
    folders.sort();
    for (count, folder) in folders.iter().enumerate() {
        let name = folder.file_name().unwrap_or_default().to_string_lossy();
        let seed = name.parse().map_err(|_| format!("{name}: a press is named by its seed"))?;
        writeln!(std::io::stdout(), "{name}, {} of {}", count + 1, folders.len())?;
        if let Err(fault) = see(folder, seed) {
            writeln!(std::io::stderr(), "{name}: {fault}")?;
        }
    }
    Ok(())
}
