//! Presses that are solved once for all tests.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use fingervision_gel::{PressCache, Simulation};

/// Solves a press, or takes it from the presses solved before. One at a time: two tests do not solve the same.
pub(crate) fn solve(simulation: &mut Simulation) {
    static SOLVING: Mutex<()> = Mutex::new(());
    let _solving = SOLVING.lock().unwrap_or_else(PoisonError::into_inner);
    let cache = PressCache::at(Path::new(env!("CARGO_TARGET_TMPDIR")).join("presses"));
    simulation.solve(&cache, &mut |_| ControlFlow::Continue(())).unwrap();
}
