//! The point of the gel that each reference pixel sees.

use fingervision_elastic::SurfaceState;
use fingervision_optics::Camera;

/// A point of the undeformed surface in its cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Located {
    /// The point, mm.
    pub(super) rest_mm: [f64; 2],
    /// The cell's first node.
    node: u32,
    /// How far into the cell along x and y, 0 to 1.
    shares: [f64; 2],
}

impl Located {
    /// Finds the point of the undeformed surface at a pixel, on a state's grid; none beside the gel.
    pub(super) fn new(camera: &Camera, px: [f64; 2], state: &SurfaceState) -> Option<Self> {
        let rest_mm = camera.surface_point(px, 0.0)?;
        let (column, across) = place(&state.x_mm, rest_mm[0])?;
        let (row, down) = place(&state.y_mm, rest_mm[1])?;
        Some(Self { rest_mm, node: (row * state.x_mm.len() + column) as u32, shares: [across, down] })
    }

    /// The bilinear mean of a field of the grid's nodes, with `columns` nodes a row.
    pub(super) fn mean<const N: usize>(&self, columns: usize, value: impl Fn(usize) -> [f64; N]) -> [f64; N] {
        let first = self.node as usize;
        let [a, b, c, d] = [first, first + 1, first + columns, first + columns + 1].map(value);
        let [s, t] = self.shares;
        std::array::from_fn(|k| (1.0 - t) * (a[k] + s * (b[k] - a[k])) + t * (c[k] + s * (d[k] - c[k])))
    }
}

/// The interval between ascending lines in which a value lies, and how far in; none outside.
fn place(lines: &[f64], value: f64) -> Option<(usize, f64)> {
    let last = lines.len() - 1;
    if !(lines[0]..=lines[last]).contains(&value) {
        return None;
    }
    let interval = lines.partition_point(|&line| line <= value).clamp(1, last) - 1;
    Some((interval, (value - lines[interval]) / (lines[interval + 1] - lines[interval])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_placed_between_its_lines() {
        let lines = [-1.0, 0.0, 4.0];
        assert_eq!(place(&lines, -1.0), Some((0, 0.0)));
        assert_eq!(place(&lines, 1.0), Some((1, 0.25)));
        assert_eq!(place(&lines, 4.0), Some((1, 1.0)));
        assert_eq!(place(&lines, 4.0001), None);
        assert_eq!(place(&lines, f64::NAN), None);
    }
}
