//! Reads the columns of numbers that a run and its truth keep beside the arrays.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use fingervision_sink::{FORCE_COLUMNS, TORQUE_COLUMN};

use super::RunError;

/// The force on the gel in every frame, `(x, y, z)`, N, and the torque about z, N mm; absent where a cell is empty or not
/// finite, or where there is no such column.
pub(super) type Forces = Vec<[Option<f64>; 4]>;

/// The forces in a table's rows; none if there is no such file.
pub(super) fn read_forces(path: &Path) -> Result<Option<Forces>, RunError> {
    let text = match fs::read_to_string(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        read => read.map_err(RunError::reading(path))?,
    };
    let fault = |line: usize, reason: String| RunError::Table { file: path.to_owned(), line: line + 1, reason };
    let mut lines = text.lines().map(|line| line.trim_end_matches('\r').split(',').map(str::trim));
    let columns: Vec<&str> = lines.next().into_iter().flatten().collect();
    let place = |name: &str| columns.iter().position(|column| *column == name);
    let mut places = [None, None, None, place(TORQUE_COLUMN)];
    for (at, name) in places.iter_mut().zip(FORCE_COLUMNS) {
        *at = Some(place(name).ok_or_else(|| fault(0, format!("there is no column {name}")))?);
    }
    let frame_place = place("frame");
    let mut forces = Vec::new();
    for (row, cells) in lines.enumerate() {
        let cells: Vec<&str> = cells.collect();
        if cells.len() != columns.len() {
            let reason = format!("{} cells, expected {} as in the first line", cells.len(), columns.len());
            return Err(fault(row + 1, reason));
        }
        let frame = frame_place.map(|place| cells[place]);
        if let Some(frame) = frame.filter(|frame| frame.parse() != Ok(row)) {
            return Err(fault(row + 1, format!("frame {frame}, expected {row}: every frame has its row, from 0")));
        }
        let number = |place: usize| match cells[place] {
            "" => Ok(None),
            cell => cell.parse::<f64>().map(|value| value.is_finite().then_some(value)),
        };
        let mut force = [None; 4];
        for (value, place) in force.iter_mut().zip(places) {
            let Some(place) = place else { continue };
            let no_number = |_| fault(row + 1, format!("{} = {} is no number", columns[place], cells[place]));
            *value = number(place).map_err(no_number)?;
        }
        forces.push(force);
    }
    Ok(Some(forces))
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
            ("force_x_n,force_y_n,force_z_n\n1,2,3\n1,2,three\n", "line 3: force_z_n = three is no number"),
            ("frame,force_x_n,force_y_n,force_z_n\n1,0,0,0\n", "line 2: frame 1, expected 0"),
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
