//! Contact that is dragged along the surface: depth and force are those of the press.

use fingervision_touch::{ElasticFields, ElasticMode};

use crate::press::{Press, close};

/// A ball that is pressed down until frame 2 and dragged until frame 4.
const BALL: &str = "shape = 'sphere'\nradius_mm = 12.0";
const DRAG: &str = "keyframes = [{ at = 2, depth_mm = 0.8 }, { at = 4, shear_mm = [1.5, 0.0] }]";

#[test]
fn shear_force_is_found_from_a_face_that_is_dragged() {
    let motion = "keyframes = [{ at = 2, depth_mm = 1.0 }, { at = 4, shear_mm = [1.0, 0.0] }]";
    let press = Press::new("shape = 'rectangle'\nsize_mm = [6.0, 6.0]", "stick", motion);
    let mut inverse = press.inverse(ElasticMode::Exact);
    let fields = inverse.solve(&press.flow, &press.deviation, &press.valid);
    let force = fields.force_n.unwrap();
    assert!(close(force[0], press.force_n[0], 0.1), "{force:?} {:?}", press.force_n);
    assert!(close(force[2], press.force_n[2], 0.1), "{force:?} {:?}", press.force_n);
    assert!(!fields.is_beyond_linear, "the depth of a face that sticks does not depend on shear");
    let (error_mm, overlap) = press.judge(fields);
    assert!(error_mm < 0.01 && overlap > 0.8, "{error_mm} mm, {overlap}");
}

#[test]
fn a_ball_that_is_dragged_is_not_taken_for_a_deeper_one() {
    let press = Press::new(BALL, "stick", DRAG);
    let mut exact = press.inverse(ElasticMode::Exact);
    let fields = exact.solve(&press.flow, &press.deviation, &press.valid);
    assert!(fields.is_beyond_linear, "shear that is large relative to the depth");
    let (error_mm, overlap) = press.judge(fields);
    assert!(error_mm < 0.009 && overlap > 0.7, "{error_mm} mm, {overlap}");
    let mut live = press.inverse(ElasticMode::Live);
    for _ in 0..8 {
        live.solve(&press.flow, &press.deviation, &press.valid);
    }
    let (error_mm, _) = press.judge(live.fields());
    assert!(error_mm < 0.010, "{error_mm} mm");
}

#[test]
fn a_ball_that_sticks_keeps_its_depth_while_it_is_dragged() {
    let [pressed, dragged] = Press::frames(BALL, "stick", DRAG, [2, 4]);
    // At the rim, contact itself is uncertain.
    let inside_mm = |press: &Press, fields: &ElasticFields| {
        let depths = fields.depth_mm.values().iter().zip(press.depth_mm.values()).filter(|(_, truth)| **truth > 0.4);
        depths.clone().map(|(found, truth)| f64::from((found - truth).abs())).sum::<f64>() / depths.count() as f64
    };
    for mode in [ElasticMode::Exact, ElasticMode::Live] {
        let mut alone = dragged.inverse(mode);
        let alone_mm = inside_mm(&dragged, alone.solve(&dragged.flow, &dragged.deviation, &dragged.valid));
        let mut inverse = dragged.inverse(mode);
        let before_mm = inside_mm(&pressed, inverse.solve(&pressed.flow, &pressed.deviation, &pressed.valid));
        let fields = inverse.solve(&dragged.flow, &dragged.deviation, &dragged.valid);
        let followed_mm = inside_mm(&dragged, fields);
        assert!(
            followed_mm < before_mm + 0.005 && followed_mm < 0.7 * alone_mm,
            "{mode:?}: {followed_mm} mm, before {before_mm}, alone {alone_mm}"
        );
        let force_n = fields.force_n.unwrap();
        assert!(close(force_n[2], dragged.force_n[2], 0.12), "{mode:?}: {force_n:?} of {:?}", dragged.force_n);
        // What was known before is forgotten.
        inverse.restart();
        let again_mm = inside_mm(&dragged, inverse.solve(&dragged.flow, &dragged.deviation, &dragged.valid));
        assert!((again_mm - alone_mm).abs() < 1e-12, "{mode:?}: {again_mm} mm after a restart, {alone_mm} mm alone");
    }
}

#[test]
fn a_ball_that_slips_while_it_is_dragged_is_not_taken_for_a_deeper_one() {
    let motion = "keyframes = [{ at = 2, depth_mm = 0.6 }, { at = 4, shear_mm = [0.7, 0.5] }]";
    let ball = "shape = 'sphere'\nradius_mm = 7.5\n[gel]\npoissons_ratio = 0.4";
    let frames = Press::frames(ball, "{ friction = 0.3 }", motion, [2, 4]);
    for mode in [ElasticMode::Exact, ElasticMode::Live] {
        let mut inverse = frames[0].inverse(mode);
        for press in &frames {
            let force_n = inverse.solve(&press.flow, &press.deviation, &press.valid).force_n.unwrap();
            assert!(close(force_n[2], press.force_n[2], 0.11), "{mode:?}: {force_n:?} of {:?}", press.force_n);
        }
        let part = inverse.cells().without_drag.map_or(0.0, |without_drag| without_drag.part);
        assert_eq!(part.to_bits(), 1.0_f32.to_bits(), "{mode:?}: slipping contact is dragged, too");
    }
}

#[test]
fn shear_is_subtracted_only_where_there_is_any_and_dragged_frames_do_not_allocate() {
    let frames = Press::frames(BALL, "stick", DRAG, [2, 4]);
    let mut inverse = frames[0].inverse(ElasticMode::Exact);
    let mut parts = [0.0; 2];
    for (press, part) in frames.iter().zip(&mut parts) {
        inverse.solve(&press.flow, &press.deviation, &press.valid);
        *part = inverse.cells().without_drag.map_or(0.0, |without_drag| without_drag.part);
    }
    assert_eq!(parts.map(f32::to_bits), [0.0, 1.0].map(f32::to_bits), "{parts:?}");
    // What was subtracted is a motion along x that decreases away from contact.
    let grid = inverse.cells().grid;
    let dragged_mm =
        inverse.cells().without_drag.map(|without_drag| without_drag.dragged_mm[grid.len() / 2 + grid.columns / 2]);
    assert!(dragged_mm.is_some_and(|[x, y, _]| x > 1.2 && x < 1.6 && y.abs() < 0.1), "{dragged_mm:?} mm");
    let dragged = &frames[1];
    let allocations = allocation_counter::measure(|| {
        inverse.solve(&dragged.flow, &dragged.deviation, &dragged.valid);
    });
    assert_eq!(allocations.count_total, 0, "{allocations:?}");
    inverse.restart();
    assert!(inverse.cells().without_drag.is_none(), "after a restart");
}
