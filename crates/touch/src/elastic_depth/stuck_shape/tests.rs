//! A ball that is pressed, then moves on: stuck, sliding, spreading, beside another object.

use super::super::rigid::tests::{show_at, surface};
use super::*;

const NOISE_MM: f64 = 0.003;
const THICKNESS_MM: f64 = 10.0;

/// Depth under a ball of radius 25 mm, 1 mm deep, mm.
fn depth_mm([x, y]: [f64; 2]) -> f64 {
    1.0 - (x * x + y * y) / 50.0
}

fn ball([x, y]: [f64; 2]) -> [f64; 3] {
    [x, y, depth_mm([x, y]).max(0.0)]
}

/// A surface, the shape of the ball on it, and contact as a network finds it.
struct Press {
    surface: Surface,
    shape: StuckShape,
    touches: Vec<bool>,
    depth_mm: Vec<f32>,
    deviation_mm: Vec<f32>,
}

impl Press {
    /// The ball is pressed straight down.
    fn new() -> Self {
        let mut surface = surface();
        show_at(&mut surface, ball);
        let centres = || (0..surface.seen.len()).map(|cell| surface.centre_mm(cell));
        let touches: Vec<_> = centres().map(|at| depth_mm(at) > 0.3).collect();
        let depth_mm: Vec<_> = centres().map(|at| ball(at)[2] as f32).collect();
        let mut shape = StuckShape::new(surface.grid);
        shape.take(&surface, &touches, &depth_mm, |_| 0.01);
        let deviation_mm = vec![0.05; depth_mm.len()];
        Self { surface, shape, touches, depth_mm, deviation_mm }
    }

    /// Contact moves on, with a network whose depth is wrong by a factor; returns whether it sticks.
    fn moves(&mut self, to: impl Fn([f64; 3]) -> [f64; 3], error: f32) -> bool {
        show_at(&mut self.surface, |rest| to(ball(rest)));
        for cell in 0..self.depth_mm.len() {
            self.depth_mm[cell] = error * ball(self.surface.centre_mm(cell))[2] as f32;
        }
        self.shape.begin();
        self.hold()
    }

    fn hold(&mut self) -> bool {
        let Self { surface, shape, touches, depth_mm, deviation_mm } = self;
        let inner: Vec<_> = (0..touches.len()).filter(|&cell| touches[cell]).collect();
        let whole_mm = depth_mm.clone();
        let contact = Contact { touches, inner: &inner, whole_mm: &whole_mm, depth_mm, deviation_mm };
        shape.hold(surface, contact, NOISE_MM, THICKNESS_MM, &mut Vec::new())
    }

    /// The largest error of the depth in contact, mm, if it is this much deeper than the ball was.
    fn error_mm(&self, deeper_mm: f64) -> f64 {
        let touched = (0..self.touches.len()).filter(|&cell| self.touches[cell]);
        let truth_mm = |cell: usize| depth_mm(self.surface.centre_mm(cell)) + deeper_mm;
        touched.map(|cell| (f64::from(self.depth_mm[cell]) - truth_mm(cell)).abs()).fold(0.0, f64::max)
    }
}

#[test]
fn contact_that_is_dragged_and_pressed_on_keeps_its_shape() {
    for deeper_mm in [-0.1, 0.0, 0.2] {
        let mut press = Press::new();
        assert!(press.moves(|[x, y, z]| [x + 1.2, y - 0.5, z + deeper_mm], 1.3));
        assert!(press.error_mm(deeper_mm) < 1e-3, "{} mm", press.error_mm(deeper_mm));
        let mut deviations = press.touches.iter().zip(&press.deviation_mm).filter(|(touches, _)| **touches);
        assert!(deviations.all(|(_, deviation)| (0.01..0.1).contains(deviation)));
    }
}

#[test]
fn contact_that_is_twisted_keeps_its_shape() {
    let (sin, cos) = 0.2_f64.sin_cos();
    let mut press = Press::new();
    assert!(press.moves(|[x, y, z]| [cos * x - sin * y, sin * x + cos * y, z], 1.2));
    assert!(press.error_mm(0.0) < 1e-3, "{} mm", press.error_mm(0.0));
}

#[test]
fn contact_that_slides_does_not_keep_its_shape_and_it_is_forgotten() {
    let slides = |[x, y, z]: [f64; 3]| [x + 0.5 + 0.03 * x, y + 0.02 * y * x, z];
    let sticks = |[x, y, z]: [f64; 3]| [x + 1.2, y, z];
    let mut press = Press::new();
    assert!(!press.moves(slides, 1.2) && (press.error_mm(0.0) - 0.2).abs() < 0.01, "the network's depth remains");
    assert!(press.moves(sticks, 1.2), "the frame before may have been wrong");
    assert!(!press.moves(slides, 1.2));
    press.shape.forget_if_slid();
    assert!(!press.moves(sticks, 1.2));
}

