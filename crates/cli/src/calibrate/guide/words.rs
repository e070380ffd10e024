//! The texts of the guided calibration: the checklist, and the instructions for each recording.

use std::fmt;
use std::path::Path;

use fingervision_calibrate::check::{BOARD_IMAGES, STILL_IMAGES};

use super::Progress;
use super::look::{Kind, State, Step};

impl fmt::Display for Progress<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "Calibration of the sensor in {}\n", self.folder.display())?;
        for step in &self.steps {
            write_row(f, step)?;
        }
        writeln!(f)?;
        if let Some(outcome) = &self.outcome {
            return outcome.fmt(f);
        }
        match self.steps.iter().find(|step| step.is_open()) {
            Some(step) => write_next(f, step, self.folder),
            None => Ok(()),
        }
    }
}

fn write_row(f: &mut fmt::Formatter<'_>, step: &Step) -> fmt::Result {
    let mark = match step.state {
        State::Done => "done",
        State::Redo => "redo",
        State::Next => "next",
        State::Later => "-",
        State::Optional => "optional",
    };
    write!(f, "  {mark:8}  {:10}", step.name)?;
    if let Some(answer) = &step.answer {
        write!(f, "{answer}")?;
    }
    if step.state == State::Optional {
        write!(f, "{}", question(step.kind))?;
    }
    let Some(check) = &step.check else { return writeln!(f) };
    if check.images > 0 {
        writeln!(f, "{check}")?;
    }
    for (number, fault) in check.faults.iter().enumerate() {
        let indent = if number == 0 && check.images == 0 { "" } else { "                      " };
        writeln!(f, "{indent}{fault}\n                      do: {}", fault.remedy)?;
    }
    Ok(())
}

fn write_next(f: &mut fmt::Formatter<'_>, step: &Step, folder: &Path) -> fmt::Result {
    let heading = if step.state == State::Redo { "Again" } else { "Next" };
    writeln!(f, "{heading}: {}\n\n{}", step.name, how_to(step.kind))?;
    if let Some(place) = &step.folder {
        let emptied = if step.state == State::Redo {
            "Replace what is in"
        } else {
            "Put the images, numbered in their order, into"
        };
        writeln!(f, "{emptied} {}", place.display())?;
    }
    let answer = if step.kind == Kind::Distance { " --distance-mm 25±0.5" } else { "" };
    writeln!(f, "Then: fingervision calibrate --folder {}{answer}", folder.display())
}

/// An optional question, and the use of its answer.
fn question(kind: Kind) -> &'static str {
    match kind {
        Kind::View => {
            "the width of the gel between the image's left and right border, measured with a ruler: --view-mm 30 (to check the board's step)"
        }
        Kind::Gel => {
            "the gel's width, height and thickness: --gel-mm 30,30,10 (for depth from elasticity, contact and force)"
        }
        _ => "",
    }
}

/// The instructions for a step.
fn how_to(kind: Kind) -> String {
    match kind {
        Kind::Still => format!(
            "Build the sensor as it will be used. Focus on the pattern and lock focus, exposure, gain and white balance: do not\n\
             change the camera after this. Touch nothing, and record the gel for some seconds: {STILL_IMAGES} images or more,\n\
             whole frames without loss (PNG). This shows whether exposure, focus, light and mounting are good enough."
        ),
        Kind::Board => format!(
            "Put a flat board with a dense random pattern where the gel's surface is (fingervision pattern prints one). It must\n\
             fill the image at both ends of the slide. Slide it along the image's x axis by equal steps of 0.5 mm, always from the same\n\
             side, and take an image at rest after each: {BOARD_IMAGES} images. Another step or direction: --step-mm, --direction."
        ),
        Kind::Distance => "The images do not show the distance: a long lens far away gives the same images. Measure from the middle of the lens to the\n\
             gel's surface, in mm, and add the standard deviation of the measurement."
            .into(),
        Kind::View | Kind::Gel => question(kind).into(),
        Kind::Press => "Press a small flat stamp, some mm wide, straight into the gel and stop at known depths, on a stage or with shims: the first\n\
             image untouched, then 5 to 10 depths down to 1 to 3 mm. One press at the centre, one midway, one towards a corner;\n\
             nine presses, 1, 2 and 3 mm deep at each place, are better than three. Beside the images write depth.csv: a line frame,depth_mm,\n\
             then a row for every image, from 0, as in 0,0.0 and 1,0.2. A third column, force_z_n, in N from a scale, gives force."
            .into(),
    }
}
