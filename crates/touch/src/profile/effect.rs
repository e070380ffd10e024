//! Finds settings that have no effect under the other settings in force.

use fingervision_flow::Preset;

use super::{Profile, ProfileError};
use crate::{DepthLaw, DepthMethod, Fields, Policy};

/// The reason why a setting has no effect, and a change that gives it an effect.
type Reason = (String, String);

impl Profile {
    /// Checks that settings, each given by its path, have an effect. The caller passes the settings that the user gave
    /// explicitly.
    ///
    /// # Errors
    ///
    /// [`ProfileError::NoEffect`] naming the first one without effect on these fields.
    pub fn expect_effect<'a>(
        &self,
        keys: impl IntoIterator<Item = &'a str>,
        fields: Fields,
    ) -> Result<(), ProfileError> {
        keys.into_iter().find_map(|key| self.no_effect(key, fields)).map_or(Ok(()), Err)
    }

    /// Why a setting has no effect; none if it has one.
    #[must_use]
    pub fn no_effect(&self, key: &str, fields: Fields) -> Option<ProfileError> {
        let reason = match key.split_once('.') {
            Some(("capture", _)) => Some((
                "a recording is tracked as it was captured".into(),
                "write it into the profile, for capture from a camera".into(),
            )),
            Some(("flow", key)) => self.idle_flow(key),
            Some(("references", key)) => self.idle_reference(key),
            Some(("elastic" | "gel", _)) => self.idle_elastic(fields),
            Some(("density", _)) => self.idle_density(fields),
            Some(("depth", key)) if key.starts_with("density") => self.idle_law(fields),
            _ if key == "elastic" || key == "gel" => self.idle_elastic(fields),
            _ => None,
        };
        reason.map(|(reason, hint)| ProfileError::NoEffect { key: key.into(), reason, hint })
    }

    fn idle_flow(&self, key: &str) -> Option<Reason> {
        let (preset, policy) = (self.flow.preset, self.references.policy);
        let is_affine = preset == Preset::Affine;
        let of_affine = || ("flow.preset is dense inverse search alone".into(), "set flow.preset=affine".into());
        match key {
            "finest_level" if is_affine => Some((
                "flow.preset = \"affine\" always ends at full size".into(),
                "set flow.preset=medium, fast or ultrafast".into(),
            )),
            "search.finest_level" if self.flow.finest_level.is_some() => {
                Some(("flow.finest_level is set and takes precedence".into(), "set flow.finest_level instead".into()))
            }
            _ if key.starts_with("search.refine") && is_affine && policy == Policy::Single => Some((
                "references.policy = \"single\" with flow.preset = \"affine\" searches lost areas only, without refinement".into(),
                "set references.policy=anchored, or flow.preset=medium".into(),
            )),
            "affine.coarsest_level" | "affine.steps" | "affine.search_steps" | "affine.fine_steps" | "affine.iterations"
                if !is_affine =>
            {
                Some(of_affine())
            }
            "affine.search_steps" if policy == Policy::Single => Some((
                "references.policy = \"single\" never searches whole images".into(),
                "set flow.affine.steps, or references.policy=anchored".into(),
            )),
            "affine.colour_row_step" if !self.flow.colour => {
                Some(("flow.colour = false matches every row in grey".into(), "set flow.colour=true".into()))
            }
            _ => None,
        }
    }

    fn idle_reference(&self, key: &str) -> Option<Reason> {
        let owners: &[Policy] = match key {
            "min_matched" => &[Policy::Anchored, Policy::Stack],
            "search_interval" | "rest_frames" => &[Policy::Anchored],
            "push_error" | "loop_error" | "coarse_grid" | "max_references" => &[Policy::Stack],
            _ => return None,
        };
        let policy = self.references.policy;
        (!owners.contains(&policy)).then(|| {
            let reason = format!("references.policy = \"{}\" does not use it", policy.name());
            (reason, format!("set references.policy={}", owners[0].name()))
        })
    }

    fn idle_elastic(&self, fields: Fields) -> Option<Reason> {
        if self.depth_method() != DepthMethod::Elastic {
            let lacks = match (self.depth.method, &self.camera, &self.gel) {
                (Some(DepthMethod::Density), ..) => {
                    return Some((BY_DENSITY.into(), "set depth.method=elastic".into()));
                }
                (_, None, _) => "[camera]",
                _ => "[gel]",
            };
            let hint = format!("describe {lacks} in the profile that --profile names");
            return Some((format!("there is no elastic depth: the profile has no {lacks}"), hint));
        }
        let is_asked = fields.depth || fields.displacement || fields.traction;
        (!is_asked).then(|| ("no elastic field is requested".into(), "add depth to --fields".into()))
    }

    fn idle_density(&self, fields: Fields) -> Option<Reason> {
        let is_used = fields.density || self.law_in_force(fields).is_some();
        (!is_used).then(|| ("the density is not requested".into(), "add density to --fields".into()))
    }

    fn idle_law(&self, fields: Fields) -> Option<Reason> {
        let reason = match self.depth_method() {
            DepthMethod::Elastic => "depth.method is \"elastic\"",
            DepthMethod::Density if !fields.depth => "depth is not requested",
            DepthMethod::Density => return None,
        };
        Some((reason.into(), "set depth.method=density and request depth".into()))
    }

    /// The law that turns density into depth, if that method is in force.
    fn law_in_force(&self, fields: Fields) -> Option<DepthLaw> {
        self.depth.density.filter(|_| fields.depth && self.depth_method() == DepthMethod::Density)
    }
}

const BY_DENSITY: &str = "depth.method = \"density\" does not use it";
