//! Computes the gel's surface in every frame of a scene: solved, or read from the cache.

use std::ops::ControlFlow;

use fingervision_elastic::{
    ContactLaw, ContinueCheck, GelBlock, Law, MeshParams, Pose, Press, PressError, PressSetup, Relief,
};
use fingervision_elastic::{SurfaceState, swept_region};
use serde::Serialize;

use super::cache::PressKey;
use super::{CacheError, MotionKind, PressCache, SCENE, Scene, SceneError, rigid};
use crate::Indenter;

/// Stands for the sources that decide how a press is solved; see the build script.
const SOLVER: &str = env!("FINGERVISION_SOLVER");

/// The gel's surface in every frame of a scene.
#[derive(Debug)]
#[non_exhaustive]
pub struct SolvedPress {
    /// One surface per frame, starting with the first; all frames unless it [ended early](SolvedPress::end).
    pub states: Vec<SurfaceState>,
    /// The origin of the surfaces.
    pub origin: Origin,
    /// Why there are fewer surfaces than frames, if there are.
    pub end: Option<EarlyEnd>,
    /// An error of the cache, if there was one; it does not affect the surfaces.
    pub cache_fault: Option<CacheError>,
}

/// The origin of the surfaces of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// They were solved.
    Solved,
    /// They were solved before.
    Cache,
    /// They are a rigid board's: there is nothing to solve.
    Rigid,
}

/// Why a press ended before its last frame.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EarlyEnd {
    /// The next pose has no solution that can be found.
    #[error(transparent)]
    Stalled(PressError),
    /// The caller stopped it.
    #[error("the press was interrupted")]
    Stopped,
}

impl EarlyEnd {
    /// What to do about it, where there is something to say.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Stalled(_) => {
                Some("press less deep, give the indenter a larger fillet_mm, or try another mesh.resolution".into())
            }
            Self::Stopped => None,
        }
    }
}

/// Called with the number of solved frames several times per frame; returns whether to continue.
pub type Progress<'a> = &'a mut (dyn FnMut(usize) -> ControlFlow<()> + Send);

/// All inputs that determine a solution, except the indenter's file and the solver.
#[derive(Serialize)]
struct Physics<'a> {
    law: Law,
    contact: ContactLaw,
    centre_mm: [f64; 2],
    gel: &'a GelBlock,
    mesh: MeshParams,
    indenter: &'a Indenter,
    poses: &'a [Pose],
}

impl Scene {
    /// The gel's surface in every frame: from the cache if this press was solved before, else solved and kept there.
    ///
    /// A press that cannot be solved to its end gives the frames before. An unusable cache costs time, not the
    /// solution. Runs on all cores; the surfaces are the same bits for any number of them.
    ///
    /// # Errors
    ///
    /// [`SceneError`] if the scene is impossible.
    pub fn solve(&self, cache: &PressCache, progress: Progress) -> Result<SolvedPress, SceneError> {
        self.validate()?;
        let poses = self.motion.poses();
        if self.motion.kind == MotionKind::Rigid {
            let states = rigid::surfaces(self.gel.size_mm, self.motion.centre_mm, &poses);
            return Ok(SolvedPress { states, origin: Origin::Rigid, end: None, cache_fault: None });
        }
        let relief = self.relief()?;
        let solver = |progress: Progress| self.press(&relief, &poses, progress);
        through(cache, &self.press_key(&poses)?, progress, solver)
    }

    /// Presses through all poses.
    fn press(&self, relief: &dyn Relief, poses: &[Pose], progress: Progress) -> Result<Course, SceneError> {
        let setup = PressSetup { block: self.gel, law: self.material.law, contact: self.contact.law };
        let centre_mm = self.motion.centre_mm;
        let mesh = self.mesh.mesh(&self.gel, &swept_region(relief, centre_mm, poses));
        let mut press = Press::new(&setup, mesh, relief, centre_mm)?;
        let rest = press.surface().clone();
        Ok(follow(rest, poses, progress, |pose, should_continue| press.step_while(pose, should_continue).cloned()))
    }

    fn press_key(&self, poses: &[Pose]) -> Result<PressKey, SceneError> {
        let (indenter, content) = self.indenter_by_content()?;
        let physics = Physics {
            law: self.material.law,
            contact: self.contact.law,
            centre_mm: self.motion.centre_mm,
            gel: &self.gel,
            mesh: self.mesh,
            indenter: &indenter,
            poses,
        };
        Ok(PressKey::of([SOLVER.as_bytes(), SCENE.to_text(&physics).as_bytes(), &content]))
    }
}

/// The surfaces so far, and why there are no more.
type Course = (Vec<SurfaceState>, Option<EarlyEnd>);

/// Goes from rest, the first pose, through the others.
fn follow(
    rest: SurfaceState,
    poses: &[Pose],
    progress: Progress,
    mut step: impl FnMut(&Pose, ContinueCheck) -> Result<SurfaceState, PressError>,
) -> Course {
    let mut states = vec![rest];
    for pose in poses.iter().skip(1) {
        if progress(states.len()).is_break() {
            return (states, Some(EarlyEnd::Stopped));
        }
        match step(pose, &mut || progress(states.len())) {
            Ok(state) => states.push(state),
            Err(PressError::Stopped) => return (states, Some(EarlyEnd::Stopped)),
            Err(error) => return (states, Some(EarlyEnd::Stalled(error))),
        }
    }
    // All is solved: there is nothing left to stop.
    let _ = progress(states.len());
    (states, None)
}

