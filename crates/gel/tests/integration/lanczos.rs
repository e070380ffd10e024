//! Sampling between pixels with a windowed ideal low-pass filter, the most accurate interpolation.

/// Pixels on either side that the interpolation takes.
pub(crate) const REACH: usize = 10;

/// Weights of the neighbours `-REACH + 1..=REACH` at a fraction of a pixel.
pub(crate) fn weights(fraction: f64) -> Vec<f64> {
    let sinc = |t: f64| if t.abs() < 1e-12 { 1.0 } else { t.sin() / t };
    let weight = |k: usize| {
        let t = std::f64::consts::PI * (fraction + (REACH - 1) as f64 - k as f64);
        sinc(t) * sinc(t / REACH as f64)
    };
    let weights: Vec<_> = (0..2 * REACH).map(weight).collect();
    let total: f64 = weights.iter().sum();
    weights.iter().map(|weight| weight / total).collect()
}
