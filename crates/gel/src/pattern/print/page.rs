//! The content of the page: the pattern, and around it crop marks, a scale bar and a caption. All in mm from the upper
//! left corner, y down.

use fingervision_image::Image;

use super::lettering;
use super::paper::Paper;
use super::stroke::Stroke;
use crate::pattern::disc::Disc;
use crate::pattern::error::PatternError;

/// From the page's border to the pattern, mm.
const MARGIN_MM: f64 = 10.0;
/// Least width between the margins, mm: needed for the caption.
const LEAST_WIDTH_MM: f64 = 30.0;
/// From a sheet's border to a pattern that is centred on it, mm: most printers cannot print the outermost 5 mm, and
/// crop marks lie between.
const SHEET_MARGIN_MM: f64 = 12.0;
/// From the pattern to a crop mark, and the mark's end, mm.
const CROP_MARK_MM: [f64; 2] = [2.0, 7.0];
/// Width of crop marks and of the scale bar's ticks, mm.
const LINE_MM: f64 = 0.1;
/// Length of the scale bar, mm, with a tick every mm.
const SCALE_BAR_MM: usize = 10;
/// From the pattern down to the scale bar, mm.
const SCALE_BAR_BELOW_MM: f64 = 11.0;
/// Height of the digits, mm, and of a line.
const LETTER_MM: f64 = 1.4;
const LINE_HEIGHT_MM: f64 = 2.6;

/// The content of the pattern's area.
#[derive(Debug, Clone)]
pub(super) enum Artwork {
    /// Square cells of one colour each.
    Cells(Image<[u8; 3]>),
    /// Grey discs on a grey ground, mm from the pattern's upper left corner; they end at its border.
    Discs { discs: Vec<Disc>, dark: u8, bright: u8 },
}

/// A page.
#[derive(Debug, Clone)]
pub(super) struct Page {
    /// Width and height, mm.
    pub(super) size_mm: [f64; 2],
    /// The pattern's upper left corner, mm.
    pub(super) origin_mm: [f64; 2],
    /// Width and height of the pattern, mm.
    pub(super) pattern_mm: [f64; 2],
    pub(super) artwork: Artwork,
    pub(super) strokes: Vec<Stroke>,
    /// The text of the caption.
    pub(super) caption: String,
}

impl Page {
    /// The page around a pattern of this size with these facts in its caption.
    pub(super) fn around(pattern_mm: [f64; 2], artwork: Artwork, facts: &[String]) -> Self {
        let width = pattern_mm[0].max(LEAST_WIDTH_MM) + 2.0 * MARGIN_MM;
        let origin_mm = [0.5 * (width - pattern_mm[0]), MARGIN_MM];
        let (strokes, bottom) = surroundings(origin_mm, pattern_mm, [MARGIN_MM, width - MARGIN_MM], facts);
        let size_mm = [width, bottom + LINE_HEIGHT_MM];
        Self { size_mm, origin_mm, pattern_mm, artwork, strokes, caption: facts.join(", ") }
    }

    /// The pattern in the middle of a sheet, in portrait or, if it fits only so, in landscape.
    ///
    /// # Errors
    ///
    /// [`PatternError::Paper`] if it fits neither way.
    pub(super) fn on_paper(
        paper: Paper,
        pattern_mm: [f64; 2],
        artwork: Artwork,
        facts: &[String],
    ) -> Result<Self, PatternError> {
        let [narrow, long] = paper.size_mm();
        let sheets = [[narrow, long], [long, narrow]];
        let fits = |room: [f64; 2]| (0..2).all(|axis| pattern_mm[axis] <= room[axis] + 1e-6);
        let sheet = sheets.into_iter().find(|&sheet| fits(room(sheet, facts)));
        let Some(size_mm) = sheet else {
            let room_mm = sheets.map(|sheet| room(sheet, facts));
            return Err(PatternError::Paper { paper: paper.to_string(), pattern_mm, room_mm });
        };
        let origin_mm = [0, 1].map(|axis| 0.5 * (size_mm[axis] - pattern_mm[axis]));
        let sides = [SHEET_MARGIN_MM, size_mm[0] - SHEET_MARGIN_MM];
        let (strokes, _) = surroundings(origin_mm, pattern_mm, sides, facts);
        Ok(Self { size_mm, origin_mm, pattern_mm, artwork, strokes, caption: facts.join(", ") })
    }
}

/// Width and height of the largest pattern in the middle of a sheet, whole mm, with bar and caption below it.
fn room([width, height]: [f64; 2], facts: &[String]) -> [f64; 2] {
    let lines = wrapped(facts, width - 2.0 * SHEET_MARGIN_MM).len() as f64;
    let below = SCALE_BAR_BELOW_MM + LINE_HEIGHT_MM * (lines + 2.0) + 0.5 * SHEET_MARGIN_MM;
    [(width - 2.0 * SHEET_MARGIN_MM).floor(), (height - 2.0 * below.max(SHEET_MARGIN_MM)).floor()]
}

/// Crop marks, scale bar and caption, the latter two between a left and a right end, and the position of the caption's
/// last line.
fn surroundings(
    origin_mm: [f64; 2],
    pattern_mm: [f64; 2],
    [left, right]: [f64; 2],
    facts: &[String],
) -> (Vec<Stroke>, f64) {
    let mut strokes = crop_marks(origin_mm, pattern_mm);
    let bar_y = origin_mm[1] + pattern_mm[1] + SCALE_BAR_BELOW_MM;
    scale_bar([left, bar_y], &mut strokes);
    let mut baseline = bar_y + LINE_HEIGHT_MM;
    for line in &wrapped(facts, right - left) {
        baseline += LINE_HEIGHT_MM;
        lettering::write(line, [left, baseline], LETTER_MM, &mut strokes);
    }
    (strokes, baseline)
}

