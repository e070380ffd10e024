//! A run: frames from a source through the tracker into a folder.

use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use fingervision_image::Frame;
use fingervision_sink::{Field, Preview, PreviewOptions, RunFolder, RunOptions, Sink, SinkError};
use fingervision_source::Source;
use fingervision_touch::{DepthMethod, Fields, LEARNED_FROM, Profile, Reading, Tracker};

use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::OutputArgs;
use crate::run_record::run_record;
use crate::summary::{Summary, Tally};

/// What to make of a source.
#[derive(Debug)]
pub(crate) struct Run {
    /// The sensor.
    pub(crate) profile: Profile,
    /// The fields asked for; absent: all that the profile is calibrated for.
    pub(crate) fields: Option<Vec<Field>>,
    /// The folder to write.
    pub(crate) folder: PathBuf,
    /// Whether a previous run there may be replaced.
    pub(crate) overwrite: bool,
    pub(crate) output: OutputArgs,
}

/// A run that has begun: all that takes its readings.
struct Sinks {
    folder: RunFolder,
    preview: Preview,
    tally: Tally,
}

impl Run {
    /// Tracks the source to its end.
    ///
    /// The second value says why the run ended early; what was read before is written all the same.
    ///
    /// # Errors
    ///
    /// Whatever keeps the run from beginning.
    pub(crate) fn track(&self, source: &mut dyn Source) -> Result<(Summary, Option<Failure>), Failure> {
        let begin = Instant::now();
        let region = self.profile.region(source.size())?;
        let Some(first) = source.next_frame()? else { return Err(SinkError::NoReadings.into()) };
        let mut tracker = self.tracker(&first, source.size())?;
        let fields = self.fields_to_keep(tracker.reading());
        let traction = tracker.reading().traction.as_ref();
        let record = run_record(&source.description(), &fields, &self.profile, traction)?;
        let traction_size = traction.map(|grid| (grid.columns, grid.rows));
        let options = RunOptions { size: tracker.size(), traction_size, fields, overwrite: self.overwrite };
        let mm_per_px = self.profile.mm_per_px().map(|scale| scale as f32);
        let mut sinks = Sinks {
            folder: RunFolder::create(&self.folder, &options, &record)?,
            preview: Preview::new(PreviewOptions { region: Some(region), mm_per_px }),
            tally: Tally::default(),
        };
        let ended = self.stream(source, first, &mut tracker, &mut sinks);
        Ok(self.finish(sinks, &tracker, begin, ended))
    }

    fn tracker(&self, first: &Frame, frame_size: (usize, usize)) -> Result<Tracker, Failure> {
        let is_asked = |field| self.fields.as_ref().is_some_and(|fields| fields.contains(&field));
        let by_default = self.fields.is_none();
        let fields = Fields {
            density: by_default || is_asked(Field::Density),
            depth: by_default || is_asked(Field::Depth) || is_asked(Field::DepthDeviation) || is_asked(Field::Contact),
            displacement: is_asked(Field::Displacement),
            traction: is_asked(Field::Traction),
        };
        let tracker = Tracker::new(&self.profile, frame_size, first.pixels.is_colour(), fields)?;
        let absent = self.fields.iter().flatten().find(|field| !field.is_in(tracker.reading()));
        if let Some(field) = absent {
            return Err(self.cannot_be_had(*field));
        }
        if by_default && !tracker.has_depth() {
            let (name, lacks) = (&self.profile.name, self.lacks_for_depth());
            self.output.note(&format!("no depth is written: the profile \"{name}\" has {lacks}"));
        }
        if let Some(remark) = self.outside_learned() {
            self.output.note(&remark);
        }
        Ok(tracker)
    }

    /// What there is to say of a sensor of which nothing was learned; none without elastic depth.
    fn outside_learned(&self) -> Option<String> {
        if self.profile.depth_method() != DepthMethod::Elastic {
            return None;
        }
        let (camera, gel) = self.profile.elastic_sensor().ok()?;
        self.profile.elastic.is_outside_learned(&camera, &gel).then(|| {
            let ([width, height], [_, _, distance]) = (gel.size_mm, camera.position_mm());
            format!(
                "depth was learned on {LEARNED_FROM}; this one is {width} by {height} by {} mm, of {}, seen from {distance:.1} mm: \
                 expect worse",
                gel.thickness_mm, gel.poissons_ratio
            )
        })
    }

