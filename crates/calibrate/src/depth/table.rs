//! The depth of every image of a press, and optionally its force, as a table beside the images.

use std::fs;
use std::path::{Path, PathBuf};

use fingervision_touch::{DEPTH_COLUMN, FORCE_COLUMNS};

use super::error::{DEPTH_FILE, DepthFitError};
use crate::{CsvFault, CsvTable};

/// The table that a simulation writes.
const TRUTH_FILE: &str = "truth/force.csv";
/// The column of the normal force.
const NORMAL_FORCE: &str = FORCE_COLUMNS[2];

/// A recorded press: the folder of its images, and its depth in each.
#[derive(Debug, Clone, PartialEq)]
pub struct PressFolder {
    /// Its name: that of its folder.
    pub name: String,
    /// The folder of its images.
    pub images: PathBuf,
    /// The depth of every image, mm.
    pub depths_mm: Vec<f64>,
    /// The normal force on the gel in every image, N, if the table contains it.
    pub forces_n: Option<Vec<f64>>,
}

impl PressFolder {
    /// Reads the depths of a press: from `depth.csv`, or from the `truth/force.csv` of a simulation. The images are in
    /// its subfolder `frames`, or beside the table.
    ///
    /// The table is comma-separated. Its first line names the columns. The column `depth_mm` is read, and, if present,
    /// `frame`, which counts the rows from 0, and `force_z_n`.
    ///
    /// # Errors
    ///
    /// [`DepthFitError::NoDepths`], [`DepthFitError::Unreadable`] or [`DepthFitError::Table`].
    pub fn open(folder: &Path) -> Result<Self, DepthFitError> {
        let tables = [DEPTH_FILE, TRUTH_FILE].map(|name| folder.join(name));
        let Some(table) = tables.into_iter().find(|table| table.is_file()) else {
            return Err(DepthFitError::NoDepths { folder: folder.to_owned() });
        };
        let text =
            fs::read_to_string(&table).map_err(|error| DepthFitError::Unreadable { file: table.clone(), error })?;
        let fault = |(line, reason)| DepthFitError::Table { file: table.clone(), line, reason };
        let Columns { depths_mm, forces_n } = columns(&text).map_err(fault)?;
        let frames = folder.join("frames");
        let images = if frames.is_dir() { frames } else { folder.to_owned() };
        let name =
            folder.file_name().map_or_else(|| folder.display().to_string(), |name| name.to_string_lossy().into());
        Ok(Self { name, images, depths_mm, forces_n })
    }
}

/// The columns that are read.
#[derive(Debug, PartialEq)]
struct Columns {
    depths_mm: Vec<f64>,
    forces_n: Option<Vec<f64>>,
}

/// The columns of a table; or the line, from 1, and its error. Rows of empty cells are left out.
fn columns(text: &str) -> Result<Columns, CsvFault> {
    let table = CsvTable::parse(text)?;
    let (depth, force) = (table.needed(DEPTH_COLUMN)?, table.place(NORMAL_FORCE));
    let (mut depths_mm, mut forces_n) = (Vec::new(), force.map(|_| Vec::new()));
    for row in table.rows().iter().filter(|row| row.cells().any(|cell| !cell.is_empty())) {
        table.check(row, depths_mm.len())?;
        let value = |place: usize| row.cell(place).parse::<f64>().ok().filter(|value| value.is_finite());
        let not_a =
            |what: &str, name: &str, place: usize| row.fault(format!("{name} = {} is not a {what}", row.cell(place)));
        depths_mm.push(value(depth).ok_or_else(|| not_a("length", DEPTH_COLUMN, depth))?);
        if let (Some(force), Some(forces_n)) = (force, &mut forces_n) {
            forces_n.push(value(force).ok_or_else(|| not_a("force", NORMAL_FORCE, force))?);
        }
    }
    Ok(Columns { depths_mm, forces_n })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_name() {
        let depths = columns("frame,depth_mm\n0,0\n1, 0.5\r\n2,1e-1\n\n").unwrap();
        assert_eq!(depths, Columns { depths_mm: vec![0.0, 0.5, 0.1], forces_n: None });
        let both = columns("force_z_n,depth_mm\n1,0\n2,0.25\n").unwrap();
        assert_eq!(both, Columns { depths_mm: vec![0.0, 0.25], forces_n: Some(vec![1.0, 2.0]) });
    }

    #[test]
    fn a_table_is_read_as_a_spreadsheet_writes_it() {
        let text = "\u{feff}\"frame\",\"depth_mm\",\"force_z_n\"\r\n0,0,0\r\n1,\"0.25\",1.5\r\n,,\r\n";
        let expected = Columns { depths_mm: vec![0.0, 0.25], forces_n: Some(vec![0.0, 1.5]) };
        assert_eq!(columns(text).unwrap(), expected);
    }

    #[test]
    fn a_fault_is_named_with_its_line() {
        for (text, line, reason) in [
            ("", 1, "there is no column depth_mm"),
            ("frame,depth\n", 1, "there is no column depth_mm"),
            ("frame,depth_mm\n0,0\n2,0.1\n", 3, "frame 2, expected 1"),
            ("frame,depth_mm\n0,deep\n", 2, "depth_mm = deep is not a length"),
            ("frame,depth_mm\n0,inf\n", 2, "depth_mm = inf is not a length"),
            ("frame,depth_mm\n0,\n", 2, "depth_mm =  is not a length"),
            ("frame,depth_mm\n0\n", 2, "1 cells, expected 2"),
            ("depth_mm,force_z_n\n0,strong\n", 2, "force_z_n = strong is not a force"),
            ("frame;depth_mm\n0;0,5\n", 1, "separated by semicolons"),
            ("frame,depth_mm\n0,0,5\n", 2, "3 cells, expected 2"),
            ("frame,depth_mm\n0,\"0,5\"\n", 2, "depth_mm = 0,5 is not a length"),
        ] {
            let (at, why) = columns(text).unwrap_err();
            assert!(at == line && why.contains(reason), "{text:?}: line {at}: {why}");
        }
    }
}
