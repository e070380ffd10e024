//! Correction of the force for finite strain, at which a gel is stiffer than at small strain.
//!
//! Four effects make the force of a neo-Hookean block larger than that of the linear one with the same displacement in
//! contact:
//!
//! 1. The gel is compressed.
//! 2. Where gel slides outwards under a face, the touched part of the surface becomes larger than it is at rest.
//! 3. Shear adds to the normal force (Poynting effect [Poynting1909]).
//! 4. Where contact slides, only the side walls of the indenter push along the surface, and they compress the gel in
//!    front of them.
//!
//! Let d be the largest depth, h the thickness, e the mean relative change of the area in contact, s the length of its
//! mean displacement along the surface, and a the radius of a disc with the area of contact. The normal force is
//! multiplied by `1 + 0.25 d / h + 0.3 e + 0.1 s² / (d a)`, shear force and torque by `1 + 0.72 d / h + 0.3 e`, plus
//! 0.09 where contact slides.
//!
//! The coefficients were fitted only to presses of a circle, a sphere and a square:
//!
//! - Normal force: stuck and sliding presses, ν 0.35 and 0.48, 2 mm deep in a gel of 10 mm.
//! - Its last coefficient: 24 presses, 1 and 1.8 mm deep, dragged by 0.8 and 1.5 mm. Each of them alone gives 0.06 to
//!   0.14. `s² / (d a)` is limited to the largest value among them.
//! - Shear force and torque: the mean over 60 presses, displaced along the surface by up to 1.5 mm or turned by 0.3
//!   rad. Single forces are within 4 %, torques within 12 %.
//! - The 0.09: 5 squares without friction, 1.2 to 2 mm deep, displaced by 1.2 mm or turned by 0.16 or 0.3 rad. Their
//!   shear forces alone give 0.05, their torques alone 0.13.

use std::f64::consts::PI;

use fingervision_elastic::SurfaceGrid;

use super::motion::Motion;
use super::surface::neighbours;

/// Relative stiffening by depth over thickness, along the normal.
const BY_DEPTH: f64 = 0.25;
/// The same for shear forces and torque, for which a pressed block is stiffer.
const SHEAR_BY_DEPTH: f64 = 0.72;
/// Relative stiffening by the change of the area in contact.
const BY_SPREAD: f64 = 0.3;
/// Relative stiffening along the normal by [drag](Strain::drag).
const BY_DRAG: f64 = 0.1;
/// Relative stiffening along the surface of contact that [slides](Strain::slide).
const BY_SLIDE: f64 = 0.09;
/// Largest drag of the presses that [`BY_DRAG`] was fitted to: larger values are limited to it.
const MOST_DRAG: f64 = 0.75;

/// The deviation of contact from small strain.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Strain {
    /// Largest depth over the gel's thickness.
    pub depth: f64,
    /// Mean relative change of the area in contact.
    pub spread: f64,
    /// `s² / (d a)`: the square of the mean displacement along the surface over depth and the radius of a disc of the
    /// area.
    pub drag: f64,
    /// How much contact slides, 0 to 1: 1 if its motion along the surface is more than a translation and a rotation.
    pub slide: f64,
}

impl Strain {
    /// Strain of a grid's cells in contact, from their displacement, mm, the largest depth, mm, and the gel's
    /// thickness, mm; the spread is that of cells whose four neighbours are in contact. 0 where there is no contact.
    ///
    /// # Panics
    ///
    /// If a field does not have one entry per cell.
    #[must_use]
    pub fn of(grid: SurfaceGrid, in_contact: &[bool], moved_mm: &[[f32; 3]], depth_mm: f64, thickness_mm: f64) -> Self {
        assert!(in_contact.len() == grid.len() && moved_mm.len() == grid.len(), "one entry a cell");
        let cells = grid.centres_mm().zip(moved_mm).zip(in_contact).filter(|(_, touches)| **touches);
        let motion = Motion::of(cells.map(|((at, &[x, y, _]), _)| (at, [f64::from(x), f64::from(y)])));
        let touched = in_contact.iter().filter(|touches| **touches).count();
        let area_mm2 = touched as f64 * grid.cell_area_mm2();
        Self {
            depth: depth_mm / thickness_mm,
            spread: spread(grid, in_contact, moved_mm),
            drag: motion.map_or(0.0, |motion| drag(motion.shift_mm(), area_mm2, depth_mm)),
            slide: motion.map_or(0.0, |motion| 1.0 - motion.sticking()),
        }
    }

