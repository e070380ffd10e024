//! The tables and figures of [Du2021], reproduced with the simulated sensor and the tracker.
//!
//! [`reproduce`] goes through them in the paper's order and returns a [`Reproduction`]: all numbers, and a page that
//! shows them beside what the paper prints. Everything is measured in the [`Setting`] that the paper's text fixes and,
//! where it makes a difference, on the default simulated sensor.
//!
//! [Du2021]: https://doi.org/10.1109/LRA.2021.3061306

mod assumptions;
mod camera;
mod indenters;
mod law;
mod pattern;
mod pictures;
mod published;
mod references;
mod report;
mod setting;
mod speed;

use std::ops::ControlFlow;

use fingervision_gel::PressCache;

pub use assumptions::{Assumption, Assumptions};
pub use camera::TableOne;
pub use indenters::{IndenterErrors, Indenters};
pub use law::LawFit;
pub use references::{PolicyErrors, ReferenceErrors};
pub use report::Reproduction;
pub use setting::Setting;
pub use speed::Speed;

use crate::experiment::ExperimentError;

pub use crate::experiment::Extent;

/// Called with the name of the next part; it can end the run.
pub type Progress<'a> = &'a (dyn Fn(&str) -> ControlFlow<()> + Sync);

/// Makes all tables and figures.
///
/// # Errors
///
/// [`ExperimentError`] if a press cannot be solved, tracked or fitted; [`ExperimentError::Interrupted`] if `progress`
/// ends it.
pub fn reproduce(extent: Extent, cache: &PressCache, progress: Progress) -> Result<Reproduction, ExperimentError> {
    let next = |part: &str| if progress(part).is_break() { Err(ExperimentError::Interrupted) } else { Ok(()) };
    let lab = Lab { extent, cache };
    let mut laws = Vec::new();
    let mut indenters = Vec::new();
    next("pattern and density")?;
    let mut sections = vec![pattern::section(&lab)?, pattern::density_section()?];
    next("references")?;
    let (references, section) = references::measure(&lab)?;
    sections.push(section);
    for &setting in extent.settings() {
        next("calibration presses")?;
        let (fits, law, section) = law::measure(&lab, setting)?;
        laws.push(law);
        sections.push(section);
        next("indenters")?;
        let (measured, shown) = indenters::measure(&lab, setting, &fits)?;
        indenters.push(measured);
        sections.extend(shown);
    }
    next("assumptions")?;
    let (assumptions, section) = assumptions::measure(&lab)?;
    sections.push(section);
    next("camera")?;
    let (table_one, section) = camera::measure(&lab)?;
    sections.push(section);
    next("speed")?;
    let (speed, section) = speed::measure(&lab)?;
    sections.push(section);
    Ok(Reproduction { extent, references, laws, assumptions, indenters, table_one, speed, sections })
}

/// The inputs of every experiment.
#[derive(Debug, Clone, Copy)]
struct Lab<'a> {
    extent: Extent,
    cache: &'a PressCache,
}
