//! Correction of the force for finite strain, at which a gel is stiffer than at small strain.
//!
//! Four effects make the force of a neo-Hookean block differ from that of the linear one with the same displacement in
//! contact:
//!
//! 1. The gel under wide contact is compressed: it cannot move aside.
//! 2. Where gel slides outwards under a face, the touched part of the surface becomes larger than it is at rest.
//! 3. Shear adds to the normal force (Poynting effect [Poynting1909]).
//! 4. Contact that is deep for its size has to push more gel aside along the surface. Where it slides without friction, only
//!    the side walls of the indenter push along the surface, and they compress the gel in front of them.
//!
//! Let d be the mean depth of contact, h the thickness, a the radius of a disc with the area of contact, e the mean relative
//! change of that area, and s the length of its mean displacement along the surface. The normal force is multiplied by
//! `1 + 0.8 d a / h² − 0.03 d / a + 0.3 e + 0.065 s² / (d a)`, shear force and torque by `1 + 0.29 d / a + 0.22 e`, plus 0.05
//! where contact slides.
//!
//! All coefficients but the last were fitted to 77 presses of the simulator on the medium mesh, from the true displacement in
//! contact: random shapes and sizes, ν 0.3 to 0.5, sticking, sliding and with friction, up to 2.8 mm deep in gels of 7 to 13
//! mm, some dragged by up to 2 mm. All four quantities are limited to their range there. The normal force of
//! presses left out of the fit is right to 0.7 % on average and to 1.8 % in 95 % of the frames, the shear force to 1.2 % and
//! 3.8 %.
//!
//! The 0.05 is a compromise: squares that slide without friction, tracked from images, need 0.02 to 0.12, balls that slide with
//! friction none.

use std::f64::consts::PI;

use fingervision_elastic::SurfaceGrid;

use super::motion::Motion;
use super::surface::neighbours;

/// Relative stiffening along the normal by [confinement](Strain::confinement).
const BY_CONFINEMENT: f64 = 0.8;
/// The same by [narrowness](Strain::narrowness): negative, the normal force of narrow contact is a little smaller.
const BY_NARROWNESS: f64 = -0.03;
/// The same by the change of the area in contact.
const BY_SPREAD: f64 = 0.3;
/// The same by [drag](Strain::drag).
const BY_DRAG: f64 = 0.065;
/// Largest confinement of the presses that [`BY_CONFINEMENT`] was fitted to: larger values are limited to it.
const MOST_CONFINEMENT: f64 = 0.17;
/// Largest narrowness of these presses, and the range of the change of area.
const MOST_NARROWNESS: f64 = 0.65;
const SPREADS: [f64; 2] = [-0.12, 0.25];
/// Largest drag of the presses that [`BY_DRAG`] was fitted to: larger values are limited to it.
const MOST_DRAG: f64 = 2.5;
/// Relative stiffening along the surface by [narrowness](Strain::narrowness).
const SHEAR_BY_NARROWNESS: f64 = 0.29;
/// The same by the change of the area in contact.
const SHEAR_BY_SPREAD: f64 = 0.22;
/// The same for contact that [slides](Strain::slide).
const SHEAR_BY_SLIDE: f64 = 0.05;

/// The deviation of contact from small strain; all numbers are dimensionless.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Strain {
    /// `d a / h²`: the mean depth of contact times the radius of a disc of its area, over the square of the gel's thickness.
    pub confinement: f64,
    /// `d / a`: the mean depth over that radius.
    pub narrowness: f64,
    /// Mean relative change of the area in contact.
    pub spread: f64,
    /// `s² / (d a)`: the square of the mean displacement along the surface over mean depth and radius.
    pub drag: f64,
    /// How much contact slides, 0 to 1: 1 if its motion along the surface is more than a translation and a rotation.
    pub slide: f64,
}

