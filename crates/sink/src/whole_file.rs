//! Small files, written as a whole or not at all.

use std::path::Path;

use crate::SinkError;

/// Writes a small file to the disk, as a whole or not at all; see [`fingervision_settings::write_file`].
///
/// # Errors
///
/// [`SinkError::Write`] if the disk refuses it.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), SinkError> {
    fingervision_settings::write_file(path, bytes).map_err(SinkError::writing(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_names_the_file_and_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        let error = write_file(&folder.path().join("none/picture.png"), b"new").unwrap_err();
        assert!(error.to_string().contains("none/picture.png"), "{error}");
        assert_eq!(error.hint(), Some("make the folder first"));
        let error = write_file(folder.path(), b"new").unwrap_err();
        assert_eq!(error.hint(), Some("name a file in the folder"));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_named() {
        let folder = tempfile::tempdir().unwrap();
        std::os::unix::fs::symlink("/dev/full", folder.path().join("picture.png.new")).unwrap();
        let error = write_file(&folder.path().join("picture.png"), b"new").unwrap_err();
        assert!(error.to_string().contains("picture.png: No space left"), "{error}");
        assert!(error.hint().is_some_and(|hint| hint.starts_with("free some space")), "{error}");
    }
}
