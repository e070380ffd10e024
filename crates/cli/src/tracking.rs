//! A run: tracks the frames of a source and writes the results to a folder.

use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use fingervision_image::Frame;
use fingervision_sink::{Field, Overlay, Precision, Preview, PreviewOptions, RunFolder, RunOptions, SinkError};
use fingervision_source::Source;
use fingervision_touch::{DepthMethod, Fields, Profile, Reading, TRAINING_RANGE, Tracker};

use crate::disk;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::OutputArgs;
use crate::part::Part;
use crate::profile_args::note_doubts;
use crate::reader::{Next, Reader};
use crate::run_record::run_record;
use crate::skipped::Skipped;
use crate::summary::{Summary, Tally};
use crate::writer::{Put, Sinks};

/// Options for tracking a source.
#[derive(Debug)]
pub(crate) struct Run {
    /// The sensor.
    pub(crate) profile: Profile,
    /// The requested fields; absent: all that the profile is calibrated for.
    pub(crate) fields: Option<Vec<Field>>,
    /// The format of floating-point numbers.
    pub(crate) precision: Precision,
    /// The video to write, if any.
    pub(crate) overlay: Option<PathBuf>,
    /// The folder to write.
    pub(crate) folder: PathBuf,
    /// Whether a previous run there may be replaced.
    pub(crate) overwrite: bool,
    /// The frames to track.
    pub(crate) part: Part,
    /// Whether a frame that cannot be read is skipped instead of ending the run.
    pub(crate) skips_bad_frames: bool,
    pub(crate) output: OutputArgs,
}

/// Said where the tracker finds that colour would harm.
const COARSE_COLOUR: &str = "the images have no colour, or less detail in it than in brightness, as of a Bayer sensor or after most compression: they are matched in grey";

impl Run {
    /// Tracks the source to its end.
    ///
    /// The second value is the reason if the run ended early; what was read before is still written.
    ///
    /// # Errors
    ///
    /// Why the run cannot begin.
    pub(crate) fn track(&self, source: &mut dyn Source) -> Result<(Summary, Option<Failure>), Failure> {
        let begin = Instant::now();
        for remark in source.remarks() {
            self.output.note(&remark);
        }
        if let Some(last) = source.last_sequence() {
            self.part.expect_within(last)?;
        }
        let region = self.profile.region(source.size())?;
        let mut skipped = Skipped::default();
        let first = self.reference(source, &mut skipped)?;
        let mut tracker = self.tracker(source.tracks_in_colour(&first.pixels), source.size())?;
        note_doubts(&self.profile, source.size(), self.output);
        let fields = self.fields_to_keep(tracker.reading());
        let traction = tracker.reading().traction.as_ref();
        let record = run_record(&source.description(), &fields, &self.profile, traction, self.part)?;
        let traction_size = traction.map(|grid| (grid.columns, grid.rows));
        let (precision, overwrite) = (self.precision, self.overwrite);
        let options = RunOptions { size: tracker.size(), traction_size, precision, fields, overwrite };
        let mm_per_px = self.profile.mm_per_px().map(|scale| scale as f32);
        let pictures = PreviewOptions { region: Some(region), mm_per_px };
        let frames = self.part.written(source.frame_count());
        disk::check(&self.folder, options.bytes_per_frame(), frames, self.output);
        self.check_overlay()?;
        let mut sinks = Sinks {
            folder: RunFolder::create(&self.folder, &options, &record)?,
            preview: Preview::new(pictures),
            overlay: self.overlay.as_deref().map(|path| Overlay::create(path, options.size, pictures)).transpose()?,
            tally: Tally::default(),
        };
        let (skips, part, output) = (self.skips_bad_frames, self.part, self.output);
        let count = part.tracked(source.frame_count());
        let reader = Reader { source, skipped: &mut skipped, skips, part, output };
        let expects_colour = tracker.uses_colour();
        let ended = reader.read(|next_frame| {
            sinks.take(&mut tracker, |tracker, put| self.stream(first, (next_frame, put), count, tracker))
        });
        if sinks.tally.frames == 0
            && let Err(failure) = ended
        {
            self.discard(sinks);
            return Err(failure);
        }
        if expects_colour && !tracker.uses_colour() {
            self.output.note(COARSE_COLOUR);
        }
        Ok(self.finish(sinks, skipped, &tracker, begin, ended))
    }

    /// Refuses to replace a file without --overwrite, and a folder that does not exist and is not the run's own.
    fn check_overlay(&self) -> Result<(), Failure> {
        let Some(path) = &self.overlay else { return Ok(()) };
        if path.exists() && !self.overwrite {
            let message = format!("{} exists already", path.display());
            return Err(Failure::new(message, "name a new file or pass --overwrite"));
        }
        match path.parent().filter(|parent| !parent.as_os_str().is_empty()) {
            Some(parent) if !parent.is_dir() && parent != self.folder => {
                let message = format!("{}: there is no folder {}", path.display(), parent.display());
                Err(Failure::new(message, "make the folder first"))
            }
            _ => Ok(()),
        }
    }

