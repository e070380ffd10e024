//! Checks whether a run fits on its disk.

use std::path::Path;

use crate::output::OutputArgs;

/// The size of a smaller run is not printed, bytes.
const WORTH_SAYING: u64 = 1 << 30;
/// Frame rate assumed for streams without an end.
const USUAL_FRAMES_PER_SECOND: u64 = 30;

/// The size of a run and the free space.
#[derive(Debug, Clone, Copy)]
struct Need {
    bytes_per_frame: u64,
    /// Number of frames; absent if it is not known.
    frames: Option<u64>,
    free_bytes: u64,
}

/// Prints the size of a run into `folder`, if it is large or more than the free space.
pub(crate) fn check(folder: &Path, bytes_per_frame: u64, frames: Option<u64>, output: OutputArgs) {
    // If the free space is not known, writing will show it.
    let remark = free(folder).and_then(|free_bytes| Need { bytes_per_frame, frames, free_bytes }.remark());
    if let Some(remark) = remark {
        output.note(&remark);
    }
}

/// The free space, bytes, where a file or folder is or will be; absent if it is not known.
pub(crate) fn free(place: &Path) -> Option<u64> {
    place.ancestors().find_map(|parent| {
        let parent = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
        fs4::available_space(parent).ok()
    })
}

impl Need {
    /// The message, if any.
    fn remark(self) -> Option<String> {
        let Self { bytes_per_frame, frames, free_bytes } = self;
        let (each, free) = (size(bytes_per_frame), size(free_bytes));
        let Some(frames) = frames else {
            let second = size(bytes_per_frame * USUAL_FRAMES_PER_SECOND);
            let room = free_bytes / bytes_per_frame.max(1);
            return Some(format!(
                "the run takes {each} a frame, {second} a second at {USUAL_FRAMES_PER_SECOND} frames per second; {free} are \
                 free, {room} frames"
            ));
        };
        let bytes = bytes_per_frame.saturating_mul(frames);
        let what = format!("{} for {frames} frames, {each} each", size(bytes));
        match bytes {
            _ if bytes > free_bytes => Some(format!(
                "the run takes {what}, but only {free} are free: it will end early; --dtype float16 takes about half, --fields depth \
                 leaves out the flow"
            )),
            WORTH_SAYING.. => Some(format!("the run takes {what}; {free} are free")),
            _ => None,
        }
    }
}

/// Bytes in a unit that leaves few digits.
pub(crate) fn size(bytes: u64) -> String {
    const UNITS: [(f64, &str); 3] = [(1e9, "GB"), (1e6, "MB"), (1e3, "kB")];
    let bytes = bytes as f64;
    let unit = UNITS.into_iter().find(|(unit, _)| bytes >= *unit);
    unit.map_or(format!("{bytes} bytes"), |(unit, name)| format!("{:.1} {name}", bytes / unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_much_and_what_does_not_fit_is_said() {
        let need = |frames, free_bytes| Need { bytes_per_frame: 4_400_000, frames, free_bytes }.remark();
        assert_eq!(need(Some(100), 80_000_000_000), None);
        let said = need(Some(1800), 80_000_000_000).unwrap();
        assert_eq!(said, "the run takes 7.9 GB for 1800 frames, 4.4 MB each; 80.0 GB are free");
        let warned = need(Some(1800), 7_900_000_000).unwrap();
        assert!(warned.starts_with("the run takes 7.9 GB for 1800 frames, 4.4 MB each, but only 7.9 GB"), "{warned}");
        let stream = need(None, 80_000_000_000).unwrap();
        assert!(stream.contains("4.4 MB a frame, 132.0 MB a second") && stream.contains("18181 frames"), "{stream}");
        assert!(need(Some(u64::MAX), u64::MAX - 1).unwrap().contains("end early"));
    }
}
