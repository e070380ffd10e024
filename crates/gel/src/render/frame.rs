//! Renders the camera's frame for a state of the gel.

use super::cells::CellTable;
use super::lattice::{Lattice, Rays, bulge_px};
use super::light::{Light, vignette};
use super::noise;
use super::parts::PartRows;
use super::patches::Patches;
use super::raster::{Planes, Target};
use super::samples::{Samples, Scene};
use super::sensor::Sensor;
use super::sight::ColourInputs;
use super::surface::{Instant, Surface, widest_mm};
use super::{RenderError, RenderParams};
use crate::Texture;
use crate::blur::Blur;
use fearless_simd::{Level, Simd, dispatch};
use fingervision_elastic::SurfaceState;
use fingervision_image::{Image, LUMA_WEIGHTS, Pixels};
use fingervision_optics::Camera;

/// Renders frames. Made once for a camera and a pattern: it owns all memory for a frame.
///
/// The gel's surface is rendered, its sides are not. A frame depends only on the state and its number, so renderers on
/// several threads give the same bytes.
///
/// ```
/// use fingervision_elastic::SurfaceState;
/// use fingervision_gel::{FrameRenderer, Pattern, RenderParams, TruthProjector};
/// use fingervision_optics::{Camera, CameraParams};
///
/// let camera = Camera::new(&CameraParams {
///     focal_length_px: [400.0, 400.0],
///     principal_point_px: [31.5, 23.5],
///     distortion: Default::default(),
///     rotation_rad: [0.0; 3],
///     translation_mm: [0.0, 0.0, 25.0],
/// })?;
/// let params = RenderParams { width: 64, height: 48, ..RenderParams::default() };
/// let texture = Pattern::default().texture([30.0, 30.0])?;
/// let mut renderer = FrameRenderer::new(&params, &camera, &texture)?;
///
/// // A surface that as a whole is 1 mm nearer to the camera.
/// let lines = vec![-15.0, 0.0, 15.0];
/// let state = SurfaceState {
///     x_mm: lines.clone(),
///     y_mm: lines,
///     displacement_mm: vec![[0.0, 0.0, 1.0]; 9],
///     in_contact: vec![true; 9],
///     ..SurfaceState::default()
/// };
/// let frame = renderer.render(&state, 0)?;
/// assert_eq!(frame.size(), (64, 48));
///
/// let mut projector = TruthProjector::new(&camera, params.width, params.height);
/// let truth = projector.project(&state)?;
/// // 31.5 px from the axis, 25 mm away before and 24 mm now.
/// assert!((truth.flow.at(63, 0)[0] - 31.5 * (25.0 / 24.0 - 1.0)).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct FrameRenderer {
    params: RenderParams,
    camera: Camera,
    texture: Texture,
    light: Light,
    background: [f32; 3],
    lattice: Lattice,
    rays: Rays,
    vignette: Vec<f32>,
    surface: Surface,
    patches: Patches,
    targets: Vec<Target>,
    planes: Planes,
    /// The pattern's cells on the gel, made with the first surface.
    cells: Option<CellTable>,
    parts: PartRows,
    samples: Samples,
    sensor: Sensor,
    levels: Image<[f32; 3]>,
    /// A row of channels before it is written to the frame.
    row: Vec<f32>,
    pixels: Pixels,
    simd: Level,
}

impl FrameRenderer {
    /// A renderer for this camera and a gel with this pattern.
    ///
    /// # Errors
    ///
    /// [`RenderError::OutOfRange`] if a parameter is.
    pub fn new(params: &RenderParams, camera: &Camera, texture: &Texture) -> Result<Self, RenderError> {
        params.validate()?;
        let (width, height) = (params.width, params.height);
        let blur = Blur::new(params.blur_px);
        let lattice = Lattice::new(width, height, blur.margin());
        let widest_mm = widest_mm(camera, width, height);
        let background = params.background.map(f32::from);
        let luma = background.iter().zip(LUMA_WEIGHTS).map(|(level, weight)| level * weight).sum();
        let pixels = if params.colour {
            Pixels::Rgb8(Image::filled(width, height, [0; 3]))
        } else {
            Pixels::Grey8(Image::filled(width, height, 0))
        };
        Ok(Self {
            light: Light::new(params.ring, params.shading),
            background: if params.colour { background } else { [luma; 3] },
            lattice,
            rays: Rays::new(lattice, camera),
            vignette: vignette(camera, params.vignetting, width, height),
            surface: Surface::new(widest_mm),
            patches: Patches::new(lattice, bulge_px(lattice, camera, widest_mm)),
            targets: Vec::new(),
            planes: Planes::new(lattice),
            cells: None,
            parts: PartRows::new(lattice),
            samples: Samples::new(),
            sensor: Sensor::new(&blur, lattice.columns - 1),
            levels: Image::filled(width, height, [0.0; 3]),
            row: vec![0.0; 3 * width],
            pixels,
            simd: Level::new(),
            params: params.clone(),
            camera: camera.clone(),
            texture: texture.clone(),
        })
    }

