//! Lettering: glyph outlines of an embedded typeface as paths to fill.

use std::sync::LazyLock;

use tiny_skia::{Path, PathBuilder};
use ttf_parser::{Face, OutlineBuilder};

use crate::colour::Rgb;

static REGULAR: LazyLock<Face<'static>> = LazyLock::new(|| face(include_bytes!("../fonts/Inter-Regular.otf")));
static SEMI_BOLD: LazyLock<Face<'static>> = LazyLock::new(|| face(include_bytes!("../fonts/Inter-SemiBold.otf")));

fn face(font: &'static [u8]) -> Face<'static> {
    Face::parse(font, 0).expect("the embedded font is whole")
}

/// The part of a text at its given position.
#[derive(Debug, Clone, Copy)]
pub enum Anchor {
    /// Its left end.
    Left,
    /// Its middle.
    Centre,
    /// Its right end.
    Right,
}

/// The style of a text.
#[derive(Debug, Clone, Copy)]
pub struct Style {
    /// Height of the em square, px.
    pub size: f32,
    /// Semi-bold instead of regular.
    pub is_bold: bool,
    /// Its colour.
    pub colour: Rgb,
    /// The point of the text that is placed at the given position.
    pub anchor: Anchor,
}

impl Style {
    /// The same with another anchor.
    #[must_use]
    pub fn anchored(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }

    /// Length of a text, px.
    #[must_use]
    pub fn width(&self, text: &str) -> f32 {
        let (face, scale) = self.face();
        let advances = text.chars().filter_map(|c| face.glyph_hor_advance(face.glyph_index(c)?));
        advances.map(|advance| f32::from(advance) * scale).sum()
    }

    /// The outline of a text with its anchor at `x` on the baseline `y`; none for a text without ink. Characters that
    /// the typeface lacks are left out. that the typeface lacks are left out.
    pub(crate) fn outline(&self, text: &str, x: f32, y: f32) -> Option<Path> {
        let (face, scale) = self.face();
        let x = match self.anchor {
            Anchor::Left => x,
            Anchor::Centre => x - self.width(text) / 2.0,
            Anchor::Right => x - self.width(text),
        };
        let mut pen = Pen { path: PathBuilder::new(), x, y, scale };
        for glyph in text.chars().filter_map(|c| face.glyph_index(c)) {
            face.outline_glyph(glyph, &mut pen);
            pen.x += f32::from(face.glyph_hor_advance(glyph).unwrap_or(0)) * scale;
        }
        pen.path.finish()
    }

    /// The typeface and the px per font unit.
    fn face(&self) -> (&'static Face<'static>, f32) {
        let face: &Face = if self.is_bold { &SEMI_BOLD } else { &REGULAR };
        (face, self.size / f32::from(face.units_per_em()))
    }
}

/// Puts outlines in font units, y up, at a place in px, y down.
struct Pen {
    path: PathBuilder,
    x: f32,
    y: f32,
    scale: f32,
}

impl Pen {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + x * self.scale, self.y - y * self.scale)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}
