//! Threads that share the work of a frame.

use std::panic::{AssertUnwindSafe, catch_unwind};

use fingervision_flow::{Estimate, FlowEstimator, FlowHistory, FlowParams, Start, Team};
use fingervision_image::{Image, Pixels, Rect};

const SIZE: (usize, usize) = (163, 125);

/// A random pattern in which a bump has moved by up to `peak` px.
fn frame(peak: f32) -> Pixels {
    let level = |x: f32, y: f32, channel: f32| {
        let wave = |k: f32| (x * (0.31 + 0.11 * k) + y * (0.83 - 0.17 * k) + 7.0 * k * k + channel).sin();
        128.0 + 20.0 * (0..6).map(|k| wave(k as f32) * wave(0.7 * k as f32 + 0.2)).sum::<f32>()
    };
    Pixels::Rgb8(Image::from_fn(SIZE.0, SIZE.1, |x, y| {
        let (x, y) = (x as f32, y as f32);
        let shift = peak * (-((x - 80.0).powi(2) + (y - 60.0).powi(2)) / 800.0).exp();
        [0.0, 1.0, 2.0].map(|channel| level(x - shift, y + 0.5 * shift, channel).clamp(0.0, 255.0) as u8)
    }))
}

/// The estimates of a press, frame by frame.
fn estimates(colour: bool, team: &Team) -> Vec<Estimate> {
    let params = FlowParams { colour, ..FlowParams::default() };
    let mut estimator = FlowEstimator::new(SIZE.0, SIZE.1, &params).unwrap();
    estimator.share(team);
    let (mut reference, mut picture) = (estimator.reference(), estimator.picture());
    let whole = Rect::whole(SIZE.0, SIZE.1);
    picture.load(&frame(0.0), whole).unwrap();
    estimator.prepare(&picture, &mut reference);
    let mut history = FlowHistory::at_rest(SIZE.0, SIZE.1);
    let of_peak = |peak: f32| {
        let mut out = Estimate::new(SIZE.0, SIZE.1);
        picture.load(&frame(peak), whole).unwrap();
        team.run(|| estimator.estimate(&reference, &picture, Start::History(&history), &mut out));
        history.push(&out.flow);
        out
    };
    [0.0, 0.6, 1.3, 3.0, 3.0, 4.5].map(of_peak).into()
}

#[test]
fn the_flow_has_the_same_bits() {
    let team = Team::new(8).unwrap();
    assert!(team.is_shared() && !Team::new(1).unwrap().is_shared());
    for colour in [false, true] {
        let pairs = estimates(colour, &team).into_iter().zip(estimates(colour, &Team::default()));
        for (number, (shared, alone)) in pairs.enumerate() {
            assert!(alone.matched > 0.8, "frame {number}: {} match", alone.matched);
            assert_eq!(shared.flow, alone.flow, "frame {number}, colour {colour}");
            assert_eq!(shared.deviation, alone.deviation, "frame {number}, colour {colour}");
            assert_eq!(shared.valid, alone.valid, "frame {number}, colour {colour}");
        }
    }
}

#[test]
fn works_that_share_a_team_wait_for_each_other() {
    // Long enough for the other thread to take a part.
    const LENGTH: u64 = 30_000;
    let team = Team::new(2).unwrap();
    let half = |first: u64| (first..first + LENGTH).map(std::hint::black_box).sum::<u64>();
    let work = || team.run(|| (0..20).map(|_| team.join(|| half(0), || half(LENGTH))).map(|(a, b)| a + b).sum::<u64>());
    // A work may contain another one.
    assert_eq!(team.run(work), 20 * half(0) + 20 * half(LENGTH));
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(|| (0..200).map(|_| work()).sum::<u64>())).collect();
        for thread in threads {
            assert_eq!(thread.join().unwrap(), 200 * 20 * (half(0) + half(LENGTH)));
        }
    });
}

#[test]
fn a_panic_leaves_no_thread_waiting() {
    let team = Team::new(2).unwrap();
    let panicked = catch_unwind(AssertUnwindSafe(|| team.run(|| -> u8 { panic!("on purpose") })));
    assert!(panicked.is_err());
    assert_eq!(team.run(|| team.join(|| 1, || 2)), (1, 2));
}
