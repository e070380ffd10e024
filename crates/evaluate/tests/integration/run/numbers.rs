//! The figures of the artificial run, computed by hand.

use fingervision_evaluate::run::{Errors, PixelCounts, Regions};

use super::made_up::{HEIGHT, MadeUp, WIDTH, depth_error, is_hidden, is_invalid, true_depth};

/// Pixels by zone: in contact and far from its border, in contact near it, outside near it, elsewhere. Of the last kind
/// there are 1200 − 400 − 364, minus row 0, which is hidden, and the rest of column 0, which is not valid.
const CORE: f64 = 144.0;
const INNER: f64 = 256.0;
const OUTER: f64 = 4.0 * 20.0 * 4.0 + 4.0 * 11.0;
const AWAY: f64 = 436.0 - 40.0 - 29.0;

fn close(actual: f64, expected: f64, what: &str) {
    assert!((actual - expected).abs() < 1e-6, "{what}: {actual}, expected {expected}");
}

/// Checks mean, root mean square and bias against the parts that a region consists of: pixels, and their error.
fn expect(errors: Option<Errors>, parts: &[(f64, f64)], what: &str) -> Errors {
    let errors = errors.unwrap();
    let sum = |value: &dyn Fn(f64) -> f64| parts.iter().map(|&(pixels, error)| pixels * value(error)).sum::<f64>();
    let pixels = sum(&|_| 1.0);
    close(errors.pixels as f64, pixels, &format!("pixels {what}"));
    close(errors.mean, sum(&f64::abs) / pixels, &format!("mean {what}"));
    close(errors.root_mean_square, (sum(&|error| error * error) / pixels).sqrt(), &format!("rms {what}"));
    close(errors.bias, sum(&|error| error) / pixels, &format!("bias {what}"));
    errors
}

fn expect_depth(depth: &Regions, strength: f64) {
    let [core, inner, outer, away] = [(CORE, -0.125), (INNER, -0.5), (OUTER, 0.25), (AWAY, 0.0625)]
        .map(|(pixels, error)| (pixels, strength * error));
    let inside = expect(depth.inside, &[core, inner], "inside");
    close(inside.largest, 0.5 * strength, "largest inside");
    close(inside.percentile_95, 0.5 * strength, "95 % inside");
    close(inside.true_peak, 2.0 * strength, "true peak");
    close(inside.peak_error(), -0.125 * strength, "peak inside");
    assert_eq!(inside.correlation, None, "the truth is flat inside");
    let border = expect(depth.border, &[inner, outer], "border");
    close(border.peak_error(), -0.5 * strength, "peak at the border");
    let outside = expect(depth.outside, &[away], "outside");
    close(outside.percentile_95, 0.0625 * strength, "95 % outside");
    expect(depth.everywhere, &[core, inner, outer, away], "everywhere");
}

#[test]
fn depth_errors_are_those_added_up_by_hand() {
    let report = MadeUp::new().evaluate().report;
    assert_eq!((report.frames, report.deepest_frame, report.region), (3, 2, [0, 0, WIDTH, HEIGHT]));
    assert_eq!(report.fields, ["flow", "depth", "force"]);
    assert_eq!(report.notes, Vec::<String>::new());
    for (frame, strength) in [(1, 0.5), (2, 1.0)] {
        expect_depth(&report.per_frame[frame].errors.depth_mm.unwrap(), strength);
    }
    // Of the mean over frames, the region inside contact has two, the one outside three.
    let mean = report.mean.depth_mm.unwrap();
    let inside = (CORE * 0.125 + INNER * 0.5) / 400.0;
    close(mean.inside.unwrap().mean, 0.75 * inside, "mean inside over two frames");
    close(mean.outside.unwrap().percentile_95, 0.0625 * (0.0 + 0.5 + 1.0) / 3.0, "mean outside over three frames");
    close(mean.everywhere.unwrap().true_peak, 1.0, "mean of the peaks");
    close(report.peak_depth_correlation.unwrap(), 1.0, "both peaks go with the press");
}

