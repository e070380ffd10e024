//! The deformed surface relative to the camera: nodes, their pixels and their light.
//!
//! A cell of the state's grid is a bilinear patch. Wide cells are divided, which does not change the surface, so that
//! every patch is small in the image.

use super::RenderError;
use super::light::Light;
use super::node::{Node, cross};
use super::patch::Patch;
use fingervision_elastic::SurfaceState;
use fingervision_optics::Camera;

/// Widest patch that the surface is divided into, px at rest.
const WIDEST_PX: f64 = 16.0;

/// The same if the centre of the image does not show the surface, mm.
const WIDEST_MM: f64 = 1.0;

/// Most lines added along an axis to divide the surface.
const MOST_DIVISIONS: f64 = 1024.0;

/// A line of the divided grid.
#[derive(Debug, Clone, Copy)]
struct Line {
    /// Place at rest, mm.
    rest_mm: f64,
    /// The state's cell in which it lies.
    cell: usize,
    /// How far into that cell, 0 to 1.
    share: f64,
}

/// A surface at an instant: a state, or an interpolation from the previous state.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Instant<'a> {
    pub(crate) state: &'a SurfaceState,
    /// The previous state.
    pub(crate) before: &'a SurfaceState,
    /// Time after the state, as a share of the time since the previous state; less than zero is before it.
    pub(crate) later: f64,
}

impl<'a> Instant<'a> {
    pub(crate) fn of(state: &'a SurfaceState) -> Self {
        Self { state, before: state, later: 0.0 }
    }

    fn displacement(&self, node: usize) -> [f64; 3] {
        let (now, before) = (self.state.displacement_mm[node], self.before.displacement_mm[node]);
        [0, 1, 2].map(|axis| now[axis] + self.later * (now[axis] - before[axis]))
    }
}

/// The surface at an instant, relative to a camera. Owns the memory for it.
#[derive(Debug, Clone)]
pub(crate) struct Surface {
    /// The state's grid lines, mm.
    grid_mm: [Vec<f64>; 2],
    lines: [Vec<Line>; 2],
    /// Widest cell after division, mm.
    widest_mm: f64,
    /// Current positions of the state's nodes, mm in gel space, and their gains.
    points: Vec<([f64; 3], f64)>,
    nodes: Vec<Node>,
}

impl Surface {
    /// No surface yet; its cells will be at most `widest_mm` wide.
    pub(crate) fn new(widest_mm: f64) -> Self {
        Self {
            grid_mm: Default::default(),
            lines: Default::default(),
            widest_mm,
            points: Vec::new(),
            nodes: Vec::new(),
        }
    }

    /// Sets the surface at an instant. Allocates only if the grid changes.
    ///
    /// # Errors
    ///
    /// [`RenderError`] if a state is not valid, or the two states' grids differ.
    pub(crate) fn take(&mut self, camera: &Camera, light: Option<&Light>, instant: Instant) -> Result<(), RenderError> {
        check(instant.state)?;
        if !std::ptr::eq(instant.state, instant.before) {
            check(instant.before)?;
            if !self::same_grid(instant.state, instant.before) {
                return Err(RenderError::OtherGrid);
            }
        }
        self.divide(instant.state);
        self.move_points(instant);
        if let Some(light) = light {
            self.light_points(light);
        }
        self.place_nodes(camera);
        Ok(())
    }

    /// Patches along x and y.
    pub(crate) fn size(&self) -> (usize, usize) {
        (self.lines[0].len() - 1, self.lines[1].len() - 1)
    }

    /// The gel's borders at rest, `[x, y]`, each from least to most, mm.
    pub(crate) fn borders_mm(&self) -> [[f64; 2]; 2] {
        [0, 1].map(|axis| {
            let lines = &self.grid_mm[axis];
            [lines[0], lines[lines.len() - 1]]
        })
    }

    /// How many patches there are.
    pub(crate) fn patches(&self) -> usize {
        self.size().0 * self.size().1
    }

    /// Column and row of a patch.
    pub(crate) fn place(&self, patch: usize) -> (usize, usize) {
        let columns = self.size().0;
        (patch % columns, patch / columns)
    }

    /// Corners of a patch: upper left, upper right, lower left, lower right.
    pub(crate) fn corners(&self, patch: usize) -> [&Node; 4] {
        let ((column, row), stride) = (self.place(patch), self.lines[0].len());
        let first = row * stride + column;
        [first, first + 1, first + stride, first + stride + 1].map(|node| &self.nodes[node])
    }

    /// A patch; patches are numbered row by row.
    pub(crate) fn patch(&self, patch: usize) -> Patch {
        let (column, row) = self.place(patch);
        let (x, y) = (&self.lines[0][column..][..2], &self.lines[1][row..][..2]);
        let rest = [[x[0].rest_mm, y[0].rest_mm], [x[1].rest_mm, y[1].rest_mm]];
        Patch::new(self.corners(patch), rest)
    }

