//! Corners as a file: `image,x_mm,y_mm,u_px,v_px`.

use thiserror::Error;

use super::corners::{Corner, LEAST_CORNERS, LEAST_POSES};

/// The first line of the file.
const HEADER: &str = "image,x_mm,y_mm,u_px,v_px";

/// Why corners do not determine a camera.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CornerError {
    /// The file's first line is not the header.
    #[error("line 1 is not {HEADER}")]
    NoHeader,
    /// A line is not five numbers.
    #[error("line {line}: \"{text}\" is not five numbers separated by commas")]
    Line {
        /// The line, counted from 1.
        line: usize,
        /// The line's content.
        text: String,
    },
    /// There are too few images.
    #[error("the corners are of {images} images: at least {LEAST_POSES} are needed")]
    TooFewImages {
        /// Number of images.
        images: usize,
    },
    /// An image has too few corners.
    #[error("image {image} has {corners} corners: at least {LEAST_CORNERS} are needed")]
    TooFewCorners {
        /// The image, counted from 0 in the order of the file.
        image: usize,
        /// Number of corners.
        corners: usize,
    },
    /// The corners of an image lie on a line.
    #[error("the corners of an image lie on one line")]
    NoPlane,
    /// The board was parallel to the image in all images.
    #[error("the board is not tilted in any image: its corners do not tell the focal length")]
    NoTilt,
    /// No camera explains the corners.
    #[error("no camera explains the corners: the best misses them by {residual_px:.1} px on average")]
    NotConverged {
        /// Mean distance, px.
        residual_px: f64,
    },
}

impl CornerError {
    /// What to do about it.
    #[must_use]
    pub fn hint(&self) -> &'static str {
        match self {
            Self::NoHeader | Self::Line { .. } => {
                "a row for each corner: the image's number, where the corner is on the board, mm, and in the image, px, below the line image,x_mm,y_mm,u_px,v_px"
            }
            Self::TooFewImages { .. } => "show the board in 5 or more poses, tilted by 15° to 40° to different sides",
            Self::TooFewCorners { .. } | Self::NoPlane => "leave the image out, or detect all its corners",
            Self::NoTilt => "tilt the board by 15° to 40° to different sides",
            Self::NotConverged { .. } => {
                "no profile was written: check the order of the corners, and that x points right and y down on the board"
            }
        }
    }
}

/// The corners of each image, in the order in which the images come.
///
/// # Errors
///
/// [`CornerError::NoHeader`] and [`CornerError::Line`].
pub fn read_corners(text: &str) -> Result<Vec<Vec<Corner>>, CornerError> {
    let mut lines = text.lines().enumerate();
    if lines.next().is_none_or(|(_, header)| header.replace(' ', "").trim() != HEADER) {
        return Err(CornerError::NoHeader);
    }
    let (mut names, mut images): (Vec<&str>, Vec<Vec<Corner>>) = (Vec::new(), Vec::new());
    for (index, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let fault = || CornerError::Line { line: index + 1, text: line.into() };
        let (name, rest) = line.split_once(',').ok_or_else(fault)?;
        let numbers: Result<Vec<f64>, _> = rest.split(',').map(|number| number.trim().parse()).collect();
        let Ok(&[x, y, u, v]) = numbers.as_deref() else { return Err(fault()) };
        if ![x, y, u, v].iter().all(|value: &f64| value.is_finite()) {
            return Err(fault());
        }
        let image = names.iter().position(|known| *known == name.trim()).unwrap_or_else(|| {
            names.push(name.trim());
            images.push(Vec::new());
            images.len() - 1
        });
        images[image].push(Corner { board_mm: [x, y], px: [u, v] });
    }
    Ok(images)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_read_image_by_image() {
        let images =
            read_corners("image,x_mm,y_mm,u_px,v_px\na,0,0,10.5,20\nb,1,0,30,40\na, 1, 0, 12, 20\n\n").unwrap();
        assert_eq!(images.iter().map(Vec::len).collect::<Vec<_>>(), [2, 1]);
        assert_eq!(images[0][1], Corner { board_mm: [1.0, 0.0], px: [12.0, 20.0] });
    }

    #[test]
    fn an_invalid_corner_is_named_with_its_line() {
        assert_eq!(read_corners("x,y"), Err(CornerError::NoHeader));
        let header = "image,x_mm,y_mm,u_px,v_px\n";
        for line in ["0,1,2,3", "0,1,2,3,x", "0,1,2,3,nan", "0,1,2,3,4,5"] {
            let error = read_corners(&format!("{header}{line}")).unwrap_err();
            assert_eq!(error, CornerError::Line { line: 2, text: line.into() });
        }
    }
}
