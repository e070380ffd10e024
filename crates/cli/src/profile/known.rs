//! Known values of a sensor before the calibration, as options.

use std::str::FromStr;

/// Known values of a sensor before the calibration.
#[derive(Debug, Default, clap::Args)]
pub(super) struct Known {
    /// Name of the sensor, as in "left index"
    #[arg(long, value_name = "NAME")]
    pub(super) name: Option<String>,
    /// Width and height of the camera's images, px, as in 640x480
    #[arg(long, value_name = "WxH", value_parser = size_px)]
    pub(super) image_size: Option<[usize; 2]>,
    /// The part of the image that shows the gel: left column, top row, width and height, px, as in 15,15,610,450;
    /// without it the whole image
    #[arg(long, value_name = "X,Y,W,H", value_parser = region)]
    pub(super) region_of_interest: Option<[usize; 4]>,
    /// Distance from the lens to the gel's surface, mm, as in 25
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub(super) distance_mm: Option<f64>,
    /// Width of the gel's surface that the region shows, mm, as in 38: a first estimate of the focal length, with
    /// --distance-mm and the size of the image or the region
    #[arg(long, value_name = "MM", value_parser = positive, requires = "distance_mm", conflicts_with = "focal_length_px")]
    pub(super) view_width_mm: Option<f64>,
    /// Focal length, px, as in 400, if it is known
    #[arg(long, value_name = "PX", value_parser = positive, requires = "distance_mm")]
    pub(super) focal_length_px: Option<f64>,
    /// Width and height of the gel, mm, as in 30,30
    #[arg(long, value_name = "W,H", value_parser = size_mm)]
    pub(super) gel_size_mm: Option<[f64; 2]>,
    /// Thickness of the gel as poured, mm, as in 10
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub(super) thickness_mm: Option<f64>,
    /// Poisson's ratio of the gel, 0 to below 0.5; silicone is nearly incompressible
    #[arg(long, value_name = "RATIO", default_value_t = 0.48, value_parser = ratio)]
    pub(super) poissons_ratio: f64,
    /// Young's modulus of the gel, MPa, as in 0.6 for silicone of shore 20A: needed for force
    #[arg(long, value_name = "MPA", value_parser = positive)]
    pub(super) youngs_modulus_mpa: Option<f64>,
}

/// Numbers separated by commas, or by x.
fn numbers<const N: usize, T: FromStr + Copy + Default>(text: &str) -> Option<[T; N]> {
    let mut values = [T::default(); N];
    let mut parts = text.split([',', 'x']);
    for value in &mut values {
        *value = parts.next()?.trim().parse().ok()?;
    }
    parts.next().is_none().then_some(values)
}

fn size_px(text: &str) -> Result<[usize; 2], String> {
    let size = numbers(text).filter(|size: &[usize; 2]| size.iter().all(|&side| side > 0));
    size.ok_or_else(|| "expected a width and a height above 0 px, as in 640x480".into())
}

fn region(text: &str) -> Result<[usize; 4], String> {
    let region = numbers(text).filter(|&[_, _, width, height]: &[usize; 4]| width > 0 && height > 0);
    region.ok_or_else(|| "expected x, y, width and height in px, as in 15,15,610,450".into())
}

fn size_mm(text: &str) -> Result<[f64; 2], String> {
    let size = numbers(text).filter(|size: &[f64; 2]| size.iter().all(|side| side.is_finite() && *side > 0.0));
    size.ok_or_else(|| "expected a width and a height above 0 mm, as in 30,30".into())
}

fn positive(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value: &f64| value.is_finite() && *value > 0.0);
    value.ok_or_else(|| "expected a number above 0".into())
}

fn ratio(text: &str) -> Result<f64, String> {
    let ratio = text.parse().ok().filter(|ratio| (0.0..0.5).contains(ratio));
    ratio.ok_or_else(|| "expected a number from 0 to below 0.5".into())
}