    /// Sets the state's grid and divides its wide cells.
    fn divide(&mut self, state: &SurfaceState) {
        for (axis, grid) in [&state.x_mm, &state.y_mm].into_iter().enumerate() {
            if self.grid_mm[axis] == *grid {
                continue;
            }
            self.grid_mm[axis].clone_from(grid);
            let lines = &mut self.lines[axis];
            lines.clear();
            let widest = self.widest_mm.max((grid[grid.len() - 1] - grid[0]) / MOST_DIVISIONS);
            for (cell, ends) in grid.windows(2).enumerate() {
                let parts = ((ends[1] - ends[0]) / widest).ceil().max(1.0);
                let line = |share: f64| Line { rest_mm: ends[0] + share * (ends[1] - ends[0]), cell, share };
                lines.extend((0..parts as usize).map(|part| line(part as f64 / parts)));
            }
            lines.push(Line { rest_mm: grid[grid.len() - 1], cell: grid.len() - 2, share: 1.0 });
        }
    }

    fn move_points(&mut self, instant: Instant) {
        self.points.clear();
        let [x_mm, y_mm] = &self.grid_mm;
        let rest = y_mm.iter().flat_map(|&y| x_mm.iter().map(move |&x| [x, y, 0.0]));
        self.points.extend(rest.enumerate().map(|(node, rest)| {
            let displacement = instant.displacement(node);
            ([0, 1, 2].map(|axis| rest[axis] + displacement[axis]), 1.0)
        }));
    }

    /// The gain at every node, with a normal from its neighbours on both sides: smooth from patch to patch.
    fn light_points(&mut self, light: &Light) {
        let (columns, rows) = (self.grid_mm[0].len(), self.grid_mm[1].len());
        for row in 0..rows {
            let (above, below) = (row.saturating_sub(1), (row + 1).min(rows - 1));
            for column in 0..columns {
                let (left, right) = (column.saturating_sub(1), (column + 1).min(columns - 1));
                let point = |column: usize, row: usize| self.points[row * columns + column].0;
                let across = difference(point(right, row), point(left, row));
                let down = difference(point(column, below), point(column, above));
                let gain = light.gain(point(column, row), cross(across, down));
                self.points[row * columns + column].1 = gain;
            }
        }
    }

    fn place_nodes(&mut self, camera: &Camera) {
        let columns = self.grid_mm[0].len();
        let camera_mm = camera.position_mm();
        self.nodes.clear();
        for y in &self.lines[1] {
            for x in &self.lines[0] {
                let first = y.cell * columns + x.cell;
                let corners = [first, first + 1, first + columns, first + columns + 1].map(|node| self.points[node]);
                let mix = |value: fn(&([f64; 3], f64), usize) -> f64, axis: usize| {
                    let [a, b, c, d] = [0, 1, 2, 3].map(|corner| value(&corners[corner], axis));
                    (1.0 - y.share) * (a + x.share * (b - a)) + y.share * (c + x.share * (d - c))
                };
                let point = [0, 1, 2].map(|axis| mix(|(point, _), axis| point[axis], axis));
                let gain = mix(|&(_, gain), _| gain, 0);
                let place = [point[0] - camera_mm[0], point[1] - camera_mm[1], camera_mm[2] - point[2]];
                self.nodes.push(Node { place, px: camera.project(point).unwrap_or([f64::NAN; 2]), gain });
            }
        }
    }
}

/// Largest width of a patch at rest for an image of this size, mm.
pub(crate) fn widest_mm(camera: &Camera, width: usize, height: usize) -> f64 {
    let middle = [width, height].map(|size| 0.5 * (size as f64 - 1.0));
    camera.mm_per_px(middle).map_or(WIDEST_MM, |mm_per_px| WIDEST_PX * mm_per_px)
}

/// Whether two states lie on the same grid.
fn same_grid(a: &SurfaceState, b: &SurfaceState) -> bool {
    a.x_mm == b.x_mm && a.y_mm == b.y_mm
}

/// Checks that a state is valid.
///
/// # Errors
///
/// [`RenderError`] names the first error.
pub(crate) fn check(state: &SurfaceState) -> Result<(), RenderError> {
    for (axis, lines) in [('x', &state.x_mm), ('y', &state.y_mm)] {
        let ascend = lines.windows(2).all(|pair| pair[1] - pair[0] > 0.0 && (pair[1] - pair[0]).is_finite());
        if lines.len() < 2 || !ascend {
            return Err(RenderError::GridLines { axis, count: lines.len() });
        }
    }
    let (columns, rows) = (state.x_mm.len(), state.y_mm.len());
    let counts = [("displacement", state.displacement_mm.len()), ("contact", state.in_contact.len())];
    if let Some(&(field, found)) = counts.iter().find(|&&(_, count)| count != columns * rows) {
        return Err(RenderError::NodeCount { field, found, columns, rows });
    }
    let is_finite = |displacement: &[f64; 3]| displacement.iter().all(|value| value.is_finite());
    match state.displacement_mm.iter().position(|displacement| !is_finite(displacement)) {
        Some(node) => {
            Err(RenderError::NotFinite { x_mm: state.x_mm[node % columns], y_mm: state.y_mm[node / columns] })
        }
        None => Ok(()),
    }
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
