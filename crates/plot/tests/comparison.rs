//! The picture of estimated fields beside true ones.

use fingervision_flow::FlowField;
use fingervision_image::Image;
use fingervision_plot::{Comparison, FramePlot, INVALID_COLOUR, Pair};

/// A round press: truth and estimate.
struct Press {
    truth: Image<f32>,
    estimate: Image<f32>,
    true_flow: FlowField,
    estimated_flow: FlowField,
    seen: Image<u8>,
    valid: Image<u8>,
    contact: Image<u8>,
    plots: Vec<FramePlot>,
}

impl Press {
    fn of(width: usize, height: usize) -> Self {
        let centre = ((width - 1) as f32 / 2.0, (height - 1) as f32 / 2.0);
        let radius = 0.3 * height as f32;
        let place = |x: usize, y: usize| ((x as f32 - centre.0) / radius, (y as f32 - centre.1) / radius);
        let depth = |width: f32| {
            move |x, y| {
                let (x, y) = place(x, y);
                2.0 / (1.0 + (x * x + y * y).powf(2.0 * width)) - 0.1 * (-(x.hypot(y) - 1.7).powi(2)).exp()
            }
        };
        let flow = |size: f32| {
            let along = move |t: f32, x: f32, y: f32| size * t * (-(x * x + y * y)).exp();
            let u = Image::from_fn(width, height, |i, j| along(place(i, j).0, place(i, j).0, place(i, j).1));
            let v = Image::from_fn(width, height, |i, j| along(place(i, j).1, place(i, j).0, place(i, j).1));
            FlowField { u, v }
        };
        let frames = |size: f32| (0..21u8).map(|frame| size * f32::from(frame)).collect::<Vec<_>>();
        let with_gap = frames(0.03).into_iter().map(|value| if value < 0.1 { f32::NAN } else { value }).collect();
        let depth_lines = vec![
            ("inside contact".into(), with_gap),
            ("within 1 mm of its border".into(), frames(0.02)),
            ("outside".into(), frames(0.001)),
        ];
        Self {
            truth: Image::from_fn(width, height, depth(2.0)),
            estimate: Image::from_fn(width, height, depth(1.0)),
            true_flow: flow(20.0),
            estimated_flow: flow(19.0),
            seen: Image::from_fn(width, height, |x, _| u8::from(x > 4)),
            valid: Image::from_fn(width, height, |_, y| u8::from(y > 4)),
            contact: Image::from_fn(width, height, |x, y| u8::from(place(x, y).0.hypot(place(x, y).1) < 1.0)),
            plots: vec![
                FramePlot { heading: "Mean absolute error of depth, mm".into(), lines: depth_lines },
                FramePlot { heading: "Flow error, px".into(), lines: vec![("mean".into(), frames(0.002))] },
            ],
        }
    }

    fn comparison(&self) -> Comparison<'_> {
        Comparison {
            title: "Frame 20, the deepest: 2.00 mm",
            facts: "21 frames",
            depth_mm: Some(Pair { truth: &self.truth, estimate: &self.estimate }),
            flow_px: Some(Pair { truth: &self.true_flow, estimate: &self.estimated_flow }),
            seen: &self.seen,
            valid: &self.valid,
            depth_valid: &self.valid,
            contact: Some(&self.contact),
            shown_frame: 20,
            plots: &self.plots,
        }
    }
}

#[test]
fn truth_estimate_and_difference_stand_side_by_side() {
    let press = Press::of(480, 480);
    let picture = press.comparison().draw();
    assert_eq!(picture.width(), 1600);
    let panel = |place: usize| 40 + 520 * place;
    let (left, top) = (2, 2);
    for (place, (x, y), name) in [
        (0, (left, 240), "truth is unseen at the left"),
        (1, (240, top), "the estimate is not valid at the top"),
        (2, (left, 240), "no difference where truth is unseen"),
        (2, (240, top), "no difference where the estimate is not valid"),
    ] {
        assert_eq!(picture.at(panel(place) + x, 152 + y), INVALID_COLOUR, "{name}");
    }
    let [red, _, blue] = picture.at(panel(0) + 240, 152 + 240);
    assert!(red > 150 && blue < 50, "a deep press is red");
    let border = picture.at(panel(0) + 240, 152 + 240 - 144);
    assert!(border.iter().all(|level| *level < 90), "the border of the contact is drawn: {border:?}");
    let [red, _, blue] = picture.at(panel(2) + 240, 152 + 240 - 125);
    assert!(blue > red, "too shallow at the edge is blue");
}

#[test]
fn what_is_absent_leaves_no_gap() {
    let press = Press::of(48, 36);
    let whole = press.comparison().draw().height();
    let depth_only = Comparison { flow_px: None, contact: None, ..press.comparison() }.draw().height();
    let flow_only = Comparison { depth_mm: None, ..press.comparison() }.draw().height();
    assert_eq!(depth_only, flow_only);
    assert!(whole > depth_only + 360, "{whole} and {depth_only}");
}

#[test]
fn odd_fields_can_be_drawn() {
    for (width, height) in [(1, 1), (300, 7), (7, 300)] {
        let mut press = Press::of(width, height);
        press.truth.values_mut().fill(f32::NAN);
        press.estimated_flow.fill(f32::INFINITY);
        press.seen.values_mut().fill(0);
        for plot in &mut press.plots {
            plot.lines.iter_mut().for_each(|(_, values)| values.fill(f32::NAN));
        }
        assert_eq!(press.comparison().draw().width(), 1600);
        press.plots.clear();
        assert_eq!(press.comparison().draw().width(), 1600);
    }
}
