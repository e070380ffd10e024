//! The header of a `.npy` file: type, order and shape of its values.
//!
//! After 6 magic bytes and the version, the header's length and a Python dictionary follow, such as
//! `{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), }` (`NumPy`, `numpy.lib.format`). It is parsed here,
//! because the existing library contains a parser generator, which takes a twentieth of the build time of the whole
//! program.

use std::fmt;
use std::io::{self, Read};

/// The first bytes of every `.npy` file.
const MAGIC: &[u8; 6] = b"\x93NUMPY";

/// The longest header that is read, bytes. The header of an array of numbers has about 100.
const MOST_BYTES: u64 = 1 << 16;

/// A header.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct NpyHeader {
    /// The type code of the values, as in `<f4`; of a compound type, its description.
    pub(crate) code: String,
    /// Whether the first index varies fastest.
    pub(crate) is_fortran: bool,
    pub(super) shape: Vec<u64>,
    /// Bytes before the first value.
    pub(super) len: u64,
}

/// Why a file has no header.
#[derive(Debug)]
pub(crate) enum HeaderError {
    Read(io::Error),
    /// The file ends within its header.
    CutOff,
    /// A sentence.
    NotOne(String),
}

impl fmt::Display for HeaderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read(error) => error.fmt(f),
            Self::CutOff => f.write_str("its header is longer than the file"),
            Self::NotOne(reason) => f.write_str(reason),
        }
    }
}

impl From<io::Error> for HeaderError {
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::UnexpectedEof { Self::CutOff } else { Self::Read(error) }
    }
}

impl NpyHeader {
    /// Reads the header at the beginning of a file.
    pub(crate) fn read(file: &mut impl Read) -> Result<Self, HeaderError> {
        let not_one = |reason: &str| HeaderError::NotOne(reason.into());
        let mut start = [0; 8];
        let is_short = match file.read_exact(&mut start) {
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => true,
            read => read.map(|()| false)?,
        };
        if is_short || !start.starts_with(MAGIC) {
            return Err(not_one("it does not begin as a .npy file does"));
        }
        let (prefix, len) = if start[6] == 1 {
            let mut len = [0; 2];
            file.read_exact(&mut len)?;
            (10, u64::from(u16::from_le_bytes(len)))
        } else {
            let mut len = [0; 4];
            file.read_exact(&mut len)?;
            (12, u64::from(u32::from_le_bytes(len)))
        };
        let mut text = Vec::new();
        file.take(len.min(MOST_BYTES)).read_to_end(&mut text)?;
        match text.len() as u64 {
            MOST_BYTES if len > MOST_BYTES => return Err(not_one("its header is too long")),
            there if there < len => return Err(HeaderError::CutOff),
            _ => {}
        }
        let text = String::from_utf8(text).map_err(|_| not_one("its header is not text"))?;
        let header = Dictionary { rest: &text }.header();
        header.map(|header| Self { len: prefix + len, ..header }).map_err(HeaderError::NotOne)
    }
}

/// The rest of a dictionary's text.
struct Dictionary<'a> {
    rest: &'a str,
}

impl<'a> Dictionary<'a> {
    fn header(mut self) -> Result<NpyHeader, String> {
        let (mut code, mut order, mut shape) = (None, None, None);
        self.expect('{')?;
        while !self.takes('}') {
            let key = self.string()?;
            self.expect(':')?;
            match key {
                "descr" => code = Some(self.description()?),
                "fortran_order" => order = Some(self.truth()?),
                "shape" => shape = Some(self.numbers()?),
                other => return Err(format!("its header has an unknown key {other:?}")),
            }
            if !self.takes(',') {
                self.expect('}')?;
                break;
            }
        }
        let missing = |key: &str| format!("its header has no {key}");
        Ok(NpyHeader {
            code: code.ok_or_else(|| missing("descr"))?,
            is_fortran: order.ok_or_else(|| missing("fortran_order"))?,
            shape: shape.ok_or_else(|| missing("shape"))?,
            len: 0,
        })
    }

    /// Takes a character if it comes next, after spaces.
    fn takes(&mut self, character: char) -> bool {
        self.rest = self.rest.trim_start();
        let rest = self.rest.strip_prefix(character);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    fn expect(&mut self, character: char) -> Result<(), String> {
        if self.takes(character) { Ok(()) } else { Err(self.unexpected(&format!("{character:?}"))) }
    }

    fn unexpected(&self, expected: &str) -> String {
        let found: String = self.rest.chars().take(12).collect();
        format!("its header has {found:?} where {expected} is expected")
    }

    /// A text in either kind of quotes, without escapes.
    fn string(&mut self) -> Result<&'a str, String> {
        let quote = if self.takes('\'') { '\'' } else { '"' };
        if quote == '"' {
            self.expect('"')?;
        }
        let (text, rest) = self.rest.split_once(quote).ok_or_else(|| self.unexpected("a closing quote"))?;
        self.rest = rest;
        Ok(text)
    }

