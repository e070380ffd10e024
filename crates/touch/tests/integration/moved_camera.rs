//! A camera that moves slowly while nothing touches the gel, for example because its mount gets warm.

use fingervision_image::Frame;
use fingervision_touch::{Flags, Reading, Tracker};

use crate::elastic_tracking::Press;

/// From the camera to the gel at first, then 10 and 20 µm nearer.
const DISTANCES_MM: [f64; 3] = [25.0, 24.99, 24.98];
/// Frames at each distance, four a second: three seconds.
const FRAMES: usize = 12;
const LAST: usize = 8;
/// From frame to frame while the gel is pressed, s.
const FRAME_S: f64 = 1.0 / 90.0;

/// A ball that is pressed down in eight steps, seen from this distance, mm.
fn press(distance_mm: f64) -> Press {
    Press::new(&format!(
        "[camera]\ntranslation_mm = [0.0, 0.0, {distance_mm:?}]\n[gel]\npoissons_ratio = 0.48\n\
         [contact]\nlaw = 'frictionless'\n[indenter]\nshape = 'sphere'\nradius_mm = 6.0\n\
         [motion]\nframes = 9\nkeyframes = [{{ at = 8, depth_mm = 0.8 }}]"
    ))
}

/// Frames with increasing numbers and times.
struct Clock {
    sequence: u64,
    time_s: f64,
}

impl Clock {
    fn track<'a>(&mut self, tracker: &'a mut Tracker, frame: Frame, step_s: f64) -> &'a Reading {
        self.sequence += 1;
        self.time_s += step_s;
        tracker.track(&Frame { sequence: self.sequence, capture_time_s: self.time_s, ..frame }).unwrap()
    }
}

#[test]
fn depth_and_force_are_those_of_a_camera_that_does_not_move() {
    let mut moved = DISTANCES_MM.map(press);
    let (mut tracker, mut fresh) = (moved[0].tracker(), moved[2].tracker());
    let [mut clock, mut fresh_clock] = [(); 2].map(|()| Clock { sequence: 0, time_s: 0.0 });
    for press in &mut moved {
        for _ in 0..FRAMES {
            let reading = clock.track(&mut tracker, press.frame(0), 0.25);
            assert_eq!((reading.flags, reading.force_n), (Flags::default(), Some([0.0; 3])));
        }
    }
    fresh_clock.track(&mut fresh, moved[2].frame(0), FRAME_S);
    for pose in 1..=LAST {
        let expected = fresh_clock.track(&mut fresh, moved[2].frame(pose), FRAME_S);
        let found = clock.track(&mut tracker, moved[2].frame(pose), FRAME_S);
        assert_eq!(found.flags, expected.flags, "pose {pose}");
        let [found_n, expected_n] = [found, expected].map(|reading| reading.force_n.unwrap()[2]);
        assert!((found_n - expected_n).abs() < 0.03 * expected_n + 0.01, "pose {pose}: {found_n} N, not {expected_n}");
        let [found_mm, expected_mm] = [found, expected].map(|reading| reading.max_depth_mm.unwrap());
        assert!((found_mm - expected_mm).abs() < 0.02, "pose {pose}: {found_mm} mm, not {expected_mm}");
    }
}
