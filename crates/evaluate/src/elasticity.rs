//! Simulated presses, stuck and sliding, through the whole tracker: errors of depth, contact and force from elasticity.
//!
//! Every ready-made press is solved with two of Poisson's ratios and two contact laws, rendered, tracked image by image,
//! and the last reading is compared with the exact truth. Depth counts at every visible pixel, valid or not.

use crate::benchmark::{Case, cases};
use crate::experiment::{
    ElasticRun, ElasticScore, ExperimentError, Extent, Followed, Following, Recording, follow_last,
};
use crate::{Asked, PressOptions, Table};
use fingervision_gel::PressCache;
use rayon::prelude::*;

/// The variations of the benchmark that are measured, and what the table calls them.
const VARIATIONS: [(&str, &str); 4] = [
    ("nu-0.35", "ν 0.35, stuck"),
    ("default", "ν 0.48, stuck"),
    ("nu-0.35-frictionless", "ν 0.35, sliding"),
    ("frictionless", "ν 0.48, sliding"),
];

/// The quantities of a press, in the order of the columns.
const COLUMNS: [&str; 8] =
    ["depth, mm", "in contact", "at its border", "outside", "contact, IoU", "normal force", "shear force", "torque"];

/// The tables of [`measure`].
#[derive(Debug, Clone)]
pub struct Tables {
    /// The errors of every press. Those of the forces are parts of the true values; positive: too large.
    pub presses: Table,
    /// Their means and largest absolute values, with the required ones.
    pub over_all: Table,
}

/// Measures all presses, several at once. `progress` gets the name of each when it is done, and why a press could not be
/// solved to its end; its row then has no figures.
///
/// # Errors
///
/// [`ExperimentError`] if a scene is not known, or cannot be solved or tracked.
pub fn measure(
    options: &PressOptions,
    cache: &PressCache,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Tables, ExperimentError> {
    options.check()?;
    let all = cases(Extent::Full, options.mesh)?;
    let picked = presses(&all, options);
    let scored = picked.par_iter().map(|(name, case)| {
        let score = match score(case, cache) {
            Err(ExperimentError::EndedEarly { reason, .. }) => {
                progress(&format!("{name}: {reason}"));
                return Ok((name.as_str(), None));
            }
            score => score?,
        };
        progress(name);
        Ok((name.as_str(), Some(score)))
    });
    Ok(tables(&scored.collect::<Result<Vec<_>, ExperimentError>>()?))
}

/// The presses to measure with their names in the table.
fn presses<'a>(all: &'a [Case], options: &PressOptions) -> Vec<(String, &'a Case)> {
    let of_variation = |variation: &str, name: &str| {
        let cases = all.iter().filter(|case| case.variation.name == variation && options.includes(case.base));
        cases.map(|case| (format!("{}, {name}", case.base), case)).collect::<Vec<_>>()
    };
    VARIATIONS.iter().flat_map(|(variation, name)| of_variation(variation, name)).collect()
}

fn score(case: &Case, cache: &PressCache) -> Result<ElasticScore, ExperimentError> {
    let recording = Recording::of(&case.scene, cache)?;
    let mut elastic = ElasticRun::new(&recording)?;
    let take = |found: Followed<'_>| elastic.take(found);
    follow_last(&recording, &recording.profile, Following::Dense, take, |_| ())?;
    Ok(elastic.score(&recording, &recording.scorer()).0)
}

fn tables(scored: &[(&str, Option<ElasticScore>)]) -> Tables {
    let mut presses = Table::new("Depth and force from elasticity: depth, mm, and parts of the true force", &COLUMNS);
    for (name, score) in scored {
        presses.push(*name, None, score.as_ref().map_or_else(|| vec![f64::NAN; COLUMNS.len()], figures));
    }
    let mut over_all = Table::new("Over all presses: absolute errors", &["value"]);
    let mut row = |name: &str, column: usize, mean_asked: Option<f64>, largest_asked: f64| {
        let figures: Vec<f64> =
            presses.rows.iter().map(|row| row.values[column].abs()).filter(|figure| !figure.is_nan()).collect();
        let mean = figures.iter().sum::<f64>() / figures.len() as f64;
        over_all.push(format!("{name}, mean"), mean_asked.map(Asked::AtMost), vec![mean]);
        let largest = figures.iter().copied().fold(f64::NAN, f64::max);
        over_all.push(format!("{name}, largest"), Some(Asked::AtMost(largest_asked)), vec![largest]);
    };
    row("depth, whole image, mm", 0, Some(0.006), 0.012);
    row("normal force", 5, Some(0.02), 0.05);
    row("shear force", 6, None, 0.05);
    row("torque", 7, None, 0.05);
    Tables { presses, over_all }
}

/// The figures of a press; not a number where it has none.
fn figures(score: &ElasticScore) -> Vec<f64> {
    let ElasticScore { depth, contact_overlap, normal_force, shear_force, torque } = *score;
    let depths = [depth.everywhere_mm, depth.inside_mm, depth.border_mm, depth.outside_mm];
    let forces = [normal_force, shear_force, torque].map(|part| part.unwrap_or(f64::NAN));
    depths.into_iter().chain([contact_overlap]).chain(forces).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::DepthScore;
    use fingervision_gel::Resolution;

    fn score(depth_mm: f64, force: f64, torque: Option<f64>) -> ElasticScore {
        let depth = DepthScore {
            everywhere_mm: depth_mm,
            inside_mm: 0.0,
            border_mm: 0.0,
            outside_mm: 0.0,
            trusted_mm: 0.0,
            trusted: 1.0,
            correlation: 1.0,
        };
        ElasticScore { depth, contact_overlap: 1.0, normal_force: Some(force), shear_force: None, torque }
    }

    #[test]
    fn errors_of_either_sign_do_not_cancel_and_missing_ones_do_not_count() {
        let (one, two) = (score(0.004, -0.03, None), score(0.006, 0.01, Some(-0.2)));
        let tables = tables(&[("one", Some(one)), ("unsolved", None), ("two", Some(two))]);
        let value = |name: &str| tables.over_all.rows.iter().find(|row| row.name == name).unwrap().values[0];
        assert!((value("depth, whole image, mm, mean") - 0.005).abs() < 1e-12);
        assert!((value("normal force, mean") - 0.02).abs() < 1e-12);
        assert!((value("normal force, largest") - 0.03).abs() < 1e-12);
        assert!((value("torque, mean") - 0.2).abs() < 1e-12);
        assert!(value("shear force, largest").is_nan());
        let short: Vec<&str> = tables.over_all.short().map(|row| row.name.as_str()).collect();
        // No press has a shear force: a figure that is missing is not met.
        assert_eq!(short, ["shear force, largest", "torque, largest"]);
    }

    #[test]
    fn every_press_is_measured_stuck_and_sliding_at_two_ratios() {
        let all = cases(Extent::Full, Resolution::Draft).unwrap();
        let options = |scenes: Vec<String>| PressOptions { mesh: Resolution::Draft, scenes };
        assert_eq!(presses(&all, &options(vec![])).len(), 13 * 4);
        let letter = presses(&all, &options(vec!["letter".into()]));
        let names: Vec<String> = letter.into_iter().map(|(name, _)| name).collect();
        let expected = ["ν 0.35, stuck", "ν 0.48, stuck", "ν 0.35, sliding", "ν 0.48, sliding"];
        assert_eq!(names, expected.map(|variation| format!("letter, {variation}")));
        assert!(measure(&options(vec!["no such scene".into()]), &PressCache::OFF, &|_| {}).is_err());
    }
}
