//! The tractions that cause the displacement in contact, their force and torque, and whether they explain the motion of
//! the gel around contact.

use fingervision_elastic::{BlockOperator, SurfaceGrid};

use super::coarse::CoarseGrid;
use super::contact::ContactFinder;
use super::far_field::FarField;
use super::fit::Unexplained;
use super::motion::Motion;
use super::nearest::Nearest;
use super::stiffening::Strain;
use super::surface::{Seen, Surface};
use super::thresholds::THRESHOLDS;
use super::traction::{Limits, Tractions};

/// Prescribes the displacement of the gel in contact.
#[derive(Debug)]
pub(super) struct HeldGel {
    coarse: CoarseGrid,
    limits: Limits,
    tractions: Tractions,
    seen: Vec<Seen>,
    touches: Vec<bool>,
    wanted_mm: Vec<[f32; 3]>,
    /// Places away from contact, and the motion there that the tractions do not explain.
    left_mm: Vec<([f64; 2], [f64; 2])>,
    /// The nearest cell in contact for each cell.
    nearest: Nearest,
}

impl HeldGel {
    /// A gel at rest; `operator` is its compliance on the grid of `coarse`.
    pub(super) fn new(coarse: CoarseGrid, operator: BlockOperator, limits: Limits) -> Self {
        let cells = coarse.grid.len();
        Self {
            coarse,
            limits,
            tractions: Tractions::new(operator),
            seen: vec![Seen::default(); cells],
            touches: vec![false; cells],
            wanted_mm: vec![[0.0; 3]; cells],
            left_mm: Vec::with_capacity(cells),
            nearest: Nearest::new((coarse.grid.columns, coarse.grid.rows)),
        }
    }

    /// The cells that the tractions act on.
    pub(super) fn grid(&self) -> SurfaceGrid {
        self.coarse.grid
    }

    /// Displacement of the cells, mm.
    pub(super) fn displacement_mm(&self) -> &[[f32; 3]] {
        self.tractions.displacement_mm()
    }

    /// Forgets the previous frames.
    pub(super) fn rest(&mut self) {
        self.tractions.rest();
    }

    /// Finds tractions that cause the displacement in contact.
    pub(super) fn hold(&mut self, surface: &Surface, contact: &ContactFinder) {
        self.gather(surface, contact);
        self.tractions.hold(&self.touches, &self.wanted_mm, self.limits);
    }

    /// Transfers values of the surface's cells to the larger cells, as the mean around each centre.
    fn gather(&mut self, surface: &Surface, contact: &ContactFinder) {
        for (cell, around) in self.coarse.around().enumerate() {
            let seen = Seen {
                apparent_mm: [0, 1].map(|axis| around.mean(|cell| surface.seen[cell].apparent_mm[axis])),
                slope: [0, 1].map(|axis| around.mean(|cell| surface.seen[cell].slope[axis])),
                trust: around.mean(|cell| surface.seen[cell].trust),
                deviation_mm: around.mean(|cell| surface.seen[cell].deviation_mm),
            };
            let depth = around.mean(|cell| contact.depth_mm[cell]);
            let [x, y] = seen.lateral_mm(depth);
            self.touches[cell] = contact.touches_around(around);
            (self.seen[cell], self.wanted_mm[cell]) = (seen, [x, y, depth]);
        }
    }

    /// Difference between measured motion along the surface and the motion that the tractions predict, away from
    /// contact and beyond the error of the flow: root mean square over `farthest_mm`. Without contact, the whole
    /// surface is compared. None if the motion is too small.
    pub(super) fn unexplained(&mut self, thickness_mm: f64, farthest_mm: f64, mm_per_px: f64) -> Option<Unexplained> {
        let away = THRESHOLDS.away * thickness_mm / self.grid().cell_mm;
        self.nearest.find(&self.touches);
        self.left_mm.clear();
        let moved = self.tractions.displacement_mm();
        let (mut all, mut error) = (0.0, 0.0);
        for (cell, at_mm) in self.coarse.grid.centres_mm().enumerate() {
            let (seen, moved) = (&self.seen[cell], moved[cell]);
            if self.nearest.distance(cell) <= away || !seen.is_tracked() {
                continue;
            }
            let left_mm = [0, 1].map(|axis| seen.apparent_mm[axis] - (moved[axis] + seen.slope[axis] * moved[2]));
            self.left_mm.push((at_mm, left_mm.map(f64::from)));
            all += seen.apparent_mm.iter().map(|&moved| f64::from(moved).powi(2)).sum::<f64>();
            error += (THRESHOLDS.flow_deviations * f64::from(seen.deviation_mm)).powi(2);
        }
        let count = self.left_mm.len() as f64;
        let least_mm = THRESHOLDS.least_motion_px * mm_per_px;
        if all - error <= count * least_mm * least_mm {
            return None;
        }
        let even = Motion::of(self.left_mm.iter().copied())?;
        let left_mm = (even.whole_mm().powi(2) - error / count).max(0.0).sqrt();
        let farthest_mm = farthest_mm.max(least_mm);
        Some(Unexplained { part: left_mm / farthest_mm, even: even.mean_mm() / farthest_mm, farthest_mm })
    }

