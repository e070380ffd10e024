//! Straight lines through points, by least squares.
//!
//! The uncertainties are the standard ones of linear regression, which assume independent residuals. The residuals of
//! frames of one press are partly correlated, so these are lower limits.

use serde::Serialize;

/// `y = slope · x + intercept`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LineFit {
    /// Number of points.
    pub count: usize,
    /// Change of y with x.
    pub slope: f64,
    /// Its standard uncertainty.
    pub slope_uncertainty: f64,
    /// y where x is 0.
    pub intercept: f64,
    /// Its standard uncertainty.
    pub intercept_uncertainty: f64,
    /// Pearson's correlation of x and y, −1 to 1, dimensionless.
    pub correlation: f64,
    /// Root mean square of the residuals.
    pub residual: f64,
}

/// `y = slope · x`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OriginFit {
    /// Number of points.
    pub count: usize,
    /// Change of y with x.
    pub slope: f64,
    /// Its standard uncertainty.
    pub slope_uncertainty: f64,
    /// Root mean square of the residuals.
    pub residual: f64,
}

/// The least-squares line in y through points `[x, y]`.
///
/// None for fewer than three points, or if x or y never changes.
#[must_use]
pub fn fit_line(points: &[[f64; 2]]) -> Option<LineFit> {
    let count = points.len();
    if count < 3 {
        return None;
    }
    let n = count as f64;
    let mean = [0, 1].map(|i| points.iter().map(|point| point[i]).sum::<f64>() / n);
    let sum = |i: usize, j: usize| points.iter().map(|p| (p[i] - mean[i]) * (p[j] - mean[j])).sum::<f64>();
    let (xx, xy, yy) = (sum(0, 0), sum(0, 1), sum(1, 1));
    let changes = xx.is_finite() && yy.is_finite() && xx > 0.0 && yy > 0.0;
    changes.then(|| {
        let slope = xy / xx;
        let intercept = mean[1] - slope * mean[0];
        let squares = squares(points, |x| slope * x + intercept);
        let variance = squares / (n - 2.0);
        LineFit {
            count,
            slope,
            slope_uncertainty: (variance / xx).sqrt(),
            intercept,
            intercept_uncertainty: (variance * (1.0 / n + mean[0] * mean[0] / xx)).sqrt(),
            correlation: (xy / (xx.sqrt() * yy.sqrt())).clamp(-1.0, 1.0),
            residual: (squares / n).sqrt(),
        }
    })
}

/// The least-squares line in y through the origin and points `[x, y]`.
///
/// None for fewer than two points, or if x is always 0.
#[must_use]
pub fn fit_through_origin(points: &[[f64; 2]]) -> Option<OriginFit> {
    let count = points.len();
    let sum = |f: fn([f64; 2]) -> f64| points.iter().copied().map(f).sum::<f64>();
    let (xx, xy) = (sum(|[x, _]| x * x), sum(|[x, y]| x * y));
    (count >= 2 && xx.is_finite() && xy.is_finite() && xx > 0.0).then(|| {
        let slope = xy / xx;
        let squares = squares(points, |x| slope * x);
        let n = count as f64;
        OriginFit { count, slope, slope_uncertainty: (squares / (n - 1.0) / xx).sqrt(), residual: (squares / n).sqrt() }
    })
}

