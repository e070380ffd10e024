//! The result of a comparison.

use std::path::PathBuf;

use serde::Serialize;

/// Errors of one quantity over some pixels, in the quantity's unit.
///
/// For a quantity with one value (depth, or a component of the displacement), the error is the absolute difference
/// between estimate and truth. For the flow it is the length of the vector difference; bias, peaks and correlation are
/// those of the length of the flow.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// Number of pixels.
    pub pixels: u64,
    /// Mean error.
    pub mean: f64,
    /// Root of the mean squared error.
    pub root_mean_square: f64,
    /// 95th percentile of the errors: exact for one frame, exact to one part in 4096 over several frames.
    pub percentile_95: f64,
    /// The largest error.
    pub largest: f64,
    /// Mean of estimate − truth.
    pub bias: f64,
    /// The largest true value.
    pub true_peak: f64,
    /// The largest estimated value, at any pixel.
    pub estimated_peak: f64,
    /// Pearson's correlation of estimate and truth over the pixels; none if either is constant.
    pub correlation: Option<f64>,
}

impl Errors {
    /// How much the largest estimated value exceeds the largest true one.
    #[must_use]
    pub fn peak_error(&self) -> f64 {
        self.estimated_peak - self.true_peak
    }

    /// The mean of every figure over frames; the pixels are those of all frames together. None without a frame.
    fn mean_of(frames: &[&Self]) -> Option<Self> {
        let mean =
            |figure: fn(&Self) -> f64| frames.iter().map(|errors| figure(errors)).sum::<f64>() / frames.len() as f64;
        let correlations: Vec<f64> = frames.iter().filter_map(|errors| errors.correlation).collect();
        (!frames.is_empty()).then(|| Self {
            pixels: frames.iter().map(|errors| errors.pixels).sum(),
            mean: mean(|errors| errors.mean),
            root_mean_square: mean(|errors| errors.root_mean_square),
            percentile_95: mean(|errors| errors.percentile_95),
            largest: mean(|errors| errors.largest),
            bias: mean(|errors| errors.bias),
            true_peak: mean(|errors| errors.true_peak),
            estimated_peak: mean(|errors| errors.estimated_peak),
            correlation: mean_of(&correlations),
        })
    }
}

/// A part of the gel. `Inside` and `Border` overlap, so their pixels must not be added.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Region {
    /// All pixels that are compared.
    Everywhere,
    /// In the true contact.
    Inside,
    /// Within a given distance of the border of the true contact, on either side, measured on the undeformed gel.
    Border,
    /// Neither in contact nor near its border.
    Outside,
}

impl Region {
    /// Every region.
    pub const ALL: [Self; 4] = [Self::Everywhere, Self::Inside, Self::Border, Self::Outside];
}

/// A value for each region; absent if a region has no pixels or is not known.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Regions<T = Errors> {
    /// [`Region::Everywhere`].
    pub everywhere: Option<T>,
    /// [`Region::Inside`].
    pub inside: Option<T>,
    /// [`Region::Border`].
    pub border: Option<T>,
    /// [`Region::Outside`].
    pub outside: Option<T>,
}

impl<T> Regions<T> {
    /// The value for a region.
    #[must_use]
    pub fn get(&self, region: Region) -> Option<&T> {
        match region {
            Region::Everywhere => self.everywhere.as_ref(),
            Region::Inside => self.inside.as_ref(),
            Region::Border => self.border.as_ref(),
            Region::Outside => self.outside.as_ref(),
        }
    }

    pub(super) fn from_fn(mut value: impl FnMut(Region) -> Option<T>) -> Self {
        let [everywhere, inside, border, outside] = Region::ALL.map(&mut value);
        Self { everywhere, inside, border, outside }
    }
}

/// Errors of the displacement, mm, by component in gel space, over all pixels that are compared.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Components {
    /// To the right.
    pub x: Option<Errors>,
    /// Downwards in the image.
    pub y: Option<Errors>,
    /// Towards the camera.
    pub z: Option<Errors>,
}

