//! Sequence numbers that show where frames are missing.
//!
//! A frame's sequence number is its position in the complete recording: if the images have a gap, the numbers have a gap,
//! too, and the tracker can count the missing frames.

/// Sequence numbers by the numbers in file names: from 0, with a gap for every number that is missing.
///
/// Names count frames if they consist of a common text, a number that grows from file to file, and a common text. The
/// usual step between two numbers is the smallest; every other step must be a multiple of it, and at least half of the
/// steps must equal it. A recording with every tenth image is thus complete. Names that do not count, such as times of
/// day, contain no information about gaps: none for these.
pub(crate) fn by_names<'a>(stems: impl IntoIterator<Item = &'a str>) -> Option<Vec<u64>> {
    let parts: Vec<Parts> = stems.into_iter().map(Parts::of).collect::<Option<_>>()?;
    let first = parts.first()?;
    if parts.iter().any(|part| (part.before, part.after) != (first.before, first.after)) {
        return None;
    }
    let steps: Vec<u64> =
        parts.windows(2).map(|pair| pair[1].number.checked_sub(pair[0].number)).collect::<Option<_>>()?;
    let usual = *steps.iter().min().filter(|&&step| step > 0)?;
    let count = steps.iter().filter(|&&step| step == usual).count();
    let is_counted = steps.iter().all(|step| step % usual == 0) && 2 * count >= steps.len();
    is_counted.then(|| parts.iter().map(|part| (part.number - first.number) / usual).collect())
}

/// A file name around the last number in it.
struct Parts<'a> {
    before: &'a str,
    number: u64,
    after: &'a str,
}

impl<'a> Parts<'a> {
    fn of(stem: &'a str) -> Option<Self> {
        let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
        let start = stem[..end].trim_end_matches(|c: char| c.is_ascii_digit()).len();
        Some(Self { before: &stem[..start], number: stem[start..end].parse().ok()?, after: &stem[end..] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers<const N: usize>(stems: [&str; N]) -> Option<Vec<u64>> {
        by_names(stems)
    }

    #[test]
    fn a_number_that_is_missing_leaves_a_gap() {
        assert_eq!(numbers(["000001", "000002", "000005"]), Some(vec![0, 1, 4]));
        assert_eq!(numbers(["a-7", "a-8", "a-9"]), Some(vec![0, 1, 2]));
        assert_eq!(numbers(["cam0_08_rgb", "cam0_09_rgb", "cam0_11_rgb"]), Some(vec![0, 1, 3]));
    }

    #[test]
    fn every_tenth_image_is_a_whole_recording() {
        assert_eq!(numbers(["f0", "f10", "f20", "f30"]), Some(vec![0, 1, 2, 3]));
        assert_eq!(numbers(["f0", "f10", "f20", "f50"]), Some(vec![0, 1, 2, 5]));
        assert_eq!(numbers(["f3", "f9"]), Some(vec![0, 1]));
    }

    #[test]
    fn names_that_do_not_count_frames_tell_nothing() {
        assert_eq!(numbers(["rest", "press"]), None);
        assert_eq!(numbers(["a1", "b2", "b3"]), None);
        assert_eq!(numbers(["t1000", "t1033", "t1067", "t1100"]), None);
        assert_eq!(numbers(["1", "4", "6", "13", "20"]), None);
        assert_eq!(numbers(["1", "01", "2"]), None);
    }
}
