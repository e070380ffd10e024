//! Finds the position of a value in a text.

use std::fmt::Write;

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

/// The path of the value or table that an error is about, as in `motion.keyframes[2].depth_mm`; empty for the document
/// itself.
///
/// The deserialiser names the keys on the way in the last line of its message, ``in `motion.keyframes.depth_mm` ``, and
/// gives the error's place in the text. The place shows which items of lists they belong to.
pub(crate) fn path_of(text: &str, error: &toml::de::Error) -> String {
    let mut alone = error.clone();
    alone.set_input(None);
    let shown = alone.to_string();
    let keys = shown.lines().last().and_then(|line| line.strip_prefix("in `")?.strip_suffix('`')).unwrap_or_default();
    let root = DeTable::parse(text).ok().map(|root| DeValue::Table(root.into_inner()));
    let (mut path, mut value) = (String::new(), root.as_ref());
    for key in keys.split('.').filter(|key| !key.is_empty()) {
        let joint = if path.is_empty() { "" } else { "." };
        let _ = write!(path, "{joint}{key}");
        value = value.and_then(|value| value.as_table()?.get(key)).map(toml::Spanned::get_ref);
        while let Some((index, item)) = item_at(value, error.span().map_or(0, |span| span.start)) {
            let _ = write!(path, "[{index}]");
            value = Some(item);
        }
    }
    path
}

/// The item of a list that the byte at `offset` is in: the last one that begins before it. Absent if the value is no list,
/// or if the place is that of the list itself.
fn item_at<'a, 'b>(value: Option<&'a DeValue<'b>>, offset: usize) -> Option<(usize, &'a DeValue<'b>)> {
    let items = value?.as_array()?.iter().enumerate();
    items.take_while(|(_, item)| item.span().start <= offset).last().map(|(index, item)| (index, item.get_ref()))
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
    fn an_error_is_found_in_lists_of_every_form() {
        #[derive(serde::Deserialize, Debug)]
        #[serde(deny_unknown_fields)]
        struct Root {
            #[expect(dead_code, reason = "only its errors matter")]
            table: Option<Inner>,
            #[expect(dead_code, reason = "only its errors matter")]
            items: Option<Vec<Inner>>,
        }
        #[derive(serde::Deserialize, Debug)]
        #[serde(deny_unknown_fields)]
        struct Inner {
            #[expect(dead_code, reason = "only its errors matter")]
            sizes: Vec<[f64; 2]>,
        }
        for (text, path) in [
            ("other = 1", ""),
            ("table = 1", "table"),
            ("[table]", "table"),
            ("[table]\nsizes = 1", "table.sizes"),
            ("table.sizes = [[1, 2], [3, 'a']]", "table.sizes[1][1]"),
            ("table.sizes = [[1, 2], [3]]", "table.sizes[1]"),
            ("[[items]]\nsizes = []\n[[items]]\nsizes = [[1, 'a']]", "items[1].sizes[0][1]"),
            ("[[items]]\nsizes = []\n[[items]]\nsize = 1", "items[1]"),
            ("items = [{ sizes = [] }, { sizes = 1 }, { sizes = [] }]", "items[1].sizes"),
        ] {
            let error = toml::from_str::<Root>(text).unwrap_err();
            assert_eq!(path_of(text, &error), path, "{text}: {error}");
        }
    }

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
