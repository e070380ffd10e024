//! Takes the recordings of a calibration with a camera: an image or a series each time the user presses Enter.

use std::fmt::Write as _;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use fingervision_calibrate::check::{BOARD_IMAGES, ImageQuality};
use fingervision_image::{Pixels, Rect};
use fingervision_sink::{write_file, write_pixels};
use indicatif::ProgressBar;

use super::lines::{Lines, Typed};
use super::look::{Kind, Step};
use crate::failure::Failure;

/// Images of the untouched gel.
const STILLS: usize = 30;
/// Interval at which the line with exposure and focus is updated.
const REFRESH: Duration = Duration::from_millis(200);
/// The best sharpness so far is multiplied by this factor after every image, so that a change of the scene can lower
/// it.
const FADE: f32 = 0.9995;

/// A camera that takes images on request.
pub(super) trait Pictures {
    /// The newest image that was not seen yet; absent if there is none.
    fn newest(&mut self) -> Option<Pixels>;

    /// The next image that is exposed after this call.
    fn next_after_now(&mut self) -> Result<Pixels, Failure>;
}

/// The user, with a camera.
pub(super) struct Shoot<'a, P, W> {
    pub(super) camera: &'a mut P,
    pub(super) lines: &'a Lines,
    pub(super) out: &'a mut W,
    /// The line with exposure and focus.
    pub(super) line: ProgressBar,
    /// The part of the image that is used.
    pub(super) region: Option<Rect>,
    pub(super) best_sharpness: f32,
}

impl<P: Pictures, W: Write> Shoot<'_, P, W> {
    /// Takes the recording of a step; false if the input has ended before it was complete.
    pub(super) fn take(&mut self, step: &Step) -> Result<bool, Failure> {
        let Some(place) = &step.folder else { return Ok(true) };
        let recording = Recording::begin(place)?;
        let is_complete = match step.kind {
            Kind::Still => self.stills(&recording)?,
            Kind::Board => self.board(&recording)?,
            _ => self.press(&recording)?,
        };
        if is_complete { recording.finish(place).map(|()| true) } else { Ok(false) }
    }

    fn stills(&mut self, recording: &Recording) -> Result<bool, Failure> {
        let asked = format!("Touch nothing. Press Enter to take {STILLS} images");
        if self.ask(&asked)?.is_none() {
            return Ok(false);
        }
        for number in 0..STILLS {
            self.save(recording, number)?;
        }
        Ok(true)
    }

    fn board(&mut self, recording: &Recording) -> Result<bool, Failure> {
        let mut number = 0;
        while number < BOARD_IMAGES {
            let asked = format!(
                "Image {} of {BOARD_IMAGES}: press Enter when the board is at rest, or b to repeat the last one",
                number + 1
            );
            match self.ask(&asked)? {
                None => return Ok(false),
                Some(text) if text == "b" => number = number.saturating_sub(1),
                Some(_) => {
                    self.save(recording, number)?;
                    number += 1;
                }
            }
        }
        Ok(true)
    }

    fn press(&mut self, recording: &Recording) -> Result<bool, Failure> {
        if self.ask("Image 1, the gel untouched: press Enter")?.is_none() {
            return Ok(false);
        }
        self.save(recording, 0)?;
        let mut rows: Vec<(f64, Option<f64>)> = Vec::new();
        loop {
            let number = rows.len() + 1;
            let asked = format!(
                "Image {}: press deeper and hold still, then type the depth in mm and, if you measure it, the force in N, as in 0.5 or \
                 0.5 1.2; b repeats the last one, an empty line ends the press",
                number + 1
            );
            let Some(text) = self.ask(&asked)? else { return Ok(false) };
            match text.as_str() {
                "" if rows.is_empty() => writeln!(self.out, "a press needs at least one depth")?,
                "" => break,
                "b" => {
                    rows.pop();
                }
                text => match row(text, rows.first()) {
                    Ok(row) => {
                        self.save(recording, number)?;
                        rows.push(row);
                    }
                    Err(form) => writeln!(self.out, "{text}: {form}")?,
                },
            }
        }
        recording.truncate(rows.len() + 1)?;
        recording.depths(&rows)?;
        Ok(true)
    }

    /// Waits for a line and shows exposure and focus meanwhile; none at the end of the input.
    fn ask(&mut self, asked: &str) -> Result<Option<String>, Failure> {
        self.line.suspend(|| writeln!(self.out, "{asked}."))?;
        self.out.flush()?;
        loop {
            match self.lines.next_within(REFRESH) {
                Typed::Line(line) => return Ok(Some(line.trim().to_owned())),
                Typed::End => return Ok(None),
                Typed::Nothing => {}
            }
            if let Some(pixels) = self.camera.newest() {
                self.show(&pixels);
            }
        }
    }

    fn show(&mut self, pixels: &Pixels) {
        let (width, height) = pixels.size();
        let region = self.region.unwrap_or(Rect { x: 0, y: 0, width, height });
        let Some(quality) = ImageQuality::of(pixels, region) else { return };
        self.best_sharpness = quality.sharpness.max(FADE * self.best_sharpness);
        let focus = 100.0 * quality.sharpness / self.best_sharpness.max(f32::MIN_POSITIVE);
        let exposure = quality.exposure_advice().unwrap_or("exposure is right");
        self.line.set_message(format!(
            "mean level {:.0}, {:.1} % saturated: {exposure}; focus {focus:.0} % of the best so far",
            quality.mean_level,
            100.0 * quality.saturated
        ));
    }

    fn save(&mut self, recording: &Recording, number: usize) -> Result<(), Failure> {
        let pixels = self.camera.next_after_now()?;
        recording.save(&pixels, number)?;
        self.show(&pixels);
        Ok(())
    }
}

