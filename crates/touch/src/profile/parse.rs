//! From text to profile and back.

use serde::Deserialize;
use toml::{Table, Value};

use super::{Place, Profile, ProfileError};

pub(super) fn from_text(text: &str) -> Result<Profile, ProfileError> {
    let line_at = |offset: usize| 1 + text.bytes().take(offset).filter(|&byte| byte == b'\n').count();
    let line_of = |error: &toml::de::Error| error.span().map(|span| line_at(span.start));
    let syntax = |error: toml::de::Error| {
        let place = Place { file: None, line: line_of(&error) };
        ProfileError::Syntax { place, message: one_line(error.message()) }
    };
    let deserializer = toml::Deserializer::parse(text).map_err(syntax)?;
    serde_path_to_error::deserialize(deserializer).map_err(|error| {
        let key = error.path().to_string();
        let line = line_of(error.inner());
        refused(Place { file: None, line }, key, error.inner())
    })
}

pub(super) fn to_text(profile: &Profile) -> String {
    toml::to_string(profile).expect("every value of a profile has a form in TOML")
}

/// The profile with some values replaced, not yet validated.
pub(super) fn with_assignments<'a>(
    profile: &Profile,
    assignments: impl IntoIterator<Item = (&'a str, &'a str)>,
) -> Result<Profile, ProfileError> {
    let mut table = Table::try_from(profile).map_err(|error| beyond_a_table(&error))?;
    for (path, text) in assignments {
        assign(&mut table, path, value_of(text))?;
    }
    serde_path_to_error::deserialize(table).map_err(|error: serde_path_to_error::Error<toml::de::Error>| {
        refused(Place::default(), error.path().to_string(), error.inner())
    })
}

/// The TOML value that a text stands for; the text itself if it stands for none.
fn value_of(text: &str) -> Value {
    let value = toml::de::ValueDeserializer::parse(text.trim()).and_then(Value::deserialize);
    value.unwrap_or_else(|_| Value::String(text.into()))
}

fn assign(table: &mut Table, path: &str, value: Value) -> Result<(), ProfileError> {
    let (tables, name) = path.rsplit_once('.').map_or((None, path), |(tables, name)| (Some(tables), name));
    let mut inner = table;
    for part in tables.iter().flat_map(|tables| tables.split('.')) {
        let entry = inner.entry(part).or_insert_with(|| Value::Table(Table::new()));
        let Value::Table(next) = entry else {
            let message = format!("{part} is a value, not a table");
            return Err(ProfileError::WrongType { place: Place::default(), key: path.into(), message });
        };
        inner = next;
    }
    inner.insert(name.into(), value);
    Ok(())
}

/// An integer of the profile that a table cannot hold: one above `i64::MAX`.
fn beyond_a_table(error: &toml::ser::Error) -> ProfileError {
    let (key, message) = ("profile".into(), one_line(&error.to_string()));
    ProfileError::WrongType { place: Place::default(), key, message }
}

/// What a refusal of the deserialiser means.
///
/// Serde names an unknown key and the known ones only in its message: ``unknown field `a`, expected `b` or `c` ``.
fn refused(place: Place, key: String, error: &toml::de::Error) -> ProfileError {
    let message = error.message();
    if !message.starts_with("unknown field") {
        return ProfileError::WrongType { place, key, message: one_line(message) };
    }
    let mut names = message.split('`').skip(1).step_by(2);
    let name = names.next().unwrap_or_default();
    let known = names.map(Into::into).collect();
    let key = if key.ends_with(name) { key } else { format!("{key}.{name}") };
    ProfileError::UnknownKey { place, key, known }
}

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}
