//! Depth, 3-D displacement and force from the flow, by perspective and the gel's elasticity.
//!
//! The camera gives two equations for the three unknowns of every point ([`surface`]). Elasticity gives the third:
//!
//! 1. A small network, trained on simulated presses, estimates where the gel is touched and how deep ([`network`]).
//!    Around contact it corrects linear elasticity for large strain. The motion caused by shear and twist of contact is then
//!    subtracted, and depth estimated again ([`drag`]).
//! 2. A face that the gel sticks to moves as a rigid body: where that explains the flow to its noise, perspective
//!    determines the depth of the face far more accurately than anything else ([`rigid`]), but for the strain that the
//!    face had when the gel began to stick ([`frozen_strain`]).
//! 3. Contact of any shape that sticks while it is dragged also moves as a rigid body, from the shape that it had before
//!    ([`stuck_shape`]).
//! 4. The tractions that cause the displacement in contact are found; outside contact there are none
//!    ([`traction`]). They give the force and the torque, and show whether the gel is the one described. Without the
//!    network they alone give the displacement around contact.
//! 5. In nearly incompressible gel the motion far from contact shows the normal force, too ([`far_field`]).
//!
//! Elasticity is linear, that of a block with free sides, bonded at its base. The solution is that of small strain:
//! beyond a depth of about a quarter of the thickness it is an approximation.

mod coarse;
mod contact;
mod drag;
mod error;
mod face_search;
mod far_field;
mod fields;
mod fit;
mod frozen_strain;
mod held;
mod motion;
mod nearest;
mod network;
mod network_inputs;
mod params;
mod pixel_sums;
mod rays;
mod rigid;
mod stiffening;
mod stuck_shape;
mod surface;
mod thresholds;
mod to_pixels;
mod traction;
mod untracked;

pub use coarse::{Around, CoarseGrid};
pub use error::ElasticError;
pub use fields::{ElasticFields, TractionGrid};
pub use network::TRAINING_RANGE;
pub use params::{ElasticMode, ElasticParams};
pub use stiffening::Strain;
pub use surface::{Seen, WithoutDrag};
pub use traction::{Limits, Tractions};

use contact::ContactFinder;
use drag::Drag;
use far_field::FarField;
use fingervision_elastic::{BlockOperator, GelBlock, SurfaceGrid};
use fingervision_flow::{FlowField, Team};
use fingervision_image::Image;
use fingervision_optics::Camera;
use fit::Fit;
use held::HeldGel;
use rays::Rays;
use std::sync::OnceLock;
use stuck_shape::StuckShape;
use surface::Surface;
use thresholds::THRESHOLDS;
use to_pixels::{Known, Planes};
use untracked::Untracked;

use crate::whole_motion::WholeMotion;

/// Cells along the gel's longer side.
const CELLS: usize = 120;
/// Largest difference between motion away from contact and elasticity, root mean square, relative to the largest depth plus
/// a part of the motion of contact along the surface.
/// Above it, the flow is not that of the gel in the profile.
pub const MOST_UNEXPLAINED: f64 = THRESHOLDS.most_unexplained;

/// Termination of the solver for tractions in exact mode.
const EXACT: Limits = Limits { tolerance: 1e-3, most_iterations: 30 };
/// The same in live mode.
const LIVE: Limits = Limits { tolerance: 0.03, most_iterations: 8 };

/// The gel's surface as square cells, row by row, its centre in the grid's middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cells<'a> {
    /// The cells.
    pub grid: SurfaceGrid,
    /// The camera's measurement of each cell.
    pub seen: &'a [Seen],
    /// The same without the displacement by shear and twist of contact, in frames where that was subtracted.
    pub without_drag: Option<WithoutDrag<'a>>,
    /// Whether each is touched.
    pub touches: &'a [bool],
    /// Depth of each that is touched, mm.
    pub depth_mm: &'a [f32],
    /// Size of a pixel on the undeformed surface, mm.
    pub mm_per_px: f64,
}

