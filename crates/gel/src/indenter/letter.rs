//! Letters as outlines, from an embedded typeface.

use std::sync::LazyLock;

use ttf_parser::{Face, OutlineBuilder};

use super::IndenterError;

static TYPEFACE: LazyLock<Face<'static>> = LazyLock::new(|| {
    Face::parse(include_bytes!("../../fonts/Inter-SemiBold.otf"), 0).expect("the embedded typeface is whole")
});

/// Largest distance between a straight edge and the curve that it approximates, as a share of the cap height.
const FLATNESS: f64 = 1e-3;

/// The outlines of a line of text whose capitals are `height_mm` high, its box centred at the origin, upright in the
/// image.
pub(super) fn outlines(text: &str, height_mm: f64) -> Result<Vec<Vec<[f64; 2]>>, IndenterError> {
    let cap_height = TYPEFACE.capital_height().map_or(f64::from(TYPEFACE.ascender()), f64::from);
    let mut pen =
        Pen { loops: Vec::new(), advance: 0.0, scale: height_mm / cap_height, flatness: FLATNESS * height_mm };
    for character in text.chars() {
        let no_glyph = || IndenterError::NoGlyph { text: text.into(), character };
        let glyph = TYPEFACE.glyph_index(character).ok_or_else(no_glyph)?;
        TYPEFACE.outline_glyph(glyph, &mut pen);
        pen.advance += f64::from(TYPEFACE.glyph_hor_advance(glyph).unwrap_or(0));
    }
    match text.chars().next() {
        Some(character) if pen.loops.is_empty() => Err(IndenterError::NoGlyph { text: text.into(), character }),
        _ => Ok(centred(pen.loops)),
    }
}

fn centred(mut loops: Vec<Vec<[f64; 2]>>) -> Vec<Vec<[f64; 2]>> {
    let middle = [0, 1].map(|axis| {
        let along = loops.iter().flatten().map(|corner| corner[axis]);
        let [low, high] =
            along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
        low.midpoint(high)
    });
    for corner in loops.iter_mut().flatten() {
        *corner = [corner[0] - middle[0], corner[1] - middle[1]];
    }
    loops
}

/// Draws outlines in font units, y up, as loops of straight edges in mm, y down.
struct Pen {
    loops: Vec<Vec<[f64; 2]>>,
    /// Start of the letter, font units.
    advance: f64,
    /// Length of a font unit, mm.
    scale: f64,
    flatness: f64,
}

impl Pen {
    fn place(&self, x: f32, y: f32) -> [f64; 2] {
        [(f64::from(x) + self.advance) * self.scale, -f64::from(y) * self.scale]
    }

    fn go_to(&mut self, place: [f64; 2]) {
        if let Some(corners) = self.loops.last_mut()
            && corners.last() != Some(&place)
        {
            corners.push(place);
        }
    }

    /// Approximates a Bézier curve from the current point. Wang's formula bounds the number of edges for the flatness.
    fn follow<const N: usize>(&mut self, controls: [[f64; 2]; N]) {
        let Some(&start) = self.loops.last().and_then(|corners| corners.last()) else { return };
        let mut points = vec![start];
        points.extend(controls);
        let bend = |p: &[[f64; 2]]| (p[0][0] - 2.0 * p[1][0] + p[2][0]).hypot(p[0][1] - 2.0 * p[1][1] + p[2][1]);
        let largest = points.windows(3).map(bend).fold(0.0, f64::max);
        let edges = ((N * (N - 1)) as f64 / 8.0 * largest / self.flatness).sqrt().ceil().max(1.0) as usize;
        for edge in 1..=edges {
            let share = edge as f64 / edges as f64;
            let mut at = points.clone();
            while at.len() > 1 {
                let mix = |p: &[[f64; 2]]| [0, 1].map(|axis| p[0][axis] + share * (p[1][axis] - p[0][axis]));
                at = at.windows(2).map(mix).collect();
            }
            self.go_to(at[0]);
        }
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.loops.push(vec![self.place(x, y)]);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.go_to(self.place(x, y));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.follow([self.place(x1, y1), self.place(x, y)]);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.follow([self.place(x1, y1), self.place(x2, y2), self.place(x, y)]);
    }

    fn close(&mut self) {
        if let Some(corners) = self.loops.last_mut()
            && corners.len() > 1
            && corners.first() == corners.last()
        {
            corners.pop();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::outline::Outline;
    use super::*;

    #[test]
    fn capitals_have_the_height_asked_for_and_stand_in_the_middle() {
        for text in ["A", "H", "AH"] {
            let [x, y] = Outline::new(&outlines(text, 6.0).unwrap()).extent_mm();
            assert!((y[1] - y[0] - 6.0).abs() < 1e-6 && (x[0] + x[1]).abs() < 1e-9, "{text}: {x:?} {y:?}");
        }
        let [one, two] = ["H", "HH"].map(|text| Outline::new(&outlines(text, 6.0).unwrap()).extent_mm()[0][1]);
        assert!(two > 2.0 * one);
    }

    #[test]
    fn an_a_stands_upright_and_has_its_hole() {
        let letter = Outline::new(&outlines("A", 6.0).unwrap());
        // From the top: the point, the hole, the bar, the gap between the feet.
        let down: Vec<bool> = [-2.8, -0.3, 1.3, 2.8].map(|y| letter.contains([0.0, y])).into();
        assert_eq!(down, [true, false, true, false]);
        assert!(letter.contains([-2.2, 2.8]) && letter.contains([2.2, 2.8]) && !letter.contains([2.2, -2.8]));
        assert!(letter.nearest([0.0, -0.3]).unwrap().distance_mm < 1.0);
    }

    #[test]
    fn letters_take_few_edges() {
        for character in "ABCGORSadegs03689&".chars() {
            let count: usize = outlines(&character.to_string(), 6.0).unwrap().iter().map(Vec::len).sum();
            assert!(count <= 200, "{character}: {count} edges");
        }
    }

    #[test]
    fn a_character_without_a_glyph_is_named() {
        let error = outlines("A漢", 6.0).unwrap_err();
        assert_eq!(error.to_string(), "indenter.text = \"A漢\": there is no letter for '漢'");
        assert!(
            outlines("A\n", 6.0).is_err()
                && outlines("\u{a0}", 6.0).is_err_and(|error| error.hint().contains("letters"))
        );
    }
}
