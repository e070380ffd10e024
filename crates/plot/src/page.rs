//! The layout and the lettering of a page: three columns of panels, each with its legend below.

use crate::colour::Rgb;
use crate::text::{Anchor, Style};

/// Width of a page, px.
pub const WIDTH: f32 = 1600.0;
/// Around everything, px.
pub const MARGIN: f32 = 40.0;
/// Between panels, px.
pub const GAP: f32 = 40.0;
/// Width of a panel and its legend, px.
pub const COLUMN: f32 = (WIDTH - 2.0 * MARGIN - 2.0 * GAP) / 3.0;
/// A tall image is scaled to fit its column, px.
pub const MAX_PANEL_HEIGHT: f32 = 600.0;
/// Where the first row of panels begins, px.
pub const PANEL_TOP: f32 = 152.0;
/// Height of the legend below a panel, px.
pub const LEGEND_HEIGHT: f32 = 124.0;

/// The colour of a page.
pub const BACKGROUND: Rgb = [255; 3];
/// The colour of invalid or wrong values.
pub const WARNING_INK: Rgb = [179, 38, 30];
const INK: Rgb = [32, 33, 36];
const FAINT_INK: Rgb = [95, 99, 104];

/// The first line of a page.
pub const TITLE: Style = Style { size: 28.0, is_bold: true, colour: INK, anchor: Anchor::Left };
/// Above a panel or a plot.
pub const HEADING: Style = Style { size: 18.0, ..TITLE };
/// Names and numbers.
pub const BODY: Style = Style { size: 16.0, is_bold: false, colour: INK, anchor: Anchor::Left };
/// Explanations.
pub const NOTE: Style = Style { colour: FAINT_INK, ..BODY };
