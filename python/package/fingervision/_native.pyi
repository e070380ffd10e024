from collections.abc import Iterator, Sequence
from os import PathLike
from types import TracebackType
from typing import Any, Literal, Protocol, TypeAlias, final

import numpy as np
import numpy.typing as npt

__all__ = [
    "FLAGS",
    "CameraInfo",
    "Flow",
    "FlowEstimator",
    "Frame",
    "Frames",
    "Profile",
    "Reading",
    "Readings",
    "Recording",
    "SimulatedFrame",
    "Simulation",
    "Tracker",
    "__version__",
    "cameras",
    "open",
    "run",
    "scenes",
    "simulate",
]

__version__: str
FLAGS: dict[str, str]

_Floats: TypeAlias = npt.NDArray[np.float32]
_Mask: TypeAlias = npt.NDArray[np.bool_]
_Pixels: TypeAlias = npt.NDArray[np.uint8] | npt.NDArray[np.uint16]
_Path: TypeAlias = str | PathLike[str]
_Channels: TypeAlias = Literal["rgb", "bgr"]
_Field: TypeAlias = Literal[
    "flow",
    "density",
    "depth",
    "depth_valid",
    "depth_deviation",
    "contact",
    "displacement",
    "traction",
    "deviation",
]

class _DLPack(Protocol):
    def __dlpack__(self) -> Any: ...
    def __dlpack_device__(self) -> Any: ...

class _ArrayInterface(Protocol):
    @property
    def __array_interface__(self) -> dict[str, Any]: ...

_Image: TypeAlias = _Pixels | _DLPack | _ArrayInterface

@final
class Profile:
    """One sensor: its camera, its gel, its calibration and the parameters of tracking. Cannot be changed.

    `Profile()` is a sensor without calibration, tracked over the whole image, without depth. `Profile.load(path)` reads a
    file, `profile.replace({"flow.finest_level": 1})` is a copy with other values. Profiles can be compared and pickled.
    """
    def __new__(cls, *, set: dict[str, Any] | None = None) -> Profile: ...
    @classmethod
    def load(cls, path: _Path, *, set: dict[str, Any] | None = None) -> Profile:
        """The profile in a file: `sensor.toml`, or the `run.toml` of a run.

        Raises `ProfileError` with the line that is wrong.
        """
    @classmethod
    def from_toml(cls, text: str) -> Profile:
        """The profile in a text, as of its file.

        Raises `ProfileError` with the line that is wrong.
        """
    def replace(self, set: dict[str, Any]) -> Profile:
        """A copy with some values set by their paths, as in `{"gel.thickness_mm": 8.0}`.

        Raises `ProfileError` for a path that does not exist or a value that is impossible.
        """
    def to_toml(self) -> str:
        """The text of its file, every default written out."""
    def save(self, path: _Path) -> None:
        """Writes its file, as a whole or not at all.

        Raises `SourceError` if the file cannot be written.
        """
    @property
    def name(self) -> str:
        """The name of the sensor."""
    @property
    def depth_method(self) -> Literal["elastic", "density"]:
        """How depth is computed: `"elastic"` or `"density"`."""
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __reduce__(self) -> tuple[Any, tuple[str]]: ...