#[test]
fn figures_over_all_frames_are_those_of_their_pixels_at_once() {
    let report = MadeUp::new().evaluate().report;
    let pooled = report.pooled.depth_mm.unwrap();
    let inside = pooled.inside.unwrap();
    assert_eq!(inside.pixels, 800);
    close(inside.mean, 0.75 * (CORE * 0.125 + INNER * 0.5) / 400.0, "mean");
    let squares = (1.0 + 0.25) * (CORE * 0.125_f64.powi(2) + INNER * 0.25);
    close(inside.root_mean_square, (squares / 800.0).sqrt(), "rms");
    // 256 of 800 errors are 0.5, so is the 95th percentile; outside, two thirds are below the largest of the three.
    assert!((inside.percentile_95 / 0.5 - 1.0).abs() < 1.0 / 4096.0, "{}", inside.percentile_95);
    close(pooled.border.unwrap().largest, 0.5, "largest");
    close(inside.correlation.unwrap(), pooled_correlation(), "correlation");
    let FieldPixels { compared, hidden, not_valid } = FieldPixels::of_a_frame();
    assert_eq!(
        report.pooled.pixels.everywhere.unwrap(),
        PixelCounts { compared: 3 * compared, hidden: 3 * hidden, not_valid: 3 * not_valid }
    );
}

/// Pearson's correlation inside contact of the two frames that have it, from its definition.
fn pooled_correlation() -> f64 {
    let pairs = [0.5, 1.0].into_iter().flat_map(|s| {
        [(CORE, 1.875 * s, 2.0 * s), (INNER, 1.5 * s, 2.0 * s)].map(|(n, estimate, truth)| (n, estimate, truth))
    });
    let pairs: Vec<_> = pairs.collect();
    let mean = |value: fn(&(f64, f64, f64)) -> f64| pairs.iter().map(|pair| pair.0 * value(pair)).sum::<f64>() / 800.0;
    let (x, y) = (mean(|pair| pair.1), mean(|pair| pair.2));
    let (xx, yy, xy) = (mean(|p| p.1 * p.1) - x * x, mean(|p| p.2 * p.2) - y * y, mean(|p| p.1 * p.2) - x * y);
    xy / (xx * yy).sqrt()
}

struct FieldPixels {
    compared: u64,
    hidden: u64,
    not_valid: u64,
}