#[test]
fn contact_that_spreads_is_not_taken_for_deeper() {
    // In the image, 0.8 % looks like 0.2 mm in depth, with and without motion along the surface.
    for shift_mm in [0.0, 0.3, 1.2] {
        let mut press = Press::new();
        assert!(!press.moves(|[x, y, z]| [1.008 * x + shift_mm, 1.008 * y, z], 1.0), "moved by {shift_mm} mm");
    }
}

#[test]
fn another_object_keeps_its_depth_but_the_rim_of_the_same_one_does_not() {
    let mut press = Press::new();
    let cell_near = |press: &Press, [x, y]: [f64; 2]| {
        let away = |cell: usize| {
            let at = press.surface.centre_mm(cell);
            (at[0] - x).hypot(at[1] - y)
        };
        (0..press.touches.len()).min_by(|&a, &b| away(a).total_cmp(&away(b))).unwrap()
    };
    // The shape reaches 5.9 mm from its middle, and the box around it 12 cells of 1.25 mm farther.
    press.shape.columns_reached = [9, 14];
    press.shape.rows_reached = [9, 14];
    let [rim, beside] = [[6.9, 0.0], [14.0, 14.0]].map(|at| cell_near(&press, at));
    press.shape.rows_reached[1] -= REACH;
    show_at(&mut press.surface, |rest| {
        let [x, y, z] = ball(rest);
        [x + 1.2, y, z]
    });
    for cell in [rim, beside] {
        press.touches[cell] = true;
    }
    press.depth_mm.iter_mut().for_each(|depth_mm| *depth_mm *= 1.2);
    (press.depth_mm[rim], press.depth_mm[beside]) = (0.12, 0.12);
    let rim_mm = depth_mm(press.surface.centre_mm(rim));
    assert!(press.hold());
    let found_mm = press.depth_mm[rim];
    assert!((f64::from(found_mm) - rim_mm).abs() < 2e-3 && rim_mm < 0.08, "{found_mm} mm, it was {rim_mm}");
    assert!(press.deviation_mm[rim] > 0.05, "{} mm", press.deviation_mm[rim]);
    assert!((press.depth_mm[beside] - 0.12).abs() < 1e-6 && (press.deviation_mm[beside] - 0.05).abs() < 1e-6);
}

#[test]
fn contact_that_grows_keeps_its_shape_and_contact_elsewhere_does_not() {
    let sticks = |[x, y, z]: [f64; 3]| [x + 1.2, y, z];
    let mut press = Press::new();
    let cells = || 0..press.touches.len();
    let larger: Vec<_> = cells().map(|cell| depth_mm(press.surface.centre_mm(cell)) > -1.0).collect();
    let elsewhere: Vec<_> = cells().map(|cell| press.surface.centre_mm(cell)[0] > 9.0).collect();
    let first = press.touches.clone();
    press.touches = larger;
    press.moves(sticks, 1.2);
    press.shape.forget_if_slid();
    press.shape.begin();
    press.touches.clone_from(&first);
    assert!(press.moves(sticks, 1.2), "it grew, and did not slide");
    press.shape.begin();
    press.touches = elsewhere;
    assert!(!press.moves(sticks, 1.2));
    press.shape.forget_if_slid();
    press.shape.begin();
    press.touches = first;
    assert!(!press.moves(sticks, 1.2), "it moved away");
}

#[test]
fn nothing_is_known_after_a_press_or_some_lost_frames() {
    let sticks = |[x, y, z]: [f64; 3]| [x + 1.2, y, z];
    let mut press = Press::new();
    press.shape.skip();
    press.shape.skip();
    assert!(press.moves(sticks, 1.2));
    for _ in 0..MOST_SKIPPED_FRAMES {
        press.shape.skip();
    }
    assert!(!press.moves(sticks, 1.2));
    // Frames that were lost before the press do not count.
    let mut press = Press::new();
    for _ in 0..MOST_SKIPPED_FRAMES - 1 {
        press.shape.skip();
        press.shape.begin();
    }
    press.shape.skip();
    assert!(press.moves(sticks, 1.2));
    let mut press = Press::new();
    press.shape.forget();
    assert!(!press.moves(sticks, 1.2));
}