impl Strain {
    /// Strain of a grid's cells in contact, from their displacement, mm, and the gel's thickness, mm; the spread is that of
    /// cells whose four neighbours are in contact. All numbers are 0 where nothing is touched, or where
    /// the mean depth is not positive.
    ///
    /// # Panics
    ///
    /// If a field does not have one entry per cell.
    #[must_use]
    pub fn of(grid: SurfaceGrid, in_contact: &[bool], moved_mm: &[[f32; 3]], thickness_mm: f64) -> Self {
        assert!(in_contact.len() == grid.len() && moved_mm.len() == grid.len(), "one entry a cell");
        let touched = || (0..grid.len()).filter(|&cell| in_contact[cell]);
        let count = touched().count() as f64;
        let depth_mm = touched().map(|cell| f64::from(moved_mm[cell][2])).sum::<f64>() / count;
        let radius_mm = (count * grid.cell_area_mm2() / PI).sqrt();
        let cells = grid.centres_mm().zip(moved_mm).zip(in_contact).filter(|(_, touches)| **touches);
        let motion = Motion::of(cells.map(|((at, &[x, y, _]), _)| (at, [f64::from(x), f64::from(y)])));
        let Some(motion) = motion.filter(|_| depth_mm > 0.0) else { return Self::default() };
        let [x, y] = motion.shift_mm();
        Self {
            confinement: depth_mm * radius_mm / thickness_mm.powi(2),
            narrowness: depth_mm / radius_mm,
            spread: spread(grid, in_contact, moved_mm),
            drag: (x * x + y * y) / (depth_mm * radius_mm),
            slide: 1.0 - motion.sticking(),
        }
    }

    /// Factors from the linear force `(x, y, z)` to that of a block of finite strain.
    #[must_use]
    pub fn stiffening(self) -> [f64; 3] {
        let Self { confinement, drag, slide, .. } = self;
        let (narrowness, spread) = (self.narrowness.min(MOST_NARROWNESS), self.spread.clamp(SPREADS[0], SPREADS[1]));
        let along = 1.0 + SHEAR_BY_NARROWNESS * narrowness + SHEAR_BY_SPREAD * spread + SHEAR_BY_SLIDE * slide;
        let by_shape = BY_CONFINEMENT * confinement.min(MOST_CONFINEMENT) + BY_NARROWNESS * narrowness;
        [along, along, 1.0 + by_shape + BY_SPREAD * spread + BY_DRAG * drag.min(MOST_DRAG)]
    }
}

