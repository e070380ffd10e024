/// Why a sheet or a motion cannot be rendered.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GelError {
    /// A parameter of the sheet lies outside its range.
    #[error("{name} is {value}: {allowed} is allowed")]
    OutOfRange {
        /// The parameter.
        name: &'static str,
        /// Its value, in the parameter's own unit.
        value: f64,
        /// The range in words, with its unit.
        allowed: &'static str,
    },
    /// The motion maps two points of the reference to the same place, so the image is not defined there.
    #[error("the motion folds: its smallest stretch is {stretch:.3}, which must be above zero")]
    Folds {
        /// Smallest ratio of a current length to its reference length along a ray from the centre, dimensionless.
        stretch: f64,
    },
}
