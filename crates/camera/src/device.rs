//! The interface between this crate and a system's cameras.

use std::io;
use std::path::Path;
use std::time::Duration;

use crate::{Mode, Node, Offer};

/// An open camera.
///
/// Errors keep the system's error number, which distinguishes an unplugged camera from a busy one.
pub trait Device: Send {
    /// Formats, sizes and rates.
    ///
    /// # Errors
    ///
    /// The system's.
    fn offers(&self) -> io::Result<Vec<Offer>>;

    /// The controls: exposure, gain and others.
    ///
    /// # Errors
    ///
    /// The system's.
    fn controls(&self) -> io::Result<Vec<Control>>;

    /// The value of a control.
    ///
    /// # Errors
    ///
    /// The system's.
    fn control(&self, id: u32) -> io::Result<i64>;

    /// Sets a control.
    ///
    /// # Errors
    ///
    /// The system's.
    fn set_control(&mut self, id: u32, value: i64) -> io::Result<()>;

    /// Sets format, size and rate. Returns the values that the driver accepted, and how the frames lie in memory.
    ///
    /// # Errors
    ///
    /// The system's.
    fn set_mode(&mut self, mode: Mode) -> io::Result<Layout>;

    /// Starts to capture.
    ///
    /// # Errors
    ///
    /// The system's.
    fn start(&mut self) -> io::Result<()>;

    /// The next frame; the previous one is returned to the driver.
    ///
    /// # Errors
    ///
    /// [`io::ErrorKind::TimedOut`] if none comes in time, otherwise the system's.
    fn next(&mut self, wait: Duration) -> io::Result<Buffer<'_>>;

    /// Stops capture. A camera that was unplugged has already stopped.
    fn stop(&mut self);
}

/// The cameras of a system.
pub trait Bus: Send {
    /// The video nodes of this system, including those that are not cameras.
    fn nodes(&self) -> Vec<Node>;

    /// Whether a node captures images that this crate can read; nodes of metadata do not.
    ///
    /// # Errors
    ///
    /// The system's.
    fn is_capture(&self, node: &Path) -> io::Result<bool>;

    /// Opens a camera.
    ///
    /// # Errors
    ///
    /// The system's.
    fn open(&self, node: &Path) -> io::Result<Box<dyn Device>>;

    /// Waits before the next attempt to find a camera that is missing.
    fn pause(&self, duration: Duration) {
        std::thread::sleep(duration);
    }
}

/// The mode in force and how its frames lie in memory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layout {
    /// The mode in force; it may differ from the requested one.
    pub mode: Mode,
    /// Distance from one row to the next, bytes; 0 if the rows follow each other without padding.
    pub row_bytes: u32,
    /// Luma spans 0 to 255.
    pub is_full_range: bool,
}

/// A frame as the driver delivers it.
#[derive(Debug, Clone, Copy)]
pub struct Buffer<'a> {
    /// The bytes that the frame uses.
    pub bytes: &'a [u8],
    /// The driver's count of frames, which includes those that it dropped.
    pub sequence: u32,
    /// The driver's time stamp, s.
    pub stamp_s: f64,
    /// The driver reports the frame as damaged.
    pub is_damaged: bool,
}

/// A control of a camera.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Control {
    /// Its number in V4L2.
    pub id: u32,
    /// The driver's name for it.
    pub name: String,
    /// The smallest value.
    pub least: i64,
    /// The largest value.
    pub most: i64,
}
