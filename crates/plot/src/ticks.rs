//! Round numbers for axes and scales, and their format.

/// Mantissas of the ends of scales.
const ENDS: [f32; 10] = [1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
/// Mantissas of steps between ticks.
const STEPS: [f32; 4] = [1.0, 2.0, 5.0, 10.0];

/// The smallest round number that is not below a positive `value`; 1 for any other.
#[must_use]
pub fn round_up(value: f32) -> f32 {
    among(&ENDS, value, |end| end >= value * 0.999)
}

/// The smallest of 1, 2, 5, 10, … times a power of ten that is not below a positive `value`; 1 for any other.
pub(crate) fn step_above(value: f32) -> f32 {
    among(&STEPS, value, |step| step >= value * 0.999)
}

/// The largest of 1, 2, 5, 10, … times a power of ten that is not above a positive `value`; 1 for any other.
#[must_use]
pub fn step_below(value: f32) -> f32 {
    let above = step_above(value);
    if above <= value { above } else { step_above(above / 2.6) }
}

fn among(mantissas: &[f32], value: f32, is_enough: impl Fn(f32) -> bool) -> f32 {
    if !value.is_finite() || value < f32::MIN_POSITIVE {
        return 1.0;
    }
    let magnitude = 10f32.powf(value.log10().floor());
    let scaled = mantissas.iter().map(|mantissa| mantissa * magnitude);
    scaled.into_iter().find(|&number| is_enough(number)).unwrap_or(10.0 * magnitude)
}

/// Evenly spaced round numbers between two ends, with at most `most` steps, and their text.
pub(crate) fn ticks(low: f32, high: f32, most: usize) -> Vec<(f32, String)> {
    let step = step_above((high - low) / most as f32);
    let (first, last) = ((low / step - 1e-3).ceil() as i64, (high / step + 1e-3).floor() as i64);
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let tick = |i| {
        let value = i as f32 * step;
        (value, with_minus(format!("{value:.decimals$}")))
    };
    (first..=last).map(tick).collect()
}

/// Three significant digits, or two decimals for small numbers.
#[must_use]
pub fn number(value: f32) -> String {
    with_minus(match value.abs() {
        size if size >= 99.95 => format!("{value:.0}"),
        size if size >= 9.995 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    })
}

/// A round number without trailing zeros.
#[must_use]
pub fn plain(value: f32) -> String {
    with_minus(format!("{}", (f64::from(value) * 1e6).round() / 1e6))
}

/// With a real minus sign, and none before a zero.
fn with_minus(number: String) -> String {
    match number.strip_prefix('-') {
        Some(zero) if zero.chars().all(|c| "0.".contains(c)) => zero.to_string(),
        Some(size) => format!("−{size}"),
        None => number,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_the_next_round_number() {
        for (value, end) in [(4.3, 5.0), (0.021, 0.025), (8.01, 10.0), (1.0, 1.0), (0.0, 1.0), (f32::NAN, 1.0)] {
            assert!((round_up(value) - end).abs() < 1e-4 * end, "{value}: {} instead of {end}", round_up(value));
        }
    }

    #[test]
    fn steps_surround_a_value() {
        for (value, below, above) in [(4.3, 2.0, 5.0), (1.4, 1.0, 2.0), (0.07, 0.05, 0.1), (50.0, 50.0, 50.0)] {
            let (got_below, got_above) = (step_below(value), step_above(value));
            assert!((got_below - below).abs() < 1e-4 * below, "{value}: {got_below} instead of {below}");
            assert!((got_above - above).abs() < 1e-4 * above, "{value}: {got_above} instead of {above}");
        }
    }

    #[test]
    fn ticks_include_both_ends_where_they_are_round() {
        let written: Vec<_> = ticks(-1.5, 1.5, 6).into_iter().map(|(_, text)| text).collect();
        assert_eq!(written, ["−1.5", "−1.0", "−0.5", "0.0", "0.5", "1.0", "1.5"]);
    }

    #[test]
    fn numbers_keep_three_digits_and_no_negative_zero() {
        let numbers = [123.4, 12.34, -1.234, -0.001];
        assert_eq!(numbers.map(number), ["123", "12.3", "−1.23", "0.00"]);
        assert_eq!(plain(0.2), "0.2");
    }
}