/// The depth, mm, and the force, N, that were typed. All rows of a table have a force, or none.
fn row(text: &str, first: Option<&(f64, Option<f64>)>) -> Result<(f64, Option<f64>), String> {
    let form = "expected the depth in mm, 0 to 100, and, if it is measured, the force in N, as in 0.5 1.2";
    let numbers: Result<Vec<f64>, _> = text.replace(',', ".").split_whitespace().map(str::parse).collect();
    let row = match numbers.as_deref() {
        Ok(&[depth]) if (0.0..=100.0).contains(&depth) => (depth, None),
        Ok(&[depth, force]) if (0.0..=100.0).contains(&depth) && (0.0..=1e4).contains(&force) => (depth, Some(force)),
        _ => return Err(form.into()),
    };
    match first {
        Some(first) if first.1.is_some() != row.1.is_some() => {
            Err("give a force with every depth of a press, or with none".into())
        }
        _ => Ok(row),
    }
}

/// A recording that is being taken, beside the folder that it replaces when it is complete.
struct Recording {
    folder: PathBuf,
}

impl Recording {
    fn begin(place: &Path) -> Result<Self, Failure> {
        let name = place.file_name().unwrap_or_default().to_string_lossy().into_owned();
        // The guide does not see a folder of this name.
        let folder = place.with_file_name(format!(".{name}.new"));
        let begun = Self { folder };
        if begun.folder.exists() {
            fs::remove_dir_all(&begun.folder).map_err(|error| begun.failure(&error))?;
        }
        fs::create_dir_all(&begun.folder).map_err(|error| begun.failure(&error))?;
        Ok(begun)
    }

    fn failure(&self, error: &std::io::Error) -> Failure {
        let message = format!("{}: {error}", self.folder.display());
        Failure::new(message, "make the sensor's folder writable, and make room on its disk")
    }

    fn image(&self, number: usize) -> PathBuf {
        self.folder.join(format!("{number:06}.png"))
    }

    fn save(&self, pixels: &Pixels, number: usize) -> Result<(), Failure> {
        Ok(write_pixels(pixels, &self.image(number))?)
    }

    /// Removes images behind the first `count`.
    fn truncate(&self, count: usize) -> Result<(), Failure> {
        let mut behind = (count..).map(|number| self.image(number)).take_while(|path| path.exists());
        behind.try_for_each(|path| fs::remove_file(path).map_err(|error| self.failure(&error)))
    }