    /// The frame that tracking begins with.
    fn reference(&self, source: &mut dyn Source, skipped: &mut Skipped) -> Result<Frame, Failure> {
        let wanted = self.part.reference;
        while let Some(frame) = skipped.next_frame(source, self.skips_bad_frames, self.output)? {
            if wanted.is_none() && skipped.count > 0 {
                return Err(Failure::new(
                    "the first frame cannot be read, and it is the reference",
                    format!("if frame {0} shows the gel untouched, use --reference-frame {0}", frame.sequence),
                ));
            }
            let Some(wanted) = wanted.filter(|&wanted| wanted != frame.sequence) else { return Ok(frame) };
            if frame.sequence > wanted {
                let message = format!("the reference frame {wanted} cannot be read");
                return Err(Failure::new(
                    message,
                    "use --reference-frame with another one that shows the gel untouched",
                ));
            }
        }
        let Some(wanted) = wanted else { return Err(SinkError::NoReadings.into()) };
        Err(Part::without_reference(wanted, skipped.last_read()))
    }

    fn tracker(&self, is_colour: bool, frame_size: (usize, usize)) -> Result<Tracker, Failure> {
        let (by_default, fields) =
            (self.fields.is_none(), fields_to_compute(self.fields.as_deref(), self.profile.depth_method()));
        let tracker = Tracker::new(&self.profile, frame_size, is_colour, fields)?;
        let absent = self.fields.iter().flatten().find(|field| !field.is_in(tracker.reading()));
        if let Some(field) = absent {
            return Err(self.cannot_be_had(*field));
        }
        if by_default && !tracker.has_depth() {
            self.output.note(&format!("no depth is written: {}", self.lacks_for_depth()));
        }
        if let Some(remark) = self.outside_training() {
            self.output.note(&remark);
        }
        Ok(tracker)
    }

    /// A warning for a sensor outside the training range; none without elastic depth.
    fn outside_training(&self) -> Option<String> {
        if self.profile.depth_method() != DepthMethod::Elastic {
            return None;
        }
        let (camera, gel) = self.profile.elastic_sensor().ok()?;
        self.profile.elastic.is_outside_training(&camera, &gel).then(|| {
            let ([width, height], [_, _, distance]) = (gel.size_mm, camera.position_mm());
            format!(
                "the sensor is outside the network's training range: it was trained on {TRAINING_RANGE}; this one is {width} by {height} by {:.1} mm with a Poisson's ratio of {:.3}, seen from {distance:.1} mm: \
                 expect larger errors",
                gel.thickness_mm, gel.poissons_ratio
            )
        })
    }

    /// Why a requested field is not available with this profile.
    fn cannot_be_had(&self, field: Field) -> Failure {
        let name = field.name();
        match (field, self.profile.depth_method()) {
            (Field::Depth, DepthMethod::Density) => Failure::new(
                format!("depth was requested, but {}", self.lacks_for_depth()),
                "leave depth out of --fields, give the profile [camera] and [gel], or fit depth.density: fingervision \
                 calibrate depth PRESSES --profile sensor.toml",
            ),
            (_, DepthMethod::Density) => Failure::new(
                format!("{name} was requested, which needs elastic depth, but {}", self.lacks_for_elastic_depth()),
                format!(
                    "leave {name} out of --fields, or give the profile [camera] and [gel] and no depth.method = \"density\""
                ),
            ),
            (_, DepthMethod::Elastic) => Failure::new(
                format!("{name} was requested, but {} has no gel.youngs_modulus_mpa", self.named_profile()),
                format!("leave {name} out of --fields, or give the gel's stiffness: --set gel.youngs_modulus_mpa=0.6"),
            ),
        }
    }

    /// The missing parts of a profile without depth.
    fn lacks_for_depth(&self) -> String {
        match self.profile.depth.method {
            Some(DepthMethod::Density) => {
                format!("{} has depth.method = \"density\" but no depth.density", self.named_profile())
            }
            _ => format!("{} and no depth.density", self.lacks_for_elastic_depth()),
        }
    }

    /// The missing parts of a profile without elastic depth.
    fn lacks_for_elastic_depth(&self) -> String {
        let Profile { camera, gel, .. } = &self.profile;
        let lacks = match (camera, gel) {
            (None, None) => "no [camera], no [gel]",
            (None, Some(_)) => "no [camera]",
            (Some(_), None) => "no [gel]",
            (Some(_), Some(_)) => "depth.method = \"density\"",
        };
        format!("{} has {lacks}", self.named_profile())
    }

    /// The name of the profile, or a description if no file is given.
    fn named_profile(&self) -> String {
        let name = &self.profile.name;
        if *name == Profile::default().name {
            "the profile (--profile)".into()
        } else {
            format!("the profile \"{name}\"")
        }
    }

