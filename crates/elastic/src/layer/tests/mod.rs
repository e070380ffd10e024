mod circular_punch;
mod compliance;
mod contact;
mod operator;

use super::*;
use crate::GelBlock;

/// A material of 0.6 `MPa`, 10 mm thick.
fn block(poissons_ratio: f64) -> GelBlock {
    GelBlock { size_mm: [30.0, 30.0], thickness_mm: 10.0, poissons_ratio, youngs_modulus_mpa: Some(0.6) }
}

fn layer(poissons_ratio: f64) -> Layer {
    Layer::new(&block(poissons_ratio)).unwrap()
}

fn half_space(poissons_ratio: f64) -> Layer {
    Layer::half_space(&block(poissons_ratio)).unwrap()
}

fn assert_near(value: f64, expected: f64, tolerance: f64, what: &str) {
    let difference = (value - expected).abs() / expected.abs().max(f64::MIN_POSITIVE);
    assert!(difference <= tolerance, "{what}: {value}, expected {expected}, {difference:.2e} off");
}