/// Sum of the squared distances in y from a curve.
fn squares(points: &[[f64; 2]], curve: impl Fn(f64) -> f64) -> f64 {
    points.iter().map(|&[x, y]| (y - curve(x)).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ozone readings against a standard; the expected values below were made with rational arithmetic.
    const POINTS: [[f64; 2]; 6] =
        [[0.2, 0.1], [337.4, 338.8], [118.2, 118.1], [884.6, 888.0], [10.1, 9.2], [226.5, 228.1]];

    /// Slope, intercept, their uncertainties, residual; slope through the origin and its uncertainty.
    const EXPECTED: [f64; 7] = [
        1.004_437_611_868_281_2,
        -0.283_018_986_046_596_14,
        0.000_814_391_395_432_662_4,
        0.326_050_193_774_932,
        0.491_901_074_025_746_95,
        1.003_973_531_239_167_3,
        0.000_598_985_857_206_686_9,
    ];

    fn assert_near(given: f64, expected: f64, what: &str) {
        assert!((given - expected).abs() < 1e-9 * expected.abs().max(1e-3), "{what}: {given}, expected {expected}");
    }

    #[test]
    fn the_fit_finds_a_line_of_any_slope() {
        for (slope, intercept) in [(15.2, -0.4), (-3.0, 1000.0), (1e-6, 0.0)] {
            let points: Vec<_> = (0..5).map(|i| f64::from(i) * 0.01).map(|x| [x, slope * x + intercept]).collect();
            let fit = fit_line(&points).unwrap();
            assert!((fit.slope - slope).abs() < 1e-9 * slope.abs().max(1.0), "{fit:?}");
            assert!((fit.intercept - intercept).abs() < 1e-9 * intercept.abs().max(1.0), "{fit:?}");
            assert!((fit.correlation - slope.signum()).abs() < 1e-6 && fit.residual < 1e-9, "{fit:?}");
        }
    }

    #[test]
    fn the_figures_are_those_of_the_textbook() {
        let fit = fit_line(&POINTS).unwrap();
        assert_near(fit.slope, EXPECTED[0], "slope");
        assert_near(fit.intercept, EXPECTED[1], "intercept");
        assert_near(fit.slope_uncertainty, EXPECTED[2], "uncertainty of the slope");
        assert_near(fit.intercept_uncertainty, EXPECTED[3], "uncertainty of the intercept");
        assert_near(fit.residual, EXPECTED[4], "residual");
        let through = fit_through_origin(&POINTS).unwrap();
        assert_near(through.slope, EXPECTED[5], "slope through the origin");
        assert_near(through.slope_uncertainty, EXPECTED[6], "its uncertainty");
    }

    #[test]
    fn the_uncertainty_is_the_scatter_of_repeated_fits() {
        let mut state = 1_u64;
        let mut noise = || {
            // Twelve uniform numbers add up to nearly a normal one.
            let mut uniform = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64
            };
            (0..12).map(|_| uniform()).sum::<f64>() - 6.0
        };
        let fits: Vec<LineFit> = (0..400)
            .map(|_| {
                let points: Vec<_> = (0..20).map(f64::from).map(|x| [x, 2.0 * x + 1.0 + noise()]).collect();
                fit_line(&points).unwrap()
            })
            .collect();
        let scatter = |value: fn(&LineFit) -> f64, truth: f64| {
            (fits.iter().map(|fit| (value(fit) - truth).powi(2)).sum::<f64>() / fits.len() as f64).sqrt()
        };
        let stated = |value: fn(&LineFit) -> f64| fits.iter().map(value).sum::<f64>() / fits.len() as f64;
        let slope = scatter(|fit| fit.slope, 2.0) / stated(|fit| fit.slope_uncertainty);
        let intercept = scatter(|fit| fit.intercept, 1.0) / stated(|fit| fit.intercept_uncertainty);
        assert!(
            (slope - 1.0).abs() < 0.12 && (intercept - 1.0).abs() < 0.12,
            "{slope} and {intercept} of what is stated"
        );
    }

    #[test]
    fn what_cannot_be_fitted_is_none() {
        assert_eq!(fit_line(&[[0.0, 0.0], [1.0, 1.0]]), None);
        assert_eq!(fit_line(&[[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]]), None);
        assert_eq!(fit_line(&[[0.0, 1.0], [1.0, 1.0], [2.0, 1.0]]), None);
        assert_eq!(fit_line(&[[f64::NAN, 1.0], [1.0, 2.0], [2.0, 1.0]]), None);
        assert_eq!(fit_through_origin(&[[0.0, 1.0], [0.0, 2.0]]), None);
        assert_eq!(fit_through_origin(&[[1.0, 1.0]]), None);
    }
}
