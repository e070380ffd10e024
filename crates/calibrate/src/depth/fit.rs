//! The laws fitted to presses of known depth, and the error of each.

use fingervision_touch::{DepthLaw, DepthLine, PerspectiveGain};
use serde::Serialize;

use super::regression::{LineFit, OriginFit, fit_line, fit_through_origin};
use super::thresholds::THRESHOLDS;
use super::{DepthFitError, PressCurve, PressPoint};

/// A form of the law from the density feature to depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// A line with an intercept, as published.
    Line,
    /// A line through the origin: untouched gel has no depth.
    Origin,
    /// A line through the origin, whose slope at every pixel is that of the camera's perspective times a gain.
    Perspective,
}

/// The result for one press.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PressFit {
    /// Its curve.
    #[serde(flatten)]
    pub curve: PressCurve,
    /// The line that gives depth, mm, from the feature.
    pub line: LineFit,
}

/// A law fitted to all presses, and its error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FittedLaw {
    /// Its form.
    pub method: Method,
    /// The law, as written to the profile.
    pub law: DepthLaw,
    /// Root mean square error over all frames of all presses, mm.
    pub error_mm: f64,
    /// The same, every press compared with the law fitted to all others, mm; absent for a single press.
    pub left_out_error_mm: Option<f64>,
}

/// The result for all presses.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DepthFit {
    /// One for each press, in the given order.
    pub presses: Vec<PressFit>,
    /// The same line over all frames of all presses.
    pub pooled: LineFit,
    /// The line through the origin over the same frames.
    pub origin: OriginFit,
    /// The gain of perspective, dimensionless; absent without a camera.
    pub perspective: Option<OriginFit>,
    /// The largest slope of a press over the smallest, dimensionless.
    pub slope_factor: f64,
    /// Every law that can be fitted.
    pub laws: Vec<FittedLaw>,
    /// The law with the least error: on presses that were left out, if there are several.
    pub best: Method,
    /// Warnings, for example that no single line fits.
    pub warnings: Vec<String>,
}

impl DepthFit {
    /// Fits every law to these presses.
    ///
    /// # Errors
    ///
    /// [`DepthFitError::NoResponse`] if the feature does not grow with the depth in a press or in all of them together.
    ///
    /// # Panics
    ///
    /// If there are no presses.
    pub fn new(curves: Vec<PressCurve>) -> Result<Self, DepthFitError> {
        assert!(!curves.is_empty(), "a fit needs a press");
        let no_response = |press: &str| DepthFitError::NoResponse { press: press.into() };
        let presses = curves
            .into_iter()
            .map(|curve| match fit_line(&by_feature(curve.points.iter())) {
                Some(line) if line.slope > 0.0 => Ok(PressFit { curve, line }),
                _ => Err(no_response(&curve.name)),
            })
            .collect::<Result<Vec<_>, _>>()?;
        let all = || presses.iter().flat_map(|press| &press.curve.points);
        let pooled = fit_line(&by_feature(all())).ok_or_else(|| no_response("all presses"))?;
        let origin = fit_through_origin(&by_feature(all())).ok_or_else(|| no_response("all presses"))?;
        let perspective = by_perspective(all()).and_then(|points| fit_through_origin(&points));
        let laws = fitted_laws(&presses);
        let error = |law: &FittedLaw| law.left_out_error_mm.unwrap_or(law.error_mm);
        let best = laws.iter().min_by(|a, b| error(a).total_cmp(&error(b))).map(|law| law.method);
        let best = best.ok_or_else(|| no_response("all presses"))?;
        let slope_factor = slope_factor(&presses);
        let warnings = warnings(&presses, &pooled, slope_factor);
        Ok(Self { presses, pooled, origin, perspective, slope_factor, laws, best, warnings })
    }

    /// The law of this form.
    ///
    /// # Errors
    ///
    /// [`DepthFitError::NoCamera`] if perspective is requested and the profile had no camera.
    pub fn law(&self, method: Method) -> Result<&FittedLaw, DepthFitError> {
        self.laws.iter().find(|law| law.method == method).ok_or(DepthFitError::NoCamera)
    }
}

