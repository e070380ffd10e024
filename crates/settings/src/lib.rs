//! Settings as TOML text: read, written, single values set by path, and every error named by path and line.
//!
//! A [`Document`] is a kind of file, such as a sensor's profile or a simulated scene. It converts text to the type that
//! describes the file, and back. An error is a [`SettingsError`]: it contains the [`Place`], the key's path and value,
//! and what the user can do about it.
//!
//! ```
//! use fingervision_settings::{Document, SettingsError};
//!
//! #[derive(Debug, Default, serde::Serialize, serde::Deserialize)]
//! #[serde(default, deny_unknown_fields)]
//! struct Lamp {
//!     power_w: f64,
//! }
//!
//! let document = Document::new("lamp");
//! let error = document.parse::<Lamp>("\npower = 5.0").unwrap_err();
//! assert_eq!(error.to_string(), "line 2: unknown key power");
//! assert_eq!(error.hint().as_deref(), Some("did you mean power_w?"));
//! let lamp: Lamp = document.with_assignments(&Lamp::default(), &[("power_w", "5")])?;
//! assert_eq!(document.to_text(&lamp), "power_w = 5.0\n");
//! # Ok::<(), SettingsError>(())
//! ```

mod document;
mod error;
mod fault;
mod likeness;
mod line;
mod place;
mod value_reader;
mod whole_file;

pub use document::Document;
pub use error::SettingsError;
pub use likeness::nearest;
pub use place::Place;
pub use whole_file::write_file;
