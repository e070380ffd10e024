/// Why a flow cannot be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FlowError {
    /// A parameter is outside its range.
    #[error("flow.{name} = {value} is out of range: {range}")]
    Parameter {
        /// Path of the parameter below `flow`.
        name: &'static str,
        /// The value given.
        value: f64,
        /// Its allowed range.
        range: &'static str,
    },
    /// The picture is too small to hold patches.
    #[error("a picture of {width}x{height} px is too small: width and height must be at least {least} px")]
    TooSmall {
        /// Columns, px.
        width: usize,
        /// Rows, px.
        height: usize,
        /// The least width and height, px.
        least: usize,
    },
    /// The picture has more pixels than the kernels can address.
    #[error("a picture of {width}x{height} px is too large: it may have at most {most} px in total")]
    TooLarge {
        /// Columns, px.
        width: usize,
        /// Rows, px.
        height: usize,
        /// The largest number of pixels.
        most: usize,
    },
}

impl FlowError {
    /// An error for parameter `name` unless the condition holds.
    pub(crate) fn check(holds: bool, name: &'static str, value: f64, range: &'static str) -> Result<(), Self> {
        if holds { Ok(()) } else { Err(Self::Parameter { name, value, range }) }
    }
}