impl Method {
    const ALL: [Self; 3] = [Self::Line, Self::Origin, Self::Perspective];

    /// Its name on the command line and in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Line => "line",
            Self::Origin => "origin",
            Self::Perspective => "perspective",
        }
    }

    /// The law of this form with the best fit.
    fn fit<'a>(self, points: impl Iterator<Item = &'a PressPoint>) -> Option<DepthLaw> {
        let line = |slope_mm, intercept_mm| DepthLaw::Line(DepthLine { slope_mm, intercept_mm });
        Some(match self {
            Self::Line => fit_line(&by_feature(points)).map(|fit| line(fit.slope, fit.intercept))?,
            Self::Origin => fit_through_origin(&by_feature(points)).map(|fit| line(fit.slope, 0.0))?,
            Self::Perspective => {
                let gain = fit_through_origin(&by_perspective(points)?)?.slope;
                DepthLaw::Perspective(PerspectiveGain { gain })
            }
        })
    }
}

/// The depth of a point by a law, mm; not a number without a camera where one is needed.
fn depth_mm(law: &DepthLaw, point: &PressPoint) -> f64 {
    match law {
        DepthLaw::Line(line) => line.slope_mm * point.feature + line.intercept_mm,
        DepthLaw::Perspective(PerspectiveGain { gain }) => gain * point.perspective_mm.unwrap_or(f64::NAN),
    }
}

fn by_feature<'a>(points: impl Iterator<Item = &'a PressPoint>) -> Vec<[f64; 2]> {
    points.map(|point| [point.feature, point.depth_mm]).collect()
}

fn by_perspective<'a>(points: impl Iterator<Item = &'a PressPoint>) -> Option<Vec<[f64; 2]>> {
    points.map(|point| Some([point.perspective_mm?, point.depth_mm])).collect()
}

fn fitted_laws(presses: &[PressFit]) -> Vec<FittedLaw> {
    let fitted = |method: Method| {
        let all = || presses.iter().flat_map(|press| &press.curve.points);
        let law = method.fit(all())?;
        law.validate().ok()?;
        let error_mm = root_mean_square(all().map(|point| depth_mm(&law, point) - point.depth_mm));
        Some(FittedLaw { method, law, error_mm, left_out_error_mm: left_out_error_mm(presses, method) })
    };
    Method::ALL.into_iter().filter_map(fitted).collect()
}

fn left_out_error_mm(presses: &[PressFit], method: Method) -> Option<f64> {
    let mut errors = Vec::new();
    for (number, press) in presses.iter().enumerate() {
        let others = presses.iter().enumerate().filter(|&(other, _)| other != number);
        let law = method.fit(others.flat_map(|(_, other)| &other.curve.points))?;
        errors.extend(press.curve.points.iter().map(|point| depth_mm(&law, point) - point.depth_mm));
    }
    Some(root_mean_square(errors.into_iter()))
}

fn root_mean_square(errors: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = errors.fold((0.0, 0.0), |(sum, count), error| (sum + error * error, count + 1.0));
    (sum / count).sqrt()
}

fn slope_factor(presses: &[PressFit]) -> f64 {
    let slopes = || presses.iter().map(|press| press.line.slope);
    slopes().fold(f64::MIN, f64::max) / slopes().fold(f64::MAX, f64::min)
}