fn spread(grid: SurfaceGrid, in_contact: &[bool], moved_mm: &[[f32; 3]]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for cell in (0..grid.len()).filter(|&cell| in_contact[cell]) {
        let near = neighbours(grid, cell).filter(|near| near.iter().all(|&near| in_contact[near]));
        let Some([left, right, above, below]) = near else { continue };
        let change = |to: usize, from: usize, axis: usize| {
            f64::from(moved_mm[to][axis] - moved_mm[from][axis]) / (2.0 * grid.cell_mm)
        };
        // The determinant, so that a rotation does not count as a change of area.
        let area = (1.0 + change(right, left, 0)) * (1.0 + change(below, above, 1))
            - change(right, left, 1) * change(below, above, 0);
        sum += area - 1.0;
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: SurfaceGrid = SurfaceGrid { columns: 12, rows: 10, cell_mm: 0.5 };

    /// The strain of contact 3 mm by 2 mm, 0.5 mm deep in 10 mm, with this displacement from where it was.
    fn strain(moved: impl Fn([f64; 2]) -> [f64; 2]) -> Strain {
        let moved: Vec<_> = GRID.centres_mm().map(&moved).map(|[x, y]| [x as f32, y as f32, 0.5]).collect();
        let touches: Vec<_> =
            (0..GRID.len()).map(|cell| (3..9).contains(&(cell % 12)) && (3..7).contains(&(cell / 12))).collect();
        Strain::of(GRID, &touches, &moved, 10.0)
    }

    #[test]
    fn contact_that_grows_by_a_tenth_spreads_by_a_tenth() {
        let grown = strain(|[x, y]| [0.06 * x, 0.04 * y]);
        assert!((grown.spread - (1.06 * 1.04 - 1.0)).abs() < 1e-6 && grown.drag < 1e-9, "{grown:?}");
    }

    #[test]
    fn contact_that_turns_does_not_spread() {
        let (sin, cos) = 0.3_f64.sin_cos();
        let turned = strain(|[x, y]| [cos * x - sin * y - x, sin * x + cos * y - y]);
        assert!(turned.spread.abs() < 1e-6 && turned.drag < 1e-9, "{turned:?}");
    }

    #[test]
    fn depth_counts_relative_to_the_size_of_contact_and_of_the_gel() {
        let radius_mm = (6.0 / PI).sqrt();
        let pressed = strain(|_| [0.0; 2]);
        assert!((pressed.narrowness - 0.5 / radius_mm).abs() < 1e-9, "{pressed:?}");
        assert!((pressed.confinement - 0.5 * radius_mm / 100.0).abs() < 1e-9, "{pressed:?}");
        let [along_x, along_y, normal] = pressed.stiffening();
        assert!((along_x - 1.0 - 0.29 * pressed.narrowness).abs() < 1e-9 && (along_x - along_y).abs() < 1e-12);
        assert!((normal - 1.0 - 0.8 * pressed.confinement + 0.03 * pressed.narrowness).abs() < 1e-9);
    }

    #[test]
    fn shear_adds_to_the_normal_force() {
        let (dragged, pressed) = (strain(|_| [0.3, -0.4]), strain(|_| [0.0; 2]));
        let radius_mm = (6.0 / PI).sqrt();
        assert!((dragged.drag - 0.5 / radius_mm).abs() < 1e-6 && dragged.spread.abs() < 1e-6, "{dragged:?}");
        let more = [0, 1, 2].map(|axis| dragged.stiffening()[axis] - pressed.stiffening()[axis]);
        assert!(more[0].abs() < 1e-6 && more[1].abs() < 1e-6 && (more[2] - 0.065 * dragged.drag).abs() < 1e-6);
    }

    #[test]
    fn beyond_the_fitted_presses_no_factor_grows() {
        let far = |times: f64| {
            let strain = Strain { confinement: times, narrowness: times, spread: times, drag: 3.0 * times, slide: 1.0 };
            strain.stiffening()
        };
        for (once, twice) in far(1.0).into_iter().zip(far(2.0)) {
            assert!((once - twice).abs() < 1e-12, "{once}, and {twice}");
        }
    }

    #[test]
    fn contact_that_slides_is_stiffer_along_the_surface() {
        let slid = strain(|[x, y]| [0.1 + 0.1 * x, 0.1 * y]);
        assert!((slid.slide - 1.0).abs() < 1e-9, "{slid:?}");
        for stuck in [strain(|_| [0.5, 0.0]), strain(|_| [0.0; 2])] {
            assert!(stuck.slide < 1e-9, "{stuck:?}");
        }
        let without = Strain { slide: 0.0, ..slid }.stiffening();
        let more = [0, 1, 2].map(|axis| slid.stiffening()[axis] - without[axis]);
        assert!((more[0] - 0.05).abs() < 1e-9 && (more[1] - 0.05).abs() < 1e-9 && more[2].abs() < 1e-12);
    }

    #[test]
    fn without_contact_there_is_no_strain() {
        let (rest, pulled) = (vec![[0.0; 3]; GRID.len()], vec![[0.0, 0.0, -1.0]; GRID.len()]);
        assert!(Strain::of(GRID, &vec![false; GRID.len()], &rest, 10.0) == Strain::default());
        assert!(Strain::of(GRID, &vec![true; GRID.len()], &pulled, 10.0) == Strain::default());
        assert!(Strain::default().stiffening().iter().all(|factor| (factor - 1.0).abs() < 1e-12));
    }
}
