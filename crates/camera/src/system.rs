//! The cameras of this machine.

use fingervision_touch::CaptureSection;

#[cfg(target_os = "linux")]
use crate::Video4Linux;
use crate::{Camera, CameraError};

/// Opens a camera of this machine.
///
/// # Errors
///
/// [`CameraError`] if no camera matches `capture`, it cannot be opened, or does not offer the mode. Where cameras are not
/// supported, [`CameraError::NoCamera`].
pub fn open(capture: CaptureSection) -> Result<Camera, CameraError> {
    #[cfg(target_os = "linux")]
    return Camera::open(Box::new(Video4Linux::default()), capture);
    #[cfg(not(target_os = "linux"))]
    {
        let _ = capture;
        Err(CameraError::NoCamera)
    }
}
