//! Boxes: a length, four letters, and content that may again be boxes. All numbers are big-endian.

/// The letters of a box.
pub(super) type Kind = [u8; 4];

/// A view of bytes that are read from front to back; `None` at the end.
#[derive(Clone, Copy)]
pub(super) struct Bytes<'a>(pub(super) &'a [u8]);

impl<'a> Bytes<'a> {
    pub(super) fn take(&mut self, len: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(len)?;
        self.0 = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*taken)
    }

    pub(super) fn u8(&mut self) -> Option<u8> {
        self.array().map(u8::from_be_bytes)
    }

    pub(super) fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_be_bytes)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_be_bytes)
    }

    pub(super) fn i32(&mut self) -> Option<i32> {
        self.array().map(i32::from_be_bytes)
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_be_bytes)
    }

    pub(super) fn kind(&mut self) -> Option<Kind> {
        self.array()
    }

    /// A number of 32 bits, or of 64 in version 1 of a box.
    pub(super) fn u32_or_u64(&mut self, version: u8) -> Option<u64> {
        if version == 1 { self.u64() } else { self.u32().map(u64::from) }
    }

    /// The version and the flags at the start of many boxes.
    pub(super) fn version_and_flags(&mut self) -> Option<(u8, u32)> {
        let word = self.u32()?;
        Some(((word >> 24) as u8, word & 0xff_ffff))
    }

    /// The count in front of a table, if the table has that many entries of `entry_len` bytes.
    pub(super) fn table_len(&mut self, entry_len: usize) -> Option<usize> {
        let count = self.u32()? as usize;
        (count.checked_mul(entry_len)? <= self.0.len()).then_some(count)
    }
}

/// The boxes within `content`, up to the first that does not fit.
pub(super) fn boxes(content: &[u8]) -> impl Iterator<Item = (Kind, &[u8])> {
    let mut rest = Bytes(content);
    std::iter::from_fn(move || {
        let len = rest.u32()?;
        let kind = rest.kind()?;
        let len = match len {
            0 => rest.0.len(),
            1 => usize::try_from(rest.u64()?).ok()?.checked_sub(16)?,
            len => (len as usize).checked_sub(8)?,
        };
        Some((kind, rest.take(len)?))
    })
}

/// The content of the first box of a kind.
pub(super) fn find(content: &[u8], kind: Kind) -> Option<&[u8]> {
    boxes(content).find(|(found, _)| *found == kind).map(|(_, content)| content)
}

/// The content of a box within boxes.
pub(super) fn find_path<'a>(content: &'a [u8], path: &[Kind]) -> Option<&'a [u8]> {
    path.iter().try_fold(content, |content, kind| find(content, *kind))
}
