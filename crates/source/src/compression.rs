//! Finds the images of a folder that have lossy compression.

use std::path::PathBuf;

/// A note for a folder that contains images both with and without loss; none if all are of one kind.
///
/// JPEG shifts edges by parts of a pixel in its own way. If all images are JPEG, this is the same in all and mostly
/// cancels; between an image with and one without it, it appears as flow that does not exist.
pub(crate) fn mixed(files: &[PathBuf]) -> Option<String> {
    let is_lossy = |file: &&PathBuf| {
        let ending = file.extension().unwrap_or_default();
        ending.eq_ignore_ascii_case("jpg") || ending.eq_ignore_ascii_case("jpeg")
    };
    let lossy = files.iter().filter(is_lossy).count();
    let first_lossy = files.iter().find(is_lossy)?;
    (lossy < files.len()).then(|| {
        format!(
            "{lossy} of {} images are JPEG, the first is {}, the others have no loss: what JPEG changes in an image looks like \
             flow between the two kinds; record all in one format",
            files.len(),
            first_lossy.file_name().unwrap_or_default().display()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_mixture_is_spoken_of() {
        let files = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        let said = mixed(&files(&["a/0.png", "a/1.JPG", "a/2.tif", "a/3.jpeg"])).unwrap();
        assert!(said.starts_with("2 of 4 images are JPEG, the first is 1.JPG"), "{said}");
        assert_eq!(mixed(&files(&["0.png", "1.tiff", "2.bmp"])), None);
        assert_eq!(mixed(&files(&["0.jpg", "1.jpeg"])), None);
    }
}
