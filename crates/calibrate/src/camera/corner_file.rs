//! Reads corners from a file with the columns `image,x_mm,y_mm,u_px,v_px`.

use super::corner_error::{CornerError, HEADER};
use super::corners::Corner;
use crate::CsvTable;

/// The corners of each image, in the order in which the images come.
///
/// # Errors
///
/// [`CornerError::Table`], [`CornerError::NoHeader`] and [`CornerError::Line`].
pub fn read_corners(text: &str) -> Result<Vec<Vec<Corner>>, CornerError> {
    let table = CsvTable::parse(text).map_err(|(line, reason)| CornerError::Table { line, reason })?;
    if !table.names().eq(HEADER.split(',')) {
        return Err(CornerError::NoHeader);
    }
    let (mut names, mut images): (Vec<&str>, Vec<Vec<Corner>>) = (Vec::new(), Vec::new());
    for row in table.rows() {
        let fault = || {
            let text = text.lines().nth(row.line - 1).unwrap_or_default();
            CornerError::Line { line: row.line, text: text.into() }
        };
        let numbers: Result<Vec<f64>, _> = row.cells().skip(1).map(str::parse).collect();
        let Ok(&[x, y, u, v]) = numbers.as_deref() else { return Err(fault()) };
        if ![x, y, u, v].iter().all(|value: &f64| value.is_finite()) {
            return Err(fault());
        }
        let name = row.cell(0);
        let image = names.iter().position(|known| *known == name).unwrap_or_else(|| {
            names.push(name);
            images.push(Vec::new());
            images.len() - 1
        });
        images[image].push(Corner { board_mm: [x, y], px: [u, v] });
    }
    Ok(images)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_read_image_by_image() {
        let images =
            read_corners("image,x_mm,y_mm,u_px,v_px\na,0,0,10.5,20\nb,1,0,30,40\na, 1, 0, 12, 20\n\n").unwrap();
        assert_eq!(images.iter().map(Vec::len).collect::<Vec<_>>(), [2, 1]);
        assert_eq!(images[0][1], Corner { board_mm: [1.0, 0.0], px: [12.0, 20.0] });
    }

    #[test]
    fn corners_are_read_as_a_spreadsheet_writes_them() {
        let images = read_corners("\u{feff}image,x_mm,y_mm,u_px,v_px\r\n0,0,0,10.5,20\r\n").unwrap();
        assert_eq!(images, [[Corner { board_mm: [0.0, 0.0], px: [10.5, 20.0] }]]);
        let error = read_corners("image;x_mm;y_mm;u_px;v_px\n0;0;0;10,5;20\n").unwrap_err();
        assert_eq!(error.to_string(), "line 1: its cells are separated by semicolons, not by commas");
        assert!(error.hint().contains("image,x_mm,y_mm,u_px,v_px"));
    }

    #[test]
    fn an_invalid_corner_is_named_with_its_line() {
        assert_eq!(read_corners("x,y"), Err(CornerError::NoHeader));
        let header = "image,x_mm,y_mm,u_px,v_px\n";
        for line in ["0,1,2,3", "0,1,2,3,x", "0,1,2,3,nan", "0,1,2,3,4,5"] {
            let error = read_corners(&format!("{header}{line}")).unwrap_err();
            assert_eq!(error, CornerError::Line { line: 2, text: line.into() });
        }
    }
}
