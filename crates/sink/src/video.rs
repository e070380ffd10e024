//! The file of a video, in the format that the ending of its name says.

use std::path::Path;

use fingervision_image::Image;
use fingervision_plot::Rgb;
use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;

use crate::SinkError;
use crate::avi::AviWriter;
#[cfg(feature = "mp4")]
use crate::mp4::Mp4Writer;

/// JPEG quality, 0 to 100.
const QUALITY: u8 = 90;

/// A video that grows picture by picture.
#[derive(Debug)]
pub(crate) enum Video {
    /// Motion JPEG.
    Avi { to: AviWriter, jpeg: Vec<u8> },
    /// H.264.
    #[cfg(feature = "mp4")]
    Mp4(Box<Mp4Writer>),
}

impl Video {
    /// Creates a file, or empties it, for pictures of this size in px: MP4 if its name ends so, otherwise AVI.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the file cannot be written, [`SinkError::NotBuilt`] for MP4 without the feature.
    pub(crate) fn create(path: &Path, size: (usize, usize)) -> Result<Self, SinkError> {
        if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mp4")) {
            #[cfg(feature = "mp4")]
            return Ok(Self::Mp4(Box::new(Mp4Writer::create(path, size)?)));
            #[cfg(not(feature = "mp4"))]
            return Err(SinkError::NotBuilt { path: path.to_path_buf(), what: "MP4" });
        }
        Ok(Self::Avi { to: AviWriter::create(path, size)?, jpeg: Vec::new() })
    }

    /// Appends a picture at this time, s since the first one; `period_s` is the mean time between pictures so far.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the file cannot take it.
    #[cfg_attr(not(feature = "mp4"), expect(unused_variables, reason = "an AVI file has one period for all pictures"))]
    pub(crate) fn write(&mut self, picture: &Image<Rgb>, time_s: f64, period_s: f64) -> Result<(), SinkError> {
        match self {
            Self::Avi { to, jpeg } => {
                jpeg.clear();
                let (width, height) = picture.size();
                JpegEncoder::new_with_quality(&mut *jpeg, QUALITY)
                    .encode(picture.values().as_flattened(), width as u32, height as u32, ExtendedColorType::Rgb8)
                    .map_err(|error| {
                        SinkError::writing(Path::new("a frame of the overlay"))(std::io::Error::other(error))
                    })?;
                to.write(jpeg, period_s)
            }
            #[cfg(feature = "mp4")]
            Self::Mp4(to) => to.write(picture, time_s),
        }
    }

    /// Closes the video and flushes it to the disk.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the disk refuses it.
    pub(crate) fn finish(self) -> Result<(), SinkError> {
        match self {
            Self::Avi { to, .. } => to.finish(),
            #[cfg(feature = "mp4")]
            Self::Mp4(to) => to.finish(),
        }
    }
}
