//! Formats, sizes and rates of a camera.

use std::fmt;

use fingervision_source::CameraCoding;

/// Two rates count as equal up to this relative difference: a camera states 30, its driver 30000/1001.
const RATE_TOLERANCE: f64 = 0.005;

/// The code of a pixel format, as in `MJPG`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FourCc(pub [u8; 4]);

impl FourCc {
    /// Motion JPEG.
    pub const MJPG: Self = Self(*b"MJPG");
    /// JPEG pictures, as some drivers name them.
    pub const JPEG: Self = Self(*b"JPEG");
    /// 4:2:2, `Y U Y V`.
    pub const YUYV: Self = Self(*b"YUYV");
    /// 8-bit grey.
    pub const GREY: Self = Self(*b"GREY");
    /// 16-bit grey.
    pub const Y16: Self = Self(*b"Y16 ");

    /// The code from its name, with or without trailing spaces, in any case.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        let name = name.trim_end().to_ascii_uppercase();
        let is_code = (1..=4).contains(&name.len()) && name.bytes().all(|byte| byte.is_ascii_graphic());
        let padded = format!("{name:4}");
        is_code.then(|| padded.as_bytes().first_chunk().copied()).flatten().map(Self)
    }

    /// How frames of this format are decoded; `None` if they cannot be decoded.
    #[must_use]
    pub fn coding(self, is_full_range: bool) -> Option<CameraCoding> {
        match &self.0 {
            b"MJPG" | b"JPEG" => Some(CameraCoding::MotionJpeg),
            b"YUYV" => Some(CameraCoding::Yuyv { is_full_range }),
            b"GREY" => Some(CameraCoding::Grey8),
            b"Y16 " => Some(CameraCoding::Grey16),
            _ => None,
        }
    }

    /// The order of preference if no format is requested: compressed formats, then colour, then grey.
    fn preference(self) -> Option<usize> {
        [Self::MJPG, Self::JPEG, Self::YUYV, Self::GREY, Self::Y16].iter().position(|format| *format == self)
    }
}

impl fmt::Display for FourCc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(String::from_utf8_lossy(&self.0).trim_end())
    }
}

/// One way to capture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mode {
    /// The pixel format.
    pub format: FourCc,
    /// Columns and rows, px.
    pub size: [u32; 2],
    /// Frames per second.
    pub frames_per_second: f64,
}

impl Mode {
    /// The mode in which a camera captures if nothing is requested: 640x480 px if it offers this size, at the highest
    /// rate; of several formats with this rate, MJPG is preferred, then YUYV, then grey. `None` if the camera offers no
    /// format that can be decoded.
    #[must_use]
    pub fn preferred(offers: &[Offer]) -> Option<Self> {
        choose(offers, Wish::default())
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        write!(f, "{} {width}x{height} px at {}", self.format, rate(self.frames_per_second))
    }
}

/// A rate in words.
pub(crate) fn rate(frames_per_second: f64) -> String {
    format!("{} frames/s", rounded(frames_per_second))
}

/// A rate with at most two decimals.
fn rounded(frames_per_second: f64) -> f64 {
    (100.0 * frames_per_second).round() / 100.0
}

/// A format, a size or a range of sizes, and their rates.
#[derive(Debug, Clone, PartialEq)]
pub struct Offer {
    /// The pixel format.
    pub format: FourCc,
    /// Its size.
    pub size: SizeOffer,
    /// The rates at this size.
    pub rates: RateOffer,
}

/// The sizes of an offer, columns and rows, px.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SizeOffer {
    /// One size.
    One([u32; 2]),
    /// Any size between two, in steps that the driver defines.
    Range {
        /// The smallest.
        least: [u32; 2],
        /// The largest.
        most: [u32; 2],
    },
}

/// The rates of an offer, frames per second.
#[derive(Debug, Clone, PartialEq)]
pub enum RateOffer {
    /// These.
    List(Vec<f64>),
    /// Any between two.
    Range {
        /// The lowest.
        least: f64,
        /// The highest.
        most: f64,
    },
    /// The driver does not say.
    Unknown,
}

impl SizeOffer {
    fn holds(self, size: [u32; 2]) -> bool {
        match self {
            Self::One(one) => one == size,
            Self::Range { least, most } => (0..2).all(|axis| (least[axis]..=most[axis]).contains(&size[axis])),
        }
    }
}

impl RateOffer {
    /// The highest rate, frames per second.
    #[must_use]
    pub fn highest(&self) -> Option<f64> {
        match self {
            Self::List(rates) => rates.iter().copied().reduce(f64::max),
            Self::Range { most, .. } => Some(*most),
            Self::Unknown => None,
        }
    }

    fn holds(&self, frames_per_second: f64) -> bool {
        match self {
            Self::List(rates) => rates.iter().any(|rate| is_same_rate(*rate, frames_per_second)),
            Self::Range { least, most } => {
                (*least * (1.0 - RATE_TOLERANCE)..=*most * (1.0 + RATE_TOLERANCE)).contains(&frames_per_second)
            }
            Self::Unknown => true,
        }
    }
}

/// Whether two rates differ by no more than rounding.
pub(crate) fn is_same_rate(a: f64, b: f64) -> bool {
    (a - b).abs() <= RATE_TOLERANCE * a.abs().max(b.abs())
}

