//! A solved press as bytes: little endian, with a checksum, so that damage is noticed.
//!
//! Magic, SHA-256 of the rest, then the number of frames and for each frame the grid lines, the displacement of every
//! node, the values of the nodes in contact, and the totals. Every number keeps all its bits.

use fingervision_elastic::SurfaceState;
use sha2::{Digest, Sha256};

/// Names the format; its last byte is the version.
const MAGIC: &[u8; 8] = b"FVPRESS\x03";
const CHECKSUM_LEN: usize = 32;

/// The bytes of an entry.
pub(super) fn to_bytes(states: &[SurfaceState]) -> Vec<u8> {
    let mut writer = Writer::default();
    writer.count(states.len());
    for state in states {
        writer.state(state);
    }
    let mut bytes = MAGIC.to_vec();
    bytes.extend(Sha256::digest(&writer.bytes));
    bytes.extend(writer.bytes);
    bytes
}

/// The content of an entry; absent if it is damaged or of another format.
pub(super) fn from_bytes(bytes: &[u8]) -> Option<Vec<SurfaceState>> {
    let (checksum, content) = bytes.strip_prefix(MAGIC)?.split_at_checked(CHECKSUM_LEN)?;
    if Sha256::digest(content).as_slice() != checksum {
        return None;
    }
    let mut reader = Reader { rest: content };
    let count = reader.count()?;
    let states = (0..count).map(|_| reader.state()).collect::<Option<Vec<_>>>()?;
    reader.rest.is_empty().then_some(states)
}

#[derive(Default)]
struct Writer {
    bytes: Vec<u8>,
}

impl Writer {
    fn count(&mut self, count: usize) {
        self.bytes.extend((count as u64).to_le_bytes());
    }

    fn numbers(&mut self, numbers: &[f64]) {
        self.bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    }

    fn lines(&mut self, lines: &[f64]) {
        self.count(lines.len());
        self.numbers(lines);
    }

    fn state(&mut self, state: &SurfaceState) {
        self.lines(&state.x_mm);
        self.lines(&state.y_mm);
        self.numbers(state.displacement_mm.as_flattened());
        let carries = |node: &usize| {
            let load = [state.nodal_force_n[*node], state.traction_mpa[*node]];
            state.in_contact[*node] || load.as_flattened().iter().any(|value| value.to_bits() != 0)
        };
        let carrying: Vec<usize> = (0..state.in_contact.len()).filter(carries).collect();
        self.count(carrying.len());
        for node in carrying {
            self.count(node);
            self.bytes.push(u8::from(state.in_contact[node]));
            self.numbers(&state.nodal_force_n[node]);
            self.numbers(&state.traction_mpa[node]);
        }
        self.numbers(&state.force_n);
        self.numbers(&state.torque_nmm);
    }
}

struct Reader<'a> {
    rest: &'a [u8],
}

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.rest.split_first_chunk::<N>()?;
        self.rest = rest;
        Some(*taken)
    }

    fn count(&mut self) -> Option<usize> {
        usize::try_from(u64::from_le_bytes(self.take()?)).ok()
    }

    fn vector<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut vector = [0.0; N];
        for value in &mut vector {
            *value = f64::from_le_bytes(self.take()?);
        }
        Some(vector)
    }

    fn lines(&mut self) -> Option<Vec<f64>> {
        let count = self.count()?;
        (0..count).map(|_| self.vector::<1>().map(|[line]| line)).collect()
    }

    fn state(&mut self) -> Option<SurfaceState> {
        let (x_mm, y_mm) = (self.lines()?, self.lines()?);
        let nodes = x_mm.len().checked_mul(y_mm.len())?;
        let displacement_mm = (0..nodes).map(|_| self.vector()).collect::<Option<Vec<_>>>()?;
        let mut state = SurfaceState {
            x_mm,
            y_mm,
            displacement_mm,
            nodal_force_n: vec![[0.0; 3]; nodes],
            traction_mpa: vec![[0.0; 3]; nodes],
            in_contact: vec![false; nodes],
            ..SurfaceState::default()
        };
        for _ in 0..self.count()? {
            let node = self.count()?;
            *state.in_contact.get_mut(node)? = self.take::<1>()? == [1];
            state.nodal_force_n[node] = self.vector()?;
            state.traction_mpa[node] = self.vector()?;
        }
        (state.force_n, state.torque_nmm) = (self.vector()?, self.vector()?);
        Some(state)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::stub::bump;

    #[test]
    fn every_bit_comes_back() {
        let states = [0.0, 0.7, 1.3].map(bump);
        assert_eq!(from_bytes(&to_bytes(&states)).unwrap(), states);
        assert_eq!(from_bytes(&to_bytes(&[])).unwrap(), []);
    }

    #[test]
    fn any_damage_is_noticed() {
        let bytes = to_bytes(&[bump(0.5)]);
        for place in (0..bytes.len()).step_by(97) {
            let mut damaged = bytes.clone();
            damaged[place] ^= 0x10;
            assert_eq!(from_bytes(&damaged), None, "byte {place}");
            assert_eq!(from_bytes(&bytes[..place]), None, "cut at {place}");
        }
    }

    #[test]
    fn a_count_that_cannot_be_takes_no_memory() {
        let mut content = Vec::new();
        content.extend(1_u64.to_le_bytes());
        content.extend(u64::MAX.to_le_bytes());
        let mut bytes = MAGIC.to_vec();
        bytes.extend(Sha256::digest(&content));
        bytes.extend(content);
        assert_eq!(from_bytes(&bytes), None);
    }
}
