"""The frames of a run or a recording as arrays by name, with their times."""

from __future__ import annotations

import csv
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

import fingervision
from fingervision._errors import ArgumentError, FieldError, NotFoundError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    import numpy.typing as npt

    Values = dict[str, npt.NDArray[Any]]

_FORCE = ("force_x_n", "force_y_n", "force_z_n")
_NUMBERS = {"torque": "torque_z_nmm", "max_depth": "max_depth_mm", "contact_area": "contact_area_mm2"}
_MASKS = ("valid", "contact", "depth_valid")
_ARRAYS = ("flow", "density", "depth", "depth_deviation", "displacement", "traction", "deviation", *_MASKS)


@dataclass(frozen=True)
class Episode:
    """What a run or a recording contains, frame by frame."""

    source: str
    times_s: npt.NDArray[np.float64]
    profile: fingervision.Profile
    frames: Callable[[], Iterator[Values]]


@dataclass(frozen=True)
class Tracking:
    """How a recording is tracked."""

    profile: fingervision.Profile | str | os.PathLike[str] | None
    fields: Sequence[Any] | None
    images: bool
    set: dict[str, Any] | None


def open_episode(source: str | os.PathLike[str], tracking: Tracking) -> Episode:
    """The episode of a run's folder or a recording."""
    text = os.fspath(source)
    path = Path(text.split("?sensor=")[0])
    if not path.exists():
        raise NotFoundError(f"there is no {path}")
    if (path / "run.toml").is_file():
        if tracking.profile is not None or tracking.set is not None:
            raise ArgumentError(f"{path} was tracked already: profile and set have no effect")
        return _run(path, tracking.fields)
    if path.suffix != ".mcap":
        raise ArgumentError(f"{path} is neither a run nor a recording: give a folder of `track`, or FILE.mcap")
    return _recording(text, path, tracking)


def _recording(text: str, path: Path, tracking: Tracking) -> Episode:
    sensor = text.split("?sensor=")[1] if "?sensor=" in text else None
    recording = fingervision.Recording(path)

    def tracked() -> fingervision.Readings:
        return recording.track(tracking.profile, sensor=sensor, fields=tracking.fields, set=tracking.set)

    def frames() -> Iterator[Values]:
        with tracked() as readings:
            for reading in readings:
                yield _of_reading(reading, images=tracking.images)

    # Closed until its frames are wanted, because there may be more recordings than files can be open.
    with tracked() as readings:
        profile = readings.profile
    return Episode(text, recording.capture_times_s(sensor), profile, frames)


def _of_reading(reading: fingervision.Reading, *, images: bool) -> Values:
    values: Values = {
        "capture_time_ns": _nanoseconds(reading.capture_time_s),
        "sequence": np.array([reading.sequence], np.int64),
        "flags": np.array([name in reading.flags for name in fingervision.FLAGS]),
        "valid": reading.valid,
    }
    for name in ("force", "torque", "max_depth_mm", "contact_area_mm2"):
        try:
            number = getattr(reading, name)
        except FieldError:
            continue
        values[name.removesuffix("_mm2").removesuffix("_mm")] = np.atleast_1d(np.asarray(number, np.float32))
    values |= {name: getattr(reading, name) for name in reading.fields}
    if images:
        values["image"] = _colour(reading.image)
    return values


def _colour(image: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
    """The image as `(H, W, 3)`, which LeRobot expects of every camera."""
    if image.dtype != np.uint8:
        raise ArgumentError(f"the images have {image.dtype}, LeRobot needs uint8: export without images")
    return image if image.ndim == 3 else np.repeat(image[..., np.newaxis], 3, axis=2)


def _nanoseconds(time_s: float) -> npt.NDArray[np.int64]:
    """A whole number, because LeRobot reads every other number in single precision."""
    return np.array([round(time_s * 1e9)], np.int64)


def _run(path: Path, fields: Sequence[str] | None) -> Episode:
    with (path / "readings.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    arrays: Values = {}
    for name in _ARRAYS:
        file_of_field = path / f"{name}.npy"
        is_wanted = fields is None or name in fields or name in _MASKS
        if file_of_field.is_file() and is_wanted:
            arrays[name] = cast("npt.NDArray[Any]", np.load(file_of_field, mmap_mode="r"))
            if len(arrays[name]) != len(rows):
                message = f"{file_of_field} has {len(arrays[name])} frames, readings.csv has {len(rows)}"
                raise ArgumentError(f"{message}: track the recording again")
    missing = [name for name in fields or () if name not in arrays]
    if missing:
        raise FieldError(f"{path} has no {', '.join(missing)}: track with --fields {','.join(missing)}")

    def frames() -> Iterator[Values]:
        for index, row in enumerate(rows):
            yield _of_row(row) | {name: _as_exported(name, array[index]) for name, array in arrays.items()}

    times = np.array([float(row["capture_time_s"]) for row in rows])
    return Episode(str(path), times, fingervision.Profile.load(path / "run.toml"), frames)


def _of_row(row: dict[str, str]) -> Values:
    flags = row["flags"].split("+")
    values: Values = {
        "capture_time_ns": _nanoseconds(float(row["capture_time_s"])),
        "sequence": np.array([int(row["sequence"])], np.int64),
        "flags": np.array([name in flags for name in fingervision.FLAGS]),
    }
    columns = {"force": _FORCE} | {name: (column,) for name, column in _NUMBERS.items()}
    for name, cells in columns.items():
        if all(cell in row for cell in cells):
            values[name] = np.array([float(row[cell] or "nan") for cell in cells], np.float32)
    return values


def _as_exported(name: str, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return np.asarray(values, np.bool_ if name in _MASKS else np.float32)