@final
class Reading:
    """Everything that was computed from one frame. All fields lie on the reference grid: they belong to points of the gel.

    An array is made when it is first asked for, and is the same object from then on. It is a copy of its own: it stays as
    it is while tracking goes on. `H` and `W` are rows and columns of the region of interest. A field that was not
    requested, or that the profile does not allow, raises `FieldError`, which is also an `AttributeError`.
    """
    @property
    def sequence(self) -> int:
        """The frame's number in its source, from 0; numbers of missing frames are skipped."""
    @property
    def capture_time_s(self) -> float:
        """When the frame was exposed, s, on the source's clock."""
    @property
    def dropped_frames(self) -> int:
        """Frames that the source dropped since tracking began."""
    @property
    def reference_id(self) -> int:
        """Number of the reference that the frame was matched with, from 0."""
    @property
    def photometric_error(self) -> float:
        """How well the frame matches its reference: root mean square of the residuals, grey levels from 0 to 255."""
    @property
    def mean_level(self) -> float:
        """Mean grey level of the region of interest, 0 to 255, whatever the camera's depth."""
    @property
    def saturated_part(self) -> float:
        """Part of the pixels of the region of interest of which a channel is saturated, 0 to 1."""
    @property
    def sharpness(self) -> float:
        """Sharpness of the region of interest, dimensionless; compare it only with other images of this sensor."""
    @property
    def latency_ms(self) -> float:
        """Time that tracking took, ms. It is the only value that differs from run to run."""
    @property
    def flags(self) -> tuple[str, ...]:
        """The names of the reading's problems, as in `("lost",)`; `fingervision.FLAGS` explains them."""
    @property
    def damaged_part(self) -> float:
        """Part of the image that never tracks while the gel around it does, or that dirt hides, 0 to 1."""
    @property
    def fields(self) -> tuple[_Field, ...]:
        """The names of the fields that this reading has."""
    @property
    def image(self) -> _Pixels:
        """The camera image: `(H, W)` or `(H, W, 3)` in red, green, blue; uint8 or uint16; the whole frame."""
    @property
    def flow(self) -> _Floats:
        """Displacement in the image: `(H, W, 2)` float32, px, x right and y down. `x + flow(x)` is the current position."""
    @property
    def deviation(self) -> _Floats:
        """Predicted standard deviation of the flow: `(H, W)` float32, px; infinite where nothing was measured."""
    @property
    def valid(self) -> _Mask:
        """Where flow, density and depth from density are valid: `(H, W)` bool. Elastic depth has `depth_valid`."""
    @property
    def density(self) -> _Floats:
        """Density feature: `(H, W)` float32, dimensionless, 0 at rest, positive where the surface expands."""
    @property
    def depth(self) -> _Floats:
        """Depth: `(H, W)` float32, mm, positive pressed in, 0 where it is not valid (`depth_valid`)."""
    @property
    def depth_deviation(self) -> _Floats:
        """Expected error of an elastic depth: `(H, W)` float32, mm; infinite where depth is not valid."""
    @property
    def depth_valid(self) -> _Mask:
        """Where depth is valid, and contact and displacement with it: `(H, W)` bool."""
    @property
    def contact(self) -> _Mask:
        """Where the gel touches something: `(H, W)` bool; with elastic depth."""
    @property
    def displacement(self) -> _Floats:
        """Displacement of the surface: `(H, W, 3)` float32, mm, gel space: x right, y down, z towards the camera."""
    @property
    def traction(self) -> _Floats:
        """Traction on the gel: `(h, w, 3)` float32, MPa, gel space; on square cells of `traction_cell_mm`, centred on the gel."""
    @property
    def traction_cell_mm(self) -> float:
        """Side of a cell of `traction`, mm."""
    @property
    def force(self) -> _Floats:
        """Force of the object on the gel: `(3,)` float32, N, gel space, pressing is +z; NaN if this frame has none."""
    @property
    def torque(self) -> float:
        """Torque on the gel about z through the centre of contact, N mm; NaN if this frame has none."""
    @property
    def max_depth_mm(self) -> float:
        """Largest depth where it is valid, mm; NaN if this frame has none."""
    @property
    def contact_area_mm2(self) -> float:
        """Area of contact in the undeformed surface, mm²; NaN if this frame has none. With elastic depth."""

