//! Properties of all settings, tested on random ones.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

use fingervision_settings::{Document, SettingsError};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;
use serde::{Deserialize, Serialize};

const DOCUMENT: Document = Document::new("document");

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Settings {
    name: String,
    count: i64,
    is_on: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    ratio: Option<f64>,
    inner: Inner,
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Inner {
    lengths_mm: Vec<f64>,
    words: Vec<String>,
}

fn number() -> impl Strategy<Value = f64> {
    any::<f64>().prop_filter("equal to itself", |value| !value.is_nan())
}

fn settings() -> impl Strategy<Value = Settings> {
    let inner = (vec(number(), 0..5), vec(any::<String>(), 0..3));
    let inner = inner.prop_map(|(lengths_mm, words)| Inner { lengths_mm, words });
    let all = (any::<String>(), any::<i64>(), any::<bool>(), option::of(number()), inner);
    all.prop_map(|(name, count, is_on, ratio, inner)| Settings { name, count, is_on, ratio, inner })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(512) })]

    #[test]
    fn what_is_written_is_read_again(settings in settings()) {
        let text = DOCUMENT.to_text(&settings);
        prop_assert_eq!(DOCUMENT.parse::<Settings>(&text).unwrap(), settings, "\n{}", text);
    }

    #[test]
    fn a_value_that_is_set_is_the_only_one_that_changes(settings in settings(), lengths_mm in vec(number(), 0..5)) {
        let text = format!("{lengths_mm:?}");
        let changed = DOCUMENT.with_assignments(&settings, &[("inner.lengths_mm", text.as_str())]).unwrap();
        let mut expected = settings;
        expected.inner.lengths_mm = lengths_mm;
        prop_assert_eq!(changed, expected);
    }

    #[test]
    fn any_text_is_read_or_refused(text in any::<String>()) {
        let _ = DOCUMENT.parse::<Settings>(&text);
        let _ = DOCUMENT.with_assignments(&Settings::default(), &[("name", text.as_str())]);
        let _ = DOCUMENT.with_assignments(&Settings::default(), &[(text.as_str(), "1")]);
    }

    #[test]
    fn a_key_that_is_not_there_is_named(key in "[a-z]{8}") {
        let error = DOCUMENT.parse::<Settings>(&format!("[inner]\n{key} = 1\n")).unwrap_err();
        let SettingsError::UnknownKey { place, key: found, .. } = error else { panic!("{error}") };
        prop_assert_eq!((place.line, found), (Some(2), format!("inner.{key}")));
    }
}