    /// The motion far from contact and what the tractions contribute to it, for a gel of this thickness, mm, and without the
    /// twentieth of the gel at each side. Needs [`Self::unexplained`] of the same frame. Without shear all tractions count as
    /// those along the normal, which saves a product with the compliance.
    pub(super) fn far_field(&mut self, thickness_mm: f64, is_sheared: bool) -> FarField {
        let SurfaceGrid { columns, rows, cell_mm } = self.grid();
        let away = THRESHOLDS.away * thickness_mm / cell_mm;
        let [beside_x, beside_y] = [columns, rows].map(|count| count / 20);
        let mut far = FarField::default();
        if is_sheared {
            self.tractions.find_normal();
        }
        let (by_all, by_normal) = (self.tractions.displacement_mm(), self.tractions.by_normal_mm());
        let by_normal = if is_sheared { by_normal } else { by_all };
        for row in beside_y..rows - beside_y {
            for cell in row * columns + beside_x..(row + 1) * columns - beside_x {
                if self.nearest.distance(cell) > away && self.seen[cell].is_tracked() {
                    far.add(&self.seen[cell], by_all[cell], by_normal[cell]);
                }
            }
        }
        far
    }

    /// Strain in contact; what is known to stick does not slide.
    pub(super) fn strain(&self, thickness_mm: f64, sticks: bool) -> Strain {
        let strain = Strain::of(self.grid(), &self.touches, &self.wanted_mm, thickness_mm);
        if sticks { Strain { slide: 0.0, ..strain } } else { strain }
    }

    /// Force `(x, y, z)`, N, and torque about the z axis through the centre of contact, N mm, for a gel of this shear
    /// modulus, with these factors for the three directions; passes the traction of each cell, `MPa`, to `write`.
    pub(super) fn force(
        &self,
        shear_modulus_mpa: f64,
        factors: [f64; 3],
        mut write: impl FnMut(usize, [f64; 3]),
    ) -> ([f64; 3], f64) {
        let factors = factors.map(|factor| factor * shear_modulus_mpa);
        let centre = self.centre_mm();
        let area = self.grid().cell_area_mm2();
        let (mut force, mut torque) = ([0.0; 3], 0.0);
        let cells = self.grid().centres_mm().zip(self.tractions.traction()).zip(&self.wanted_mm);
        for (cell, (([x, y], traction), moved)) in cells.enumerate() {
            let traction = [0, 1, 2].map(|axis| factors[axis] * f64::from(traction[axis]));
            write(cell, traction);
            if !self.touches[cell] {
                continue;
            }
            let arm = [x + f64::from(moved[0]) - centre[0], y + f64::from(moved[1]) - centre[1]];
            for axis in 0..3 {
                force[axis] += area * traction[axis];
            }
            torque += area * (arm[0] * traction[1] - arm[1] * traction[0]);
        }
        (force, torque)
    }

    /// The current middle of contact, mm.
    fn centre_mm(&self) -> [f64; 2] {
        let (mut sum, mut count) = ([0.0; 2], 0.0);
        let cells = self.grid().centres_mm().zip(&self.wanted_mm).zip(&self.touches);
        for ((at, moved), _) in cells.filter(|(_, touches)| **touches) {
            for axis in 0..2 {
                sum[axis] += at[axis] + f64::from(moved[axis]);
            }
            count += 1.0;
        }
        sum.map(|sum| if count > 0.0 { sum / count } else { 0.0 })
    }
}