@final
class Readings:
    """The readings of a source, from `fingervision.open`: an iterator, and a context manager that closes the source.

    After an error the source is at its end: the next call ends the iteration.
    """
    def __iter__(self) -> Readings: ...
    def __next__(self) -> Reading: ...
    def __enter__(self) -> Readings: ...
    def __exit__(
        self,
        kind: type[BaseException] | None = None,
        error: BaseException | None = None,
        traceback: TracebackType | None = None,
        /,
    ) -> None: ...
    def close(self) -> None:
        """Closes the source. Reading on raises `ClosedError`, which is a `ValueError`."""
    def reset(self) -> None:
        """Makes the next frame the new reference: from there on displacement, depth and force are relative to it."""
    @property
    def profile(self) -> Profile:
        """The profile in force."""
    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the fields, px: the region of interest."""
    @property
    def frame_count(self) -> int | None:
        """Number of frames; `None` where that is not known beforehand."""
    @property
    def description(self) -> str:
        """One line on where the frames come from and what they are."""
    @property
    def remarks(self) -> list[str]:
        """What is unusual about the source, a sentence each."""

def open(
    source: _Path,
    profile: Profile | _Path | None = None,
    *,
    fields: Sequence[_Field] | None = None,
    frames_per_second: float | None = None,
    set: dict[str, Any] | None = None,
) -> Readings:
    """Opens a source and tracks it: iterate over its readings. The first frame is the reference: it shows the gel untouched.

    `source` is a folder of images, a video, a recording `FILE.mcap` (`FILE.mcap?sensor=NAME` if it has several), a
    simulated press `sim:SCENE`, or a camera: `camera`, `camera:ID`, `/dev/video0`. `profile` is a `Profile` or the path
    of its file; without it, a recording has its own, a simulated press that of its sensor, and any other source is tracked
    without calibration. `fields` lists what is computed, as in `["depth", "displacement", "traction"]`; without it all
    that the profile is calibrated for, except displacement and traction. `frames_per_second` is the rate of an image
    folder or a simulated press, 30 by default. `set` sets values of the profile by their paths, as in
    `{"flow.finest_level": 1}`.

    The same frames give the same bits as in the command `fingervision track`. A simulated press is solved first, which may
    take minutes (`sim:letter?draft`: seconds), and is then kept.

    Raises `NotFoundError`, `SourceError`, `RecordingError`, `CameraError`, `ProfileError`, `FieldError`, `ArgumentError`.
    """
@final
class Tracker:
    """Tracks the gel through images that your program provides. The first image is the reference: it shows the gel untouched.

    `profile` is a `Profile`, the path of its file, or `None` for a sensor without calibration: displacement and density
    only. `fields` lists what is computed; without it all that the profile is calibrated for. `channels` is the order of
    colour: `"rgb"`, or `"bgr"` for images that OpenCV has read; grey images need none. `frames_per_second` gives images without a time theirs.
    `set` sets values of the profile by their paths, as in `{"flow.finest_level": 1}`.

    While an image is tracked, other threads of Python run. Each thread should have a tracker of its own; calls of the same
    tracker wait for each other.

    Raises `ProfileError` and `ArgumentError`; what depends on the size of the images is checked with the first of them.
    """
    def __new__(
        cls,
        profile: Profile | _Path | None = None,
        *,
        fields: Sequence[_Field] | None = None,
        channels: _Channels | None = None,
        frames_per_second: float = 30.0,
        set: dict[str, Any] | None = None,
    ) -> Tracker: ...
    def track(
        self, image: _Image, *, sequence: int | None = None, capture_time_s: float | None = None
    ) -> Reading:
        """The reading of an image: `(H, W)` or `(H, W, 3)`, uint8 or uint16.

        The image is copied, so it may have any strides, be read-only, and change afterwards. Pillow images and tensors in
        the memory of the CPU are accepted, too. `sequence` is the number of the image, by default the next one; numbers
        that are left out count as dropped frames. `capture_time_s` is by default the number divided by the rate.

        Raises `ArgumentTypeError` (a `TypeError`) for another type or dtype, `ArgumentError` (a `ValueError`) for another
        shape or an array on another device, `TrackError` for an image of another size or out of order.
        """
    def reset(self) -> None:
        """Makes the next image the new reference: from there on displacement, depth and force are relative to it."""
    @property
    def profile(self) -> Profile:
        """The profile in force."""

@final
class FlowEstimator:
    """Dense flow from a reference to other images of the same size, without a sensor.

    Everything that depends only on the reference is computed once. `set` sets parameters by their paths in a profile, as
    in `{"flow.finest_level": 1}`; `channels` is the order of colour, `"rgb"` or `"bgr"`; grey images need none.

    Raises `FlowError` for an image that is too small, `ProfileError` for a wrong parameter, and `ArgumentError` and
    `ArgumentTypeError` as `Tracker.track`.
    """
    def __new__(
        cls, reference: _Image, *, channels: _Channels | None = None, set: dict[str, Any] | None = None
    ) -> FlowEstimator: ...
    def estimate(self, image: _Image) -> Flow:
        """The flow to an image, found without any knowledge of it, even if it is large.

        Raises `ArgumentError` if the image has another size than the reference, and as `Tracker.track`.
        """

@final
class Flow:
    """Flow from a reference to an image."""
    @property
    def flow(self) -> _Floats:
        """Displacement: `(H, W, 2)` float32, px, x right and y down, at the points of the reference."""
    @property
    def deviation(self) -> _Floats:
        """Predicted standard deviation: `(H, W)` float32, px; infinite where nothing was measured."""
    @property
    def valid(self) -> _Mask:
        """Where the flow is a measurement: `(H, W)` bool; elsewhere it is interpolated."""
    @property
    def matched(self) -> float:
        """Part of the textured patches that match, 0 to 1."""

@final
class Simulation:
    """A simulated press, from `fingervision.simulate`: a sequence of `SimulatedFrame`, which are rendered when asked for."""
    def __iter__(self) -> Iterator[SimulatedFrame]: ...
    def __len__(self) -> int: ...
    def __getitem__(self, index: int, /) -> SimulatedFrame: ...
    @property
    def profile(self) -> Profile:
        """The profile of the simulated sensor."""
    def to_toml(self) -> str:
        """The text of the scene's file, every default written out."""

