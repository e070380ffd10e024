//! The frames of the truth that a run contains: a part of a recording may be tracked, and frames that cannot be read
//! are left out.

use std::fs;
use std::path::Path;

use fingervision_calibrate::CsvTable;
use fingervision_touch::SEQUENCE_COLUMN;

use super::RunError;

/// The numbers of the run's frames, from the column `sequence` of its table of readings; `frames` is the number of
/// truth frames. None if the run contains the first frames without gaps, or if the table does not give valid numbers.
///
/// # Errors
///
/// [`RunError::Table`] if it is not a table.
pub(super) fn part(file: &Path, frames: u64) -> Result<Option<Vec<u64>>, RunError> {
    let Ok(text) = fs::read_to_string(file) else { return Ok(None) };
    let fault = |(line, reason)| RunError::Table { file: file.to_owned(), line, reason };
    Ok(numbers(&CsvTable::parse(&text).map_err(fault)?, frames))
}

fn numbers(table: &CsvTable, frames: u64) -> Option<Vec<u64>> {
    let place = table.place(SEQUENCE_COLUMN)?;
    let numbers: Vec<u64> = table.rows().iter().map(|row| row.cell(place).parse().ok()).collect::<Option<_>>()?;
    let is_part = numbers.is_sorted_by(|a, b| a < b) && numbers.last().is_some_and(|&last| last < frames);
    let is_beginning = numbers.iter().zip(0..).all(|(&number, row)| number == row);
    (is_part && !is_beginning).then_some(numbers)
}

/// Number of truth frames to advance for each frame of the run.
pub(super) fn steps(numbers: &[u64]) -> Vec<u64> {
    let before = std::iter::once(None).chain(numbers.iter().copied().map(Some));
    numbers.iter().zip(before).map(|(&number, before)| number + 1 - before.map_or(0, |before| before + 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part_of(table: &str, frames: u64) -> Option<Vec<u64>> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("readings.csv");
        fs::write(&path, table).unwrap();
        part(&path, frames).unwrap()
    }

    #[test]
    fn a_part_is_recognised_by_its_sequence_numbers() {
        assert_eq!(part_of("sequence,x\n3,a\n5,b\n", 6), Some(vec![3, 5]));
        assert_eq!(part_of("x,sequence\n0,0\n0,2\n", 6), Some(vec![0, 2]));
        assert_eq!(steps(&[3, 5, 6]), [4, 2, 1]);
    }

    #[test]
    fn other_tables_are_compared_from_the_first_frame() {
        for table in ["", "x\n1\n", "sequence\n0\n1\n2\n", "sequence\n3\n9\n", "sequence\n5\n3\n", "sequence\na\n"] {
            assert_eq!(part_of(table, 6), None, "{table:?}");
        }
        assert_eq!(part(Path::new("nowhere/readings.csv"), 6).unwrap(), None);
    }

    #[test]
    fn a_table_with_semicolons_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("readings.csv");
        fs::write(&path, "sequence;x\n3;0,5\n").unwrap();
        let error = part(&path, 6).unwrap_err().to_string();
        assert!(error.contains("readings.csv, line 1: its cells are separated by semicolons"), "{error}");
    }
}