impl fmt::Display for Offer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.size {
            SizeOffer::One([width, height]) => write!(f, "{} {width}x{height}", self.format)?,
            SizeOffer::Range { least, most } => {
                write!(f, "{} {}x{} to {}x{}", self.format, least[0], least[1], most[0], most[1])?;
            }
        }
        match &self.rates {
            RateOffer::List(rates) if rates.is_empty() => Ok(()),
            RateOffer::List(rates) => {
                let rates: Vec<String> = rates.iter().map(|rate| rounded(*rate).to_string()).collect();
                write!(f, " at {} frames/s", rates.join(", "))
            }
            RateOffer::Range { least, most } => write!(f, " at {} to {} frames/s", rounded(*least), rounded(*most)),
            RateOffer::Unknown => Ok(()),
        }
    }
}

/// The requested values of a mode; absent ones are chosen here.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Wish {
    pub(crate) format: Option<FourCc>,
    pub(crate) size: Option<[u32; 2]>,
    pub(crate) frames_per_second: Option<f64>,
}

/// The size if none is requested, px.
const STANDARD_SIZE: [u32; 2] = [640, 480];
/// The rate if neither the profile nor the driver gives one.
const STANDARD_RATE: f64 = 30.0;

/// The mode to capture in; `None` if the camera does not offer the requested values.
///
/// Absent values are chosen as in [`Mode::preferred`].
pub(crate) fn choose(offers: &[Offer], wish: Wish) -> Option<Mode> {
    let has_standard =
        offers.iter().any(|offer| offer.format.coding(false).is_some() && offer.size.holds(STANDARD_SIZE));
    let sizes = |offer: &Offer| match (wish.size, offer.size) {
        (Some(size), held) => held.holds(size).then_some(size),
        (None, held) if has_standard => held.holds(STANDARD_SIZE).then_some(STANDARD_SIZE),
        (None, SizeOffer::One(size) | SizeOffer::Range { most: size, .. }) => Some(size),
    };
    let mode = |offer: &Offer| {
        let frames_per_second = match wish.frames_per_second {
            Some(rate) => offer.rates.holds(rate).then_some(rate)?,
            None => offer.rates.highest().unwrap_or(STANDARD_RATE),
        };
        let is_wished = wish.format.is_none_or(|format| format == offer.format);
        let order = offer.format.preference()?;
        is_wished.then_some((order, Mode { format: offer.format, size: sizes(offer)?, frames_per_second }))
    };
    let modes = offers.iter().filter_map(mode);
    let better = |(a_order, a): (usize, Mode), (b_order, b): (usize, Mode)| {
        let is_better = if is_same_rate(a.frames_per_second, b.frames_per_second) {
            b_order < a_order
        } else {
            b.frames_per_second > a.frames_per_second
        };
        if is_better { (b_order, b) } else { (a_order, a) }
    };
    modes.reduce(better).map(|(_, mode)| mode)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn offer(format: FourCc, size: [u32; 2], rates: &[f64]) -> Offer {
        Offer { format, size: SizeOffer::One(size), rates: RateOffer::List(rates.to_vec()) }
    }

    fn offers() -> Vec<Offer> {
        vec![
            offer(FourCc::YUYV, [640, 480], &[30.0, 15.0]),
            offer(FourCc(*b"H264"), [640, 480], &[240.0]),
            offer(FourCc::MJPG, [640, 480], &[90.0, 30.0]),
            offer(FourCc::MJPG, [1280, 720], &[60.0]),
        ]
    }

    #[test]
    fn without_a_wish_the_fastest_mode_of_640x480_is_chosen() {
        let mode = choose(&offers(), Wish::default()).unwrap();
        assert_eq!(mode, Mode { format: FourCc::MJPG, size: [640, 480], frames_per_second: 90.0 });
        assert_eq!(mode.to_string(), "MJPG 640x480 px at 90 frames/s");
    }

    #[test]
    fn of_equal_rates_the_smallest_on_the_wire_is_chosen() {
        let wish = Wish { frames_per_second: Some(29.97), ..Wish::default() };
        assert_eq!(choose(&offers(), wish).unwrap().format, FourCc::MJPG);
    }

    #[test]
    fn what_is_not_offered_is_not_chosen() {
        let wish = Wish { format: Some(FourCc::YUYV), frames_per_second: Some(60.0), ..Wish::default() };
        assert_eq!(choose(&offers(), wish), None);
        assert_eq!(choose(&offers(), Wish { size: Some([320, 240]), ..Wish::default() }), None);
        assert_eq!(choose(&offers(), Wish { format: Some(FourCc(*b"H264")), ..Wish::default() }), None);
        assert_eq!(choose(&[], Wish::default()), None);
    }

    #[test]
    fn a_range_of_sizes_and_rates_holds_what_lies_in_it() {
        let size = SizeOffer::Range { least: [2, 2], most: [8192, 8192] };
        let ranged = [Offer { format: FourCc::GREY, size, rates: RateOffer::Range { least: 1.0, most: 100.0 } }];
        let wish = Wish { size: Some([800, 600]), frames_per_second: Some(90.0), ..Wish::default() };
        assert_eq!(choose(&ranged, wish).unwrap().size, [800, 600]);
        assert_eq!(choose(&ranged, Wish::default()).unwrap().size, [640, 480]);
        assert_eq!(choose(&ranged, Wish { frames_per_second: Some(120.0), ..wish }), None);
    }

    #[test]
    fn codes_have_names() {
        assert_eq!(FourCc::from_name("mjpg"), Some(FourCc::MJPG));
        assert_eq!(FourCc::from_name("Y16"), Some(FourCc::Y16));
        assert_eq!(FourCc::Y16.to_string(), "Y16");
        assert_eq!(FourCc::from_name("jpeg5"), None);
        assert_eq!(FourCc::from_name(""), None);
    }
}
