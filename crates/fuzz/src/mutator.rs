//! One input: a valid file after a few random changes.

use crate::form::Form;
use crate::random::Random;
use std::ops::Range;

/// Most changes of one input.
const MOST_CHANGES: usize = 4;
/// Most bytes that one change inserts, removes or fills.
const MOST_BYTES: usize = 64;
/// Numbers at which arithmetic of 8, 16, 32 and 64 bits overflows or counts are too large.
const EDGES: [u64; 14] = [
    0,
    1,
    2,
    0x7f,
    0x80,
    0xff,
    0x7fff,
    0xffff,
    0x00ff_ffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x7fff_ffff_ffff_ffff,
    0xffff_ffff_ffff_ffff,
];
/// The words that replace a number or another word of a text.
const WORDS: [&str; 20] = [
    "0",
    "-0",
    "1",
    "-1",
    "nan",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1e-308",
    "0.5",
    "4294967296",
    "18446744073709551616",
    "-9223372036854775808",
    "true",
    "\"\"",
    "[]",
    "{}",
    "",
    "é",
];

/// The changed file that a stream of random numbers leads to.
pub(crate) fn mutation(random: &mut Random, form: Form, files: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = files[random.below(files.len())].clone();
    for _ in 0..=random.below(MOST_CHANGES) {
        match form {
            Form::Text if random.below(4) > 0 => change_text(random, &mut bytes, files),
            _ => change_bytes(random, &mut bytes, files),
        }
    }
    bytes
}

fn change_bytes(random: &mut Random, bytes: &mut Vec<u8>, files: &[Vec<u8>]) {
    let at = place(random, bytes.len());
    match random.below(12) {
        0..=2 => {
            if let Some(byte) = bytes.get_mut(at) {
                *byte ^= 1 << random.below(8);
            }
        }
        3..=5 => overwrite(random, bytes, at),
        6 => bytes.truncate(at),
        7 => drop(bytes.drain(piece(random, bytes.len()))),
        8 => {
            let inserted: Vec<u8> = (0..=random.below(MOST_BYTES)).map(|_| random.next() as u8).collect();
            bytes.splice(at..at, inserted);
        }
        9 => {
            let repeated = bytes[piece(random, bytes.len())].to_vec();
            bytes.splice(at..at, repeated);
        }
        10 => {
            let range = piece(random, bytes.len());
            bytes[range].fill([0x00, 0xff][random.below(2)]);
        }
        _ => exchange(random, bytes, files),
    }
}

/// Puts a number of 1, 2, 4 or 8 bytes in either order of bytes, as counts and lengths are written.
fn overwrite(random: &mut Random, bytes: &mut [u8], at: usize) {
    let value = match random.below(3) {
        0 => (bytes.len() as u64 + random.next() % 3).saturating_sub(1),
        _ => EDGES[random.below(EDGES.len())],
    };
    let len = 1 << random.below(4);
    let number = if random.below(2) == 0 {
        value.to_le_bytes()[..len].to_vec()
    } else {
        value.to_be_bytes()[8 - len..].to_vec()
    };
    for (byte, new) in bytes.iter_mut().skip(at).zip(number) {
        *byte = new;
    }
}

/// Replaces the rest, or a piece, by one of any of the files.
fn exchange(random: &mut Random, bytes: &mut Vec<u8>, files: &[Vec<u8>]) {
    let other = &files[random.below(files.len())];
    if random.below(2) == 0 {
        bytes.truncate(place(random, bytes.len()));
        bytes.extend_from_slice(&other[place(random, other.len())..]);
    } else {
        let (to, from) = (piece(random, bytes.len()), piece(random, other.len()));
        bytes.splice(to, other[from].iter().copied());
    }
}

fn change_text(random: &mut Random, bytes: &mut Vec<u8>, files: &[Vec<u8>]) {
    let lines: Vec<Range<usize>> = runs(bytes, |byte| byte != b'\n');
    let line = lines.get(random.below(lines.len())).cloned().unwrap_or(0..0);
    match random.below(6) {
        0 => drop(bytes.drain(line)),
        1 => {
            let other = &files[random.below(files.len())];
            let others = runs(other, |byte| byte != b'\n');
            let from = others.get(random.below(others.len())).cloned().unwrap_or(0..0);
            let inserted: Vec<u8> = other[from].iter().copied().chain([b'\n']).collect();
            bytes.splice(line.start..line.start, inserted);
        }
        choice => {
            // Half of the changed words are numbers.
            let is_part = |byte: u8| match choice {
                2 | 3 => byte.is_ascii_digit() || b"+-.eE".contains(&byte),
                _ => byte.is_ascii_alphanumeric() || b"_\"".contains(&byte),
            };
            let words = runs(bytes, is_part);
            if let Some(word) = words.get(random.below(words.len())) {
                bytes.splice(word.clone(), random.choose(&WORDS).bytes());
            }
        }
    }
}

/// The longest pieces whose bytes all pass a test.
fn runs(bytes: &[u8], is_part: impl Fn(u8) -> bool) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for (at, _) in bytes.iter().enumerate().filter(|&(_, &byte)| is_part(byte)) {
        match runs.last_mut().filter(|run| run.end == at) {
            Some(run) => run.end = at + 1,
            None => runs.push(at..at + 1),
        }
    }
    runs
}

/// A place in a file; every second one near its start, where most formats have their header.
fn place(random: &mut Random, len: usize) -> usize {
    let end = if random.below(2) == 0 { len.min(256) } else { len };
    random.below(end)
}

/// A short piece of a file.
fn piece(random: &mut Random, len: usize) -> Range<usize> {
    let start = place(random, len);
    start..len.min(start + 1 + random.below(MOST_BYTES))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn input(number: u64, form: Form) -> Vec<u8> {
        let files = [b"width = 3\nheight = 4\n".to_vec(), b"depth = 0.5\n".to_vec()];
        mutation(&mut Random::new("parser", 1, number), form, &files)
    }

    #[test]
    fn an_input_is_repeated_by_its_number() {
        for number in 0..200 {
            assert_eq!(input(number, Form::Binary), input(number, Form::Binary), "input {number}");
            assert_eq!(input(number, Form::Text), input(number, Form::Text), "input {number}");
        }
    }

    #[test]
    fn inputs_are_of_many_kinds() {
        let inputs: std::collections::HashSet<_> = (0..500).map(|number| input(number, Form::Text)).collect();
        assert!(inputs.len() > 300, "{} different inputs of 500", inputs.len());
        let has = |text: &str| inputs.iter().any(|input| String::from_utf8_lossy(input).contains(text));
        for text in ["= nan", "= []", "depth = 0.5\nwidth", "width = 3\ndepth"] {
            assert!(has(text), "{text}");
        }
    }

    #[test]
    fn empty_files_bear_every_change() {
        for number in 0..500 {
            for form in [Form::Binary, Form::Text] {
                mutation(&mut Random::new("parser", 1, number), form, &[Vec::new()]);
            }
        }
    }
}
