//! Seeded mutation of valid files, for the tests of every parser that reads files from outside.
//!
//! A test hands [`Parser::run`] a few valid files and a closure that parses bytes. The closure runs on mutations of
//! these files: bits flipped, numbers overwritten, pieces removed, inserted, repeated and exchanged between files. An
//! input fails if the closure panics, if it holds more memory than allowed, or if it does not return within a minute.
//! The report of a failure names the parser, the seed and the number of the input.
//!
//! An input depends on the parser's name, the seed and its own number only, so a failure is repeated with
//!
//! ```text
//! FINGERVISION_FUZZ_SEED=1 FINGERVISION_FUZZ_FIRST=4711 FINGERVISION_FUZZ_INPUTS=1 cargo test -p … fuzz
//! ```
//!
//! Without these variables a parser gets the number of inputs that its test states, from number 0 with seed 1. A long
//! run sets `FINGERVISION_FUZZ_INPUTS`, the number of inputs of every parser.

mod form;
mod mutator;
mod parser;
mod random;
mod settings;
mod watchdog;

pub use form::Form;
pub use parser::Parser;
