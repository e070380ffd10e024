//! The file of a recording: its name, and its contents in words.

use std::path::Path;

use fingervision_recording::RecorderProgress;

use crate::disk;
use crate::failure::Failure;

/// Refuses a file without the ending of recordings, one that exists, and one in a folder that does not.
pub(crate) fn refuse_other_names(file: &Path, replaces: bool) -> Result<(), Failure> {
    let shown = file.display();
    if !file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap")) {
        let hint = format!("name it {}", file.with_extension("mcap").display());
        return Err(Failure::new(format!("{shown}: recordings are MCAP files"), hint));
    }
    if file.exists() && !replaces {
        return Err(Failure::new(
            format!("{shown} exists already"),
            "name a new file; `record --overwrite` replaces it",
        ));
    }
    match file.parent().filter(|parent| !parent.as_os_str().is_empty() && !parent.is_dir()) {
        Some(parent) => {
            let message = format!("{shown}: there is no folder {}", parent.display());
            Err(Failure::new(message, "make the folder first"))
        }
        None => Ok(()),
    }
}

/// The progress of a recording, for the terminal.
pub(crate) fn progress_text(file: &Path, progress: &RecorderProgress) -> String {
    let RecorderProgress { bytes, seconds, .. } = *progress;
    let rate = if seconds > 0.0 { bytes as f64 / seconds } else { 0.0 };
    let free = disk::free(file).map_or_else(String::new, |free| format!(", {} free", disk::size(free)));
    format!("{}: {seconds:.1} s, {}, {}/s{free}", file.display(), disk::size(bytes), disk::size(rate as u64))
}

/// The contents of a recording.
pub(crate) fn summary_text(file: &Path, progress: &RecorderProgress) -> String {
    let RecorderProgress { bytes, frames, readings, seconds, .. } = *progress;
    format!("{}: {frames} frames, {readings} readings, {seconds:.1} s, {}", file.display(), disk::size(bytes))
}