    /// The fields to write: all that were requested, and with elastic depth always contact and validity.
    fn fields_to_keep(&self, reading: &Reading) -> Vec<Field> {
        // With elastic depth, density is not needed.
        let by_default = || match self.profile.depth_method() {
            DepthMethod::Elastic => vec![Field::Flow, Field::Depth],
            DepthMethod::Density => vec![Field::Flow, Field::Density, Field::Depth],
        };
        let mut fields = self.fields.clone().unwrap_or_else(by_default);
        fields.retain(|field| field.is_in(reading));
        let is_elastic = [Field::Depth, Field::Displacement, Field::Contact, Field::Traction]
            .iter()
            .any(|field| fields.contains(field));
        for field in [Field::Contact, Field::DepthValid] {
            if is_elastic && field.is_in(reading) && !fields.contains(&field) {
                fields.push(field);
            }
        }
        fields
    }

    /// Takes frame after frame; returns why it ended early.
    fn stream(
        &self,
        first: Frame,
        (next_frame, put): (&mut Next<'_>, &mut Put<'_>),
        count: Option<u64>,
        tracker: &mut Tracker,
    ) -> Result<(), Failure> {
        let interrupt = Interrupt::listen();
        let progress = self.output.progress("tracking", count);
        let mut next = Some(first);
        let mut is_any_written = false;
        while let Some(frame) = next {
            let sequence = frame.sequence;
            tracker.track(&frame)?;
            if self.part.is_written(sequence) {
                put(tracker, frame)?;
                is_any_written = true;
            }
            progress.inc(1);
            if interrupt.is_asked() {
                return self.interrupted(is_any_written, progress.position(), count);
            }
            if self.part.is_behind(sequence + 1) {
                break;
            }
            let following = next_frame()?;
            // Skipped frames may extend beyond the part.
            next = following.filter(|frame| !self.part.is_behind(frame.sequence));
        }
        progress.finish_and_clear();
        if is_any_written { Ok(()) } else { Err(self.part.absent(None)) }
    }

    /// A stream without an end ends normally when it is interrupted; one with an end is cut short.
    fn interrupted(&self, is_any_written: bool, frames: u64, count: Option<u64>) -> Result<(), Failure> {
        match count {
            _ if !is_any_written => Err(self.part.interrupted()),
            Some(count) if frames < count => Err(Failure::new(
                format!("interrupted after {frames} of {count} frames"),
                "the frames written so far can be used; --overwrite starts again",
            )),
            _ => Ok(()),
        }
    }

    /// Removes the files of a run without any reading.
    fn discard(&self, sinks: Sinks) {
        let Sinks { folder, overlay, .. } = sinks;
        if let (Some(path), Some(overlay)) = (&self.overlay, overlay) {
            drop(overlay);
            // The error that is reported is the one that ended the run.
            let _ = fs::remove_file(path);
        }
        folder.discard();
    }

    /// Writes everything to disk and draws the preview. The first error is reported.
    fn finish(
        &self,
        sinks: Sinks,
        skipped: Skipped,
        tracker: &Tracker,
        begin: Instant,
        ended: Result<(), Failure>,
    ) -> (Summary, Option<Failure>) {
        let Sinks { folder, preview, overlay, mut tally, .. } = sinks;
        tally.finish();
        let overlaid = overlay.map_or(Ok(()), Overlay::finish);
        let path = self.folder.join("preview.png");
        let drawn = if tally.frames > 0 { preview.save(&path) } else { Ok(()) };
        let has_preview = tally.frames > 0 && drawn.is_ok();
        let closed = folder.finish();
        let summary = Summary {
            folder: self.folder.clone(),
            preview: has_preview.then_some(path),
            overlay: self.overlay.clone(),
            size: tracker.size(),
            has_depth: tracker.has_depth(),
            seconds: begin.elapsed().as_secs_f64(),
            tally,
            skipped,
        };
        let ended = ended.and(closed.map(drop).map_err(Failure::from));
        let ended = ended.and(drawn.map_err(Failure::from)).and(overlaid.map_err(Failure::from));
        (summary, ended.err())
    }
}

/// The fields that the tracker computes; absent: depth if the profile is calibrated for it, and density where depth is
/// not elastic.
#[must_use]
pub fn fields_to_compute(asked: Option<&[Field]>, method: DepthMethod) -> Fields {
    let is_asked = |field| asked.is_some_and(|fields| fields.contains(&field));
    let by_default = asked.is_none();
    Fields {
        density: (by_default && method == DepthMethod::Density) || is_asked(Field::Density),
        depth: by_default || is_asked(Field::Depth) || is_asked(Field::DepthDeviation) || is_asked(Field::Contact),
        displacement: is_asked(Field::Displacement),
        traction: is_asked(Field::Traction),
    }
}