fn warnings(presses: &[PressFit], pooled: &LineFit, slope_factor: f64) -> Vec<String> {
    let by_slope = |a: &&PressFit, b: &&PressFit| a.line.slope.total_cmp(&b.line.slope);
    let poor = presses.iter().filter(|press| press.line.correlation < THRESHOLDS.usual_correlation);
    let mut warnings: Vec<String> = poor
        .map(|press| {
            format!(
                "{}: its density feature hardly grows with its depth (r = {:.2}): leave it out if its contact is as small as 1 mm, \
                 and check the order of its images",
                press.curve.name, press.line.correlation
            )
        })
        .collect();
    warnings.extend(weak_presses(presses));
    if let (Some(flat), Some(steep)) = (presses.iter().min_by(by_slope), presses.iter().max_by(by_slope))
        && slope_factor > THRESHOLDS.most_factor
    {
        warnings.push(format!(
            "one line does not fit all presses: their slopes differ by a factor of {slope_factor:.1}, from {:.1} mm \
             ({}) to {:.1} mm ({})",
            flat.line.slope, flat.curve.name, steep.line.slope, steep.curve.name
        ));
    }
    let least = presses.iter().map(|press| press.line.correlation).fold(1.0, f64::min);
    if pooled.correlation < least - THRESHOLDS.most_drop {
        warnings.push(format!(
            "depth from one line is uncertain: the correlation is {:.3} for all presses together, but {least:.3} or more for each press",
            pooled.correlation
        ));
    } else if presses.len() > 1 && pooled.correlation < THRESHOLDS.good_correlation {
        warnings.push(format!(
            "depth by one line is uncertain: the correlation of all presses together is {:.4}, below {}",
            pooled.correlation, THRESHOLDS.good_correlation
        ));
    }
    warnings
}

