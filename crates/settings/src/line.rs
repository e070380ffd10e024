//! Finds the position of a value in a text.

use toml::de::{DeTable, DeValue};

/// The line, from 1, of the value at `path`, as in `motion.keyframes[2].depth_mm`; the line of the innermost table on the
/// way if the value itself is not in the text. Absent if nothing on the way is.
pub(crate) fn line_of(text: &str, path: &str) -> Option<usize> {
    let root = DeValue::Table(DeTable::parse(text).ok()?.into_inner());
    let (mut value, mut offset) = (&root, None);
    for step in steps(path) {
        let inner = match step {
            Step::Key(key) => {
                let entry = value.as_table().and_then(|table| table.iter().find(|(name, _)| name.get_ref() == key));
                entry.map(|(name, inner)| (name.span(), inner))
            }
            Step::Index(index) => {
                value.as_array().and_then(|array| array.get(index)).map(|inner| (inner.span(), inner))
            }
        };
        let Some((span, inner)) = inner else { break };
        (value, offset) = (inner.get_ref(), Some(span.start));
    }
    offset.map(|offset| line_at(text, offset))
}

/// The line, from 1, that contains the byte at `offset`.
pub(crate) fn line_at(text: &str, offset: usize) -> usize {
    1 + text.bytes().take(offset).filter(|&byte| byte == b'\n').count()
}

enum Step<'a> {
    Key(&'a str),
    Index(usize),
}

fn steps(path: &str) -> impl Iterator<Item = Step<'_>> {
    path.split('.').flat_map(|part| {
        let mut pieces = part.split('[');
        let key = pieces.next().unwrap_or_default();
        let indices = pieces.filter_map(|piece| piece.trim_end_matches(']').parse().ok().map(Step::Index));
        std::iter::once(Step::Key(key)).chain(indices)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str =
        "name = 'a'\n[gel]\nsize_mm = [30, 30]\n[motion]\nkeyframes = [\n{ at = 1 },\n{ at = 2,\ndepth = 3 }]\n";

    #[test]
    fn a_value_is_found_by_its_path() {
        for (path, line) in [
            ("name", Some(1)),
            ("gel", Some(2)),
            ("gel.size_mm", Some(3)),
            ("gel.size_mm[1]", Some(3)),
            ("motion.keyframes", Some(5)),
            ("motion.keyframes[1].depth", Some(8)),
        ] {
            assert_eq!(line_of(TEXT, path), line, "{path}");
        }
    }

    #[test]
    fn what_is_not_written_has_the_line_of_its_table() {
        assert_eq!(line_of(TEXT, "gel.thickness_mm"), Some(2));
        assert_eq!(line_of(TEXT, "motion.keyframes[0].depth"), Some(6));
        assert_eq!(line_of(TEXT, "motion.keyframes[7].depth"), Some(5));
        assert_eq!(line_of(TEXT, "camera.focal_length_px"), None);
        assert_eq!(line_of("not toml", "name"), None);
    }
}
