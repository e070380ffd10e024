//! Interlaced motion JPEG: two pictures in a sample.

/// Whether a second picture follows the first: the two fields of an interlaced frame.
///
/// A decoder stops after the first, and half of the rows would pass for the frame.
pub(crate) fn has_two_fields(sample: &[u8]) -> bool {
    let behind = end_of_picture(sample).and_then(|end| sample.get(end..)).unwrap_or_default();
    behind.windows(3).any(|start| start == [0xff, 0xd8, 0xff])
}

/// The end of the first picture, by its markers: a thumbnail's end lies within a segment that is skipped.
fn end_of_picture(picture: &[u8]) -> Option<usize> {
    let mut at = 2;
    loop {
        let marker = at + picture.get(at..)?.windows(2).position(|pair| pair[0] == 0xff && is_marker(pair[1]))?;
        let content = marker + 2;
        at = match picture[marker + 1] {
            0xd9 => return Some(content),
            _ => content + usize::from(u16::from_be_bytes([*picture.get(content)?, *picture.get(content + 1)?])),
        };
    }
}

/// Not a byte of coded data, not padding, and none of the markers without content that stand between rows.
fn is_marker(byte: u8) -> bool {
    !matches!(byte, 0x00 | 0xff | 0x01 | 0xd0..=0xd7)
}