    /// Factors from the linear force `(x, y, z)` to that of a block of finite strain.
    #[must_use]
    pub fn stiffening(self) -> [f64; 3] {
        let by_drag = BY_DRAG * self.drag.min(MOST_DRAG);
        let by_slide = BY_SLIDE * self.slide;
        [(SHEAR_BY_DEPTH, by_slide), (SHEAR_BY_DEPTH, by_slide), (BY_DEPTH, by_drag)]
            .map(|(by_depth, by_motion)| 1.0 + by_depth * self.depth + BY_SPREAD * self.spread + by_motion)
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

/// Drag of contact of this area, mm², for this displacement, mm, and depth, mm.
fn drag([x, y]: [f64; 2], area_mm2: f64, depth_mm: f64) -> f64 {
    let radius_mm = (area_mm2 / PI).sqrt();
    if depth_mm > 0.0 { (x * x + y * y) / (depth_mm * radius_mm) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: SurfaceGrid = SurfaceGrid { columns: 12, rows: 10, cell_mm: 0.5 };

    /// The strain of contact 3 mm by 2 mm, 1 mm deep in 10 mm, with this displacement from where it was.
    fn strain(moved: impl Fn([f64; 2]) -> [f64; 2]) -> Strain {
        let moved: Vec<_> = GRID.centres_mm().map(&moved).map(|[x, y]| [x as f32, y as f32, 1.0]).collect();
        let touches: Vec<_> =
            (0..GRID.len()).map(|cell| (3..9).contains(&(cell % 12)) && (3..7).contains(&(cell / 12))).collect();
        Strain::of(GRID, &touches, &moved, 1.0, 10.0)
    }

    #[test]
    fn contact_that_grows_by_a_tenth_spreads_by_a_tenth() {
        let grown = strain(|[x, y]| [0.06 * x, 0.04 * y]);
        assert!((grown.spread - (1.06 * 1.04 - 1.0)).abs() < 1e-6 && grown.drag < 1e-9, "{grown:?}");
        let nowhere = Strain::of(GRID, &vec![false; GRID.len()], &vec![[1.0; 3]; GRID.len()], 1.0, 10.0);
        assert!(nowhere.spread.abs() < 1e-12 && nowhere.drag.abs() < 1e-12, "nothing is touched");
    }

    #[test]
    fn contact_that_turns_does_not_spread() {
        let (sin, cos) = 0.3_f64.sin_cos();
        let turned = strain(|[x, y]| [cos * x - sin * y - x, sin * x + cos * y - y]);
        assert!(turned.spread.abs() < 1e-6 && turned.drag < 1e-9, "{turned:?}");
    }

    #[test]
    fn shear_adds_to_the_normal_force() {
        let dragged = strain(|_| [0.3, -0.4]);
        let radius_mm = (6.0 / PI).sqrt();
        assert!((dragged.drag - 0.25 / radius_mm).abs() < 1e-6 && dragged.spread.abs() < 1e-6, "{dragged:?}");
        let [along_x, along_y, normal] = dragged.stiffening();
        assert!((along_x - 1.072).abs() < 1e-9 && (along_y - 1.072).abs() < 1e-9);
        assert!((normal - 1.025 - 0.1 * dragged.drag).abs() < 1e-9);
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
        assert!((more[0] - 0.09).abs() < 1e-9 && (more[1] - 0.09).abs() < 1e-9 && more[2].abs() < 1e-12);
    }

    #[test]
    fn a_shallow_press_that_does_not_spread_is_linear() {
        assert!(Strain::default().stiffening().iter().all(|factor| (factor - 1.0).abs() < 1e-12));
        let [_, _, normal] = Strain { depth: 0.2, spread: 0.1, ..Strain::default() }.stiffening();
        assert!((normal - 1.08).abs() < 1e-12);
    }
}
