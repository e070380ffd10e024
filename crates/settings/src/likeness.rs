//! Suggests the name that was probably meant.

/// Similarity from which a name is suggested, by [`strsim::jaro_winkler`], dimensionless.
const ALIKE: f64 = 0.8;

/// The known name that is most similar to `name`, if any is similar enough. One that contains it as a word is preferred.
pub fn nearest<'a, S: AsRef<str>>(name: &str, known: &'a [S]) -> Option<&'a str> {
    let has_word = |known: &str| known.split(['-', '_', '.']).any(|word| word == name);
    let likeness = |known: &&str| strsim::jaro_winkler(name, known) + f64::from(u8::from(has_word(known)));
    let best = known.iter().map(AsRef::as_ref).max_by(|a, b| likeness(a).total_cmp(&likeness(b)))?;
    (likeness(&best) > ALIKE).then_some(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_like_name_is_found_and_an_unlike_one_is_not() {
        let known = ["circle", "crossing", "sphere"];
        assert_eq!(nearest("spher", &known), Some("sphere"));
        assert_eq!(nearest("crosing", &known), Some("crossing"));
        let scenes = ["sphere", "press-then-shear", "press-then-twist"];
        assert_eq!(nearest("shear", &scenes), Some("press-then-shear"), "more than sphere");
        assert_eq!(nearest("zzz", &known), None);
        assert_eq!(nearest::<&str>("circle", &[]), None);
    }
}
