//! The formats that a camera on Linux offers, their sizes, and the rates of each size.

use std::io;

use moq_v4l::frameinterval::FrameIntervalEnum;
use moq_v4l::framesize::FrameSizeEnum;
use moq_v4l::video::Capture;
use moq_v4l::{Device, FourCC, Fraction};

use crate::{FourCc, Offer, RateOffer, SizeOffer};

pub(crate) fn offers(device: &Device) -> io::Result<Vec<Offer>> {
    let mut offers = Vec::new();
    for format in device.enum_formats()? {
        for size in sizes(device, format.fourcc)? {
            let rates = rates(device, format.fourcc, size);
            offers.push(Offer { format: FourCc(format.fourcc.repr), size, rates });
        }
    }
    Ok(offers)
}

/// The sizes of a format; if the driver does not list them, the current size.
fn sizes(device: &Device, format: FourCC) -> io::Result<Vec<SizeOffer>> {
    let Ok(listed) = device.enum_framesizes(format) else {
        let now = device.format()?;
        return Ok(vec![SizeOffer::One([now.width, now.height])]);
    };
    let size = |size: FrameSizeEnum| match size {
        FrameSizeEnum::Discrete(one) => SizeOffer::One([one.width, one.height]),
        FrameSizeEnum::Stepwise(range) => {
            SizeOffer::Range { least: [range.min_width, range.min_height], most: [range.max_width, range.max_height] }
        }
    };
    Ok(listed.into_iter().map(|listed| size(listed.size)).collect())
}

fn rates(device: &Device, format: FourCC, size: SizeOffer) -> RateOffer {
    let (SizeOffer::One([width, height]) | SizeOffer::Range { most: [width, height], .. }) = size;
    let mut list = Vec::new();
    for listed in device.enum_frameintervals(format, width, height).unwrap_or_default() {
        match listed.interval {
            FrameIntervalEnum::Discrete(interval) => list.extend(rate(interval)),
            // The longest interval is the lowest rate.
            FrameIntervalEnum::Stepwise(range) => {
                let (Some(least), Some(most)) = (rate(range.max), rate(range.min)) else { continue };
                return RateOffer::Range { least, most };
            }
        }
    }
    if list.is_empty() { RateOffer::Unknown } else { RateOffer::List(list) }
}

/// Frames per second of an interval; `None` for zero.
pub(crate) fn rate(interval: Fraction) -> Option<f64> {
    let Fraction { numerator, denominator } = interval;
    (numerator > 0 && denominator > 0).then(|| f64::from(denominator) / f64::from(numerator))
}