/// Looks into the cache, or solves and keeps.
fn through(
    cache: &PressCache,
    key: &PressKey,
    progress: Progress,
    solver: impl FnOnce(Progress) -> Result<Course, SceneError>,
) -> Result<SolvedPress, SceneError> {
    let mut cache_fault = match cache.load(key) {
        Ok(Some(states)) => return Ok(SolvedPress { states, origin: Origin::Cache, end: None, cache_fault: None }),
        Ok(None) => None,
        Err(fault) => Some(fault),
    };
    let (states, end) = solver(progress)?;
    if end.is_none()
        && let Err(fault) = cache.store(key, &states)
    {
        cache_fault.get_or_insert(fault);
    }
    Ok(SolvedPress { states, origin: Origin::Solved, end, cache_fault })
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::fs;

    use super::*;
    use crate::scene::stub::bump;

    /// A press of five frames that stalls at a frame, if it is given one; counts how often it was solved.
    fn solve(cache: &PressCache, solved: &Cell<usize>, stall_at: Option<usize>) -> SolvedPress {
        let poses: Vec<Pose> =
            (0..5).map(|frame| Pose { depth_mm: 0.1 * f64::from(frame), ..Pose::default() }).collect();
        let solver = |progress: Progress| {
            solved.set(solved.get() + 1);
            let mut frame = 0;
            Ok(follow(bump(0.0), &poses, progress, |pose, _| {
                frame += 1;
                let stalled = PressError::Stalled { reached_mm: 0.15, asked_mm: pose.depth_mm };
                if stall_at == Some(frame) { Err(stalled) } else { Ok(bump(pose.depth_mm)) }
            }))
        };
        through(cache, &PressKey::of([b"press".as_slice()]), &mut |_| ControlFlow::Continue(()), solver).unwrap()
    }

    #[test]
    fn a_press_is_solved_once() {
        let folder = tempfile::tempdir().unwrap();
        let (cache, solved) = (PressCache::at(folder.path()), Cell::new(0));
        let first = solve(&cache, &solved, None);
        let second = solve(&cache, &solved, None);
        assert_eq!((first.origin, second.origin, solved.get()), (Origin::Solved, Origin::Cache, 1));
        assert_eq!(first.states, second.states);
        assert_eq!(solve(&PressCache::OFF, &solved, None).origin, Origin::Solved);
    }

    #[test]
    fn a_damaged_entry_is_reported_and_solved_again() {
        let folder = tempfile::tempdir().unwrap();
        let (cache, solved) = (PressCache::at(folder.path()), Cell::new(0));
        let first = solve(&cache, &solved, None);
        let entry = fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap().path();
        let mut bytes = fs::read(&entry).unwrap();
        *bytes.last_mut().unwrap() ^= 1;
        fs::write(&entry, bytes).unwrap();
        let second = solve(&cache, &solved, None);
        assert!(matches!(second.cache_fault, Some(CacheError::Damaged { .. })));
        assert_eq!((second.origin, second.states), (Origin::Solved, first.states));
        assert_eq!(solve(&cache, &solved, None).origin, Origin::Cache, "the entry is whole again");
    }

    #[test]
    fn a_cache_that_cannot_be_written_costs_no_solution() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("taken");
        fs::write(&taken, "a file").unwrap();
        let press = solve(&PressCache::at(taken), &Cell::new(0), None);
        assert_eq!(press.states.len(), 5);
        assert!(matches!(press.cache_fault, Some(CacheError::Io { .. })));
    }

    #[test]
    fn a_press_that_stalls_keeps_the_frames_before_and_is_not_kept() {
        let folder = tempfile::tempdir().unwrap();
        let cache = PressCache::at(folder.path());
        let press = solve(&cache, &Cell::new(0), Some(3));
        assert_eq!(press.states.len(), 3);
        let end = press.end.unwrap();
        assert!(end.to_string().contains("did not converge beyond a depth of 0.150 mm"), "{end}");
        assert_eq!(cache.size().entries, 0);
    }

    #[test]
    fn a_press_is_stopped_where_the_caller_says_so() {
        let mut seen = Vec::new();
        let mut progress = |frames| {
            seen.push(frames);
            if frames == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let poses = [Pose::default(); 5];
        let (states, end) = follow(bump(0.0), &poses, &mut progress, |_, _| Ok(bump(0.1)));
        assert_eq!((states.len(), end, seen), (3, Some(EarlyEnd::Stopped), vec![1, 2, 3]));
    }

    #[test]
    fn a_press_is_stopped_within_a_frame() {
        let mut asked = 0;
        let mut progress = |_| {
            asked += 1;
            if asked > 6 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let mut scene = Scene::find("circle").unwrap();
        scene.make_draft();
        let press = scene.solve(&PressCache::OFF, &mut progress).unwrap();
        assert_eq!(press.end, Some(EarlyEnd::Stopped));
        assert!(press.states.len() < 4, "{} frames after 6 questions", press.states.len());
    }
}