/// A warning if presses follow their line, but not closely.
fn weak_presses(presses: &[PressFit]) -> Option<String> {
    let range = THRESHOLDS.usual_correlation..THRESHOLDS.good_correlation;
    let weak: Vec<&PressFit> = presses.iter().filter(|press| range.contains(&press.line.correlation)).collect();
    let worst = weak.iter().min_by(|a, b| a.line.correlation.total_cmp(&b.line.correlation))?;
    let PressFit { curve, line } = worst;
    let others = match weak.len() - 1 {
        0 => String::new(),
        others => format!(", as for {others} other press{}", if others == 1 { "" } else { "es" }),
    };
    Some(format!(
        "{}: r = {:.4} is below {}{others}: check the depths and the order of the images; if the rim of the contact jumps, fit with \
         calibrate depth --maximum robust",
        curve.name, line.correlation, THRESHOLDS.good_correlation
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::Place;

    /// A press whose depth is a line of the feature, its slope by perspective scaled by `distance`.
    fn curve(name: &str, slope_mm: f64, intercept_mm: f64, distance: f64) -> PressCurve {
        let point = |frame: u64| {
            let feature = 0.01 * frame as f64;
            let depth_mm = slope_mm * feature + intercept_mm;
            PressPoint { frame, depth_mm, feature, perspective_mm: Some(distance * feature) }
        };
        PressCurve { name: name.into(), place: Place::Centre, points: (0..11).map(point).collect(), lost: 0 }
    }

    #[test]
    fn presses_on_one_line_give_that_line_and_no_warning() {
        let fit = DepthFit::new(vec![curve("a", 12.0, 0.3, 10.0), curve("b", 12.0, 0.3, 10.0)]).unwrap();
        let DepthLaw::Line(line) = fit.law(Method::Line).unwrap().law else { panic!("{fit:?}") };
        assert!((line.slope_mm - 12.0).abs() < 1e-9 && (line.intercept_mm - 0.3).abs() < 1e-9, "{line:?}");
        assert!(fit.law(Method::Line).unwrap().error_mm < 1e-9);
        assert_eq!((fit.best, fit.warnings.as_slice()), (Method::Line, &[][..]));
        assert!((fit.slope_factor - 1.0).abs() < 1e-9);
    }

    #[test]
    fn presses_at_several_distances_are_best_explained_by_perspective() {
        let fit = DepthFit::new(vec![curve("near", 8.0, 0.0, 10.0), curve("far", 24.0, 0.0, 30.0)]).unwrap();
        let best = fit.law(fit.best).unwrap();
        let DepthLaw::Perspective(PerspectiveGain { gain }) = best.law else { panic!("{fit:?}") };
        assert!((gain - 0.8).abs() < 1e-9 && best.left_out_error_mm.unwrap() < 1e-9, "{best:?}");
        assert!(fit.law(Method::Origin).unwrap().left_out_error_mm > fit.law(Method::Origin).unwrap().error_mm.into());
        assert_eq!(
            fit.warnings,
            [
                "one line does not fit all presses: their slopes differ by a factor of 3.0, from 8.0 mm (near) to 24.0 mm \
                 (far)",
                "depth from one line is uncertain: the correlation is 0.730 for all presses together, but 1.000 or more for each press"
            ]
        );
    }

    #[test]
    fn a_single_press_has_no_error_on_others() {
        let fit = DepthFit::new(vec![curve("a", 12.0, 0.0, 10.0)]).unwrap();
        assert!(fit.laws.iter().all(|law| law.left_out_error_mm.is_none()));
        assert_eq!(fit.facts(), "1 press, r 1.000");
    }

    #[test]
    fn a_press_too_small_for_the_pattern_is_named_and_does_not_stop_the_others() {
        let mut small = curve("small", 12.0, 0.0, 10.0);
        let features = [0.0, 0.06, 0.01, 0.06, 0.02, 0.06, 0.02, 0.06, 0.03, 0.05, 0.05];
        small.points.iter_mut().zip(features).for_each(|(point, feature)| point.feature = feature);
        let fit = DepthFit::new(vec![curve("a", 12.0, 0.0, 10.0), curve("b", 12.0, 0.0, 10.0), small]).unwrap();
        assert!(fit.warnings[0].starts_with("small: its density feature hardly grows"), "{:?}", fit.warnings);
        let law = fit.law(Method::Origin).unwrap();
        fit.check(law, &fingervision_touch::Profile::default()).unwrap();
    }

    #[test]
    fn a_press_that_follows_its_depth_loosely_is_named() {
        // The feature scatters by a constant, up and down: the correlation falls with it.
        let scattered = |name: &str, scatter: f64| {
            let mut curve = curve(name, 12.0, 0.0, 10.0);
            curve.points.iter_mut().for_each(|point| point.feature += [scatter, -scatter][(point.frame % 2) as usize]);
            curve
        };
        let [good, loose] = [scattered("good", 0.004), scattered("loose", 0.0105)];
        let fit = DepthFit::new(vec![good.clone()]).unwrap();
        assert!(fit.presses[0].line.correlation > 0.98 && fit.warnings.is_empty(), "{:?}", fit.warnings);
        let fit = DepthFit::new(vec![loose.clone()]).unwrap();
        let r = fit.presses[0].line.correlation;
        assert!((0.94..0.95).contains(&r), "r = {r}");
        let [warning] = &fit.warnings[..] else { panic!("{:?}", fit.warnings) };
        assert!(warning.starts_with(&format!("loose: r = {r:.4} is below 0.95: check")), "{warning}");
        assert!(fit.to_string().contains(&format!("\nwarning      {warning}")));
        let mut other = loose.clone();
        other.name = "other".into();
        let fit = DepthFit::new(vec![loose, other]).unwrap();
        assert!(fit.warnings[0].contains(", as for 1 other press: check"), "{:?}", fit.warnings);
        assert!(fit.warnings[1].contains("of all presses together is 0.94"), "{:?}", fit.warnings);
    }

    #[test]
    fn a_feature_that_does_not_grow_is_refused() {
        for slope_mm in [0.0, -3.0] {
            let error = DepthFit::new(vec![curve("a", slope_mm, 1.0, 1.0)]).unwrap_err();
            assert_eq!(error.to_string(), "a: the density feature does not grow with the depth");
        }
    }

    #[test]
    fn without_a_camera_there_is_no_perspective() {
        let mut without = curve("a", 12.0, 0.0, 10.0);
        without.points.iter_mut().for_each(|point| point.perspective_mm = None);
        let fit = DepthFit::new(vec![without]).unwrap();
        assert!(matches!(fit.law(Method::Perspective), Err(DepthFitError::NoCamera)));
        assert!(fit.law(Method::Origin).is_ok() && fit.perspective.is_none());
    }
}