/// Finds indentation from the motion of the gel's surface in the image.
///
/// Owns all scratch memory: no call of [`ElasticDepth::solve`] allocates. The result of a frame depends on previous
/// frames in four ways only: through the start of the solver, within its tolerance; through the strain of a stuck face,
/// which is found while it is pressed down; through the shape of contact before it was dragged; and through a misfit, which
/// remains until the gel fits well, or as well as before it, or is at rest.
#[derive(Debug)]
pub struct ElasticDepth {
    gel: GelBlock,
    /// Whether the network is switched on, but gel and camera are outside its training range.
    is_outside_training: bool,
    surface: Surface,
    /// Made when displacement is asked for the first time.
    rays: OnceLock<Rays>,
    contact: ContactFinder,
    shape: StuckShape,
    /// None where the network is not used.
    drag: Option<Drag>,
    held: HeldGel,
    fit: Fit,
    /// Whether the image of this frame is torn.
    is_torn: bool,
    untracked: Untracked,
    /// What is interpolated from the cells to the pixels.
    cells: Vec<Known>,
    fields: ElasticFields,
    team: Team,
}

impl ElasticDepth {
    /// For one gel and camera; `size` is that of the reference grid, px.
    ///
    /// # Errors
    ///
    /// [`ElasticError::NoSurface`] if the camera sees no point of the gel, [`ElasticError::Gel`] if its elastic model
    /// cannot be made.
    pub fn new(
        camera: &Camera,
        gel: &GelBlock,
        size: (usize, usize),
        params: &ElasticParams,
    ) -> Result<Self, ElasticError> {
        let surface = Surface::new(camera, gel, size, CELLS).ok_or(ElasticError::NoSurface)?;
        let contact = ContactFinder::new(&surface, gel, *params);
        let (part, limits) = match params.mode {
            // The network estimates depth everywhere: tractions give only force and shear, and larger cells suffice.
            ElasticMode::Live if contact.uses_network() => (2, LIVE),
            ElasticMode::Live => (1, LIVE),
            ElasticMode::Exact => (1, EXACT),
        };
        let coarse = CoarseGrid::new(surface.grid, part);
        let operator = BlockOperator::new(gel, coarse.grid)?;
        let drag = contact.uses_network().then(|| operator.on_grid(coarse.grid)).transpose()?;
        let drag = drag.map(|operator| Drag::new(surface.grid.len(), coarse, operator, limits));
        let held = HeldGel::new(coarse, operator, limits);
        let fields = ElasticFields::at_rest(gel, held.grid(), size, |pixel| surface.shows(pixel));
        let cells = vec![Known::default(); surface.grid.len()];
        let untracked = Untracked::new(surface.grid);
        let is_outside_training = params.is_outside_training(camera, gel);
        Ok(Self {
            gel: *gel,
            is_outside_training,
            contact,
            shape: StuckShape::new(surface.grid),
            drag,
            held,
            fit: Fit::default(),
            is_torn: false,
            untracked,
            cells,
            surface,
            rays: OnceLock::new(),
            fields,
            team: Team::default(),
        })
    }

    /// Shares the work of a frame among the threads of a team, on one of which [`Self::solve`] should be called ([`Team::run`]).
    /// The result is the same, bit for bit.
    pub fn share(&mut self, team: &Team) {
        self.contact.share(team);
        self.surface.share(team);
        self.team = team.clone();
    }

    /// The fields of one frame, from its flow, px, the deviation of the flow, px, and its validity.
    ///
    /// # Panics
    ///
    /// If the fields are not of the size that was given.
    pub fn solve(&mut self, flow: &FlowField, deviation: &Image<f32>, valid: &Image<u8>) -> &ElasticFields {
        self.surface.look(flow, deviation, valid);
        let still_mm = self.contact.take_noise(&self.surface);
        if self.surface.largest_apparent_mm() < still_mm {
            self.rest(still_mm);
            self.fields.is_flow_uncertain = self.contact.is_flow_uncertain;
            return &self.fields;
        }
        self.fields.is_at_rest = false;
        self.find_contact();
        self.held.hold(&self.surface, &self.contact);
        self.write_fields();
        let deepest_mm = self.deepest_mm();
        self.write_figures(deepest_mm);
        if self.is_torn || self.fields.is_unexplained || self.fields.is_flow_uncertain || self.fields.is_untracked {
            self.contact.discard_strain();
        } else if self.contact.uses_network() {
            self.take_shape();
        }
        self.write_force();
        &self.fields
    }

    /// Says what is known of the next frame: whether its image is torn, so that later frames use nothing of it, and how the whole image has
    /// moved on the untouched gel, which is undone. Without a note no image is torn and none has moved.
    pub(crate) fn note(&mut self, is_torn: bool, untouched_motion: WholeMotion) {
        (self.is_torn, self.surface.untouched_motion) = (is_torn, untouched_motion);
    }

