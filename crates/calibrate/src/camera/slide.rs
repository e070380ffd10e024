use serde::Serialize;

/// The motion of a board along the surface between consecutive images.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Slide {
    /// Length of a step, mm.
    pub step_mm: f64,
    /// Direction in gel space, rad from x towards y.
    pub direction_rad: f64,
}

impl Slide {
    /// The step in gel space, mm.
    #[must_use]
    pub fn step_vector_mm(&self) -> [f64; 2] {
        let (sine, cosine) = self.direction_rad.sin_cos();
        [self.step_mm * cosine, self.step_mm * sine]
    }
}
