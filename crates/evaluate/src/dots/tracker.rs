//! Computes a dense flow from images of dots.

use fingervision_flow::FlowField;
use fingervision_image::{Image, Pixels, Rect, grey_into};

use super::DotError;
use super::detect::find_dots;
use super::follow::Followed;
use super::spline::ThinPlate;

/// Least number of dots for a field.
const LEAST: usize = 4;

/// The result of one image of dots.
#[derive(Debug, Clone)]
pub struct DotReading {
    /// Displacement of every pixel since the first image, px, on its grid: the thin-plate spline through the dots that
    /// are found. Beyond the outermost dots it is extrapolated.
    pub flow: FlowField,
    /// Dots of the first image that are not found in this one.
    pub lost: usize,
}

/// Tracks the dots of a first image through all later ones.
#[derive(Debug, Clone)]
pub struct DotTracker {
    size: (usize, usize),
    grey: Image<f32>,
    dots: Followed,
    spline: ThinPlate,
    reading: DotReading,
}

impl DotTracker {
    /// A tracker whose first image is this one.
    ///
    /// # Errors
    ///
    /// [`DotError::TooFew`] if it shows fewer than four dots, or all on one line.
    pub fn new(first: &Pixels) -> Result<Self, DotError> {
        let size = first.size();
        let mut grey = Image::filled(size.0, size.1, 0.0);
        grey_into(first, Rect::whole(size.0, size.1), &mut grey)?;
        let found = find_dots(&grey);
        if found.len() < LEAST {
            return Err(DotError::TooFew { seen: found.len(), least: LEAST });
        }
        let dots = Followed::new(&found);
        let spline = ThinPlate::new(&found, dots.pitch_px(), size);
        let reading = DotReading { flow: FlowField::zero(size.0, size.1), lost: 0 };
        let mut tracker = Self { size, grey, dots, spline, reading };
        tracker.interpolate()?;
        Ok(tracker)
    }

    /// Positions of the dots in the first image, `(x, y)`, px.
    #[must_use]
    pub fn reference_px(&self) -> &[[f64; 2]] {
        self.dots.reference_px()
    }

    /// Displacement of each dot from there in the last image, px; none where it was not found.
    pub fn displacements_px(&self) -> impl Iterator<Item = Option<[f64; 2]>> {
        self.dots.is_seen().iter().enumerate().map(|(dot, is_seen)| is_seen.then(|| self.dots.displacement_px(dot)))
    }

    /// The reading of the next image. Between two images a dot may move by less than half the distance to its
    /// neighbour, beyond the prediction by its last motion.
    ///
    /// # Errors
    ///
    /// [`DotError::SizeChanged`], and [`DotError::TooFew`] if fewer than four dots are found, or all on one line. The
    /// tracker stays usable.
    pub fn track(&mut self, image: &Pixels) -> Result<&DotReading, DotError> {
        let (found, expected) = (image.size(), self.size);
        if found != expected {
            return Err(DotError::SizeChanged { found, expected });
        }
        grey_into(image, Rect::whole(expected.0, expected.1), &mut self.grey)?;
        self.dots.advance(&find_dots(&self.grey));
        self.interpolate()?;
        Ok(&self.reading)
    }

    fn interpolate(&mut self) -> Result<(), DotError> {
        let is_seen = self.dots.is_seen();
        let seen = is_seen.iter().filter(|&&seen| seen).count();
        let too_few = DotError::TooFew { seen, least: LEAST };
        if seen < LEAST {
            return Err(too_few);
        }
        let displacements: Vec<[f64; 2]> = (0..is_seen.len()).map(|dot| self.dots.displacement_px(dot)).collect();
        let FlowField { u, v } = &mut self.reading.flow;
        self.reading.lost = is_seen.len() - seen;
        if self.spline.interpolate_into(&displacements, is_seen, [u, v]) { Ok(()) } else { Err(too_few) }
    }
}
