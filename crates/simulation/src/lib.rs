//! A simulated press as a recording: a source of frames, a folder of files, and a picture.
//!
//! [`SimulatedSource`] provides the frames of a scene that a [`SimulatedLocation`] names, `sim:SCENE`; [`open`] takes
//! such a location as well as a folder or a video, and [`PressFilm`] repeats presses without end. [`SimulationFolder`]
//! writes a press frame by frame with its truth, [`SimulationPreview`] draws it. [`simulated_profile`] is the profile
//! of the simulated sensor.

mod film;
mod folder;
mod frame;
mod preview;
mod profile;
mod source;

pub use film::PressFilm;
pub use folder::SimulationFolder;
pub use frame::SimulatedFrame;
pub use preview::SimulationPreview;
pub use profile::simulated_profile;
pub use source::{SimulatedLocation, SimulatedSource, open};
