//! Drawing: fields as colours, curves, panels with legends, whole pages. Their input is plain data.
//!
//! [`Comparison`], [`CurvePlots`] and [`HeatPanels`] are pages of their own. To draw another page, take a [`Canvas`]
//! and put onto it, with the sizes and the typeface of [`page`], [`Panel`]s with their keys ([`draw_colour_bar`],
//! [`draw_wheel_key`]), [`FramePlot`]s and [`TimePlots`]. [`flow_colours`] and [`heat_map`] can be used alone. This
//! crate writes no files: a picture is an image.

mod axes;
mod canvas;
mod colour;
mod colour_map;
mod comparison;
mod curves;
mod flow_colours;
mod heat_map;
mod heat_panels;
mod keys;
mod lines;
mod outline;
pub mod page;
mod panel;
mod text;
mod ticks;
mod time_plot;
mod trend;

pub use canvas::{Area, Canvas, Point, resized};
pub use colour::{INVALID_COLOUR, Rgb};
pub use colour_map::ColourMap;
pub use comparison::{Comparison, Pair};
pub use curves::{Curve, CurvePanel, CurvePlots, StraightLine};
pub use flow_colours::{LEAST_FLOW_PX, colour_wheel, flow_colours};
pub use heat_map::{HeatScale, heat_map};
pub use heat_panels::{HeatPanel, HeatPanels};
pub use keys::{RULE, draw_colour_bar, draw_invalid_key, draw_wheel_key};
pub use lines::FramePlot;
pub use outline::{Outline, draw_outline_key};
pub use panel::Panel;
pub use text::{Anchor, Style};
pub use ticks::{number, plain, round_up, step_below};
pub use time_plot::{TimePlot, TimePlots};
pub use trend::{Step, Trend};
