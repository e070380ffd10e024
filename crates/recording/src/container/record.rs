//! Records: their kinds, and how their fields are written and read. All numbers are little-endian.

/// The first and the last bytes of a file.
pub(crate) const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// Bytes before a record's content: its kind and its length.
pub(crate) const PREFIX_LEN: u64 = 9;

/// The kinds of records.
pub(crate) mod kind {
    pub(crate) const HEADER: u8 = 0x01;
    pub(crate) const FOOTER: u8 = 0x02;
    pub(crate) const SCHEMA: u8 = 0x03;
    pub(crate) const CHANNEL: u8 = 0x04;
    pub(crate) const MESSAGE: u8 = 0x05;
    pub(crate) const CHUNK: u8 = 0x06;
    pub(crate) const MESSAGE_INDEX: u8 = 0x07;
    pub(crate) const CHUNK_INDEX: u8 = 0x08;
    pub(crate) const ATTACHMENT: u8 = 0x09;
    pub(crate) const ATTACHMENT_INDEX: u8 = 0x0a;
    pub(crate) const STATISTICS: u8 = 0x0b;
    pub(crate) const METADATA: u8 = 0x0c;
    pub(crate) const METADATA_INDEX: u8 = 0x0d;
    pub(crate) const SUMMARY_OFFSET: u8 = 0x0e;
    pub(crate) const DATA_END: u8 = 0x0f;
}

/// Appends fields to a record's content.
pub(crate) trait Put {
    fn put_u16(&mut self, value: u16);
    fn put_u32(&mut self, value: u32);
    fn put_u64(&mut self, value: u64);
    /// A text, preceded by its length.
    fn put_text(&mut self, text: &str);
    /// Pairs of texts, preceded by their length in bytes.
    fn put_map(&mut self, pairs: &[(&str, &str)]);
    /// A record of this kind, whose content `fill` appends.
    fn put_record(&mut self, kind: u8, fill: impl FnOnce(&mut Self));
}

impl Put for Vec<u8> {
    fn put_u16(&mut self, value: u16) {
        self.extend_from_slice(&value.to_le_bytes());
    }

    fn put_u32(&mut self, value: u32) {
        self.extend_from_slice(&value.to_le_bytes());
    }

    fn put_u64(&mut self, value: u64) {
        self.extend_from_slice(&value.to_le_bytes());
    }

    fn put_text(&mut self, text: &str) {
        self.put_u32(text.len() as u32);
        self.extend_from_slice(text.as_bytes());
    }

    fn put_map(&mut self, pairs: &[(&str, &str)]) {
        let len: usize = pairs.iter().map(|(key, value)| 8 + key.len() + value.len()).sum();
        self.put_u32(len as u32);
        for (key, value) in pairs {
            self.put_text(key);
            self.put_text(value);
        }
    }

    fn put_record(&mut self, kind: u8, fill: impl FnOnce(&mut Self)) {
        self.push(kind);
        let at = self.len();
        self.put_u64(0);
        fill(self);
        let len = (self.len() - at - 8) as u64;
        self[at..at + 8].copy_from_slice(&len.to_le_bytes());
    }
}

/// Takes fields from a record's content. Every length is compared with the remaining bytes before memory is allocated.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Get<'a>(pub(crate) &'a [u8]);

impl<'a> Get<'a> {
    pub(crate) fn bytes(&mut self, len: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(len)?;
        self.0 = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.bytes(N)?.try_into().ok()
    }

    pub(crate) fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    pub(crate) fn text(&mut self) -> Option<&'a str> {
        let len = self.u32()? as usize;
        std::str::from_utf8(self.bytes(len)?).ok()
    }

    pub(crate) fn map(&mut self) -> Option<Vec<(&'a str, &'a str)>> {
        let len = self.u32()? as usize;
        let mut pairs = Get(self.bytes(len)?);
        let mut found = Vec::new();
        while !pairs.0.is_empty() {
            found.push((pairs.text()?, pairs.text()?));
        }
        Some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_come_back_as_they_were_written() {
        let mut bytes = Vec::new();
        bytes.put_record(kind::METADATA, |content| {
            content.put_u16(7);
            content.put_text("zwölf");
            content.put_map(&[("a", "1"), ("b", "")]);
            content.put_u64(1 << 40);
        });
        let mut prefix = Get(&bytes);
        assert_eq!((prefix.bytes(1), prefix.u64()), (Some([kind::METADATA].as_slice()), Some(bytes.len() as u64 - 9)));
        let mut content = prefix;
        assert_eq!((content.u16(), content.text()), (Some(7), Some("zwölf")));
        assert_eq!(content.map(), Some(vec![("a", "1"), ("b", "")]));
        assert_eq!((content.u64(), content.u16()), (Some(1 << 40), None));
    }

    #[test]
    fn a_length_beyond_the_end_takes_nothing() {
        let mut bytes = Vec::new();
        bytes.put_u32(u32::MAX);
        bytes.extend_from_slice(b"short");
        assert_eq!((Get(&bytes).text(), Get(&bytes).map()), (None, None));
    }
}
