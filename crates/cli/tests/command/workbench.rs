//! A new folder for a test: makes recordings in it, runs the command, and reads the results.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use image::{DynamicImage, RgbImage};
use tempfile::TempDir;

/// Columns and rows of the simulated camera, px.
pub(crate) const SIZE: (usize, usize) = (128, 96);
/// Largest displacement of the press, px.
pub(crate) const AMPLITUDE_PX: f64 = 4.0;

pub(crate) struct Workbench {
    folder: TempDir,
    /// The folder of solved presses.
    cache: PathBuf,
}

impl Workbench {
    /// Its solved presses are those of all tests. They hold for the solver that solved them: another one solves anew.
    pub(crate) fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap(), cache: Path::new(env!("CARGO_TARGET_TMPDIR")).join("presses") }
    }

    /// A bench whose solved presses are in its folder `cache`, without any at first.
    pub(crate) fn with_empty_cache() -> Self {
        let folder = tempfile::tempdir().unwrap();
        Self { cache: folder.path().join("cache"), folder }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Makes a folder of this name.
    pub(crate) fn folder(&self, name: &str) -> PathBuf {
        let path = self.path(name);
        fs::create_dir_all(&path).unwrap();
        path
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    /// A folder `press` of PNG images: the first at rest, the last pressed deepest.
    pub(crate) fn press(&self, frames: u32) -> PathBuf {
        let folder = self.folder("press");
        for frame in 0..frames {
            save(&press_image(frame, frames).into(), &folder, frame);
        }
        folder
    }

    /// The command in this folder, to be run or changed.
    pub(crate) fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fingervision"));
        command.args(arguments.split_whitespace()).current_dir(self.folder.path());
        command.env("FINGERVISION_CACHE", &self.cache);
        command
    }

    /// Runs the command with these arguments, separated by spaces, in this folder.
    pub(crate) fn run(&self, arguments: &str) -> Ended {
        Ended::from(self.command(arguments).output().unwrap())
    }

    /// The shape of an array of the run in the folder `run`, and its values.
    pub(crate) fn array<T: npyz::Deserialize>(&self, name: &str) -> (Vec<u64>, Vec<T>) {
        self.array_at(&format!("run/{name}"))
    }

    /// The shape of the array in a file of this folder, and its values.
    pub(crate) fn array_at<T: npyz::Deserialize>(&self, name: &str) -> (Vec<u64>, Vec<T>) {
        let bytes = fs::read(self.path(name)).unwrap();
        let file = npyz::NpyFile::new(&bytes[..]).unwrap();
        (file.shape().to_vec(), file.into_vec().unwrap())
    }

    /// The column of `readings.csv` of the run in the folder `run`.
    pub(crate) fn column(&self, name: &str) -> Vec<String> {
        let table = fs::read_to_string(self.path("run/readings.csv")).unwrap();
        let mut rows = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let place = rows.next().unwrap().iter().position(|&column| column == name).unwrap();
        rows.map(|row| row[place].to_string()).collect()
    }

    /// Checks that the run in the folder `run` holds so many whole frames and a picture of them.
    pub(crate) fn expect_run_of(&self, frames: u64) {
        assert_eq!(self.array::<f32>("flow.npy").0[0], frames, "frames of flow.npy");
        assert_eq!(self.array::<u8>("valid.npy").0[0], frames, "frames of valid.npy");
        assert_eq!(self.column("sequence").len() as u64, frames, "rows of readings.csv");
        let preview = image::open(self.path("run/preview.png")).unwrap();
        assert_eq!(preview.width(), 1600);
    }
}

/// A frame of a press on the simulated gel.
pub(crate) fn press_image(frame: u32, frames: u32) -> RgbImage {
    let fraction = f64::from(frame) / f64::from((frames - 1).max(1));
    picture(&press_motion().at(fraction), 1, u64::from(frame))
}

/// The deepest point of the press.
pub(crate) fn press_motion() -> Motion {
    Motion::RadialBump { centre_px: [63.5, 47.5], radius_px: 25.0, amplitude_px: AMPLITUDE_PX }
}

/// The camera's image of a gel with the pattern of this seed.
pub(crate) fn picture(motion: &Motion, pattern_seed: u64, noise_seed: u64) -> RgbImage {
    let (width, height) = SIZE;
    let renderer = SheetRenderer::new(&Sheet { width, height, pattern_seed, ..Sheet::default() }).unwrap();
    let image = renderer.render(motion, Light::EVEN, noise_seed).unwrap();
    RgbImage::from_raw(width as u32, height as u32, image.values().concat()).unwrap()
}

pub(crate) fn save(image: &DynamicImage, folder: &Path, frame: u32) {
    image.save(folder.join(format!("{frame:04}.png"))).unwrap();
}

/// What the command said and how it ended.
#[derive(Debug)]
pub(crate) struct Ended {
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) errors: String,
}

impl From<Output> for Ended {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Self { code: output.status.code(), out: text(output.stdout), errors: text(output.stderr) }
    }
}

impl Ended {
    /// Checks that the command did its work.
    pub(crate) fn expect_done(self) -> Self {
        assert_eq!(self.code, Some(0), "{self:?}");
        assert!(!self.errors.lines().any(|line| line.starts_with("error")), "{self:?}");
        self
    }

    /// Checks that the command failed with one clear line that says `what`, and one that says what to do about it.
    pub(crate) fn expect_failure(self, what: &str, hint: &str) -> Self {
        self.expect_failure_with(1, what, hint)
    }

    /// The same with another exit code.
    pub(crate) fn expect_failure_with(self, code: i32, what: &str, hint: &str) -> Self {
        assert_eq!(self.code, Some(code), "{self:?}");
        let beginning = |start: &str| self.errors.lines().filter(|line| line.starts_with(start)).collect::<Vec<_>>();
        let (errors, hints) = (beginning("error: "), beginning("hint: "));
        assert!(errors.len() == 1 && errors[0].contains(what), "no error saying \"{what}\" in {self:?}");
        assert!(hints.len() == 1 && hints[0].contains(hint), "no hint saying \"{hint}\" in {self:?}");
        let last = self.errors.lines().last();
        assert_eq!(last, hints.first().copied(), "the hint comes last: {self:?}");
        assert!(!self.errors.contains("panicked"), "{self:?}");
        self
    }
}
