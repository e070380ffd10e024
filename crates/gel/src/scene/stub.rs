//! Surfaces by formula, for tests that need a solution but no solver.

use fingervision_elastic::SurfaceState;

/// A round bump of this depth in the middle of the default gel, pressed in over 4 mm, on a coarse grid.
pub(crate) fn bump(depth_mm: f64) -> SurfaceState {
    let lines: Vec<f64> = (-10..=10).map(|line| 1.5 * f64::from(line)).collect();
    let mut state = SurfaceState { x_mm: lines.clone(), y_mm: lines.clone(), ..SurfaceState::default() };
    for (x, y) in lines.iter().flat_map(|&y| lines.iter().map(move |&x| (x, y))) {
        let fall = (-(x * x + y * y) / 16.0).exp();
        let is_touched = depth_mm > 0.0 && x.hypot(y) < 4.0;
        let push = if is_touched { depth_mm * fall } else { 0.0 };
        state.displacement_mm.push([0.1 * depth_mm * x * fall, 0.1 * depth_mm * y * fall, depth_mm * fall]);
        state.nodal_force_n.push([0.0, 0.0, push]);
        state.traction_mpa.push([0.0, 0.0, push / 2.25]);
        state.in_contact.push(is_touched);
        state.force_n[2] += push;
    }
    state
}