    fn depths(&self, rows: &[(f64, Option<f64>)]) -> Result<(), Failure> {
        let has_force = rows.iter().any(|(_, force)| force.is_some());
        let mut text =
            String::from(if has_force { "frame,depth_mm,force_z_n\n0,0,0\n" } else { "frame,depth_mm\n0,0\n" });
        for (number, (depth, force)) in (1..).zip(rows) {
            let force = force.map(|force| format!(",{force}")).unwrap_or_default();
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{number},{depth}{force}");
        }
        Ok(write_file(&self.folder.join("depth.csv"), text.as_bytes())?)
    }

    /// Replaces the folder of an earlier recording.
    fn finish(self, place: &Path) -> Result<(), Failure> {
        if place.exists() {
            fs::remove_dir_all(place).map_err(|error| self.failure(&error))?;
        }
        fs::rename(&self.folder, place).map_err(|error| self.failure(&error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    /// Images whose level counts them.
    struct Counted(u8);

    impl Pictures for Counted {
        fn newest(&mut self) -> Option<Pixels> {
            self.next_after_now().ok()
        }

        fn next_after_now(&mut self) -> Result<Pixels, Failure> {
            self.0 = self.0.wrapping_add(1);
            Ok(Pixels::Grey8(fingervision_image::Image::from_fn(8, 8, |x, _| self.0.wrapping_mul(x as u8))))
        }
    }

    /// Takes a recording with the typed lines; returns its folder, whether it is complete, and the output.
    fn take(kind: Kind, typed: &'static str) -> (tempfile::TempDir, bool, String) {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("taken");
        fs::create_dir(&place).unwrap();
        fs::write(place.join("old.png"), "").unwrap();
        let step = Step::recording(kind, place, None);
        let (mut said, lines) = (Vec::new(), Lines::of(Cursor::new(typed)));
        let (line, camera) = (ProgressBar::hidden(), &mut Counted(0));
        let mut shoot = Shoot { camera, lines: &lines, out: &mut said, line, region: None, best_sharpness: 0.0 };
        let is_complete = shoot.take(&step).unwrap();
        (folder, is_complete, String::from_utf8(said).unwrap())
    }

    fn files(folder: &tempfile::TempDir) -> Vec<String> {
        let entries = fs::read_dir(folder.path().join("taken")).unwrap();
        let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_still_replaces_an_earlier_one_when_it_is_complete() {
        let (folder, is_complete, _) = take(Kind::Still, "\n");
        assert!(is_complete && files(&folder).len() == STILLS && files(&folder)[0] == "000000.png");
        let (folder, is_complete, said) = take(Kind::Still, "");
        assert!(!is_complete && files(&folder) == ["old.png"] && said.contains("Touch nothing"), "{said}");
    }

    #[test]
    fn a_board_takes_an_image_for_every_line() {
        let (folder, is_complete, _) = take(Kind::Board, "\n\nb\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n");
        assert!(is_complete && files(&folder).len() == BOARD_IMAGES, "{:?}", files(&folder));
        assert!(!take(Kind::Board, "\n\n").1);
    }

    #[test]
    fn a_press_writes_its_depths_beside_the_images() {
        let (folder, is_complete, said) = take(Kind::Press, "\n\n0.5 1.2\ndeep\n1,0 2.5\n1.5\n2 3\nb\n1.5 3\n\n");
        assert!(is_complete);
        assert_eq!(files(&folder), ["000000.png", "000001.png", "000002.png", "000003.png", "depth.csv"]);
        let table = fs::read_to_string(folder.path().join("taken/depth.csv")).unwrap();
        assert_eq!(table, "frame,depth_mm,force_z_n\n0,0,0\n1,0.5,1.2\n2,1,2.5\n3,1.5,3\n");
        for text in ["at least one depth", "deep: expected the depth in mm", "1.5: give a force with every depth"] {
            assert!(said.contains(text), "no \"{text}\" in {said}");
        }
    }
}
