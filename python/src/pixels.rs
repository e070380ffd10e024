//! Images in: NumPy arrays, and whatever can become one without a copy, as pixels.

use fingervision_image::{Image, Pixels};
use numpy::ndarray::{ArrayView2, ArrayView3};
use numpy::{PyArray2, PyArray3, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::error::{OrRaise, wrong_type, wrong_value};

/// What an image has to be.
const NEEDED: &str = "a NumPy array is needed: uint8 or uint16, of shape (H, W) for grey or (H, W, 3) for colour";
/// What the order of channels can be.
const CHANNELS: &str = "give channels=\"rgb\", or channels=\"bgr\" for images that OpenCV has read";
/// The memory of the CPU, as DLPack numbers devices.
const CPU: i32 = 1;

/// The order of an image's colour channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Channels {
    Rgb,
    Bgr,
}

impl Channels {
    /// The order of this name.
    pub(crate) fn of(name: &str) -> PyResult<Self> {
        match name {
            "rgb" => Ok(Self::Rgb),
            "bgr" => Ok(Self::Bgr),
            _ => Err(wrong_value(format!("channels is {name:?}"), CHANNELS)),
        }
    }
}

/// A copy of an image, in `spare` if it has the same size and format. Any strides and read-only arrays are accepted.
/// Colour needs the order of its channels.
pub(crate) fn pixels(image: &Bound<'_, PyAny>, channels: Option<Channels>, spare: Option<Pixels>) -> PyResult<Pixels> {
    let array = array(image)?;
    let array = array.cast::<PyUntypedArray>()?;
    expect_shape(array.shape())?;
    let is_colour = array.shape().len() == 3;
    if is_colour {
        let channels = channels
            .ok_or_else(|| wrong_value("the image has colour, and the order of its channels is not given", CHANNELS))?;
        if let Ok(array) = array.cast::<PyArray3<u8>>() {
            let into = if let Some(Pixels::Rgb8(image)) = spare { Some(image) } else { None };
            return Ok(Pixels::Rgb8(colour(&array.readonly().as_array(), channels, into)));
        }
        if let Ok(array) = array.cast::<PyArray3<u16>>() {
            let into = if let Some(Pixels::Rgb16(image)) = spare { Some(image) } else { None };
            return Ok(Pixels::Rgb16(colour(&array.readonly().as_array(), channels, into)));
        }
    } else {
        if let Ok(array) = array.cast::<PyArray2<u8>>() {
            let into = if let Some(Pixels::Grey8(image)) = spare { Some(image) } else { None };
            return Ok(Pixels::Grey8(grey(&array.readonly().as_array(), into)));
        }
        if let Ok(array) = array.cast::<PyArray2<u16>>() {
            let into = if let Some(Pixels::Grey16(image)) = spare { Some(image) } else { None };
            return Ok(Pixels::Grey16(grey(&array.readonly().as_array(), into)));
        }
    }
    let message = format!("the image has dtype {}; uint8 or uint16 in native byte order is needed", array.dtype());
    Err(wrong_type(message, "levels from 0 to 1 become uint8 by (255 * image).round().astype(\"uint8\")"))
}

/// The object as a NumPy array: itself, or a view of an image or a tensor in the memory of the CPU.
fn array<'py>(image: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    if image.is_instance_of::<PyUntypedArray>() {
        return Ok(image.clone());
    }
    let numpy = image.py().import("numpy")?;
    if image.hasattr("__dlpack_device__")? {
        let (device, number): (i32, i32) = image.call_method0("__dlpack_device__")?.extract()?;
        if device != CPU {
            let message = format!("the image is in the memory of another device (DLPack device {device}:{number})");
            return Err(wrong_value(message, "an array in the memory of the CPU is needed: tensor.cpu()"));
        }
        return numpy.call_method1("from_dlpack", (image,));
    }
    if image.hasattr("__array_interface__")? {
        return numpy.call_method1("asarray", (image,));
    }
    let name = image.get_type().name()?;
    Err(wrong_type(format!("the image is of type {name}; {NEEDED}"), "numpy.asarray(image) makes one"))
}

