//! Frames and truth by their conventions.

use super::*;
use crate::render::FrameRenderer;
use crate::{MotionBlur, RenderError, TruthProjector};
use fingervision_image::Pixels;

fn renderer(params: &RenderParams) -> FrameRenderer {
    FrameRenderer::new(params, &camera(params.width, params.height), &texture()).unwrap()
}

/// A pattern of one grey.
fn plain(level: f32) -> Texture {
    Texture::new(Image::filled(1, 1, [level; 3]), [1.0; 2], 0.0)
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_every_run_and_thread() {
    let params = params(48, 36);
    let states: Vec<_> = (0..6).map(|k| surface(14, |x, y| bump(x, y).map(|mm| 0.2 * f64::from(k) * mm))).collect();
    let in_turn: Vec<Pixels> = {
        let mut renderer = renderer(&params);
        (0..).zip(&states).map(|(frame, state)| renderer.render(state, frame).unwrap().clone()).collect()
    };
    let of_thread = |first: usize| {
        let mut renderer = renderer(&params);
        let frames = (first..states.len()).step_by(2);
        frames.map(|frame| renderer.render(&states[frame], frame as u64).unwrap().clone()).collect::<Vec<_>>()
    };
    let [even, odd] = std::thread::scope(|scope| {
        [0, 1].map(|first| scope.spawn(move || of_thread(first))).map(|thread| thread.join().unwrap())
    });
    for frame in 0..states.len() {
        assert_eq!(in_turn[frame], [&even, &odd][frame % 2][frame / 2], "frame {frame}");
    }
    let other = RenderParams { seed: 2, ..params };
    assert_ne!(in_turn[0], *renderer(&other).render(&states[0], 0).unwrap());
    assert_ne!(in_turn[0], *renderer(&params).render(&states[0], 1).unwrap());
}

#[test]
fn a_frame_allocates_nothing_once_the_first_is_drawn() {
    let still = MotionBlur { sub_frames: 2, ..MotionBlur::default() };
    let mut renderer = renderer(&RenderParams { motion_blur: still, ..params(48, 36) });
    let mut projector = TruthProjector::new(&camera(48, 36), 48, 36);
    let states: Vec<_> =
        (0..4).map(|k| surface(24, |x, y| mushroom(x, y).map(|mm| (1.0 - 0.2 * f64::from(k)) * mm))).collect();
    renderer.render(&states[0], 0).unwrap();
    projector.project(&states[0]).unwrap();
    let allocations = allocation_counter::measure(|| {
        for pair in states.windows(2) {
            renderer.render_moving(&pair[0], &pair[1], 1).unwrap();
            projector.project(&pair[1]).unwrap();
        }
    });
    assert_eq!(allocations.count_total, 0, "{allocations:?}");
}

#[test]
fn beside_the_gel_there_is_background_and_no_truth() {
    let params = RenderParams { noise_levels: 0.0, vignetting: 0.0, background: [7, 8, 9], ..params(90, 70) };
    let mut renderer = renderer(&params);
    let state = surface(10, |_, _| [0.0; 3]);
    let Pixels::Rgb8(image) = renderer.render(&state, 0).unwrap() else { panic!("colour was asked for") };
    let mut projector = TruthProjector::new(&camera(90, 70), 90, 70);
    let truth = projector.project(&state).unwrap();
    // The gel is 60 by 50 px wide, the blur reaches 3 px.
    for (x, y) in (0..90).flat_map(|x| (0..70).map(move |y| (x, y))) {
        let is_gel = (15..75).contains(&x) && (10..60).contains(&y);
        let is_beside = !(11..79).contains(&x) || !(6..64).contains(&y);
        assert!(!is_beside || image.at(x, y) == [7, 8, 9], "({x}, {y})");
        assert_eq!(truth.depth.at(x, y).is_nan(), !is_gel, "({x}, {y})");
        assert_eq!(truth.flow.at(x, y).iter().all(|flow| flow.is_nan()), !is_gel);
        assert_eq!(truth.displacement.at(x, y).iter().all(|value| value.is_nan()), !is_gel);
        assert_eq!(truth.visible.at(x, y) == 1, is_gel);
        assert_eq!(truth.contact.at(x, y), 0);
    }
    assert!(image.at(45, 35).iter().map(|&level| u32::from(level)).sum::<u32>() > 60);
}

#[test]
fn the_slope_that_faces_the_near_lamps_is_brighter() {
    let params = RenderParams { vignetting: 0.0, shading: 0.15, ..params(60, 50) };
    let mut renderer = FrameRenderer::new(&params, &camera(60, 50), &plain(100.0)).unwrap();
    // A ridge along y right of the middle: its right side faces the lamps that are near.
    let ridge = |x: f64, _: f64| [0.0, 0.0, 0.5 * (-4.0 * (x - 1.5).powi(2)).exp()];
    let levels = renderer.render_levels(&surface(24, ridge)).unwrap();
    let at = |x_mm: f64| levels.at((29.5 + 10.0 * x_mm).round() as usize, 25)[0];
    assert!(at(2.0) > at(1.0) + 0.5, "{} right, {} left of the ridge", at(2.0), at(1.0));
    let inside = levels.rows().skip(4).take(42).flat_map(|row| &row[4..56]);
    assert!(inside.flatten().all(|level| (84.9..=115.1).contains(level)));
}

#[test]
fn grey_frames_are_the_luma_of_colour_frames() {
    let params = RenderParams { noise_levels: 0.0, ..params(40, 30) };
    let state = surface(12, bump);
    let colour = renderer(&params).render_levels(&state).unwrap().clone();
    let mut renderer = renderer(&RenderParams { colour: false, ..params });
    let Pixels::Grey8(grey) = renderer.render(&state, 0).unwrap() else { panic!("grey was asked for") };
    for (grey, [red, green, blue]) in grey.values().iter().zip(colour.values()) {
        let luma = 0.299 * red + 0.587 * green + 0.114 * blue;
        assert!((f32::from(*grey) - luma).abs() < 0.52, "{grey}, luma {luma}");
    }
}

#[test]
fn a_blurred_motion_is_the_mean_of_the_way() {
    let blurred = MotionBlur { sub_frames: 8, exposure: 1.0 };
    let params = RenderParams { noise_levels: 0.0, motion_blur: blurred, ..params(40, 30) };
    let moved = |mm: f64| surface(8, move |_, _| [mm, 0.0, 0.0]);
    let mut renderer = renderer(&params);
    let mut expected = vec![0.0; 3 * 40 * 30];
    for k in 0..8 {
        // From 0.1 to 0.2 mm in a frame, so from 0.15 to 0.25 mm while the shutter is open.
        let levels = renderer.render_levels(&moved(0.15 + 0.1 * (f64::from(k) + 0.5) / 8.0)).unwrap();
        expected.iter_mut().zip(levels.values().as_flattened()).for_each(|(sum, level)| *sum += level / 8.0);
    }
    let Pixels::Rgb8(image) = renderer.render_moving(&moved(0.1), &moved(0.2), 0).unwrap() else { panic!("colour") };
    for (byte, expected) in image.values().as_flattened().iter().zip(expected) {
        assert!((f32::from(*byte) - expected).abs() < 0.51, "{byte}, expected {expected}");
    }
}

#[test]
fn contact_is_where_half_of_the_nodes_around_have_it() {
    let mut state = surface(4, |_, _| [0.0, 0.0, 0.1]);
    state.in_contact[2 * 5 + 2] = true;
    let mut projector = TruthProjector::new(&camera(60, 50), 60, 50);
    let truth = projector.project(&state).unwrap();
    // The lines next to the middle's lie at 1.2 and 1 mm; half-way the share along one axis is ½.
    assert_eq!([truth.contact.at(29, 25), truth.contact.at(34, 25), truth.contact.at(37, 25)], [1, 1, 0]);
    assert!((truth.depth.at(29, 25) - 0.1).abs() < 1e-7);
}

#[test]
fn cells_beyond_memory_are_refused() {
    let fine = Texture::new(Image::filled(1, 1, [50.0; 3]), [1e-4; 2], 0.0);
    let mut renderer = FrameRenderer::new(&params(8, 8), &camera(8, 8), &fine).unwrap();
    let error = renderer.render(&surface(4, |_, _| [0.0; 3]), 0).unwrap_err();
    assert!(matches!(error, RenderError::TooManyCells { count, .. } if count > 3e9), "{error}");
}

#[test]
fn a_surface_behind_the_camera_is_not_seen() {
    let params = RenderParams { noise_levels: 0.0, vignetting: 0.0, ..params(20, 16) };
    let levels = renderer(&params).render_levels(&surface(4, |_, _| [0.0, 0.0, 12.0])).unwrap().clone();
    assert!(levels.values().iter().flatten().all(|level| (level - 10.0).abs() < 1e-3));
    let mut projector = TruthProjector::new(&camera(20, 16), 20, 16);
    let truth = projector.project(&surface(4, |_, _| [0.0, 0.0, 12.0])).unwrap();
    assert!(truth.visible.values().iter().all(|&visible| visible == 0) && truth.flow.at(3, 3)[0].is_nan());
    assert!((truth.depth.at(3, 3) - 12.0).abs() < 1e-6);
}

#[test]
fn an_invalid_surface_is_refused() {
    let mut renderer = renderer(&params(8, 8));
    let state = surface(4, |_, _| [0.0; 3]);
    let mut torn = state.clone();
    torn.displacement_mm[7][1] = f64::NAN;
    let error = renderer.render(&torn, 0).unwrap_err();
    assert!(error.to_string().starts_with("the surface's displacement at x = 0 mm, y = -1"), "{error}");
    let mut short = state.clone();
    short.displacement_mm.pop();
    let error = renderer.render(&short, 0).unwrap_err();
    assert_eq!(error.to_string(), "the surface has 24 values of displacement: its grid of 5x5 lines has 25 nodes");
    let mut crossed = state.clone();
    crossed.y_mm.swap(1, 2);
    assert!(matches!(renderer.render(&crossed, 0), Err(RenderError::GridLines { axis: 'y', count: 5 })));
    let other = surface(5, |_, _| [0.0; 3]);
    assert_eq!(renderer.render_moving(&other, &state, 0), Err(RenderError::OtherGrid));
    assert_eq!(
        TruthProjector::new(&camera(8, 8), 8, 8).project(&torn).map(|_| ()),
        Err(renderer.render(&torn, 0).unwrap_err())
    );
}
