"""Wrong arguments: what was given, what is needed, and a hint."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import fingervision
from conftest import Press

if TYPE_CHECKING:
    from pathlib import Path

GREY = np.full((120, 160), 90, np.uint8)


class OnTheGpu:
    """An array in the memory of a CUDA device, by what it says of itself."""

    def __dlpack_device__(self) -> tuple[int, int]:
        return (2, 0)

    def __dlpack__(self) -> Any:
        raise AssertionError("nothing is read from another device")


@pytest.mark.parametrize(
    ("image", "error", "said"),
    [
        (GREY.astype(np.float32), TypeError, ["float32", "uint8"]),
        (GREY.astype(np.int16), TypeError, ["int16", "uint8"]),
        (GREY.astype(">u2"), TypeError, [">u2", "native byte order"]),
        (GREY.astype(bool), TypeError, ["bool", "uint8"]),
        (np.zeros((3, 120, 160), np.uint8), ValueError, ["(3, 120, 160)", "transpose(1, 2, 0)"]),
        (np.zeros((120, 160, 1), np.uint8), ValueError, ["(120, 160, 1)", "image[:, :, 0]"]),
        (np.zeros((120, 160, 4), np.uint8), ValueError, ["(120, 160, 4)", "image[:, :, :3]"]),
        (np.zeros((2, 120, 160, 3), np.uint8), ValueError, ["(2, 120, 160, 3)", "one image at a time"]),
        (np.zeros(160, np.uint8), ValueError, ["(160)", "(H, W)"]),
        (np.zeros((0, 160), np.uint8), ValueError, ["(0, 160)", "empty"]),
        (np.zeros((120, 160, 3), np.uint8), ValueError, ["channels", "rgb", "bgr"]),
        (OnTheGpu(), ValueError, ["another device", "tensor.cpu()"]),
        ("press.png", TypeError, ["str", "uint8"]),
        ([[1, 2], [3, 4]], TypeError, ["list", "numpy.asarray"]),
        (None, TypeError, ["NoneType"]),
    ],
)
def test_a_wrong_image_is_refused(image: Any, error: type[Exception], said: list[str]) -> None:
    for call in (fingervision.Tracker().track, fingervision.FlowEstimator):
        with pytest.raises(error) as raised:
            call(image)
        assert isinstance(raised.value, fingervision.Error)
        assert raised.value.hint
        for text in said:
            assert text in str(raised.value)


def test_the_order_of_channels_is_named() -> None:
    with pytest.raises(ValueError, match="channels is \"gbr\""):
        fingervision.Tracker(channels="gbr")  # type: ignore[arg-type]


def test_images_of_one_tracker_have_one_size_and_format(press: Press) -> None:
    image = next(fingervision.open(press.frames)).image
    tracker = fingervision.Tracker(channels="rgb")
    tracker.track(image)
    with pytest.raises(ValueError, match="480"):
        tracker.track(image[:400])
    with pytest.raises(ValueError, match="the image is grey, the first one was colour"):
        tracker.track(np.ascontiguousarray(image[:, :, 0]))
    estimator = fingervision.FlowEstimator(image, channels="rgb")
    with pytest.raises(ValueError, match="480x400 px"):
        estimator.estimate(image[:400])
    assert tracker.track(image).sequence == 1


def test_frames_come_in_order(press: Press) -> None:
    image = next(fingervision.open(press.frames)).image
    tracker = fingervision.Tracker(channels="rgb")
    tracker.track(image, sequence=3, capture_time_s=0.5)
    with pytest.raises(fingervision.TrackError):
        tracker.track(image, sequence=3)
    reading = tracker.track(image, sequence=7, capture_time_s=1.25)
    assert (reading.sequence, reading.capture_time_s, reading.dropped_frames) == (7, 1.25, 3)
    assert "dropped" in reading.flags
    with pytest.raises(OverflowError):
        tracker.track(image, sequence=-1)


def test_a_closed_source_is_refused(press: Press) -> None:
    with fingervision.open(press.frames) as readings:
        next(readings)
    with pytest.raises(ValueError, match="the source is closed") as raised:
        next(readings)
    assert isinstance(raised.value, fingervision.ClosedError)
    readings.close()


def test_a_missing_source_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="nowhere") as raised:
        fingervision.open(tmp_path / "nowhere")
    assert isinstance(raised.value, fingervision.SourceError)
    with pytest.raises(fingervision.SourceError):
        fingervision.open(tmp_path)
    with pytest.raises(fingervision.SourceError, match="no-such-scene"):
        fingervision.open("sim:no-such-scene")
    with pytest.raises(TypeError):
        fingervision.open(3)  # type: ignore[arg-type]


def test_a_rate_is_refused_where_it_has_no_effect() -> None:
    with pytest.raises(ValueError, match="frames_per_second has no effect"):
        fingervision.open("sim:circle?draft&fps=60", frames_per_second=30.0)
    for rate in (0.0, -1.0, float("nan")):
        with pytest.raises(ValueError, match="rate|frames_per_second"):
            fingervision.Tracker(frames_per_second=rate)


def test_a_field_that_is_not_there_says_why(press: Press) -> None:
    plain = next(fingervision.open(press.frames))
    for name in ("depth", "contact", "displacement", "traction", "force", "torque", "max_depth_mm"):
        with pytest.raises(AttributeError, match="there is no") as raised:
            getattr(plain, name)
        assert isinstance(raised.value, fingervision.FieldError)
        assert raised.value.hint
    assert not hasattr(plain, "depth")
    with pytest.raises(fingervision.FieldError, match="displacement"):
        _ = next(fingervision.open(press.frames, press.profile)).displacement
    with pytest.raises(fingervision.FieldError, match="no force") as raised:
        profile = fingervision.Profile.from_toml(without_stiffness(press.profile.read_text(encoding="utf-8")))
        _ = next(fingervision.open(press.frames, profile)).force
    assert "youngs_modulus_mpa" in str(raised.value)


def without_stiffness(text: str) -> str:
    """The profile of a gel whose stiffness is not known."""
    return "\n".join(line for line in text.splitlines() if not line.startswith("youngs_modulus_mpa"))


def test_wrong_fields_are_refused(press: Press) -> None:
    with pytest.raises(ValueError, match="there is no field \"deep\"") as raised:
        fingervision.open(press.frames, fields=["deep"])  # type: ignore[list-item]
    assert "displacement" in str(raised.value)
    with pytest.raises(TypeError, match="fields is the str depth"):
        fingervision.open(press.frames, fields="depth")  # type: ignore[arg-type]
    with pytest.raises(fingervision.FieldError):
        list(fingervision.open(press.frames, fields=["traction"]))


def test_wrong_profiles_are_refused(tmp_path: Path) -> None:
    with pytest.raises(fingervision.ProfileError):
        fingervision.Profile.load(tmp_path / "sensor.toml")
    with pytest.raises(ValueError, match="line|unknown|flw"):
        fingervision.Profile.from_toml("[flw]\nfinest_level = 1")
    with pytest.raises(fingervision.ProfileError, match="finest_levl"):
        fingervision.Profile().replace({"flow.finest_levl": 1})
    with pytest.raises(TypeError, match="flow.finest_level.*object"):
        fingervision.Profile(set={"flow.finest_level": object()})
    with pytest.raises(TypeError, match="profile is of type int"):
        fingervision.Tracker(3)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="no parameter of the flow"):
        fingervision.FlowEstimator(GREY, set={"gel.thickness_mm": 3.0})


def test_an_image_without_texture_is_flagged() -> None:
    tracker = fingervision.Tracker()
    reading = [tracker.track(GREY) for _ in range(2)][-1]
    assert "no-texture" in reading.flags
    assert not reading.valid.any()
    assert set(reading.flags) <= set(fingervision.FLAGS)
