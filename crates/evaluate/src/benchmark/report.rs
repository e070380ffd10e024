//! The result of the benchmark.

use std::fmt;

use serde::Serialize;

use super::{Extent, Method, Variation};
use crate::experiment::{DepthScore, ElasticScore};

/// One method's errors on a case.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodScore {
    /// The method.
    pub method: String,
    /// Its errors in the last frame, mm.
    #[serde(flatten)]
    pub score: DepthScore,
    /// Intersection over union of estimated and true contact, 0 to 1; none if the method does not estimate contact.
    pub contact_overlap: Option<f64>,
    /// Absolute error of the normal force over the true one, dimensionless; none if it does not estimate force.
    pub normal_force: Option<f64>,
    /// Length of the error of the shear force over the true shear force, dimensionless; none where the true one is
    /// below 5 % of the normal force.
    pub shear_force: Option<f64>,
    /// Absolute error of the torque about z over the true torque, dimensionless; none where the true one is below the
    /// normal force times an arm of 0.1 mm.
    pub torque: Option<f64>,
}

impl MethodScore {
    /// The score of a method that only estimates depth.
    pub(super) fn new(method: &str, score: DepthScore) -> Self {
        let (contact_overlap, normal_force, shear_force, torque) = (None, None, None, None);
        Self { method: method.into(), score, contact_overlap, normal_force, shear_force, torque }
    }
}

impl From<ElasticScore> for MethodScore {
    fn from(elastic: ElasticScore) -> Self {
        Self {
            method: Method::Elastic.name().into(),
            score: elastic.depth,
            contact_overlap: Some(elastic.contact_overlap),
            normal_force: elastic.normal_force.map(f64::abs),
            shear_force: elastic.shear_force,
            torque: elastic.torque.map(f64::abs),
        }
    }
}

/// All methods on a case.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseReport {
    /// Its name.
    pub case: String,
    /// The scene.
    pub scene: &'static str,
    /// The variation's name.
    pub variation: &'static str,
    /// Depth of the indenter in the last frame, mm.
    pub depth_mm: f64,
    /// Mean end-point error of the flow over the valid pixels, px.
    pub flow_error_px: f64,
    /// One entry per method.
    pub scores: Vec<MethodScore>,
}

/// A method's errors over the cases of a variation, mm.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodMeans {
    /// The method.
    pub method: String,
    /// The variation.
    pub variation: &'static str,
    /// Number of cases.
    pub cases: usize,
    /// Mean over the cases of the errors over the whole image.
    pub everywhere_mm: f64,
    /// The same inside contact.
    pub inside_mm: f64,
    /// The same within 1 mm of the border of contact.
    pub border_mm: f64,
    /// The same outside contact.
    pub outside_mm: f64,
    /// The largest of the cases' errors inside contact.
    pub worst_inside_mm: f64,
    /// Number of cases in which its error over the whole image is larger than that of depth 0 everywhere.
    pub worse_than_nothing: usize,
    /// Mean over the cases of [`MethodScore::contact_overlap`].
    pub contact_overlap: Option<f64>,
    /// Mean over the cases of [`MethodScore::normal_force`].
    pub normal_force: Option<f64>,
    /// Mean over the cases of [`MethodScore::shear_force`].
    pub shear_force: Option<f64>,
    /// Mean over the cases of [`MethodScore::torque`].
    pub torque: Option<f64>,
}

/// The whole table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BenchmarkReport {
    /// How much was computed.
    pub extent: Extent,
    /// The variations.
    pub variations: Vec<&'static Variation>,
    /// Means by variation and method.
    pub means: Vec<MethodMeans>,
    /// Every case.
    pub cases: Vec<CaseReport>,
    /// Values of the tracker that differ from the simulated sensor: keys of the profile with their values.
    pub assignments: Vec<(String, String)>,
    /// Cases that were not solved to their end, and why.
    pub unsolved: Vec<String>,
}

impl BenchmarkReport {
    pub(super) fn new(
        extent: Extent,
        assignments: &[(String, String)],
        outcomes: Vec<Result<CaseReport, String>>,
    ) -> Self {
        let (mut cases, mut unsolved) = (Vec::new(), Vec::new());
        for outcome in outcomes {
            match outcome {
                Ok(case) => cases.push(case),
                Err(why) => unsolved.push(why),
            }
        }
        let names = |case: &CaseReport| case.scores.iter().map(|score| score.method.clone()).collect::<Vec<_>>();
        let mut methods: Vec<String> = Vec::new();
        for name in cases.iter().flat_map(names) {
            if !methods.contains(&name) {
                methods.push(name);
            }
        }
        let variations: Vec<_> = Variation::ALL
            .iter()
            .filter(|variation| cases.iter().any(|case| case.variation == variation.name))
            .collect();
        let means = variations
            .iter()
            .flat_map(|variation| methods.iter().filter_map(|method| MethodMeans::of(method, variation.name, &cases)));
        let assignments = assignments.to_vec();
        Self { extent, means: means.collect(), variations, cases, assignments, unsolved }
    }

    /// The names of the methods, in the tables' order.
    #[must_use]
    pub fn methods(&self) -> Vec<&str> {
        let first = self.variations.first().map_or("", |variation| variation.name);
        self.means.iter().filter(|means| means.variation == first).map(|means| means.method.as_str()).collect()
    }
}

