//! Video files: H.264 and motion JPEG, in MP4, MOV and AVI.

mod avi;
mod decoder;
mod fault;
mod fields;
mod h264;
mod mp4;
mod numbering;
mod source;
mod track;

use crate::{Source, SourceError};
use source::VideoSource;
use std::path::Path;

/// Opens an MP4 or MOV file.
pub(crate) fn open_mp4(path: &Path) -> Result<Box<dyn Source>, SourceError> {
    Ok(Box::new(VideoSource::open(path, mp4::read_track)?))
}

/// Opens an AVI file.
pub(crate) fn open_avi(path: &Path) -> Result<Box<dyn Source>, SourceError> {
    Ok(Box::new(VideoSource::open(path, avi::read_track)?))
}
