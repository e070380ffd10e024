//! The surface as the result of a press.

use super::Press;
use super::touch::Touch;
use crate::SurfaceState;

impl Press<'_> {
    /// Writes the current state.
    pub(super) fn write_state(&mut self) {
        self.finish_report();
        let [x_mm, y_mm, _] = self.assembly.mesh.lines().map(<[f64]>::to_vec);
        let areas: Vec<f64> =
            widths(&y_mm).iter().flat_map(|dy| widths(&x_mm).into_iter().map(move |dx| dx * dy)).collect();
        let mut state = SurfaceState { x_mm, y_mm, ..SurfaceState::default() };
        let (mut centre, mut touched_mm2) = ([0.0; 3], 0.0);
        let grid = self.assembly.grid;
        for (surface, area) in areas.into_iter().enumerate() {
            let (i, j) = (surface % grid.nodes[0], surface / grid.nodes[0]);
            let index = grid.index(i, j, 0);
            let in_contact = self.touches[surface] != Touch::Free;
            let force = if in_contact { self.forces[index] } else { [0.0; 3] };
            let (node, displacement) = (self.assembly.mesh.node(i, j, 0), self.displacement[index]);
            let place = [0, 1, 2].map(|c| node[c] + displacement[c]);
            let turning = cross(place, force);
            for c in 0..3 {
                state.force_n[c] += force[c];
                state.torque_nmm[c] += turning[c];
                centre[c] += if in_contact { area * place[c] } else { 0.0 };
            }
            touched_mm2 += if in_contact { area } else { 0.0 };
            state.displacement_mm.push(displacement);
            state.nodal_force_n.push(force);
            state.traction_mpa.push(force.map(|force| force / area));
            state.in_contact.push(in_contact);
        }
        if touched_mm2 > 0.0 {
            let by_place = cross(centre.map(|sum| sum / touched_mm2), state.force_n);
            state.torque_nmm = [0, 1, 2].map(|c| state.torque_nmm[c] - by_place[c]);
        }
        self.state = state;
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|c| {
        let (next, last) = ((c + 1) % 3, (c + 2) % 3);
        a[next] * b[last] - a[last] * b[next]
    })
}

/// Length that each line represents: half the distance to each neighbour, mm.
fn widths(lines: &[f64]) -> Vec<f64> {
    let at = |n: usize| lines[n.min(lines.len() - 1)];
    (0..lines.len()).map(|n| 0.5 * (at(n + 1) - at(n.saturating_sub(1)))).collect()
}