fn expect_shape(shape: &[usize]) -> PyResult<()> {
    let hint = match shape {
        _ if shape.contains(&0) => "the image is empty: check where it comes from",
        [_, _] | [_, _, 3] => return Ok(()),
        [3, _, _] => "the channels come first: image.transpose(1, 2, 0) is a view with the channels last",
        [_, _, 1] => "grey has no channel axis: image[:, :, 0]",
        [_, _, 4] => "leave the fourth channel out: image[:, :, :3]",
        [_, _, _, _] => "give one image at a time",
        _ => "give one image",
    };
    let shape: Vec<String> = shape.iter().map(ToString::to_string).collect();
    Err(wrong_value(format!("the image has shape ({}); (H, W) or (H, W, 3) is needed", shape.join(", ")), hint))
}

/// A plane of this size, in the memory of the spare one if that has the size.
fn plane<T: Clone>(spare: Option<Image<T>>, (width, height): (usize, usize), fill: T) -> Image<T> {
    let spare = spare.filter(|spare| spare.size() == (width, height));
    spare.unwrap_or_else(|| Image::filled(width, height, fill))
}

fn grey<T: Copy + Default>(from: &ArrayView2<'_, T>, spare: Option<Image<T>>) -> Image<T> {
    let (height, width) = from.dim();
    let mut to = plane(spare, (width, height), T::default());
    match from.as_slice() {
        Some(values) => to.values_mut().copy_from_slice(values),
        None => to.values_mut().iter_mut().zip(from).for_each(|(to, from)| *to = *from),
    }
    to
}

fn colour<T: Copy + Default>(
    from: &ArrayView3<'_, T>,
    channels: Channels,
    spare: Option<Image<[T; 3]>>,
) -> Image<[T; 3]> {
    let (height, width, _) = from.dim();
    let mut to = plane(spare, (width, height), [T::default(); 3]);
    let values = from.as_slice().map(|values| values.as_chunks::<3>().0);
    let pixels = to.values_mut();
    match (channels, values) {
        (Channels::Rgb, Some(values)) => pixels.copy_from_slice(values),
        (Channels::Bgr, Some(values)) => {
            pixels.iter_mut().zip(values).for_each(|(to, &[blue, green, red])| *to = [red, green, blue]);
        }
        (Channels::Rgb, None) => {
            pixels.iter_mut().zip(from.rows()).for_each(|(to, from)| *to = [from[0], from[1], from[2]]);
        }
        (Channels::Bgr, None) => {
            pixels.iter_mut().zip(from.rows()).for_each(|(to, from)| *to = [from[2], from[1], from[0]]);
        }
    }
    to
}

/// Checks that an image fits the first one.
pub(crate) fn expect_same_format(image: &Pixels, first_is_colour: bool) -> PyResult<()> {
    if image.is_colour() == first_is_colour {
        return Ok(());
    }
    let word = |is_colour: bool| if is_colour { "colour" } else { "grey" };
    let message = format!("the image is {}, the first one was {}", word(image.is_colour()), word(first_is_colour));
    Err(wrong_value(message, "give all images in one format"))
}

/// Checks a size before it is used.
pub(crate) fn expect_size(image: &Pixels, expected: (usize, usize)) -> PyResult<()> {
    let (width, height) = image.size();
    if (width, height) == expected {
        return Ok(());
    }
    let message =
        format!("the image has {width}x{height} px (width x height); {}x{} is needed", expected.0, expected.1);
    Err(wrong_value(message, "give images of the size of the first one"))
}

/// The pixels as they are, without a region of interest.
pub(crate) fn whole(image: &Pixels) -> fingervision_image::Rect {
    let (width, height) = image.size();
    fingervision_image::Rect::whole(width, height)
}

/// Loads an image into a picture of the flow.
pub(crate) fn load(picture: &mut fingervision_flow::Picture, image: &Pixels) -> PyResult<()> {
    picture.load(image, whole(image)).or_raise()
}
