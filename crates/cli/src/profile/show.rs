//! `fingervision profile show`: a profile with all defaults, and which quantities it enables.

use std::fmt;
use std::io::Write;
use std::path::PathBuf;

use fingervision_touch::{DepthMethod, Profile, ProfileReview, Weight};
use serde::Serialize;

use crate::failure::Failure;
use crate::output::OutputArgs;
use crate::profile_args::assignment;

/// Print all values, including defaults, and which quantities they enable
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The profile, or the run.toml of a run
    file: PathBuf,
    /// Set one value first, as in `gel.thickness_mm=8`; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = assignment)]
    assignments: Vec<(String, String)>,
    /// Print only the profile: a file to use, as in: fingervision profile show run/run.toml --toml > sensor.toml
    #[arg(long, conflicts_with = "json")]
    toml: bool,
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Debug, Serialize)]
struct Shown {
    file: PathBuf,
    #[serde(flatten)]
    review: ProfileReview,
    profile: Profile,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let mut profile = Profile::load(&args.file)?;
    profile.set_all(args.assignments.iter().map(|(key, value)| (key.as_str(), value.as_str())))?;
    if args.toml {
        return Ok(out.write_all(profile.to_toml().as_bytes())?);
    }
    let shown = Shown { file: args.file.clone(), review: profile.review(None), profile };
    args.output.result(out, &shown, &shown.to_string())
}

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, review, profile } = self;
        writeln!(f, "profile         \"{}\", {}", profile.name, file.display())?;
        write!(f, "{}", Facts { review, profile })?;
        for remark in &review.remarks {
            writeln!(f, "{:15} {}", Facts::word(remark.weight), remark.message)?;
        }
        writeln!(f, "\n{}", profile.to_toml().trim_end())
    }
}

/// The quantities that a profile enables, one per line.
pub(super) struct Facts<'a> {
    pub(super) review: &'a ProfileReview,
    pub(super) profile: &'a Profile,
}

impl Facts<'_> {
    /// The first word of a remark.
    pub(super) fn word(weight: Weight) -> &'static str {
        match weight {
            Weight::Fault => "fault",
            Weight::Warning => "warning",
            Weight::Missing => "missing",
        }
    }

    fn depth(&self) -> &'static str {
        match self.review.depth {
            Some(DepthMethod::Elastic) => "elastic: depth, contact and displacement from the gel's elasticity",
            Some(DepthMethod::Density) => "density: depth.density turns the density feature into depth; no contact",
            None => "none",
        }
    }
}

impl fmt::Display for Facts<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let review = self.review;
        match review.region_of_interest {
            Some([x, y, width, height]) => writeln!(f, "tracked         {width}x{height} px at ({x}, {y})")?,
            None => writeln!(f, "tracked         the whole image")?,
        }
        writeln!(f, "depth           {}", self.depth())?;
        match self.profile.gel.and_then(|gel| gel.youngs_modulus_mpa).filter(|_| review.has_force) {
            Some(modulus) => writeln!(f, "force           yes: Young's modulus is {modulus} MPa")?,
            None => writeln!(f, "force           no")?,
        }
        if let Some(scale) = review.mm_per_px {
            writeln!(f, "pixel           {scale:.4} mm on the gel")?;
        }
        if let Some([width, height]) = review.field_of_view_mm {
            writeln!(f, "field of view   {width:.1} x {height:.1} mm on the gel's surface")?;
        }
        if let Some((gel, region)) = review.gel_seen.zip(review.region_on_gel) {
            writeln!(
                f,
                "in view         {:.0} % of the gel; {:.0} % of the image shows gel",
                100.0 * gel,
                100.0 * region
            )?;
        }
        match review.is_outside_training_range {
            Some(true) => writeln!(f, "training range  outside"),
            Some(false) => writeln!(f, "training range  inside"),
            None => Ok(()),
        }
    }
}
