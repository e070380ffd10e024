//! Conversion between text and settings.

use std::fs;
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use toml::de::{DeTable, DeValue};
use toml::{Spanned, Table, Value};

use crate::fault::Fault;
use crate::line::line_at;
use crate::value_reader::ValueReader;
use crate::{Place, SettingsError};

/// A kind of file that contains settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Document {
    noun: &'static str,
}

impl Document {
    /// A kind of file that is called `noun` in messages, as in "profile".
    #[must_use]
    pub const fn new(noun: &'static str) -> Self {
        Self { noun }
    }

    /// The text of a file.
    ///
    /// # Errors
    ///
    /// [`SettingsError::Read`] with the file's name.
    pub fn read(&self, path: &Path) -> Result<String, SettingsError> {
        let noun = self.noun;
        fs::read_to_string(path).map_err(|error| SettingsError::Read {
            noun,
            file: path.to_owned(),
            kind: error.kind(),
        })
    }

    /// The settings in a text.
    ///
    /// # Errors
    ///
    /// [`SettingsError::Syntax`], [`SettingsError::UnknownKey`] or [`SettingsError::WrongType`] with its line.
    pub fn parse<T: DeserializeOwned>(&self, text: &str) -> Result<T, SettingsError> {
        let (root, offset) = self.values(text)?;
        T::deserialize(ValueReader::new(&root)).map_err(|fault| self.refused(text, &fault.at(offset)))
    }

    /// The values in a text, and where they begin.
    fn values<'a>(&self, text: &'a str) -> Result<(DeValue<'a>, usize), SettingsError> {
        let root = DeTable::parse(text).map_err(|error| {
            let line = error.span().map(|span| line_at(text, span.start));
            SettingsError::Syntax {
                noun: self.noun,
                place: Place { file: None, line },
                message: one_line(error.message()),
            }
        })?;
        let offset = Spanned::span(&root).start;
        Ok((DeValue::Table(root.into_inner()), offset))
    }

    /// The settings as text.
    ///
    /// # Panics
    ///
    /// If they contain what TOML cannot represent: a map with keys that are not strings, an integer above `i64::MAX`.
    #[must_use]
    pub fn to_text(&self, settings: &impl Serialize) -> String {
        toml::to_string(settings).expect("every value of the settings has a form in TOML")
    }

    /// The settings with some values replaced, each named by its path, as in `flow.finest_level`, and given as TOML; a
    /// word that is not a TOML value is taken as a string. Missing tables are created.
    ///
    /// # Errors
    ///
    /// [`SettingsError::UnknownKey`] or [`SettingsError::WrongType`] naming the path.
    pub fn with_assignments<T: Serialize + DeserializeOwned>(
        &self,
        settings: &T,
        assignments: &[(&str, &str)],
    ) -> Result<T, SettingsError> {
        // Through text, here and below: writing and reading a table as well would double the code that a type of settings
        // is compiled to.
        let text = toml::to_string(settings).map_err(|error| self.beyond_a_table(&error))?;
        let mut table: Table = self.parse(&text).map_err(SettingsError::without_line)?;
        for (path, text) in assignments {
            assign(&mut table, path, value_of(text))?;
        }
        self.parse(&self.to_text(&table)).map_err(SettingsError::without_line)
    }

    /// An integer that TOML cannot represent: one above `i64::MAX`.
    fn beyond_a_table(&self, error: &toml::ser::Error) -> SettingsError {
        let (key, message) = (self.noun.into(), one_line(&error.to_string()));
        SettingsError::WrongType { place: Place::default(), key, message }
    }

    /// The error for a fault in a value.
    ///
    /// Serde names an unknown key and the known ones only in its message: ``unknown field `a`, expected `b` or `c` ``.
    fn refused(&self, text: &str, fault: &Fault) -> SettingsError {
        let (message, key) = (fault.message(), fault.path());
        let place = Place { file: None, line: fault.offset().map(|offset| line_at(text, offset)) };
        if !message.starts_with("unknown field") {
            return SettingsError::WrongType { place, key, message: without_type_names(&one_line(message)) };
        }
        let mut names = message.split('`').skip(1).step_by(2);
        let name = names.next().unwrap_or_default();
        let known = names.map(Into::into).collect();
        let key = if key.is_empty() { name.into() } else { format!("{key}.{name}") };
        SettingsError::UnknownKey { noun: self.noun, place, key, known }
    }
}

/// The TOML value of a text; the text itself if it is not a TOML value.
fn value_of(text: &str) -> Value {
    let value = toml::de::ValueDeserializer::parse(text.trim()).and_then(Value::deserialize);
    value.unwrap_or_else(|_| Value::String(text.into()))
}

fn assign(table: &mut Table, path: &str, value: Value) -> Result<(), SettingsError> {
    let (tables, name) = path.rsplit_once('.').map_or((None, path), |(tables, name)| (Some(tables), name));
    let mut inner = table;
    for part in tables.iter().flat_map(|tables| tables.split('.')) {
        let entry = inner.entry(part).or_insert_with(|| Value::Table(Table::new()));
        let Value::Table(next) = entry else {
            let message = format!("{part} is a value, not a table");
            return Err(SettingsError::WrongType { place: Place::default(), key: path.into(), message });
        };
        inner = next;
    }
    inner.insert(name.into(), value);
    Ok(())
}

/// Serde's message with the meaning of the type that it ends with, which only programmers know.
fn without_type_names(message: &str) -> String {
    let Some((start, name)) = message.rsplit_once("expected ") else { return message.into() };
    let meaning = match name {
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number, 0 or more",
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number",
        "f32" | "f64" => "a number",
        _ if name == "a map" || name.starts_with("struct ") => "a table",
        _ => return message.into(),
    };
    format!("{start}expected {meaning}")
}

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}
