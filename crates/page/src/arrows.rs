//! Displacement along the surface and traction on a coarse grid, for arrows.

use fingervision_optics::Camera;
use fingervision_touch::{Profile, Reading, TractionGrid};

/// Arrows along the longer side.
const MOST_ARROWS: usize = 16;

/// The positions of a sensor's arrows, and the cells of the traction grid that belong to each.
#[derive(Debug)]
pub(crate) struct ArrowGrid {
    columns: usize,
    rows: usize,
    /// Side of the area that an arrow represents, px.
    pitch: usize,
    /// For each cell of the traction grid, its arrow; none outside the picture.
    arrow_of_cell: Vec<Option<usize>>,
}

impl ArrowGrid {
    pub(crate) fn new(profile: &Profile, reading: &Reading) -> Self {
        let (width, height) = reading.valid.size();
        let pitch = width.max(height).div_ceil(MOST_ARROWS).max(1);
        let (columns, rows) = (width / pitch, height / pitch);
        let camera = profile.camera.and_then(|params| Camera::new(&params).ok());
        let arrow_of_cell = match (&reading.traction, camera) {
            (Some(grid), Some(camera)) => cells(grid, &camera, pitch, [columns, rows]),
            _ => Vec::new(),
        };
        Self { columns, rows, pitch, arrow_of_cell }
    }

    pub(crate) fn size(&self) -> [usize; 2] {
        [self.columns, self.rows]
    }

    /// Appends displacement, then traction, of every arrow.
    pub(crate) fn write(&self, reading: &Reading, out: &mut Vec<u8>) {
        for row in 0..self.rows {
            for column in 0..self.columns {
                let [x, y] = [column, row].map(|index| index * self.pitch + self.pitch / 2);
                out.extend(displacement(reading, x, y).into_iter().flat_map(f32::to_le_bytes));
            }
        }
        let tractions = reading.traction.as_ref().map_or_else(Vec::new, |grid| self.mean_tractions(grid));
        for arrow in 0..self.columns * self.rows {
            let traction = tractions.get(arrow).copied().unwrap_or([f32::NAN; 3]);
            out.extend(traction.into_iter().flat_map(f32::to_le_bytes));
        }
    }

    fn mean_tractions(&self, grid: &TractionGrid) -> Vec<[f32; 3]> {
        let mut sums = vec![([0.0_f32; 3], 0.0_f32); self.columns * self.rows];
        for (traction, arrow) in grid.traction_mpa.iter().zip(&self.arrow_of_cell) {
            if let Some(arrow) = arrow {
                let (sum, count) = &mut sums[*arrow];
                sum.iter_mut().zip(traction).for_each(|(sum, part)| *sum += part);
                *count += 1.0;
            }
        }
        sums.into_iter().map(|(sum, count)| sum.map(|part| part / count)).collect()
    }
}

/// The arrow of each cell of the traction grid.
fn cells(grid: &TractionGrid, camera: &Camera, pitch: usize, [columns, rows]: [usize; 2]) -> Vec<Option<usize>> {
    let centre_mm = |index: usize, count: usize| (index as f64 + 0.5 - 0.5 * count as f64) * grid.cell_mm;
    let arrow = |index: usize| {
        let (column, row) = (index % grid.columns, index / grid.columns);
        let [x, y] = camera.project([centre_mm(column, grid.columns), centre_mm(row, grid.rows), 0.0])?;
        let [column, row] = [x, y].map(|place| (place / pitch as f64).floor());
        let is_inside = column >= 0.0 && row >= 0.0 && column < columns as f64 && row < rows as f64;
        is_inside.then(|| row as usize * columns + column as usize)
    };
    (0..grid.columns * grid.rows).map(arrow).collect()
}

/// Displacement along the surface, mm, or if it is not computed the flow, px; not a number where it is not valid.
fn displacement(reading: &Reading, x: usize, y: usize) -> [f32; 2] {
    if let (Some([along_x, along_y, _]), Some(deviation)) = (&reading.displacement, &reading.depth_deviation) {
        let is_valid = deviation.at(x, y).is_finite();
        return if is_valid { [along_x.at(x, y), along_y.at(x, y)] } else { [f32::NAN; 2] };
    }
    if reading.valid.at(x, y) == 1 { [reading.flow.u.at(x, y), reading.flow.v.at(x, y)] } else { [f32::NAN; 2] }
}