    /// Takes note of a frame whose flow is not to be used. The fields remain those of the frame before.
    pub fn skip(&mut self) {
        self.contact.skip();
        self.shape.skip();
    }

    /// Finds contact and its depth: contact from the whole motion, then the displacement by shear and twist, then the depth
    /// without it. If a frame used that of the previous frame instead, jumps would give wrong depths, and contact and shear
    /// would change each other from frame to frame even in a still image.
    fn find_contact(&mut self) {
        self.shape.begin();
        self.contact.find(&self.surface);
        let Some(drag) = &mut self.drag else { return };
        drag.find(&self.surface, &self.contact);
        if let Some(without_drag) = drag.found() {
            self.contact.find_depth(&self.surface, without_drag);
        }
        if self.is_dragged() && !self.contact.has_face() {
            self.contact.hold_to_shape(&self.surface, &mut self.shape);
        }
    }

    /// Takes the shape of contact in a frame that is to be trusted. If contact is dragged, the shape is that of an earlier
    /// frame, and is forgotten where contact slid.
    fn take_shape(&mut self) {
        if self.is_dragged() {
            self.shape.forget_if_slid();
            return;
        }
        let contact = &self.contact;
        self.shape.take(&self.surface, &contact.touches, &contact.depth_mm, |cell| contact.deviation_mm(cell, 0.0));
    }

    /// Whether contact moved along the surface, so that its shape is that of an earlier frame.
    fn is_dragged(&self) -> bool {
        self.drag.as_ref().is_some_and(|drag| drag.ratio() > THRESHOLDS.least_drag)
    }

