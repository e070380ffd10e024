"""Recordings: what `fingervision record` writes is read back."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

import fingervision
from conftest import Press

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture(scope="module")
def file(press: Press, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The press as a recording."""
    path = tmp_path_factory.mktemp("recording") / "press.mcap"
    fingervision.command("record", press.frames, path, "--profile", press.profile)
    return path


def test_frames_and_readings_are_kept(press: Press, file: Path) -> None:
    recording = fingervision.Recording(file)
    expected = list(fingervision.open(press.frames, press.profile))
    assert len(recording.sensors) == 1
    assert recording.remarks == []
    frames = recording.frames()
    assert len(frames) == 7
    for frame, reading in zip(frames, expected, strict=True):
        assert frame.sequence == reading.sequence
        assert frame.image.tobytes() == reading.image.tobytes()
    table = recording.readings()
    assert table["sequence"].tolist() == list(range(7))
    assert table["force_n"].tobytes() == np.stack([reading.force for reading in expected]).tobytes()
    assert table["max_depth_mm"][0] == expected[0].max_depth_mm
    assert table["flags"] == ["+".join(reading.flags) for reading in expected]


def test_a_recording_is_tracked_as_its_source(press: Press, file: Path) -> None:
    expected = list(fingervision.open(press.frames, press.profile))
    with fingervision.open(file) as readings:
        assert readings.profile.name == fingervision.Profile.load(press.profile).name
        for reading, other in zip(readings, expected, strict=True):
            assert reading.depth.tobytes() == other.depth.tobytes()


def test_the_profile_is_in_the_file(press: Press, file: Path) -> None:
    recording = fingervision.Recording(file)
    profile = recording.profile()
    assert profile is not None
    assert profile == recording.profile(recording.sensors[0])
    assert profile.replace({"elastic.mode": "exact"}) == fingervision.Profile.load(press.profile)
    assert isinstance(recording.events(), list)


def test_what_is_no_recording_is_refused(press: Press, file: Path, tmp_path: Path) -> None:
    with pytest.raises(fingervision.RecordingError, match="profile.toml"):
        fingervision.Recording(press.profile)
    with pytest.raises(fingervision.RecordingError, match="middle"):
        fingervision.Recording(file).frames("middle")
    with pytest.raises(fingervision.RecordingError):
        fingervision.Recording(tmp_path / "none.mcap")
