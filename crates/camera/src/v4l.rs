//! Cameras on Linux, through V4L2.
//!
//! The V4L2 library panics on some unknown answers of drivers. Every call therefore catches panics and returns them as
//! errors of the camera. Four mapped buffers let the driver continue while a frame is decoded.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::Duration;

use moq_v4l::buffer::{Flags, Type};
use moq_v4l::capability::Flags as Capability;
use moq_v4l::control::{Control as RawControl, Flags as ControlFlags, Type as ControlType, Value};
use moq_v4l::format::Quantization;
use moq_v4l::io::traits::CaptureStream;
use moq_v4l::prelude::MmapStream;
use moq_v4l::video::Capture;
use moq_v4l::video::capture::Parameters;
use moq_v4l::{Format, Fraction};

use crate::{Buffer, Bus, Control, Device, FourCc, Layout, Mode, Node, Offer, nodes, v4l_offers};

/// Buffers that are mapped.
const BUFFERS: u32 = 4;
/// `poll`: there is data to read.
const POLLIN: i16 = 1;
/// Rates are written in thousandths, which represents 29.97 exactly.
const RATE_DENOMINATOR: f64 = 1000.0;

/// The cameras of this machine.
#[derive(Debug, Clone)]
pub struct Video4Linux {
    dev: PathBuf,
    sys: PathBuf,
}

impl Default for Video4Linux {
    fn default() -> Self {
        Self { dev: "/dev".into(), sys: "/sys".into() }
    }
}

impl Bus for Video4Linux {
    fn nodes(&self) -> Vec<Node> {
        nodes(&self.dev, &self.sys)
    }

    fn is_capture(&self, node: &Path) -> io::Result<bool> {
        let capabilities = guarded(|| open(node)?.query_caps())?.capabilities;
        Ok(capabilities.contains(Capability::VIDEO_CAPTURE | Capability::STREAMING))
    }

    fn open(&self, node: &Path) -> io::Result<Box<dyn Device>> {
        Ok(Box::new(V4lDevice { device: open(node)?, stream: None }))
    }
}

fn open(node: &Path) -> io::Result<moq_v4l::Device> {
    moq_v4l::Device::with_path(node)
}

struct V4lDevice {
    device: moq_v4l::Device,
    stream: Option<Stream>,
}

struct Stream {
    buffers: MmapStream<'static>,
    has_started: bool,
}

impl Device for V4lDevice {
    fn offers(&self) -> io::Result<Vec<Offer>> {
        guarded(|| v4l_offers::offers(&self.device))
    }

    fn controls(&self) -> io::Result<Vec<Control>> {
        let described = match guarded(|| self.device.query_controls()) {
            Ok(described) => described,
            // No control at all.
            Err(error) if error.kind() == io::ErrorKind::InvalidInput || is_no_ioctl(&error) => return Ok(Vec::new()),
            Err(error) => return Err(error),
        };
        let is_value = |kind| {
            matches!(kind, ControlType::Integer | ControlType::Integer64 | ControlType::Boolean | ControlType::Menu)
        };
        let usable = described.into_iter().filter(|control| {
            is_value(control.typ) && !control.flags.intersects(ControlFlags::DISABLED | ControlFlags::READ_ONLY)
        });
        Ok(usable
            .map(|control| Control {
                id: control.id,
                name: control.name,
                least: control.minimum,
                most: control.maximum,
            })
            .collect())
    }

    fn control(&self, id: u32) -> io::Result<i64> {
        match guarded(|| self.device.control(id))?.value {
            Value::Integer(value) => Ok(value),
            Value::Boolean(value) => Ok(value.into()),
            _ => Err(io::Error::other("not a number")),
        }
    }

    fn set_control(&mut self, id: u32, value: i64) -> io::Result<()> {
        guarded(|| self.device.set_control(RawControl { id, value: Value::Integer(value) }))
    }

    fn set_mode(&mut self, mode: Mode) -> io::Result<Layout> {
        let [width, height] = mode.size;
        let wanted = Format::new(width, height, moq_v4l::FourCC::new(&mode.format.0));
        guarded(|| {
            let format = self.device.set_format(&wanted)?;
            let interval =
                Fraction::new(RATE_DENOMINATOR as u32, (mode.frames_per_second * RATE_DENOMINATOR).round() as u32);
            let frames_per_second = match self.device.set_params(&Parameters::new(interval)) {
                Ok(in_force) => v4l_offers::rate(in_force.interval).unwrap_or(mode.frames_per_second),
                // A driver with a single rate may refuse to set it.
                Err(error) if error.kind() == io::ErrorKind::InvalidInput || is_no_ioctl(&error) => {
                    mode.frames_per_second
                }
                Err(error) => return Err(error),
            };
            let size = [format.width, format.height];
            Ok(Layout {
                mode: Mode { format: FourCc(format.fourcc.repr), size, frames_per_second },
                row_bytes: format.stride,
                is_full_range: matches!(format.quantization, Quantization::FullRange),
            })
        })
    }

    fn start(&mut self) -> io::Result<()> {
        self.stop();
        let buffers = guarded(|| MmapStream::with_buffers(&self.device, Type::VideoCapture, BUFFERS))?;
        self.stream = Some(Stream { buffers, has_started: false });
        Ok(())
    }

    fn next(&mut self, wait: Duration) -> io::Result<Buffer<'_>> {
        let Some(Stream { buffers, has_started }) = &mut self.stream else {
            return Err(io::Error::other("capture has not started"));
        };
        let wait_ms = wait.as_millis().min(1 << 30) as i32;
        let handle = buffers.handle();
        // The first call starts the camera and waits itself. Later ones wait here, so that a wait that ends without a frame
        // leaves the buffers as they are.
        buffers.set_timeout(wait);
        if *has_started && guarded(|| handle.poll(POLLIN, wait_ms))? == 0 {
            return Err(io::ErrorKind::TimedOut.into());
        }
        *has_started = true;
        let (bytes, about) = guarded(|| CaptureStream::next(buffers))?;
        let used = (about.bytesused as usize).min(bytes.len());
        Ok(Buffer {
            bytes: &bytes[..used],
            sequence: about.sequence,
            stamp_s: about.timestamp.sec as f64 + 1e-6 * about.timestamp.usec as f64,
            is_damaged: about.flags.contains(Flags::ERROR),
        })
    }

    fn stop(&mut self) {
        let stream = self.stream.take();
        // If stopping fails, the camera has already stopped.
        let _ = guarded(|| {
            drop(stream);
            Ok(())
        });
    }
}

impl Drop for V4lDevice {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Whether the error means that the driver does not support a call (ENOTTY).
pub(crate) fn is_no_ioctl(error: &io::Error) -> bool {
    error.raw_os_error() == Some(25)
}

/// Calls the library; a panic in it becomes an error.
fn guarded<T>(call: impl FnOnce() -> io::Result<T>) -> io::Result<T> {
    catch_unwind(AssertUnwindSafe(call))
        .unwrap_or_else(|_| Err(io::Error::other("the driver's answer is not understood")))
}
