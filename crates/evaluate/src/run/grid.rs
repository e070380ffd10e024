//! The position of a run's fields on the truth's grid.

use std::path::Path;

use fingervision_image::Rect;

use super::RunError;

/// A grid of fields: its size and, if its file contains it, its region of interest in the camera image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid<'a> {
    /// Columns and rows, px.
    pub(super) size: (usize, usize),
    /// Left column, top row, width and height in the camera image, px.
    pub(super) region: Option<[usize; 4]>,
    /// The file that can contain the region.
    pub(super) file: &'a Path,
}

impl Grid<'_> {
    /// The position of the grid in the camera image; its upper left corner if it is not known.
    fn place(&self) -> Result<Rect, RunError> {
        let (width, height) = self.size;
        let Some([x, y, columns, rows]) = self.region else { return Ok(Rect::whole(width, height)) };
        let region = Rect { x, y, width: columns, height: rows };
        if (columns, rows) == self.size {
            Ok(region)
        } else {
            Err(RunError::Region { file: self.file.to_owned(), region, size: self.size })
        }
    }
}

/// The part of the truth's grid that the run covers.
///
/// It follows from their regions in the camera image. A run without a region must have the size of the truth.
pub(super) fn place(run: Grid, truth: Grid) -> Result<Rect, RunError> {
    let (run_place, truth_place) = (run.place()?, truth.place()?);
    let (width, height) = run.size;
    if run.region.is_none() && run.size == truth.size {
        return Ok(Rect::whole(width, height));
    }
    let left = run_place.x.checked_sub(truth_place.x);
    let top = run_place.y.checked_sub(truth_place.y);
    let covered = left.zip(top).map(|(x, y)| Rect { x, y, width, height });
    covered
        .filter(|covered| run.region.is_some() && covered.is_inside(truth.size.0, truth.size.1))
        .ok_or(RunError::Grids { run: run_place, truth: truth_place })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placed(
        (run_size, run_region): ((usize, usize), Option<[usize; 4]>),
        (truth_size, truth_region): ((usize, usize), Option<[usize; 4]>),
    ) -> Result<[usize; 2], String> {
        let run = Grid { size: run_size, region: run_region, file: Path::new("run.toml") };
        let truth = Grid { size: truth_size, region: truth_region, file: Path::new("profile.toml") };
        place(run, truth).map(|rect| [rect.x, rect.y]).map_err(|error| error.to_string())
    }

    #[test]
    fn the_same_grid_needs_no_region() {
        assert_eq!(placed(((8, 6), None), ((8, 6), None)), Ok([0, 0]));
        assert_eq!(placed(((8, 6), None), ((8, 6), Some([3, 2, 8, 6]))), Ok([0, 0]));
    }

    #[test]
    fn a_region_lies_where_both_say() {
        assert_eq!(placed(((4, 3), Some([2, 1, 4, 3])), ((8, 6), None)), Ok([2, 1]));
        assert_eq!(placed(((4, 3), Some([5, 3, 4, 3])), ((8, 6), Some([3, 2, 8, 6]))), Ok([2, 1]));
    }

    #[test]
    fn grids_that_do_not_fit_are_named() {
        let error = placed(((4, 3), None), ((8, 6), None)).unwrap_err();
        assert_eq!(error, "the run's grid [0, 0, 4, 3] is not inside the truth's grid [0, 0, 8, 6]");
        let error = placed(((4, 3), Some([5, 1, 4, 3])), ((8, 6), None)).unwrap_err();
        assert_eq!(error, "the run's grid [5, 1, 4, 3] is not inside the truth's grid [0, 0, 8, 6]");
        let error = placed(((4, 3), Some([1, 1, 4, 3])), ((8, 6), Some([3, 2, 8, 6]))).unwrap_err();
        assert_eq!(error, "the run's grid [1, 1, 4, 3] is not inside the truth's grid [3, 2, 8, 6]");
        let error = placed(((4, 3), Some([0, 0, 5, 3])), ((8, 6), None)).unwrap_err();
        assert_eq!(error, "run.toml: the region of interest [0, 0, 5, 3] differs in size from the arrays, 4x3 px");
    }
}
