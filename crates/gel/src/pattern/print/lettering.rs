//! Plotter lettering: characters of straight strokes, so that a print needs no typeface and looks the same everywhere.
//!
//! A glyph is drawn on a grid of 5 columns and 9 rows: the baseline is row 2, small letters reach row 6, digits and
//! ascenders row 8, descenders row 0.

use super::stroke::Stroke;

/// Grid units from one character to the next.
const ADVANCE: f64 = 6.0;
/// Grid units from the baseline to the top of a digit.
const HEIGHT: f64 = 6.0;
/// Row of the baseline.
const BASELINE: f64 = 2.0;
/// Width of a stroke, in heights of a digit.
const WEIGHT: f64 = 0.12;

/// A glyph's strokes, each a chain of grid points given as column and row digit.
fn glyph(character: char) -> &'static [&'static str] {
    match character {
        '0' => &["120307183847433212"],
        '1' => &["072822", "0242"],
        '2' => &["07183847460242"],
        '3' => &["0718384746354443321203", "2535"],
        '4' => &["32380444"],
        '5' => &["480805354443321203"],
        '6' => &["473818070312324344351504"],
        '7' => &["084812"],
        '8' => &["15060718384746351504031232434435"],
        '9' => &["031232434738180706153546"],
        'a' => &["0516364542", "441403123243"],
        'b' => &["0802", "0516364543321203"],
        'c' => &["4536160503123243"],
        'd' => &["4842", "4536160503123243"],
        'e' => &["04444536160503123243"],
        'f' => &["48382712", "0636"],
        'g' => &["4641301001", "4536160503123243"],
        'h' => &["0802", "0516364542"],
        'i' => &["1626", "262332", "2728"],
        'j' => &["36312010", "3738"],
        'k' => &["0802", "4604", "1542"],
        'l' => &["18282332"],
        'm' => &["0206", "05162522", "25364542"],
        'n' => &["0206", "0516364542"],
        'o' => &["120305163645433212"],
        'p' => &["0006", "0516364543321203"],
        'q' => &["4046", "4536160503123243"],
        'r' => &["0206", "04263645"],
        's' => &["45361605143443321203"],
        't' => &["1813223243", "0636"],
        'u' => &["0603123243", "4642"],
        'v' => &["062246"],
        'w' => &["0612243246"],
        'x' => &["0246", "0642"],
        'y' => &["0622", "46221000"],
        'z' => &["06460242"],
        '.' => &["2223"],
        ',' => &["2311"],
        '-' => &["1434"],
        '%' => &["0248", "0708181707", "3233434232"],
        _ => &[],
    }
}

/// Length of a text whose digits are `height_mm` high, mm.
pub(super) fn width_mm(text: &str, height_mm: f64) -> f64 {
    (text.chars().count() as f64 * ADVANCE - (ADVANCE - 4.0)).max(0.0) * height_mm / HEIGHT
}

/// Writes a text from `(x, y)` on its baseline, mm, y down. Unknown characters are left blank.
pub(super) fn write(text: &str, [x, y]: [f64; 2], height_mm: f64, strokes: &mut Vec<Stroke>) {
    let unit = height_mm / HEIGHT;
    for (k, character) in text.chars().enumerate() {
        let left = x + k as f64 * ADVANCE * unit;
        for chain in glyph(character) {
            let digit = |byte: u8| f64::from(byte - b'0');
            let point = |pair: &[u8]| [left + digit(pair[0]) * unit, y - (digit(pair[1]) - BASELINE) * unit];
            let points_mm = chain.as_bytes().chunks_exact(2).map(point).collect();
            strokes.push(Stroke { points_mm, width_mm: WEIGHT * height_mm });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_glyph_lies_on_its_grid() {
        for character in (' '..='~').filter(|&character| !glyph(character).is_empty()) {
            for chain in glyph(character) {
                assert!(chain.len() >= 4 && chain.len() % 2 == 0, "{character}: {chain}");
                let points = chain.as_bytes().chunks_exact(2);
                assert!(points.clone().all(|pair| (b'0'..=b'4').contains(&pair[0])), "{character}: {chain}");
                assert!(points.clone().all(|pair| (b'0'..=b'8').contains(&pair[1])), "{character}: {chain}");
            }
        }
    }

    #[test]
    fn a_text_is_as_wide_as_it_says() {
        let mut strokes = Vec::new();
        write("0 mm", [3.0, 5.0], 1.2, &mut strokes);
        let reach = strokes.iter().flat_map(|stroke| &stroke.points_mm).map(|point| point[0]).fold(0.0, f64::max);
        assert!((reach - 3.0 - width_mm("0 mm", 1.2)).abs() < 1e-12, "{reach} mm");
    }
}
