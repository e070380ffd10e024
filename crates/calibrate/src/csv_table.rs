//! A comma-separated file whose first line names its columns.
//!
//! A cell may be quoted. Spaces around cells, empty lines and a byte order mark are left out. Other separators than commas
//! are refused and not guessed: with semicolons, as many spreadsheets write them, numbers have a decimal comma.

use csv::{ReaderBuilder, StringRecord, Trim};
use fingervision_touch::FRAME_COLUMN;

/// Separators that programs write instead of commas, and their names.
const OTHER_SEPARATORS: [(char, &str); 3] = [(';', "semicolons"), ('\t', "tabs"), ('|', "vertical bars")];

/// A line, counted from 1, and its error.
pub type CsvFault = (usize, String);

/// A table whose first line names its columns.
#[derive(Debug, Clone, PartialEq)]
pub struct CsvTable {
    names: CsvRow,
    rows: Vec<CsvRow>,
}

/// A row of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct CsvRow {
    /// Its line in the file, counted from 1.
    pub line: usize,
    cells: StringRecord,
}

impl CsvTable {
    /// The table in a text.
    ///
    /// # Errors
    ///
    /// The line, counted from 1, and its error: cells that other characters than commas separate.
    pub fn parse(text: &str) -> Result<Self, CsvFault> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text).as_bytes();
        let reader = ReaderBuilder::new().has_headers(false).flexible(true).trim(Trim::All).from_reader(text);
        let (mut rows, mut line, mut counted) = (Vec::new(), 1, 0);
        for cells in reader.into_records() {
            let cells = cells.map_err(|error| (line, error.to_string()))?;
            // A row's position is where the one before ended: the rest of its line end and empty lines follow.
            let end = cells.position().map_or(counted, |position| position.byte() as usize);
            let begin = end + text[end..].iter().take_while(|byte| matches!(byte, b'\r' | b'\n')).count();
            line += text[counted..begin].split(|&byte| byte == b'\n').count() - 1;
            counted = begin;
            if cells.len() > 1 || cells.iter().any(|cell| !cell.is_empty()) {
                let row = CsvRow { line, cells };
                rows.push(row.separator_fault().map_or(Ok(row), Err)?);
            }
        }
        let mut rows = rows.into_iter();
        let names = rows.next().unwrap_or(CsvRow { line: 1, cells: StringRecord::new() });
        Ok(Self { names, rows: rows.collect() })
    }

    /// The names of the columns.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.cells.iter()
    }

    /// The rows below the names.
    #[must_use]
    pub fn rows(&self) -> &[CsvRow] {
        &self.rows
    }

    /// The index of a column, if there is one of this name.
    #[must_use]
    pub fn place(&self, name: &str) -> Option<usize> {
        self.names().position(|column| column == name)
    }

    /// The index of a required column.
    ///
    /// # Errors
    ///
    /// If there is none: the line with the names, and the missing name.
    pub fn needed(&self, name: &str) -> Result<usize, CsvFault> {
        self.place(name).ok_or_else(|| self.names.fault(format!("there is no column {name}")))
    }

    /// Checks that a row is as long as the first line and, if there is a column `frame`, that it is that frame's.
    ///
    /// # Errors
    ///
    /// The row's line and its error.
    pub fn check(&self, row: &CsvRow, frame: usize) -> Result<(), CsvFault> {
        let (cells, expected) = (row.cells.len(), self.names.cells.len());
        if cells != expected {
            return Err(row.fault(format!("{cells} cells, expected {expected} as in the first line")));
        }
        match self.place(FRAME_COLUMN).map(|place| row.cell(place)) {
            Some(number) if number.parse() != Ok(frame) => {
                Err(row.fault(format!("frame {number}, expected {frame}: every frame needs a row, from 0")))
            }
            _ => Ok(()),
        }
    }
}

impl CsvRow {
    /// The cells.
    pub fn cells(&self) -> impl Iterator<Item = &str> {
        self.cells.iter()
    }

    /// The cell of a column; empty if the row is too short.
    #[must_use]
    pub fn cell(&self, place: usize) -> &str {
        self.cells.get(place).unwrap_or_default()
    }

    /// The error of a row whose only cell contains another separator than a comma.
    fn separator_fault(&self) -> Option<CsvFault> {
        let cell = Some(self.cell(0)).filter(|_| self.cells.len() == 1)?;
        let (_, name) = OTHER_SEPARATORS.into_iter().find(|&(separator, _)| cell.contains(separator))?;
        Some(self.fault(format!("its cells are separated by {name}, not by commas")))
    }

    /// An error in this row, with its line.
    #[must_use]
    pub fn fault(&self, reason: String) -> CsvFault {
        (self.line, reason)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_counted_whatever_ends_them() {
        for (text, lines) in [
            ("a,b\n1,2\n3,4", [2, 3]),
            ("a,b\r\n1,2\r\n3,4\r\n", [2, 3]),
            ("\u{feff}a,b\r\n\r\n1,2\r\n  \r\n\n3,4\r\n", [3, 6]),
            ("a,b\n\"1\n\",2\n\n3,4\n", [2, 5]),
        ] {
            let table = CsvTable::parse(text).unwrap();
            assert!(table.names().eq(["a", "b"]), "{text:?}");
            assert_eq!(table.rows().iter().map(|row| row.line).collect::<Vec<_>>(), lines, "{text:?}");
            assert!(table.rows()[0].cells().eq(["1", "2"]) && table.rows()[1].cells().eq(["3", "4"]), "{text:?}");
        }
    }

    #[test]
    fn another_separator_is_named_with_its_line() {
        for (text, line, name) in [
            ("frame;depth_mm\n0;0,0\n1;0,25\n", 1, "semicolons"),
            ("\u{feff}\r\nframe\tdepth_mm\r\n0\t0\r\n", 2, "tabs"),
            ("frame|depth_mm\n", 1, "vertical bars"),
            ("frame,depth_mm\n0,0\n1;0.25\n", 3, "semicolons"),
        ] {
            let (at, reason) = CsvTable::parse(text).unwrap_err();
            assert_eq!((at, reason), (line, format!("its cells are separated by {name}, not by commas")), "{text:?}");
        }
        CsvTable::parse("a,b;c\n1,2;3\n").unwrap();
    }

    #[test]
    fn cells_are_trimmed_and_may_be_quoted() {
        let table = CsvTable::parse("a, b\n\"1\", 2 \n,,\n").unwrap();
        assert!(table.names().eq(["a", "b"]) && table.rows()[1].cells().eq(["", "", ""]));
        assert_eq!((table.rows()[0].cell(0), table.rows()[0].cell(1), table.rows()[0].cell(2)), ("1", "2", ""));
    }
}