impl FieldPixels {
    fn of_a_frame() -> Self {
        let pixels = || (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
        let hidden = pixels().filter(|&(x, y)| is_hidden(x, y)).count() as u64;
        let not_valid = pixels().filter(|&(x, y)| is_invalid(x, y)).count() as u64;
        Self { compared: (WIDTH * HEIGHT) as u64 - hidden - not_valid, hidden, not_valid }
    }
}

#[test]
fn flow_errors_are_distances() {
    let report = MadeUp::new().evaluate().report;
    let errors = report.deepest().unwrap().errors;
    let flow = errors.flow_px.unwrap();
    // Inside (0.375, −0.5) px of (3, 4) px, elsewhere none.
    let (inside, everywhere) = (flow.inside.unwrap(), flow.everywhere.unwrap());
    close(inside.mean, 0.625, "mean inside");
    close(inside.percentile_95, 0.625, "95 % inside");
    close(inside.true_peak, 5.0, "longest true flow");
    close(inside.bias, 3.375_f64.hypot(3.5) - 5.0, "lengths");
    close(flow.outside.unwrap().largest, 0.0, "outside");
    let compared = CORE + INNER + OUTER + AWAY;
    close(everywhere.mean, 400.0 * 0.625 / compared, "mean everywhere");
    assert_eq!(errors.pixels.everywhere.unwrap(), PixelCounts { compared: compared as u64, hidden: 40, not_valid: 29 });
}

#[test]
fn forces_are_compared_by_component() {
    let report = MadeUp::new().evaluate().report;
    let force = report.force.unwrap();
    close(force.true_peak_n, 5.0, "peak");
    let [x, y, z] = force.mean_n.map(Option::unwrap);
    close(x, 0.5, "mean of 0.5 and 0.5; the first cell is empty");
    close(y, 0.25, "mean along y");
    close(z, (0.5 + 1.0 + 1.0) / 3.0, "mean along z");
    close(force.mean_of_peak[2].unwrap(), z / 5.0, "of the peak");
    assert_eq!(force.largest_n, [Some(0.5), Some(0.25), Some(1.0)]);
    let frames: Vec<_> = report.per_frame.iter().map(|frame| frame.force.unwrap()).collect();
    assert_eq!(frames[0].error_n, [None, None, Some(0.5)]);
    assert_eq!(frames[2].error_n, [Some(-0.5), Some(-0.25), Some(1.0)]);
    assert_eq!(frames[2].of_peak, [Some(-0.1), Some(-0.05), Some(0.2)]);
}

#[test]
fn displacement_and_contact_are_compared_where_the_run_has_them() {
    let made_up = MadeUp::new();
    made_up.array("run/displacement.npy", |s, x, y| {
        let value = |value: f32| if is_invalid(x, y) { f32::NAN } else { s * value };
        [value(1.5), value(-0.25), value(2.0)]
    });
    // Two columns too many on the left, one too few on the right.
    made_up.array("run/contact.npy", |s, x, y| u8::from(s > 0.0 && (8..29).contains(&x) && (5..25).contains(&y)));
    let report = made_up.evaluate().report;
    assert_eq!(report.fields, ["flow", "depth", "displacement", "contact", "force"]);
    let errors = report.deepest().unwrap().errors;
    let displacement = errors.displacement_mm.unwrap();
    let (x, y, z) = (displacement.x.unwrap(), displacement.y.unwrap(), displacement.z.unwrap());
    close(x.bias, 0.5, "x");
    close(y.bias, -0.25, "y");
    close(y.mean, 0.25, "y");
    close(z.largest, 0.0, "z");
    close(errors.contact_overlap.unwrap(), 19.0 / 22.0, "overlap");
    assert_eq!(report.per_frame[0].errors.contact_overlap, None, "nothing is touched in the first frame");
    close(report.pooled.contact_overlap.unwrap(), 19.0 / 22.0, "overlap of all frames");
    close(report.mean.displacement_mm.unwrap().x.unwrap().mean, 0.25, "mean over frames");
}

#[test]
fn depth_with_a_mask_of_its_own_is_compared_where_that_holds() {
    let made_up = MadeUp::new();
    made_up.array("run/depth.npy", |s, x, y| s * (true_depth(x, y) + depth_error(x, y)));
    // Not trusted as flow, in contact; depth holds everywhere but in the last column.
    made_up.array("run/valid.npy", |_, x, y| u8::from(!(is_invalid(x, y) || y == 6 && (10..30).contains(&x))));
    made_up.array("run/depth_valid.npy", |_, x, _| u8::from(x + 1 < WIDTH));
    let errors = made_up.evaluate().report.deepest().unwrap().errors;
    let counts = |compared, hidden, not_valid| Some(PixelCounts { compared, hidden, not_valid });
    assert_eq!(errors.pixels.everywhere, counts(1200 - 89, 40, 49));
    assert_eq!(errors.depth_pixels.unwrap().everywhere, counts(1200 - 69, 40, 29));
    assert_eq!(errors.flow_px.unwrap().inside.unwrap().pixels, 380);
    assert_eq!(errors.depth_mm.unwrap().inside.unwrap().pixels, 400);
    let where_valid = errors.depth_where_valid_mm.unwrap();
    assert_eq!(where_valid.inside.unwrap().pixels, 380);
    close(where_valid.inside.unwrap().largest, 0.5, "largest");
    assert_eq!(where_valid.everywhere.unwrap().pixels, 1200 - 89 - 29);
}

#[test]
fn excluded_pixels_are_counted_by_region() {
    let made_up = MadeUp::new();
    // In contact, near its border: a row of 20 px that the run does not trust.
    made_up.array("run/valid.npy", |_, x, y| u8::from(!(is_invalid(x, y) || y == 6 && (10..30).contains(&x))));
    let report = made_up.evaluate().report;
    let pixels = report.deepest().unwrap().errors.pixels;
    let counts = |compared, hidden, not_valid| Some(PixelCounts { compared, hidden, not_valid });
    assert_eq!(pixels.inside, counts(380, 0, 20));
    assert_eq!(pixels.border, counts(600, 0, 20));
    assert_eq!(pixels.outside, counts(436 - 69, 40, 29));
    assert_eq!(pixels.everywhere, counts(1200 - 89, 40, 49));
    assert_eq!(report.per_frame[0].errors.pixels.border, None, "nothing is touched in the first frame");
    assert_eq!(report.mean.pixels.inside, counts(760, 0, 40));
    assert_eq!(report.pooled.pixels, report.mean.pixels);
}
