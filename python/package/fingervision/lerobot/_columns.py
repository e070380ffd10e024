"""Features and their columns in Parquet files."""

from __future__ import annotations

import importlib
import io
from typing import TYPE_CHECKING, Any

import numpy as np

import fingervision
from fingervision._errors import Error

if TYPE_CHECKING:
    import numpy.typing as npt

_COMPONENTS = {
    "force": ["x", "y", "z"],
    "torque": ["z"],
    "flags": list(fingervision.FLAGS),
    "image": ["height", "width", "channels"],
}


_PACKAGES = {"pyarrow": "pyarrow", "PIL": "Pillow"}


def library(name: str) -> Any:
    """A module of pyarrow or Pillow."""
    try:
        return importlib.import_module(name)
    except ImportError as missing:
        package = _PACKAGES[name.split(".")[0]]
        error = Error(f"LeRobot data sets need {package}, which is not installed")
        error.hint = "pip install pyarrow Pillow"
        raise error from missing


def feature(name: str, values: npt.NDArray[Any]) -> dict[str, Any]:
    """The entry of a feature in ``info.json``."""
    names = _COMPONENTS.get(name, [name] if values.shape == (1,) else None)
    dtype = "image" if name == "image" else str(values.dtype)
    return {"dtype": dtype, "shape": list(values.shape), "names": names}


def column(values: list[npt.NDArray[Any]], *, is_image: bool) -> Any:
    """The values of some frames as an Arrow array: numbers, nested lists, or PNG images."""
    arrow = library("pyarrow")
    if is_image:
        kind = arrow.struct([("bytes", arrow.binary()), ("path", arrow.string())])
        return arrow.array([{"bytes": _png(image), "path": None} for image in values], kind)
    stacked = np.stack(values)
    nested = arrow.array(stacked.reshape(-1))
    if stacked.shape[1:] == (1,):
        return nested
    for axis in range(stacked.ndim - 1, 0, -1):
        count, length = int(np.prod(stacked.shape[:axis])), stacked.shape[axis]
        offsets = arrow.array(np.arange(count + 1, dtype=np.int32) * length)
        nested = arrow.ListArray.from_arrays(offsets, nested)
    return nested


def _png(image: npt.NDArray[np.uint8]) -> bytes:
    """An image `(H, W, 3)` as a PNG file."""
    file = io.BytesIO()
    library("PIL.Image").fromarray(image).save(file, "png", compress_level=1)
    return file.getvalue()