/// Number of pixels that were compared, and of the others by reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct PixelCounts {
    /// Truth and estimate are valid.
    pub compared: u64,
    /// The truth is hidden by the gel, or the pixel does not see the gel.
    pub hidden: u64,
    /// The truth is visible, but the run has no valid estimate.
    pub not_valid: u64,
}

impl PixelCounts {
    /// All of them.
    #[must_use]
    pub fn all(&self) -> u64 {
        self.compared + self.hidden + self.not_valid
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.compared += other.compared;
        self.hidden += other.hidden;
        self.not_valid += other.not_valid;
    }
}

/// The errors of one frame, or of several.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct FieldErrors {
    /// The compared pixels. They show whether a run leaves out difficult parts.
    pub pixels: Regions<PixelCounts>,
    /// Errors of the flow, px.
    pub flow_px: Option<Regions>,
    /// The compared pixels of depth, displacement and contact, if the run has a separate mask for them
    /// (`depth_valid.npy`); otherwise they are compared at the same pixels as the flow.
    pub depth_pixels: Option<Regions<PixelCounts>>,
    /// Errors of the depth, mm.
    pub depth_mm: Option<Regions>,
    /// Errors of the depth over only those of these pixels where the flow is also valid, mm; present with
    /// `depth_pixels`.
    pub depth_where_valid_mm: Option<Regions>,
    /// Errors of the displacement, mm.
    pub displacement_mm: Option<Components>,
    /// Intersection over union of both contact masks, 0 to 1; none if neither contains contact.
    pub contact_overlap: Option<f64>,
}

impl FieldErrors {
    /// The mean over frames of every figure, each over the frames that have it; pixel counts are added.
    pub(super) fn mean_of(frames: &[FrameReport]) -> Self {
        let regions = |field: fn(&Self) -> Option<&Regions>| {
            let any = frames.iter().any(|frame| field(&frame.errors).is_some());
            any.then(|| {
                Regions::from_fn(|region| {
                    let errors = frames.iter().filter_map(|frame| field(&frame.errors)?.get(region));
                    Errors::mean_of(&errors.collect::<Vec<_>>())
                })
            })
        };
        let component = |component: fn(&Components) -> Option<&Errors>| {
            let errors = frames.iter().filter_map(|frame| component(frame.errors.displacement_mm.as_ref()?));
            Errors::mean_of(&errors.collect::<Vec<_>>())
        };
        let pixels = |counts: fn(&Self) -> Option<&Regions<PixelCounts>>| {
            Regions::from_fn(|region| {
                let counts = frames.iter().filter_map(|frame| counts(&frame.errors)?.get(region).copied());
                counts.reduce(|mut sum, pixels| {
                    sum.add(&pixels);
                    sum
                })
            })
        };
        let has_depth_pixels = frames.iter().any(|frame| frame.errors.depth_pixels.is_some());
        let overlaps: Vec<f64> = frames.iter().filter_map(|frame| frame.errors.contact_overlap).collect();
        Self {
            pixels: pixels(|errors| Some(&errors.pixels)),
            depth_pixels: has_depth_pixels.then(|| pixels(|errors| errors.depth_pixels.as_ref())),
            flow_px: regions(|errors| errors.flow_px.as_ref()),
            depth_mm: regions(|errors| errors.depth_mm.as_ref()),
            depth_where_valid_mm: regions(|errors| errors.depth_where_valid_mm.as_ref()),
            displacement_mm: frames.iter().any(|frame| frame.errors.displacement_mm.is_some()).then(|| Components {
                x: component(|errors| errors.x.as_ref()),
                y: component(|errors| errors.y.as_ref()),
                z: component(|errors| errors.z.as_ref()),
            }),
            contact_overlap: mean_of(&overlaps),
        }
    }
}