    /// Why a field that was asked for is not to be had with this profile.
    fn cannot_be_had(&self, field: Field) -> Failure {
        let (name, profile) = (field.name(), &self.profile.name);
        match (field, self.profile.depth_method()) {
            (Field::Depth, DepthMethod::Density) => Failure::new(
                format!("depth was asked for, but the profile \"{profile}\" has {}", self.lacks_for_depth()),
                "leave depth out of --fields, give the profile [camera] and [gel], or fit one: fingervision calibrate depth \
                 PRESSES --profile sensor.toml",
            ),
            (_, DepthMethod::Density) => Failure::new(
                format!("{name} was asked for, but the profile \"{profile}\" has no elastic depth"),
                format!(
                    "leave {name} out of --fields, or give the profile [camera] and [gel] and no depth.method = \"density\""
                ),
            ),
            (_, DepthMethod::Elastic) => Failure::new(
                format!("{name} was asked for, but the profile \"{profile}\" has no gel.youngs_modulus_mpa"),
                format!("leave {name} out of --fields, or tell how stiff the gel is: --set gel.youngs_modulus_mpa=0.6"),
            ),
        }
    }

    /// What a profile without depth would need for it.
    fn lacks_for_depth(&self) -> &'static str {
        let Profile { camera, gel, .. } = &self.profile;
        match (camera, gel, self.profile.depth.method) {
            (None, Some(_), None) => "no [camera] for elastic depth, and no depth line",
            (Some(_), None, None) => "no [gel] for elastic depth, and no depth line",
            _ => "no depth line",
        }
    }

    /// What is written: all that was asked for, and with elastic depth always contact and where they hold.
    fn fields_to_keep(&self, reading: &Reading) -> Vec<Field> {
        let by_default = || [Field::Flow, Field::Density, Field::Depth].to_vec();
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
        source: &mut dyn Source,
        first: Frame,
        tracker: &mut Tracker,
        sinks: &mut Sinks,
    ) -> Result<(), Failure> {
        let interrupt = Interrupt::listen()?;
        let count = source.frame_count();
        let progress = self.output.progress("tracking", count);
        let mut next = Some(first);
        while let Some(frame) = next {
            sinks.write(tracker.track(&frame)?, &frame)?;
            progress.inc(1);
            if interrupt.is_asked() {
                return interrupted(progress.position(), count);
            }
            next = source.next_frame()?;
        }
        progress.finish_and_clear();
        Ok(())
    }

    /// Puts everything on the disk and draws the preview. The first error is the one that counts.
    fn finish(
        &self,
        sinks: Sinks,
        tracker: &Tracker,
        begin: Instant,
        ended: Result<(), Failure>,
    ) -> (Summary, Option<Failure>) {
        let Sinks { folder, preview, tally } = sinks;
        let path = self.folder.join("preview.png");
        let drawn = if tally.frames > 0 { preview.save(&path) } else { Ok(()) };
        let has_preview = tally.frames > 0 && drawn.is_ok();
        if drawn.is_err() {
            // Half a picture is none; the error that is reported is the one that cut it.
            let _ = fs::remove_file(&path);
        }
        let closed = folder.finish();
        let summary = Summary {
            folder: self.folder.clone(),
            preview: has_preview.then_some(path),
            size: tracker.size(),
            has_depth: tracker.has_depth(),
            seconds: begin.elapsed().as_secs_f64(),
            tally,
        };
        let ended = ended.and(closed.map(drop).map_err(Failure::from)).and(drawn.map_err(Failure::from));
        (summary, ended.err())
    }
}

impl Sinks {
    fn write(&mut self, reading: &Reading, frame: &Frame) -> Result<(), SinkError> {
        self.folder.write(reading, frame)?;
        self.preview.write(reading, frame)?;
        self.tally.count(reading);
        Ok(())
    }
}

/// A stream without an end has ended when it is told to; one with an end is cut short.
fn interrupted(frames: u64, count: Option<u64>) -> Result<(), Failure> {
    match count {
        Some(count) if frames < count => {
            Err(Failure::new(format!("interrupted after {frames} of {count} frames"), "what was written can be read"))
        }
        _ => Ok(()),
    }
}