impl MethodMeans {
    fn of<'a>(method: &str, variation: &'static str, cases: &'a [CaseReport]) -> Option<Self> {
        let own = |case: &'a CaseReport, name: &str| case.scores.iter().find(|score| score.method == name);
        let score = |case, name: &str| own(case, name).map(|score| score.score);
        let of_variation = || cases.iter().filter(|case| case.variation == variation);
        let scores: Vec<(DepthScore, Option<DepthScore>)> = of_variation()
            .filter_map(|case| Some((score(case, method)?, score(case, Method::Nothing.name()))))
            .collect();
        let mean = |figure: fn(&DepthScore) -> f64| {
            let figures: Vec<f64> = scores.iter().map(|(score, _)| figure(score)).filter(|f| f.is_finite()).collect();
            figures.iter().sum::<f64>() / figures.len() as f64
        };
        let part = |figure: fn(&MethodScore) -> Option<f64>| {
            let parts: Vec<f64> = of_variation().filter_map(|case| figure(own(case, method)?)).collect();
            (!parts.is_empty()).then(|| parts.iter().sum::<f64>() / parts.len() as f64)
        };
        let is_worse = |(score, nothing): &&(DepthScore, Option<DepthScore>)| {
            nothing.is_some_and(|nothing| score.everywhere_mm > nothing.everywhere_mm)
        };
        (!scores.is_empty()).then(|| Self {
            method: method.into(),
            variation,
            cases: scores.len(),
            everywhere_mm: mean(|score| score.everywhere_mm),
            inside_mm: mean(|score| score.inside_mm),
            border_mm: mean(|score| score.border_mm),
            outside_mm: mean(|score| score.outside_mm),
            worst_inside_mm: scores.iter().map(|(score, _)| score.inside_mm).fold(f64::NAN, f64::max),
            worse_than_nothing: scores.iter().filter(is_worse).count(),
            contact_overlap: part(|score| score.contact_overlap),
            normal_force: part(|score| score.normal_force),
            shear_force: part(|score| score.shear_force),
            torque: part(|score| score.torque),
        })
    }
}

impl MethodMeans {
    /// Overlap of contact, and errors of normal force, shear force and torque.
    pub(super) fn contact_and_force(&self) -> [Option<f64>; 4] {
        [self.contact_overlap, self.normal_force, self.shear_force, self.torque]
    }
}

/// A part in percent, or a dash.
pub(super) fn percent(part: Option<f64>) -> String {
    part.map_or_else(|| "—".into(), |part| format!("{:.1} %", 100.0 * part))
}

/// The means, one table per variation.
impl fmt::Display for BenchmarkReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (key, value) in &self.assignments {
            writeln!(f, "changed {key} = {value}")?;
        }
        for why in &self.unsolved {
            writeln!(f, "not solved: {why}")?;
        }
        for variation in &self.variations {
            writeln!(f, "{}: {}", variation.name, variation.about)?;
            let columns = ["everywhere", "inside", "border", "outside", "worst inside", "worse than 0"];
            writeln!(f, "  {:22}{}", "mean error, mm", columns.map(|name| format!("{name:>16}")).concat())?;
            for means in self.means.iter().filter(|means| means.variation == variation.name) {
                write!(f, "  {:22}", means.method)?;
                let MethodMeans { everywhere_mm, inside_mm, border_mm, outside_mm, worst_inside_mm, .. } = means;
                for figure in [everywhere_mm, inside_mm, border_mm, outside_mm, worst_inside_mm] {
                    write!(f, "{figure:16.3}")?;
                }
                writeln!(f, "{:>16}", format!("{} of {}", means.worse_than_nothing, means.cases))?;
            }
            let of_variation = self.means.iter().filter(|means| means.variation == variation.name);
            for means in of_variation.filter(|means| means.contact_overlap.is_some()) {
                let [overlap, normal, shear, torque] = means.contact_and_force().map(percent);
                let method = &means.method;
                writeln!(
                    f,
                    "  {method}: contact overlap {overlap}; mean error of normal force {normal}, shear force {shear}, torque {torque}"
                )?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {

    use super::*;

    fn score(everywhere_mm: f64, inside_mm: f64) -> DepthScore {
        DepthScore {
            everywhere_mm,
            inside_mm,
            border_mm: f64::NAN,
            outside_mm: 0.0,
            trusted_mm: 0.0,
            trusted: 1.0,
            correlation: 0.0,
        }
    }

    #[test]
    fn means_are_over_the_cases_that_a_method_has() {
        let case = |scene, own: Option<f64>| CaseReport {
            case: scene,
            scene: "circle",
            variation: "default",
            depth_mm: 2.0,
            flow_error_px: 0.01,
            scores: [("nothing", Some(1.0)), ("mine", own)]
                .into_iter()
                .filter_map(|(name, mean)| {
                    Some(MethodScore {
                        contact_overlap: mean.filter(|_| name == "mine"),
                        ..MethodScore::new(name, score(mean?, 2.0 * mean?))
                    })
                })
                .collect(),
        };
        let cases = [case("a".into(), Some(0.5)), case("b".into(), Some(1.5)), case("c".into(), None)];
        let assignments = [("elastic.network".into(), "false".into())];
        let outcomes = cases.into_iter().map(Ok).chain([Err("d: frame 3 did not converge".into())]);
        let report = BenchmarkReport::new(Extent::Quick, &assignments, outcomes.collect());
        let text = report.to_string();
        assert!(text.contains("changed elastic.network = false") && text.contains("not solved: d: frame 3"), "{text}");
        assert_eq!(report.methods(), ["nothing", "mine"]);
        let mine = &report.means[1];
        assert_eq!((mine.cases, mine.everywhere_mm, mine.worst_inside_mm), (2, 1.0, 3.0));
        assert_eq!(mine.worse_than_nothing, 1);
        assert_eq!((mine.contact_overlap, mine.torque, report.means[0].contact_overlap), (Some(1.0), None, None));
        assert!(text.contains("mine: contact overlap 100.0 %; mean error of normal force —,"), "{text}");
        assert!(mine.border_mm.is_nan(), "no case has a border");
    }
}
