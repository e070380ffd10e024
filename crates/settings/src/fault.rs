//! What is wrong with a value, and where it is.

use std::fmt::{self, Display, Write};

/// The error of a value while a document is read.
#[derive(Debug)]
pub(crate) struct Fault(Box<Content>);

#[derive(Debug)]
struct Content {
    message: String,
    /// From the value to the document.
    steps: Vec<Step>,
    /// Where the value or the key begins in the text, in bytes.
    offset: Option<usize>,
}

/// From a table or a list to what is in it.
#[derive(Debug)]
pub(crate) enum Step {
    Key(String),
    Index(usize),
}

impl Step {
    pub(crate) fn key(key: &str) -> Self {
        Self::Key(key.into())
    }
}

impl Fault {
    pub(crate) fn message(&self) -> &str {
        &self.0.message
    }

    pub(crate) fn offset(&self) -> Option<usize> {
        self.0.offset
    }

    /// The path of the value or table, as in `motion.keyframes[2].depth_mm`; empty for the document itself.
    pub(crate) fn path(&self) -> String {
        let mut path = String::new();
        for step in self.0.steps.iter().rev() {
            let written = match step {
                Step::Key(key) if path.is_empty() => write!(path, "{key}"),
                Step::Key(key) => write!(path, ".{key}"),
                Step::Index(index) => write!(path, "[{index}]"),
            };
            written.expect("a text can be written to");
        }
        path
    }

    /// The fault with its place, unless a value within this one has it already.
    pub(crate) fn at(mut self, offset: usize) -> Self {
        self.0.offset.get_or_insert(offset);
        self
    }

    pub(crate) fn within(mut self, step: Step) -> Self {
        self.0.steps.push(step);
        self
    }
}

impl Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.message)
    }
}

impl std::error::Error for Fault {}

impl serde::de::Error for Fault {
    fn custom<T: Display>(message: T) -> Self {
        Self(Box::new(Content { message: message.to_string(), steps: Vec::new(), offset: None }))
    }
}
