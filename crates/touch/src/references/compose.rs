//! Composition of flows over an intermediate reference.

use fingervision_flow::Estimate;
use fingervision_image::Between;

/// Writes the flow from the first reference: `flow(x) = a(x) + b(x + a(x))`.
///
/// `a` leads from the first reference to an intermediate one and `b` from there to the current image. The deviations
/// add as variances; a pixel is valid where both flows are.
pub(crate) fn compose_into(a: &Estimate, b: &Estimate, out: &mut Estimate) {
    let (width, height) = a.flow.size();
    for y in 0..height {
        for x in 0..width {
            let (u, v) = (a.flow.u.at(x, y), a.flow.v.at(x, y));
            let point = (x as f32 + u, y as f32 + v);
            let (place, inside) = (Between::clamped(point, (width, height)), Between::inside(point, (width, height)));
            out.flow.u.row_mut(y)[x] = u + place.sample(&b.flow.u);
            out.flow.v.row_mut(y)[x] = v + place.sample(&b.flow.v);
            let (nearest_x, nearest_y) = place.nearest();
            let (first, second) = (a.deviation.at(x, y), b.deviation.at(nearest_x, nearest_y));
            let is_valid = inside.is_some() && a.valid.at(x, y) == 1 && b.valid.at(nearest_x, nearest_y) == 1;
            out.valid.row_mut(y)[x] = u8::from(is_valid);
            out.deviation.row_mut(y)[x] = if inside.is_some() { first.hypot(second) } else { f32::INFINITY };
        }
    }
    out.matched = b.matched;
    out.residual_levels = b.residual_levels;
    out.unexplained = b.unexplained;
    out.lost_px2 = b.lost_px2;
    out.is_motion_blurred = b.is_motion_blurred;
}

#[cfg(test)]
mod tests {
    use super::*;
    use fingervision_flow::FlowField;
    use fingervision_image::Image;

    /// Writes the plain sum of two flows, as if both belonged to the same points; used only for comparison.
    fn add_into(a: &FlowField, b: &FlowField, out: &mut FlowField) {
        for ((out, a), b) in [(&mut out.u, &a.u), (&mut out.v, &a.v)].into_iter().zip([&b.u, &b.v]) {
            for ((out, a), b) in out.values_mut().iter_mut().zip(a.values()).zip(b.values()) {
                *out = a + b;
            }
        }
    }

    /// The flow of a stretch by `s` about the image centre.
    fn stretch(s: f32) -> Estimate {
        let mut estimate = Estimate::new(80, 60);
        estimate.flow.u = Image::from_fn(80, 60, |x, _| (s - 1.0) * (x as f32 - 39.5));
        estimate.flow.v = Image::from_fn(80, 60, |_, y| (s - 1.0) * (y as f32 - 29.5));
        estimate.valid = Image::filled(80, 60, 1);
        estimate.deviation = Image::filled(80, 60, 0.01);
        estimate
    }

    #[test]
    fn two_stretches_compose_to_their_product_where_a_sum_falls_short() {
        let (a, b) = (stretch(1.2), stretch(1.25));
        let mut composed = Estimate::new(80, 60);
        compose_into(&a, &b, &mut composed);
        let mut added = FlowField::zero(80, 60);
        add_into(&a.flow, &b.flow, &mut added);
        let truth = stretch(1.5);
        for (x, y) in [(39, 29), (55, 20), (25, 40)] {
            let error = composed.flow.u.at(x, y) - truth.flow.u.at(x, y);
            assert!(error.abs() < 1e-4, "({x}, {y}): off by {error}");
        }
        let short = truth.flow.u.at(55, 20) - added.u.at(55, 20);
        assert!(short > 0.7, "the sum misses only {short} px");
    }

    #[test]
    fn a_point_that_left_the_intermediate_image_is_invalid() {
        let (a, b) = (stretch(1.2), stretch(1.0));
        let mut composed = Estimate::new(80, 60);
        compose_into(&a, &b, &mut composed);
        assert_eq!((composed.valid.at(2, 30), composed.valid.at(40, 30)), (0, 1));
        assert!(composed.deviation.at(2, 30).is_infinite());
        assert!((composed.deviation.at(40, 30) - 0.01 * 2.0_f32.sqrt()).abs() < 1e-6);
    }
}