    /// The estimates of the last frame, cell by cell.
    #[must_use]
    pub fn cells(&self) -> Cells<'_> {
        let ContactFinder { touches, depth_mm, .. } = &self.contact;
        Cells {
            grid: self.surface.grid,
            seen: &self.surface.seen,
            without_drag: self.drag.as_ref().and_then(Drag::found),
            touches,
            depth_mm,
            mm_per_px: self.surface.mm_per_px,
        }
    }

    /// The fields of the last frame; before the first one those of a gel at rest.
    #[must_use]
    pub fn fields(&self) -> &ElasticFields {
        &self.fields
    }

    /// The same, mutable, so that its planes can be exchanged; the next frame overwrites the planes put in their place.
    pub(crate) fn fields_mut(&mut self) -> &mut ElasticFields {
        &mut self.fields
    }

    /// Displacement `(x, y, z)`, mm, at every pixel, from the last frame's depth and its flow: each point lies on the
    /// ray of the pixel where it is seen, at its depth. Zero where the pixel does not show the gel.
    pub fn displacement_into(&self, flow: &FlowField, displacement_mm: &mut [Image<f32>; 3]) {
        let [x_mm, y_mm, z_mm] = displacement_mm;
        z_mm.copy_from(&self.fields.depth_mm);
        let (moved, shows) = (&self.surface.untouched_motion, |pixel| self.surface.shows(pixel));
        self.rays().lateral_into(flow, moved, z_mm, shows, [x_mm, y_mm]);
    }

    /// Makes the rays of the pixels, which only the displacement needs. Otherwise its first call does, which takes as long as
    /// some frames.
    pub(crate) fn prepare_displacement(&self) {
        self.rays();
    }

    fn rays(&self) -> &Rays {
        self.rays.get_or_init(|| self.surface.rays())
    }

    /// Forgets the previous frames: the next results are those of a new object, bit for bit. Allocates nothing.
    pub fn restart(&mut self) {
        self.surface.untouched_motion = WholeMotion::NONE;
        self.rest(THRESHOLDS.still_px * self.surface.mm_per_px);
    }

    /// Sets the result to a gel at rest, for a frame in which motion above `still_mm` would be detected.
    fn rest(&mut self, still_mm: f64) {
        // From one frame at rest to the next, nothing of these changes.
        if !self.fields.is_at_rest {
            self.held.rest();
            if let Some(drag) = &mut self.drag {
                drag.rest();
            }
            self.contact.rest();
            self.shape.forget();
            self.fit.rest();
        }
        self.fields.rest(still_mm / (THRESHOLDS.still_px * self.surface.mm_per_px));
    }

    fn write_fields(&mut self) {
        // Without the network, the tractions give the depth of the free gel.
        let moved = (!self.contact.uses_network()).then(|| self.held.displacement_mm());
        // Without the network and without a face, no depth is known.
        let is_known = self.contact.uses_network() || self.contact.has_face();
        for (cell, values) in self.cells.iter_mut().enumerate() {
            let around_mm = moved.map_or(0.0, |moved| moved[cell][2]);
            let is_estimated = moved.is_none() || self.contact.touches[cell];
            let depth = if is_estimated { self.contact.depth_mm[cell] } else { around_mm };
            *values = [depth, self.contact.deviation_mm(cell, around_mm), self.contact.share[cell], 0.0];
        }
        let ElasticFields { depth_mm, deviation_mm, contact, .. } = &mut self.fields;
        let planes = Planes {
            depth_mm: depth_mm.values_mut(),
            deviation_mm: deviation_mm.values_mut(),
            contact: contact.values_mut(),
        };
        self.surface.write_pixels(&self.cells, planes);
        if !is_known {
            deviation_mm.values_mut().fill(f32::INFINITY);
        }
    }

    /// Writes area, flags and force.
    fn write_figures(&mut self, deepest_mm: f64) {
        let thickness_mm = self.gel.thickness_mm;
        let touched = self.contact.touches.iter().filter(|touches| **touches).count();
        self.fields.contact_area_mm2 = (touched as f64 * self.surface.grid.cell_area_mm2()) as f32;
        let most_drag = THRESHOLDS.most_drag[usize::from(self.contact.sticks())];
        let is_dragged_far = self.drag.as_ref().is_some_and(|drag| drag.ratio() > most_drag);
        self.fields.is_beyond_linear = deepest_mm > THRESHOLDS.linear_range * thickness_mm || is_dragged_far;
        self.fields.is_flow_uncertain = self.contact.is_flow_uncertain;
        self.fields.is_cut = self.contact.is_cut(&self.surface);
        self.fields.is_outside_training = self.is_outside_training;
        self.fields.is_untracked = self.untracked.is_untracked(&self.surface, &self.contact.touches, touched);
        let farthest_mm = deepest_mm + THRESHOLDS.shear_over_depth * self.drag.as_ref().map_or(0.0, Drag::moved_mm);
        let unexplained = self.held.unexplained(thickness_mm, farthest_mm, self.surface.mm_per_px);
        self.fields.unexplained = unexplained.map(|motion| motion.part as f32);
        self.fields.is_unexplained = self.fit.is_misfit(unexplained, !self.is_torn);
        self.fields.is_misfit = self.fields.is_unexplained && !self.fields.is_flow_uncertain;
    }

    fn deepest_mm(&self) -> f64 {
        let depths = self.contact.depth_mm.iter().zip(&self.contact.touches).filter(|(_, touches)| **touches);
        f64::from(depths.map(|(&depth, _)| depth).fold(0.0, f32::max))
    }

    fn write_force(&mut self) {
        let Some(modulus) = self.gel.youngs_modulus_mpa else { return };
        let shear_modulus = modulus / (2.0 * (1.0 + self.gel.poissons_ratio));
        let strain = self.held.strain(self.gel.thickness_mm, self.contact.sticks());
        let mut factors = strain.stiffening();
        factors[2] *= self.by_far_field(strain);
        let grid = &mut self.fields.traction_mpa;
        let (force, torque) = self.held.force(shear_modulus, factors, |cell, traction| {
            if let Some(grid) = grid {
                grid.traction_mpa[cell] = traction.map(|value| value as f32);
            }
        });
        self.fields.force_n = Some(force.map(|value| value as f32));
        self.fields.torque_nmm = Some(torque as f32);
    }

    /// The factor by which the motion far from contact corrects the normal force.
    fn by_far_field(&mut self, strain: Strain) -> f64 {
        let is_seen_whole = self.contact.uses_network() && !self.fields.is_cut && !self.fields.is_flow_uncertain;
        if !is_seen_whole || !FarField::is_telling(self.gel.poissons_ratio) {
            return 1.0;
        }
        let far = self.held.far_field(self.gel.thickness_mm, self.is_dragged());
        far.correction(strain, self.contact.relative_deviation(), self.contact.noise_mm())
    }
}
