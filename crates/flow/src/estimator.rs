//! The flow estimator: one object per picture size, used for every frame.

use crate::affine::patches::{self, AffinePatches, AffineReference};
use crate::light::Light;
use crate::recovery::Recovery;
use crate::round_trip::{invert_into, round_trip_error_into};
use crate::search::{self, Frequency, InverseSearch, SearchReference};
use crate::{Estimate, FlowError, FlowField, FlowHistory, FlowParams, Levels, Picture, Preset, Team};
use fearless_simd::Level;
use fingervision_image::Image;

/// A reference picture prepared for matching: everything that depends only on the reference.
#[derive(Debug, Clone)]
pub struct Reference {
    search: SearchReference,
    affine: AffineReference,
    mean_level: f32,
    sharpness: f32,
    levels: Levels,
    light: Light,
    /// The picture itself, if the round trip is checked.
    picture: Option<Picture>,
}

impl Reference {
    /// Part of the picture's patches that have enough texture to be measured, 0 to 1.
    #[must_use]
    pub fn textured(&self) -> f32 {
        self.affine.textured
    }

    /// Mean grey level of the picture.
    #[must_use]
    pub fn mean_level(&self) -> f32 {
        self.mean_level
    }

    /// Mean, contrast and saturation of the picture.
    #[must_use]
    pub fn levels(&self) -> Levels {
        self.levels
    }

    /// Sharpness of the picture; see [`Picture::sharpness`].
    #[must_use]
    pub fn sharpness(&self) -> f32 {
        self.sharpness
    }
}