/// Two lines at every corner of the pattern, outside it, that end where it would be cut.
fn crop_marks([left, top]: [f64; 2], [width, height]: [f64; 2]) -> Vec<Stroke> {
    let mut marks = Vec::new();
    for (x, outwards_x) in [(left, -1.0), (left + width, 1.0)] {
        for (y, outwards_y) in [(top, -1.0), (top + height, 1.0)] {
            let across = CROP_MARK_MM.map(|distance| [x + outwards_x * distance, y]);
            let down = CROP_MARK_MM.map(|distance| [x, y + outwards_y * distance]);
            marks.extend([across, down].map(|ends| Stroke { points_mm: ends.to_vec(), width_mm: LINE_MM }));
        }
    }
    marks
}

/// A bar with a tick every mm and its length beside it.
fn scale_bar([x, y]: [f64; 2], strokes: &mut Vec<Stroke>) {
    let line = |from: [f64; 2], to: [f64; 2]| Stroke { points_mm: vec![from, to], width_mm: LINE_MM };
    let end = x + SCALE_BAR_MM as f64;
    strokes.push(line([x, y], [end, y]));
    for k in 0..=SCALE_BAR_MM {
        let tick_mm = if k % SCALE_BAR_MM == 0 {
            2.0
        } else if k % 5 == 0 {
            1.5
        } else {
            1.0
        };
        let tick = x + k as f64;
        strokes.push(line([tick, y], [tick, y - tick_mm]));
    }
    lettering::write(&format!("{SCALE_BAR_MM} mm"), [end + 1.5, y], LETTER_MM, strokes);
}

/// The facts in lines that fit a width, mm, separated by commas.
fn wrapped(facts: &[String], width_mm: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for fact in facts {
        let joined = lines.last().map(|line| format!("{line}, {fact}"));
        match (lines.last_mut(), joined) {
            (Some(line), Some(joined)) if lettering::width_mm(&joined, LETTER_MM) <= width_mm => *line = joined,
            _ => lines.push(fact.clone()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page(pattern_mm: [f64; 2]) -> Page {
        let facts = ["colour", "cell 0.1 mm", "a fact of some length", "seed 18446744073709551615"].map(String::from);
        Page::around(pattern_mm, Artwork::Cells(Image::filled(3, 3, [0; 3])), &facts)
    }

    #[test]
    fn everything_but_the_pattern_lies_outside_it_and_on_the_page() {
        for pattern_mm in [[30.0, 30.0], [3.0, 90.0], [200.0, 5.0]] {
            let Page { size_mm, origin_mm, strokes, .. } = page(pattern_mm);
            for Stroke { points_mm, width_mm } in &strokes {
                for point in points_mm {
                    let is_on_page =
                        (0..2).all(|axis| point[axis] > *width_mm && point[axis] < size_mm[axis] - width_mm);
                    assert!(is_on_page, "{point:?} on {size_mm:?}");
                    let is_inside =
                        (0..2).all(|axis| (-0.5..=pattern_mm[axis] + 0.5).contains(&(point[axis] - origin_mm[axis])));
                    assert!(!is_inside, "{point:?} in a pattern of {pattern_mm:?} at {origin_mm:?}");
                }
            }
        }
    }

    #[test]
    fn a_pattern_is_centred_on_a_sheet_with_all_around_it_in_reach_of_a_printer() {
        let facts = ["colour", "cell 0.1 mm", "a fact of some length", "seed 18446744073709551615"].map(String::from);
        let cells = || Artwork::Cells(Image::filled(3, 3, [0; 3]));
        for (paper, pattern_mm, sheet_mm) in [
            (Paper::A4, [30.0, 30.0], [210.0, 297.0]),
            (Paper::A4, [186.0, 240.0], [210.0, 297.0]),
            (Paper::Letter, [190.0, 20.0], [215.9, 279.4]),
            (Paper::Letter, [230.0, 90.0], [279.4, 215.9]),
        ] {
            let page = Page::on_paper(paper, pattern_mm, cells(), &facts).unwrap();
            assert!((0..2).all(|axis| (page.size_mm[axis] - sheet_mm[axis]).abs() < 1e-9), "{:?}", page.size_mm);
            for axis in 0..2 {
                let middle = page.origin_mm[axis] + 0.5 * pattern_mm[axis];
                assert!((middle - 0.5 * sheet_mm[axis]).abs() < 1e-9, "{middle} mm on {sheet_mm:?}");
                for point in page.strokes.iter().flat_map(|stroke| &stroke.points_mm) {
                    assert!((4.9..=sheet_mm[axis] - 4.9).contains(&point[axis]), "{point:?} on {sheet_mm:?}");
                }
            }
        }
        let error = Page::on_paper(Paper::A4, [187.0, 200.0], cells(), &facts).unwrap_err();
        assert!(error.hint().contains("186x"), "{}", error.hint());
        for room in [[186.0, 250.0], [250.0, 150.0]] {
            let PatternError::Paper { room_mm, .. } = &error else { panic!("{error}") };
            assert!(room_mm.iter().any(|[width, _]| *width >= room[0]), "{room_mm:?}");
        }
    }

    #[test]
    fn the_scale_bar_is_as_long_as_it_says() {
        let strokes = page([30.0, 30.0]).strokes;
        let bar = strokes.iter().map(|stroke| {
            let [first, last] = [stroke.points_mm[0], stroke.points_mm[stroke.points_mm.len() - 1]];
            last[0] - first[0]
        });
        assert!((bar.fold(0.0, f64::max) - 10.0).abs() < 1e-12);
    }
}
