//! Reads the forces and torques that a run and its truth contain beside the arrays.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use fingervision_calibrate::{CsvFault, CsvTable};
use fingervision_touch::{FORCE_COLUMNS, TORQUE_COLUMN};

use super::RunError;

/// The force on the gel in every frame, `(x, y, z)`, N, and the torque about z, N mm; absent if a cell is empty or not
/// finite, or if the column is missing.
pub(super) type Forces = Vec<[Option<f64>; 4]>;

/// The forces in the rows of a table. `None` if the file does not exist.
pub(super) fn read_forces(path: &Path) -> Result<Option<Forces>, RunError> {
    let text = match fs::read_to_string(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        read => read.map_err(RunError::reading(path))?,
    };
    let forces = CsvTable::parse(&text).and_then(|table| forces(&table));
    forces.map(Some).map_err(|(line, reason)| RunError::Table { file: path.to_owned(), line, reason })
}

fn forces(table: &CsvTable) -> Result<Forces, CsvFault> {
    let [x, y, z] = FORCE_COLUMNS.map(|name| table.needed(name).map(|place| Some((name, place))));
    let columns = [x?, y?, z?, table.place(TORQUE_COLUMN).map(|place| (TORQUE_COLUMN, place))];
    let mut forces = Forces::new();
    for row in table.rows() {
        table.check(row, forces.len())?;
        let mut force = [None; 4];
        for (value, column) in force.iter_mut().zip(columns) {
            let Some((name, cell)) = column.map(|(name, place)| (name, row.cell(place))) else { continue };
            if !cell.is_empty() {
                let number = cell.parse::<f64>().map_err(|_| row.fault(format!("{name} = {cell} is not a number")))?;
                *value = number.is_finite().then_some(number);
            }
        }
        forces.push(force);
    }
    Ok(forces)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Option<Forces>, RunError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("force.csv");
        fs::write(&path, text).unwrap();
        read_forces(&path)
    }

    #[test]
    fn empty_cells_and_what_is_not_finite_are_absent() {
        let forces = read("frame,force_z_n,force_x_n,force_y_n\n0,,1.5,NaN\r\n1,-2,3,4\n").unwrap().unwrap();
        assert_eq!(forces, [[Some(1.5), None, None, None], [Some(3.0), Some(4.0), Some(-2.0), None]]);
        let forces = read("force_x_n,force_y_n,force_z_n,torque_z_nmm\n1,2,3,\n1,2,3,-4\n").unwrap().unwrap();
        assert_eq!([forces[0][3], forces[1][3]], [None, Some(-4.0)]);
    }

    #[test]
    fn faults_are_named_with_their_line() {
        for (text, expected) in [
            ("frame,force_x_n,force_y_n\n", "line 1: there is no column force_z_n"),
            ("", "line 1: there is no column force_x_n"),
            ("force_x_n,force_y_n,force_z_n\n1,2\n", "line 2: 2 cells, expected 3"),
            ("force_x_n,force_y_n,force_z_n\n1,2,3\n1,2,three\n", "line 3: force_z_n = three is not a number"),
            ("frame,force_x_n,force_y_n,force_z_n\n1,0,0,0\n", "line 2: frame 1, expected 0"),
            ("force_x_n;force_y_n;force_z_n\n1,5;0;0\n", "line 1: its cells are separated by semicolons"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(expected), "{error} does not say {expected}");
        }
    }

    #[test]
    fn a_file_that_is_not_there_is_none() {
        assert!(read_forces(Path::new("nowhere/force.csv")).unwrap().is_none());
    }
}