    /// A type code, or the description of a compound type up to its closing bracket.
    fn description(&mut self) -> Result<String, String> {
        if !self.takes('[') {
            return self.string().map(Into::into);
        }
        let (inner, rest) = self.rest.split_once(']').ok_or_else(|| self.unexpected("a closing bracket"))?;
        self.rest = rest;
        Ok(format!("[{inner}]"))
    }

    fn truth(&mut self) -> Result<bool, String> {
        self.rest = self.rest.trim_start();
        for (name, value) in [("True", true), ("False", false)] {
            if let Some(rest) = self.rest.strip_prefix(name) {
                self.rest = rest;
                return Ok(value);
            }
        }
        Err(self.unexpected("True or False"))
    }

    /// Numbers in parentheses; a comma may follow the last one.
    fn numbers(&mut self) -> Result<Vec<u64>, String> {
        let mut numbers = Vec::new();
        self.expect('(')?;
        while !self.takes(')') {
            let digits = self.rest.find(|character: char| !character.is_ascii_digit()).unwrap_or(self.rest.len());
            let number = self.rest[..digits].parse().map_err(|_| self.unexpected("a length"))?;
            // Python 2 wrote long numbers with an L.
            self.rest = self.rest[digits..].trim_start_matches('L');
            numbers.push(number);
            if !self.takes(',') {
                self.expect(')')?;
                break;
            }
        }
        Ok(numbers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(version: u8, dictionary: &str) -> Vec<u8> {
        let mut bytes = [&MAGIC[..], &[version, 0]].concat();
        match version {
            1 => bytes.extend((dictionary.len() as u16).to_le_bytes()),
            _ => bytes.extend((dictionary.len() as u32).to_le_bytes()),
        }
        bytes.extend(dictionary.bytes());
        bytes
    }

    fn read(dictionary: &str) -> Result<NpyHeader, String> {
        NpyHeader::read(&mut &file(1, dictionary)[..]).map_err(|error| format!("{error:?}"))
    }

    #[test]
    fn headers_of_all_versions_are_read() {
        let dictionary = "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 480, 2), }   \n";
        for (version, prefix) in [(1, 10), (2, 12), (3, 12)] {
            let header = NpyHeader::read(&mut &file(version, dictionary)[..]).unwrap();
            let len = prefix + dictionary.len() as u64;
            assert_eq!(header, NpyHeader { code: "<f4".into(), is_fortran: false, shape: vec![3, 480, 2], len });
        }
    }

    #[test]
    fn other_orders_and_spellings_are_read() {
        let header = read(r#"{"shape":(7L,),"fortran_order":True,"descr":[('x', '<f4'), ('y', '<f4')]}"#).unwrap();
        assert_eq!((header.shape, header.is_fortran), (vec![7], true));
        assert_eq!(header.code, "[('x', '<f4'), ('y', '<f4')]");
        assert_eq!(read("{'descr': '|u1', 'fortran_order': False, 'shape': ()}").unwrap().shape, []);
    }

    #[test]
    fn what_is_not_a_header_is_refused_with_a_reason() {
        for (dictionary, reason) in [
            ("", "'{' is expected"),
            ("{}", "no descr"),
            ("{'descr': '<f4'}", "no fortran_order"),
            ("{'descr: 1}", "quote"),
            ("{'colour': 1}", "unknown key \\\"colour\\\""),
            ("{'shape': (3, -4)}", "a length"),
            ("{'shape': (99999999999999999999,)}", "a length"),
            ("{'fortran_order': 0}", "True or False"),
        ] {
            let error = read(dictionary).unwrap_err();
            assert!(error.contains(reason), "{dictionary}: {error}");
        }
        assert!(matches!(NpyHeader::read(&mut &b"\x93NUMPX\x01\0"[..]), Err(HeaderError::NotOne(_))));
        assert!(matches!(NpyHeader::read(&mut &b""[..]), Err(HeaderError::NotOne(_))));
        let whole = file(2, "{'descr': '<f4', 'fortran_order': False, 'shape': (1,)}");
        for len in 8..whole.len() {
            assert!(matches!(NpyHeader::read(&mut &whole[..len]), Err(HeaderError::CutOff)), "{len} bytes");
        }
        let huge = [&MAGIC[..], &[2, 0], &u32::MAX.to_le_bytes(), b"{"].concat();
        assert!(matches!(NpyHeader::read(&mut &huge[..]), Err(HeaderError::CutOff)));
    }
}