@final
class SimulatedFrame:
    """A frame of a simulated press and its truth. Fields lie on the grid of the first frame."""
    @property
    def image(self) -> npt.NDArray[np.uint8]:
        """The camera image: `(H, W, 3)` or `(H, W)` uint8."""
    @property
    def flow(self) -> _Floats:
        """True displacement in the image: `(H, W, 2)` float32, px; NaN where there is no gel."""
    @property
    def depth(self) -> _Floats:
        """True depth: `(H, W)` float32, mm, positive pressed in; NaN where there is no gel."""
    @property
    def displacement(self) -> _Floats:
        """True displacement of the surface: `(H, W, 3)` float32, mm, gel space; NaN where there is no gel."""
    @property
    def contact(self) -> _Mask:
        """Where the gel touches the indenter: `(H, W)` bool."""
    @property
    def visible(self) -> _Mask:
        """Where the camera sees the point: `(H, W)` bool."""
    @property
    def force(self) -> npt.NDArray[np.float64]:
        """True force of the indenter on the gel: `(3,)` float64, N, pressing is +z."""
    @property
    def torque(self) -> float:
        """True torque on the gel about z through the centre of contact, N mm."""
    @property
    def depth_mm(self) -> float:
        """Indentation depth of the indenter, mm."""

def simulate(
    scene: _Path | None = None,
    *,
    toml: str | None = None,
    set: dict[str, Any] | None = None,
    draft: bool = False,
    seed: int | None = None,
    cache: bool = True,
) -> Simulation:
    """Solves a press of the simulated sensor.

    `scene` is the name of a ready-made scene (`fingervision.scenes()` lists them) or the path of a scene file; `toml` is
    the text of one instead. `set` sets values of the scene by their paths, as in `{"gel.poissons_ratio": 0.35}`;
    `draft=True` takes a coarse mesh, seconds instead of minutes; `seed` is that of pattern and noise. Solved presses are
    kept on the disk unless `cache=False`. Ctrl-C ends it.

    Raises `SceneError` if the scene is impossible or cannot be solved to its end.
    """
def scenes() -> dict[str, str]:
    """The names of the ready-made scenes, with a sentence on each."""
