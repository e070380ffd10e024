"""The camera as LeRobot uses it. Frames come when a test sends them."""

from __future__ import annotations

import importlib.metadata
import queue
from typing import Any

import numpy as np
import pytest

pytest.importorskip("lerobot", reason="the base class is LeRobot's")

from lerobot.cameras.camera import Camera
from lerobot.cameras.configs import CameraConfig
from lerobot.cameras.utils import make_cameras_from_configs
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError
from lerobot.utils.import_utils import register_third_party_plugins

import fingervision
from lerobot_camera_fingervision import FingervisionCamera, FingervisionCameraConfig

END = None


@pytest.fixture(scope="module")
def readings() -> list[fingervision.Reading]:
    """A simulated press."""
    press = fingervision.simulate("letter", draft=True)
    tracker = fingervision.Tracker(press.profile, channels="rgb")
    return [tracker.track(press[index].image) for index in (0, len(press) // 2, len(press) - 1)]


@pytest.fixture
def sent(monkeypatch: pytest.MonkeyPatch) -> queue.Queue[Any]:
    """What is put in arrives as a reading; `END` ends the source."""
    frames: queue.Queue[Any] = queue.Queue()

    class Source:
        def __enter__(self) -> Source:
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def __iter__(self) -> Any:
            return iter(frames.get, END)

    monkeypatch.setattr(fingervision, "open", lambda *_: Source())
    return frames


def connected(sent: queue.Queue[Any], reading: Any, **options: Any) -> FingervisionCamera:
    camera = FingervisionCamera(FingervisionCameraConfig(**options))
    sent.put(reading)
    camera.connect(warmup=False)
    return camera


def test_lerobot_finds_the_type() -> None:
    names = [distribution.metadata["Name"] for distribution in importlib.metadata.distributions()]
    assert "lerobot_camera_fingervision" in names, "install the package: LeRobot looks for its distribution"
    register_third_party_plugins()
    kind = CameraConfig.get_choice_class("fingervision")
    made = make_cameras_from_configs({"finger": kind(source="camera:1", show="depth")})
    assert isinstance(made["finger"], FingervisionCamera)
    assert isinstance(made["finger"], Camera)
    assert not made["finger"].is_connected


def test_frames_are_read(sent: queue.Queue[Any], readings: list[fingervision.Reading]) -> None:
    camera = connected(sent, readings[0])
    assert camera.is_connected
    assert (camera.height, camera.width) == readings[0].image.shape[:2]
    with pytest.raises(DeviceAlreadyConnectedError):
        camera.connect()
    assert camera.read_latest(60_000).tobytes() == readings[0].image.tobytes()
    with pytest.raises(TimeoutError):
        camera.async_read(timeout_ms=1)
    sent.put(readings[1])
    assert camera.async_read(60_000).tobytes() == readings[1].image.tobytes()
    with pytest.raises(TimeoutError):
        camera.read_latest(max_age_ms=-1)
    assert camera.reading is readings[1]
    sent.put(END)
    with pytest.raises(ConnectionError, match="no more frames"):
        camera.read()
    camera.disconnect()
    assert not camera.is_connected
    for read in (camera.read, camera.async_read, camera.read_latest, camera.disconnect):
        with pytest.raises(DeviceNotConnectedError):
            read()


def test_depth_is_shown_as_grey(sent: queue.Queue[Any], readings: list[fingervision.Reading]) -> None:
    camera = connected(sent, readings[-1], show="depth", depth_range_mm=1.0)
    picture = camera.read_latest(60_000)
    expected = np.round(np.clip(readings[-1].depth, 0, 1) * 255)
    assert picture.shape == (*expected.shape, 3)
    assert np.abs(picture - expected[..., np.newaxis]).max() <= 1
    assert picture.max() > 50
    sent.put(END)
    camera.disconnect()


def test_a_failing_source_is_an_error(sent: queue.Queue[Any], monkeypatch: pytest.MonkeyPatch) -> None:
    sent.put(END)
    with pytest.raises(ConnectionError, match="no more frames"):
        FingervisionCamera(FingervisionCameraConfig()).connect()
    monkeypatch.undo()
    camera = FingervisionCamera(FingervisionCameraConfig(source="none/at/all"))
    with pytest.raises(ConnectionError, match="none/at/all"):
        camera.connect()
    assert not camera.is_connected


def test_wrong_configurations_are_refused(sent: queue.Queue[Any], readings: list[fingervision.Reading]) -> None:
    with pytest.raises(ValueError, match="'force'"):
        FingervisionCameraConfig(show="force")
    with pytest.raises(ValueError, match="depth_range_mm"):
        FingervisionCameraConfig(depth_range_mm=0.0)
    sent.put(readings[0])
    sent.put(END)
    with pytest.raises(ValueError, match="7x"):
        FingervisionCamera(FingervisionCameraConfig(width=7)).connect()


def test_cameras_are_listed() -> None:
    assert [found["id"] for found in FingervisionCamera.find_cameras()] == [f"camera:{c.id}" for c in fingervision.cameras()]
