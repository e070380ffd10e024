//! The name that was probably meant.

/// Names this alike, by [`strsim::jaro_winkler`], are worth suggesting, dimensionless.
const ALIKE: f64 = 0.8;

/// The one of the known names that is most like `name`, if any is like it.
pub fn nearest<'a, S: AsRef<str>>(name: &str, known: &'a [S]) -> Option<&'a str> {
    let likeness = |known: &&str| strsim::jaro_winkler(name, known);
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
        assert_eq!(nearest("zzz", &known), None);
        assert_eq!(nearest::<&str>("circle", &[]), None);
    }
}
