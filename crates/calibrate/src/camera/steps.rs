//! Checks whether a recording shows the slide that was given.

use super::thresholds::THRESHOLDS;
use super::{BoardError, Slide};

/// Checks the steps between consecutive images, given by the median flow of each pair, px; returns the usual one.
pub(super) fn usual_step(pairs: &[[f64; 2]]) -> Result<[f64; 2], BoardError> {
    let usual = [0, 1].map(|axis| median(pairs.iter().map(|pair| pair[axis]).collect()));
    let length = usual[0].hypot(usual[1]);
    let fastest = pairs.iter().map(|pair| pair[0].hypot(pair[1])).fold(0.0, f64::max);
    if length < THRESHOLDS.least_flow_px {
        return Err(BoardError::Still { flow_px: if fastest < THRESHOLDS.least_flow_px { fastest } else { length } });
    }
    let in_steps = |pair: &[f64; 2]| {
        let along = (pair[0] * usual[0] + pair[1] * usual[1]) / length.powi(2);
        let across = (pair[1] * usual[0] - pair[0] * usual[1]) / length.powi(2);
        (along, across)
    };
    let fault = |(index, pair): (usize, &[f64; 2])| {
        let (along, across) = in_steps(pair);
        let is_usual = (along - 1.0).hypot(across) <= THRESHOLDS.step_tolerance;
        (!is_usual).then_some(BoardError::UnevenStep { image: index + 1, steps: along })
    };
    // A step back explains the long ones beside it.
    let back = pairs.iter().position(|pair| in_steps(pair).0 < -0.3);
    match back.map(|index| (index, &pairs[index])).and_then(fault) {
        Some(error) => Err(error),
        None => pairs.iter().enumerate().find_map(fault).map_or(Ok(usual), Err),
    }
}

/// Checks the usual step against the given one and, if a camera is known, against its predicted flow, px.
pub(super) fn check_slide(usual: [f64; 2], slide: Slide, known_flow_px: Option<[f64; 2]>) -> Result<(), BoardError> {
    let [x, y] = known_flow_px.unwrap_or(slide.step_vector_mm());
    let angle = |[x, y]: [f64; 2]| y.atan2(x).to_degrees();
    let (found_deg, expected_deg) = (angle(usual), angle([x, y]));
    let apart = (found_deg - expected_deg + 540.0).rem_euclid(360.0) - 180.0;
    if apart.abs() > THRESHOLDS.direction_tolerance_deg {
        return Err(BoardError::WrongDirection { found_deg, expected_deg });
    }
    let Some([x, y]) = known_flow_px else { return Ok(()) };
    let ratio = usual[0].hypot(usual[1]) / x.hypot(y);
    if (THRESHOLDS.scale_tolerance.recip()..=THRESHOLDS.scale_tolerance).contains(&ratio) {
        Ok(())
    } else {
        Err(BoardError::WrongStep { found_mm: ratio * slide.step_mm, step_mm: slide.step_mm })
    }
}

/// The median; not a number if there is none.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let (middle, is_even) = (values.len() / 2, values.len().is_multiple_of(2));
    let upper = *values.select_nth_unstable_by(middle, f64::total_cmp).1;
    let lower = values[..middle].iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if is_even { 0.5 * (lower + upper) } else { upper }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The board's position in each image, in steps of 8 px.
    fn refusal(places: &[f64]) -> String {
        let pairs: Vec<_> = places.windows(2).map(|pair| [8.0 * (pair[1] - pair[0]), 0.1]).collect();
        usual_step(&pairs).unwrap_err().to_string()
    }

    #[test]
    fn equal_steps_are_taken() {
        let pairs = [[8.0, 0.1], [8.2, 0.0], [7.9, -0.1], [8.1, 0.1], [8.0, 0.0]];
        let [x, y] = usual_step(&pairs).unwrap();
        assert!((x - 8.0).abs() < 1e-12 && y.abs() < 1e-12, "({x}, {y})");
    }

    #[test]
    fn every_fault_of_the_order_is_named() {
        let swapped = refusal(&[0.0, 1.0, 3.0, 2.0, 4.0, 5.0, 6.0, 7.0]);
        assert_eq!(swapped, "images are out of order: from image 3 to 4 the board moves back by 1.0 steps");
        let doubled = refusal(&[0.0, 1.0, 2.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(doubled, "images 3 and 4 show the board at the same place");
        let missing = refusal(&[0.0, 1.0, 2.0, 4.0, 5.0, 6.0, 7.0]);
        assert_eq!(missing, "1 image is missing between image 3 and 4: the board moves 2.00 steps");
        let uneven = refusal(&[0.0, 1.0, 2.0, 3.4, 4.4, 5.4, 6.4]);
        assert_eq!(uneven, "the steps are uneven: from image 3 to 4 the board moves 1.40 times the usual step");
        let still = refusal(&[0.0, 0.01, 0.0, 0.01, 0.0, 0.01]);
        assert!(still.starts_with("the board does not move"), "{still}");
    }

    #[test]
    fn a_slide_is_compared_with_what_was_given() {
        let slide = Slide { step_mm: 0.5, direction_rad: 0.0 };
        assert_eq!(check_slide([8.0, 1.0], slide, None), Ok(()));
        assert_eq!(check_slide([8.0, 1.0], slide, Some([8.3, 0.5])), Ok(()));
        let other = check_slide([-8.0, 0.0], slide, None).unwrap_err().to_string();
        assert_eq!(other, "the board moves towards 180° in the image, not towards 0°");
        let wrong = check_slide([16.0, 0.0], slide, Some([8.0, 0.0])).unwrap_err().to_string();
        assert_eq!(wrong, "with the known camera, the board moves 1.000 mm from image to image, not 0.5 mm");
    }

    #[test]
    fn the_median_is_the_middle() {
        assert!((median(vec![3.0, 1.0, 2.0]) - 2.0).abs() < 1e-12);
        assert!((median(vec![4.0, 1.0, 2.0, 3.0]) - 2.5).abs() < 1e-12);
        assert!(median(Vec::new()).is_nan());
    }
}