    /// The parameters.
    #[must_use]
    pub fn params(&self) -> &RenderParams {
        &self.params
    }

    /// The frame of a state at rest. `frame` is the frame's number: each has its own noise.
    ///
    /// # Errors
    ///
    /// [`RenderError`] if the state is not valid, or the pattern's cells are too small for so large a gel.
    pub fn render(&mut self, state: &SurfaceState, frame: u64) -> Result<&Pixels, RenderError> {
        self.render_levels(state)?;
        Ok(self.expose(frame))
    }

    /// The frame of a state during a motion, coming from the state a frame before.
    ///
    /// The motion continues at the same rate while the shutter is open, from half the exposure before the state to half
    /// of it after. So the truth of the state itself is that of the frame's middle.
    ///
    /// # Errors
    ///
    /// [`RenderError`] if a state is not valid or their grids differ.
    pub fn render_moving(
        &mut self,
        before: &SurfaceState,
        state: &SurfaceState,
        frame: u64,
    ) -> Result<&Pixels, RenderError> {
        let blur = self.params.motion_blur;
        let count = blur.sub_frames as f64;
        self.levels.values_mut().fill([0.0; 3]);
        for k in 0..blur.sub_frames {
            let later = blur.exposure * ((k as f64 + 0.5) / count - 0.5);
            self.add(Instant { state, before, later }, 1.0 / count as f32)?;
        }
        Ok(self.expose(frame))
    }

    /// The signal of the sensor, in grey levels, before noise and rounding. Grey repeats its value.
    ///
    /// # Errors
    ///
    /// [`RenderError`] if the state is not valid.
    pub fn render_levels(&mut self, state: &SurfaceState) -> Result<&Image<[f32; 3]>, RenderError> {
        self.levels.values_mut().fill([0.0; 3]);
        self.add(Instant::of(state), 1.0)?;
        Ok(&self.levels)
    }

    /// Adds the surface at an instant to the levels, with a weight.
    fn add(&mut self, instant: Instant, weight: f32) -> Result<(), RenderError> {
        self.surface.take(&self.camera, Some(&self.light), instant)?;
        self.patches.take(&self.surface);
        let borders_mm = self.surface.borders_mm();
        if self.cells.as_ref().is_none_or(|cells| cells.borders_mm() != borders_mm) {
            self.cells = Some(CellTable::new(&self.texture, self.params.colour, borders_mm)?);
        }
        let level = self.simd;
        dispatch!(level, simd => self.draw(simd));
        dispatch!(level, simd => self.develop(simd, weight));
        Ok(())
    }

    /// Finds the surface point at every part corner.
    #[inline(always)]
    fn draw<S: Simd>(&mut self, simd: S) {
        self.planes.clear();
        self.targets.clear();
        self.targets.resize(self.surface.patches(), Target::default());
        for (patch, bounds) in self.patches.iter() {
            let target = Target::new(&self.surface.patch(patch), Patches::beyond(&self.surface, patch));
            self.targets[patch] = target;
            self.planes.draw(simd, self.lattice, &self.rays, &target, bounds);
        }
    }

    /// Computes the colours of the parts and sums the pixels.
    #[inline(always)]
    fn develop<S: Simd>(&mut self, simd: S, weight: f32) {
        let Self { cells, parts, sensor, levels, vignette, samples, lattice, .. } = self;
        let Some(cells) = cells else { return };
        let (planes, patches, background) = (&self.planes, &self.patches, self.background);
        let inputs = ColourInputs { lattice: *lattice, planes, cells, patches, background };
        let scene = Scene { targets: &self.targets, rays: &self.rays };
        let width = levels.width();
        parts.begin(simd, &inputs);
        for row in 0..lattice.rows - 1 {
            parts.next(simd, &inputs, (samples, &scene), row, sensor.row_mut(row));
            let Some(pixel_row) = sensor.completed(row) else { continue };
            let gains = &vignette[pixel_row * width..][..width];
            let levels = levels.row_mut(pixel_row);
            sensor.expose(simd, pixel_row, |column, [red, green, blue, _]| {
                let gain = weight * gains[column];
                levels[column].iter_mut().zip([red, green, blue]).for_each(|(level, value)| *level += gain * value);
            });
        }
    }

    /// Adds noise and rounds.
    fn expose(&mut self, frame: u64) -> &Pixels {
        let Self { params, levels, row: grey, pixels, .. } = self;
        let deviation = params.noise_levels as f32;
        for (row, levels) in levels.rows().enumerate() {
            let stream = noise::stream(params.seed, frame, row as u64);
            match pixels {
                Pixels::Rgb8(image) => {
                    noise::round_row(levels.as_flattened(), deviation, stream, image.row_mut(row).as_flattened_mut());
                }
                Pixels::Grey8(image) => {
                    grey.clear();
                    grey.extend(levels.iter().map(|level| level[0]));
                    noise::round_row(grey, deviation, stream, image.row_mut(row));
                }
                Pixels::Grey16(_) | Pixels::Rgb16(_) => {}
            }
        }
        pixels
    }
}