@final
class Recording:
    """A recording in an MCAP file, as `fingervision record` writes it; opened, and read when asked.

    `fingervision.open(path)` tracks it instead. A method's `sensor` is the name of one of `sensors`; it may be left out if
    there is only one.

    Raises `RecordingError` if the file is none.
    """
    def __new__(cls, path: _Path) -> Recording: ...
    @property
    def sensors(self) -> list[str]:
        """The names of the sensors."""
    @property
    def remarks(self) -> list[str]:
        """What is unusual about the file, a sentence each: that it was not closed, or is damaged."""
    def profile(self, sensor: str | None = None) -> Profile | None:
        """The profile that was in force; `None` if it is not in the file."""
    def frames(self, sensor: str | None = None) -> Frames:
        """The frames, decoded one by one.

        Raises `SourceError` while iterating if one is damaged.
        """
    def capture_times_s(self, sensor: str | None = None) -> npt.NDArray[np.float64]:
        """When each frame was exposed, `(N,)` float64, s, on the source's clock; quicker than `frames()`, which decodes images."""
    def track(
        self,
        profile: Profile | _Path | None = None,
        *,
        sensor: str | None = None,
        fields: Sequence[_Field] | None = None,
        set: dict[str, Any] | None = None,
    ) -> Readings:
        """Tracks the frames of a sensor, as `fingervision.open` does. `profile`, `fields` and `set` are those of `open`.

        Raises `RecordingError`, `SourceError`, `ProfileError`, `FieldError`, `ArgumentError`.
        """
    def events(self, sensor: str | None = None) -> list[str]:
        """The events, such as a lost camera or a re-zero, a sentence each."""
    def truths(self, sensor: str | None = None) -> dict[str, npt.NDArray[Any]]:
        """The truth of every frame of a simulated sensor, a column each, of length `N`, which is 0 for a real sensor.

        `sequence`, int64; `capture_time_s`, s, `depth_mm`, the indentation depth of the indenter, mm, and `torque_nmm`,
        N mm, float64; `force_n`, `(N, 3)` float64, N, pressing is +z.
        """
    def readings(self, sensor: str | None = None) -> dict[str, Any]:
        """The numbers of the recorded readings, a column each, of length `N`.

        `sequence` and `dropped_frames`, int64; `capture_time_s` and `latency_ms`, float64; `photometric_error`,
        `mean_level`, `saturated_part`, `sharpness`, float32, as in a `Reading`; `max_depth_mm`, `contact_area_mm2`,
        `torque_nmm`, float32, and `force_n`, `(N, 3)` float32, N, with NaN where a reading has none; `flags`, a list of
        strings joined by `+`.
        """

@final
class Frames:
    """The frames of a sensor of a recording, an iterator."""
    def __iter__(self) -> Frames: ...
    def __len__(self) -> int: ...
    def __next__(self) -> Frame: ...

@final
class Frame:
    """A frame of a recording."""
    @property
    def sequence(self) -> int:
        """The frame's number, from 0; numbers of missing frames are skipped."""
    @property
    def capture_time_s(self) -> float:
        """When it was exposed, s."""
    @property
    def image(self) -> _Pixels:
        """The camera image: `(H, W)` or `(H, W, 3)` in red, green, blue; uint8 or uint16."""

@final
class CameraInfo:
    """A camera that is plugged in, from `fingervision.cameras`."""
    @property
    def id(self) -> str:
        """Its id, which stays the same when cameras are plugged in: `fingervision.open("camera:ID")`."""
    @property
    def name(self) -> str:
        """Its name."""
    @property
    def path(self) -> str:
        """The node in `/dev`, which may change."""
    @property
    def driver(self) -> str:
        """The kernel's driver."""
    @property
    def serial(self) -> str | None:
        """Its serial number, if it has one."""
    @property
    def is_accessible(self) -> bool:
        """Whether it can be opened."""

def cameras() -> list[CameraInfo]:
    """The cameras that are plugged in; empty where cameras are not supported, which is everywhere but on Linux."""
def run(arguments: Sequence[str]) -> int:
    """Runs the program with these arguments, the first of which is its name, and returns its exit code."""