/// The initial flow of an estimate.
#[derive(Debug, Clone, Copy)]
pub enum Start<'a> {
    /// Cold start: the dense inverse search finds the flow, even if it is large. The search also tries the given flow,
    /// if any.
    Search(Option<&'a FlowField>),
    /// Cold start of a frame that follows others: the search also tries the last flow.
    SearchHistory(&'a FlowHistory),
    /// Warm start: from a flow with errors of a few px at most, such as that of the previous frame.
    Flow(&'a FlowField),
    /// Warm start of a frame that follows others: from the last flow and its last change, or from the last flow alone where
    /// the picture then matches clearly better.
    History(&'a FlowHistory),
}

/// Estimates flow between pictures of one size. It owns its scratch memory: an estimate allocates nothing, except that a cold
/// start of the preset [`Preset::Affine`] takes 30 MB more for 640×480 px, and returns them at its end.
#[derive(Debug, Clone)]
pub struct FlowEstimator {
    width: usize,
    height: usize,
    params: FlowParams,
    search: InverseSearch,
    affine: AffinePatches,
    recovery: Recovery,
    found: FlowField,
    /// The last flow of a history at every pixel, where it is needed.
    last: FlowField,
    backward: Option<Box<Backward>>,
}

/// Memory for the round-trip check: the current picture as reference, and the backward flow.
#[derive(Debug, Clone)]
struct Backward {
    reference: Reference,
    start: FlowField,
    flow: FlowField,
    error: Image<f32>,
}

/// Fixed-point iterations that invert the flow. The backward flow starts from the inverse.
const INVERSION_PASSES: usize = 6;

/// Largest number of pixels of a picture: the kernels compute pixel indices in `f32`, which is exact up to this number.
const MOST_PIXELS: usize = 1 << 24;

/// Least part of the textured patches that must match after a search. If fewer match, the search is repeated with an
/// exhaustive search on its coarsest level.
const LEAST_MATCHED: f32 = 0.7;

/// Least width and height of a picture, px.
const LEAST_SIZE: usize = 32;

impl FlowEstimator {
    /// An estimator for pictures of this size.
    ///
    /// # Errors
    ///
    /// [`FlowError::TooSmall`] below 32 px along an axis; [`FlowError::TooLarge`] above 2²⁴ px in total;
    /// [`FlowError::Parameter`] for a parameter out of range.
    pub fn new(width: usize, height: usize, params: &FlowParams) -> Result<Self, FlowError> {
        Self::with_level(width, height, params, Level::new())
    }

    /// As [`FlowEstimator::new`], with an instruction set that the processor has.
    pub(crate) fn with_level(width: usize, height: usize, params: &FlowParams, simd: Level) -> Result<Self, FlowError> {
        params.validate()?;
        if width.min(height) < LEAST_SIZE {
            return Err(FlowError::TooSmall { width, height, least: LEAST_SIZE });
        }
        if width.saturating_mul(height) > MOST_PIXELS {
            return Err(FlowError::TooLarge { width, height, most: MOST_PIXELS });
        }
        let frequency = if params.preset == Preset::Affine { Frequency::Seldom } else { Frequency::EveryFrame };
        let mut estimator = Self {
            width,
            height,
            params: *params,
            search: InverseSearch::new(width, height, params.search(), frequency, simd),
            affine: AffinePatches::new(width, height, params, simd),
            recovery: Recovery::new(width, height),
            found: FlowField::zero(width, height),
            last: FlowField::zero(width, height),
            backward: None,
        };
        estimator.backward = params.validity.max_round_trip_px.is_some().then(|| {
            Box::new(Backward {
                reference: estimator.reference(),
                start: FlowField::zero(width, height),
                flow: FlowField::zero(width, height),
                error: Image::filled(width, height, 0.0),
            })
        });
        Ok(estimator)
    }

    /// The parameters.
    #[must_use]
    pub fn params(&self) -> &FlowParams {
        &self.params
    }

    /// An empty picture with the levels and channels that this estimator needs.
    #[must_use]
    pub fn picture(&self) -> Picture {
        let coarsest = search::coarsest_level(self.width, self.height);
        let coarsest = coarsest.max(patches::coarsest_level(self.width, self.height, &self.params));
        Picture::new(self.width, self.height, coarsest, self.params.colour)
    }

    /// An empty reference, to be filled by [`FlowEstimator::prepare`].
    #[must_use]
    pub fn reference(&self) -> Reference {
        let picture = self.params.validity.max_round_trip_px.map(|_| self.picture());
        let (search, affine) = (self.search.reference(), self.affine.reference());
        let light = Light::new(self.width, self.height, self.params.colour);
        Reference { search, affine, mean_level: 0.0, sharpness: 0.0, levels: Levels::default(), light, picture }
    }

    /// Prepares a reference from a picture. A reference for pictures with other channels is made anew.
    pub fn prepare(&self, picture: &Picture, reference: &mut Reference) {
        if !self.affine.fits(&reference.affine) {
            *reference = self.reference();
        }
        self.search.prepare(picture, &mut reference.search);
        self.affine.prepare(picture, &mut reference.affine);
        (reference.mean_level, reference.sharpness) = (picture.mean_level(), picture.sharpness());
        reference.levels = picture.levels();
        reference.light.copy_from(&picture.light);
        if let Some(kept) = &mut reference.picture {
            kept.copy_from(picture);
        }
    }

    /// Adapts a reference to the noise of the last frames, which were followed from [`Start::History`]: call it before each of them.
    /// Hardly any call changes anything. Without it the noise stays as [`FlowEstimator::prepare`] set it: by the contrast of the
    /// reference, and by the frames until then.
    pub fn adapt(&self, reference: &mut Reference) {
        self.affine.adapt(&mut reference.affine);
    }

    /// Corrects the light of a picture to that of a reference, before it is matched with it: each channel is multiplied by the ratio of the
    /// mean levels around each place. `history` leads from the reference to the last frame. Without it, a light that differs within
    /// 16 px, or from colour to colour, is an error of the flow. Places far from any change by more than 2 % stay as they are.
    pub fn correct_light(&self, reference: &Reference, picture: &mut Picture, history: &FlowHistory) {
        let [u, _, _, v, ..] = &history.last_nodes().planes;
        picture.correct_light(&reference.light, [u, v]);
    }

    /// Shares the work of an estimate among the threads of a team, on one of which it should be called ([`Team::run`]). The flow
    /// is the same, bit for bit.
    pub fn share(&mut self, team: &Team) {
        self.affine.set_team(team);
    }

    /// Forgets the previous frames: the next estimates are those of a new estimator, bit for bit. Allocates nothing.
    pub fn restart(&mut self) {
        self.recovery.restart();
        self.affine.restart();
    }

    /// Writes the flow from a reference to the current picture.
    pub fn estimate(&mut self, reference: &Reference, current: &Picture, start: Start<'_>, out: &mut Estimate) {
        out.is_motion_blurred = false;
        match (self.params.preset, start) {
            (Preset::Affine, Start::Flow(flow)) => {
                self.affine.start(flow);
                let affine = &self.params.affine;
                self.affine.follow(&reference.affine, current, affine.coarsest_level, affine.steps);
                let (lost_px2, is_searched) = self.recovery.find(&self.affine, &reference.affine);
                out.lost_px2 = if is_searched { self.recover(reference, current, flow) } else { lost_px2 };
                self.affine.write(&reference.affine, current, out);
            }
            (Preset::Affine, Start::History(history)) => {
                self.follow_history(reference, current, history);
                let (lost_px2, is_searched) = self.recovery.find(&self.affine, &reference.affine);
                out.lost_px2 = if is_searched {
                    self.with_last(history, |estimator, last| estimator.recover(reference, current, last))
                } else {
                    lost_px2
                };
                let scratch = [&mut self.last, &mut self.found];
                out.is_motion_blurred = self.affine.follow_blur(&reference.affine, current, history, scratch);
                if out.is_motion_blurred {
                    out.lost_px2 = self.recovery.lost_px2(&self.affine, &reference.affine);
                }
                self.affine.write(&reference.affine, current, out);
                self.affine.note_residual(out);
            }
            (Preset::Affine, Start::Search(guess)) => {
                self.search_and_refine(reference, current, guess, false, out);
                let matched = out.matched;
                if matched < LEAST_MATCHED && self.params.search().coarse_reach > 0 {
                    self.search_and_refine(reference, current, guess, true, out);
                    if out.matched < matched {
                        self.search_and_refine(reference, current, guess, false, out);
                    }
                }
            }
            (Preset::Affine, Start::SearchHistory(history)) => {
                let again = |estimator: &mut Self, last: &_| {
                    estimator.estimate(reference, current, Start::Search(Some(last)), out);
                };
                return self.with_last(history, again);
            }
            (_, Start::Search(guess)) => self.search_alone(reference, current, guess, out),
            (_, Start::Flow(guess)) => self.search_alone(reference, current, Some(guess), out),
            (_, Start::History(history) | Start::SearchHistory(history)) => {
                self.with_last(history, |estimator, last| estimator.search_alone(reference, current, Some(last), out));
            }
        }
        if let (Some(limit), Some(picture)) = (self.params.validity.max_round_trip_px, &reference.picture) {
            self.check_round_trip(picture, current, limit, out);
        }
    }

    /// Computes the backward flow. A pixel is not valid if forward and backward flow together end more than `limit` px
    /// from it.
    fn check_round_trip(&mut self, reference: &Picture, current: &Picture, limit: f32, out: &mut Estimate) {
        let Some(mut backward) = self.backward.take() else { return };
        let Backward { reference: current_reference, start, flow, error } = &mut *backward;
        self.prepare(current, current_reference);
        invert_into(&out.flow, INVERSION_PASSES, start);
        match self.params.preset {
            Preset::Affine => {
                self.affine.start(start);
                self.affine.follow(&current_reference.affine, reference, 0, self.params.affine.steps);
                self.affine.expand(flow);
            }
            _ => self.search.flow(&current_reference.search, reference, Some(start), false, flow),
        }
        round_trip_error_into(&out.flow, flow, error);
        for (valid, error) in out.valid.values_mut().iter_mut().zip(error.values()) {
            *valid &= u8::from(*error <= limit);
        }
        self.backward = Some(backward);
    }

    /// Follows a motion that was seen in earlier frames.
    fn follow_history(&mut self, reference: &Reference, current: &Picture, history: &FlowHistory) {
        let Self { affine, recovery, params, .. } = self;
        let reference = &reference.affine;
        if affine.predict(reference, current, history) {
            affine.follow_prediction(reference, current, |patches| recovery.lost_px2(patches, reference) > 0.0);
        } else {
            affine.follow(reference, current, params.affine.coarsest_level, params.affine.steps);
        }
    }

    /// Searches the areas that were found to be lost from `last`; returns the area that is still lost, px².
    fn recover(&mut self, reference: &Reference, current: &Picture, last: &FlowField) -> f32 {
        let references = (&reference.search, &reference.affine);
        self.recovery.run(references, current, last, &mut self.search, &mut self.affine)
    }

    /// Runs something with the last flow of a history at every pixel.
    fn with_last<T>(&mut self, history: &FlowHistory, run: impl FnOnce(&mut Self, &FlowField) -> T) -> T {
        let mut last = std::mem::replace(&mut self.last, FlowField::zero(0, 0));
        self.affine.expand_last(history, &mut last);
        let result = run(self, &last);
        self.last = last;
        result
    }

    /// Finds the flow by a search and refines it with the affine patches.
    fn search_and_refine(
        &mut self,
        reference: &Reference,
        current: &Picture,
        guess: Option<&FlowField>,
        is_exhaustive: bool,
        out: &mut Estimate,
    ) {
        self.search.flow(&reference.search, current, guess, is_exhaustive, &mut self.found);
        self.affine.start(&self.found);
        self.affine.refine(&reference.affine, current, self.params.affine.search_steps);
        self.affine.write(&reference.affine, current, out);
        out.lost_px2 = self.recovery.lost_px2(&self.affine, &reference.affine);
    }

    fn search_alone(
        &mut self,
        reference: &Reference,
        current: &Picture,
        guess: Option<&FlowField>,
        out: &mut Estimate,
    ) {
        self.search.flow(&reference.search, current, guess, false, &mut out.flow);
        self.affine.start(&out.flow);
        self.affine.inspect(&reference.affine, current);
        self.affine.add_fine_error(&out.flow, &mut self.found);
        self.affine.write_validity(&reference.affine, out);
        out.lost_px2 = self.recovery.lost_px2(&self.affine, &reference.affine);
    }
}