/// The results of one frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrameReport {
    /// The frame, counted from 0.
    pub frame: u64,
    /// The largest visible true depth, mm.
    pub true_depth_mm: Option<f64>,
    /// The largest visible true flow, px.
    pub true_flow_px: Option<f64>,
    /// The errors of its fields.
    #[serde(flatten)]
    pub errors: FieldErrors,
    /// The errors of its force.
    pub force: Option<ForceErrors>,
}

/// The force of one frame, each array in the order x, y, z.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ForceErrors {
    /// The true force on the gel, N.
    pub true_n: [Option<f64>; 3],
    /// The estimated force on the gel, N.
    pub estimated_n: [Option<f64>; 3],
    /// Estimate − truth, N.
    pub error_n: [Option<f64>; 3],
    /// The error over the length of the largest true force of all frames, dimensionless.
    pub of_peak: [Option<f64>; 3],
    /// The true torque about z, N mm.
    pub true_torque_nmm: Option<f64>,
    /// The estimated torque about z, N mm.
    pub estimated_torque_nmm: Option<f64>,
}

/// The errors of one part of the load on the gel: normal force or shear force, N, or torque about z, N mm. The error of
/// a shear force is the length of the vector difference.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoadErrors {
    /// The largest true size of all frames.
    pub true_peak: f64,
    /// Mean error.
    pub mean: f64,
    /// The largest error.
    pub largest: f64,
    /// The mean error over the largest true size, dimensionless. None if that size is 0, for a shear force if it is
    /// below 5 % of the largest force, for a torque if it is below the largest force times an arm of 0.1 mm.
    pub mean_of_peak: Option<f64>,
    /// The error in the frame of the largest true size, the last of them, over that size, dimensionless; none as above.
    pub at_peak: Option<f64>,
}

/// The forces of all frames, each array in the order x, y, z.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ForceReport {
    /// Length of the largest true force, N.
    pub true_peak_n: f64,
    /// Mean of the absolute error, N.
    pub mean_n: [Option<f64>; 3],
    /// The largest absolute error, N.
    pub largest_n: [Option<f64>; 3],
    /// The mean absolute error over the largest true force, dimensionless.
    pub mean_of_peak: [Option<f64>; 3],
    /// Errors of the normal force.
    pub normal: Option<LoadErrors>,
    /// Errors of the shear force.
    pub shear: Option<LoadErrors>,
    /// Errors of the torque about z.
    pub torque: Option<LoadErrors>,
}

/// The result of a comparison. Prints as a table of the deepest frame and of the mean over frames.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// The run's folder.
    pub run: PathBuf,
    /// The folder of the truth.
    pub truth: PathBuf,
    /// Number of compared frames.
    pub frames: u64,
    /// Left column, top row, width and height of the run's grid on the truth's, px.
    pub region: [usize; 4],
    /// The fields that were compared.
    pub fields: Vec<&'static str>,
    /// Width of [`Region::Border`] on either side, mm on the undeformed gel.
    pub border_mm: f64,
    /// Missing inputs, and their consequences.
    pub notes: Vec<String>,
    /// The frame of the largest true depth, or flow where there is no true depth; the last one within 0.1 % of it.
    pub deepest_frame: u64,
    /// Each figure's mean over the frames.
    pub mean: FieldErrors,
    /// The figures over all pixels of all frames at once.
    pub pooled: FieldErrors,
    /// Pearson's correlation over the frames of the largest estimated with the largest true depth.
    pub peak_depth_correlation: Option<f64>,
    /// The errors of the force.
    pub force: Option<ForceReport>,
    /// Every frame.
    pub per_frame: Vec<FrameReport>,
}

impl Report {
    /// The results of the deepest frame; none if there is no frame.
    #[must_use]
    pub fn deepest(&self) -> Option<&FrameReport> {
        self.per_frame.iter().find(|frame| frame.frame == self.deepest_frame)
    }
}

/// The mean of some numbers; none if there are none.
pub(super) fn mean_of(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}
