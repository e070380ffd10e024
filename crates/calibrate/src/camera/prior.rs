//! Prior knowledge of a camera, before it is fitted.

use serde::Serialize;

use super::unknowns::{UNKNOWNS, Unknown, Unknowns};

/// Prior knowledge of one number: a value and a standard deviation, in its unit. Infinite: no prior.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Prior {
    /// The most likely value.
    pub value: f64,
    /// Its standard deviation.
    pub deviation: f64,
}

/// Prior knowledge of every unknown.
///
/// A slide does not determine all of a camera, so priors are needed. Defaults are weak:
///
/// | unknown | value | standard deviation |
/// | --- | --- | --- |
/// | tilt about x and y | 0 | 0.2 rad |
/// | twist about z | 0 | 0.5 rad |
/// | origin along x and y | 0 | 5 mm; it is set to the middle of the picture afterwards |
/// | distance | 50 mm, the start of the published fit | 25 mm |
/// | k1, k2 | 0 | 0.5 |
/// | p1, p2 | 0 | 0.01 |
/// | focal length | – | – |
/// | principal point | middle of the camera image | 3 % of the picture's width |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Priors {
    values: Unknowns,
    deviations: Unknowns,
    given: [bool; UNKNOWNS],
}

/// Distance at the start of the published fit, mm; its focal length in px is the same number.
pub(super) const PUBLISHED_START: f64 = 50.0;

impl Priors {
    /// Weak priors for a picture of this many columns, with the middle of the camera image at `middle_px`.
    #[must_use]
    pub fn weak(columns: usize, middle_px: [f64; 2]) -> Self {
        let [x, y] = middle_px;
        let aside = 0.03 * columns as f64;
        let start = PUBLISHED_START;
        Self {
            values: Unknowns::from([[0.0, 0.0, 0.0, 0.0, 0.0, start, 0.0, 0.0, 0.0, 0.0, start, x, y]]),
            deviations: Unknowns::from([[
                0.2,
                0.2,
                0.5,
                5.0,
                5.0,
                0.5 * start,
                0.5,
                0.5,
                0.01,
                0.01,
                f64::INFINITY,
                aside,
                aside,
            ]]),
            given: [false; UNKNOWNS],
        }
    }

    /// Sets the prior of one unknown.
    pub fn give(&mut self, unknown: Unknown, prior: Prior) {
        let index = unknown.index();
        self.values[index] = prior.value;
        self.deviations[index] = prior.deviation;
        self.given[index] = true;
    }

    /// The prior of one unknown.
    #[must_use]
    pub fn of(&self, unknown: Unknown) -> Prior {
        let index = unknown.index();
        Prior { value: self.values[index], deviation: self.deviations[index] }
    }

    /// Whether the user gave a prior.
    #[must_use]
    pub fn is_given(&self, unknown: Unknown) -> bool {
        self.given[unknown.index()]
    }

    pub(super) fn values(&self) -> &Unknowns {
        &self.values
    }

    /// One over the standard deviations; zero without a prior.
    pub(super) fn weights(&self) -> Unknowns {
        self.deviations.map(f64::recip)
    }
}

impl Prior {
    /// Reads `NAME=VALUE±DEVIATION`, as in `distance_mm=25±0.5`; `+-` can be written for `±`.
    ///
    /// # Errors
    ///
    /// The expected form, in words.
    pub fn parse(text: &str) -> Result<(Unknown, Self), String> {
        let form = || "expected NAME=VALUE±DEVIATION, as in distance_mm=25±0.5 (+- can be written for ±)".to_string();
        let (name, number) = text.split_once('=').ok_or_else(form)?;
        let names = || Unknown::ALL.map(Unknown::name).join(", ");
        let unknown = Unknown::ALL.into_iter().find(|unknown| unknown.name() == name.trim());
        let unknown = unknown.ok_or_else(|| format!("no parameter is named {}; known are {}", name.trim(), names()))?;
        let number = number.replace("+-", "±");
        let (value, deviation) = number.split_once('±').ok_or_else(form)?;
        let parse = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(form);
        let prior = Self { value: parse(value)?, deviation: parse(deviation)? };
        let is_length = matches!(unknown, Unknown::Distance | Unknown::FocalLength);
        if prior.deviation <= 0.0 || is_length && prior.value <= 0.0 {
            return Err("a deviation, a distance and a focal length are above 0".into());
        }
        Ok((unknown, prior))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_prior_is_read_as_it_is_written() {
        let expected = (Unknown::Distance, Prior { value: 25.0, deviation: 0.5 });
        assert_eq!(Prior::parse("distance_mm=25±0.5"), Ok(expected));
        assert_eq!(Prior::parse(" distance_mm = 25 +- 0.5 "), Ok(expected));
    }

    #[test]
    fn an_invalid_prior_is_explained() {
        for text in ["distance_mm", "distance_mm=25", "distance_mm=25±x", "k1=1±inf"] {
            assert!(Prior::parse(text).unwrap_err().starts_with("expected NAME=VALUE"), "{text}");
        }
        assert!(Prior::parse("distance=25±1").unwrap_err().contains("known are rotation_x_rad"));
        assert!(Prior::parse("distance_mm=-25±1").unwrap_err().contains("above 0"));
        assert!(Prior::parse("k1=0±0").unwrap_err().contains("above 0"));
    }
}
