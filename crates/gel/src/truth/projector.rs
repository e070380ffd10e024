use super::located::Located;
use crate::render::{Instant, Lattice, Patches, RenderError, Surface, bulge_px, check, widest_mm};
use fingervision_elastic::SurfaceState;
use fingervision_image::Image;
use fingervision_optics::Camera;

/// Share of a cell's corners in contact, bilinear between them, from which a point is.
const CONTACT: f64 = 0.5;

/// Two meetings of a ray with the surface are one if they lie closer than this at rest, mm.
const SAME_POINT_MM: f64 = 1e-3;

/// The truth of a frame on the reference grid: the value at a pixel belongs to the point of the gel that this pixel
/// sees while the gel is undeformed.
///
/// Where the pixel sees no gel, all numbers are NaN and both masks 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// The displacement of the point in the image, to the right and down, px.
    pub flow: Image<[f32; 2]>,
    /// The surface's displacement towards the camera, mm, positive pressed in.
    pub depth: Image<f32>,
    /// The surface's displacement, mm, gel space.
    pub displacement: Image<[f32; 3]>,
    /// 1 where the surface touches the indenter: where the nodes' contact, 0 or 1 and bilinear between them, reaches ½.
    pub contact: Image<u8>,
    /// 1 where the point is in the frame, hidden by no other part of the surface.
    pub visible: Image<u8>,
}

/// Tells the truth of frames. Made once for a camera, an image size and a grid.
#[derive(Debug, Clone)]
pub struct TruthProjector {
    camera: Camera,
    lattice: Lattice,
    /// The grid that pixels are located on, mm.
    grid_mm: [Vec<f64>; 2],
    located: Vec<Option<Located>>,
    surface: Surface,
    patches: Patches,
    truth: Truth,
}

impl TruthProjector {
    /// A projector for images of this size, px.
    #[must_use]
    pub fn new(camera: &Camera, width: usize, height: usize) -> Self {
        let lattice = Lattice::new(width, height, 0);
        let widest_mm = widest_mm(camera, width, height);
        Self {
            camera: camera.clone(),
            lattice,
            grid_mm: Default::default(),
            located: vec![None; width * height],
            surface: Surface::new(widest_mm),
            patches: Patches::new(lattice, bulge_px(lattice, camera, widest_mm)),
            truth: Truth {
                flow: Image::filled(width, height, [f32::NAN; 2]),
                depth: Image::filled(width, height, f32::NAN),
                displacement: Image::filled(width, height, [f32::NAN; 3]),
                contact: Image::filled(width, height, 0),
                visible: Image::filled(width, height, 0),
            },
        }
    }

    /// The truth of a state. Pixels are located once for all states on one grid.
    ///
    /// # Errors
    ///
    /// [`RenderError`] if the state is not one.
    pub fn project(&mut self, state: &SurfaceState) -> Result<&Truth, RenderError> {
        check(state)?;
        self.locate(state);
        self.surface.take(&self.camera, None, Instant::of(state))?;
        self.patches.take(&self.surface);
        for pixel in 0..self.located.len() {
            self.tell(pixel, state);
        }
        Ok(&self.truth)
    }

    fn locate(&mut self, state: &SurfaceState) {
        if self.grid_mm[0] == state.x_mm && self.grid_mm[1] == state.y_mm {
            return;
        }
        self.grid_mm = [state.x_mm.clone(), state.y_mm.clone()];
        let width = self.truth.depth.width();
        for (pixel, located) in self.located.iter_mut().enumerate() {
            *located = Located::new(&self.camera, px(pixel, width), state);
        }
    }

    /// Writes all values of one pixel.
    fn tell(&mut self, pixel: usize, state: &SurfaceState) {
        let Self { camera, truth, .. } = self;
        let Some(located) = self.located[pixel] else {
            truth.flow.values_mut()[pixel] = [f32::NAN; 2];
            truth.depth.values_mut()[pixel] = f32::NAN;
            truth.displacement.values_mut()[pixel] = [f32::NAN; 3];
            truth.contact.values_mut()[pixel] = 0;
            truth.visible.values_mut()[pixel] = 0;
            return;
        };
        let columns = state.x_mm.len();
        let displacement = located.mean(columns, |node| state.displacement_mm[node]);
        let [contact] = located.mean(columns, |node| [f64::from(u8::from(state.in_contact[node]))]);
        let [x, y] = located.rest_mm;
        let point = [x + displacement[0], y + displacement[1], displacement[2]];
        let [from_x, from_y] = px(pixel, truth.depth.width());
        let now = camera.project(point);
        let flow = now.map_or([f64::NAN; 2], |[x, y]| [x - from_x, y - from_y]);
        truth.flow.values_mut()[pixel] = flow.map(|value| value as f32);
        truth.depth.values_mut()[pixel] = displacement[2] as f32;
        truth.displacement.values_mut()[pixel] = displacement.map(|value| value as f32);
        truth.contact.values_mut()[pixel] = u8::from(contact >= CONTACT);
        let is_visible = now.is_some_and(|now| self.is_visible(&located, point, now));
        self.truth.visible.values_mut()[pixel] = u8::from(is_visible);
    }

    /// Whether a point of the surface that appears at `px` is in the image and nothing is before it.
    fn is_visible(&self, located: &Located, point: [f64; 3], px: [f64; 2]) -> bool {
        let corner = px.map(|px| self.lattice.corner(px));
        let parts = [self.lattice.columns - 1, self.lattice.rows - 1];
        if (0..2).any(|axis| !(0.0..=parts[axis] as f64).contains(&corner[axis])) {
            return false;
        }
        let part = (corner[0].min(parts[0] as f64 - 1.0) as usize, corner[1].min(parts[1] as f64 - 1.0) as usize);
        if !self.patches.may_fold(part.0, part.1) {
            return true;
        }
        let camera_mm = self.camera.position_mm();
        let down = camera_mm[2] - point[2];
        let slope = [0, 1].map(|axis| (point[axis] - camera_mm[axis]) / down);
        let is_other =
            |rest: [f64; 2]| (rest[0] - located.rest_mm[0]).hypot(rest[1] - located.rest_mm[1]) > SAME_POINT_MM;
        let mut around = self.patches.around(part);
        !around.any(|patch| {
            let patch = self.surface.patch(patch);
            patch.meetings(slope).any(|meeting| meeting.down_mm < down && is_other(meeting.rest_mm))
        })
    }
}

/// Where a pixel lies.
fn px(pixel: usize, width: usize) -> [f64; 2] {
    [pixel % width, pixel / width].map(|index| index as f64)
}
