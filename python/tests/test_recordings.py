"""Recordings: what `fingervision record` writes is read back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import fingervision
from conftest import SCENE, Press

if TYPE_CHECKING:
    from pathlib import Path


def test_frames_and_readings_are_kept(file: Path, tracked: list[fingervision.Reading]) -> None:
    recording, expected = fingervision.Recording(file), tracked
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
    for name in ("mean_level", "saturated_part", "sharpness"):
        values = np.array([getattr(reading, name) for reading in expected], np.float32)
        assert table[name].tobytes() == values.tobytes(), name
    times = recording.capture_times_s()
    assert times.dtype == np.float64
    assert times.tolist() == [reading.capture_time_s for reading in expected]


def test_the_levels_are_those_of_the_image() -> None:
    image = np.full((96, 128), 40, np.uint8)
    image[:, :64] = 100
    image[:16] = 255
    reading = fingervision.Tracker(fields=["flow"]).track(image)
    assert reading.mean_level == pytest.approx(image.mean(), rel=1e-3)
    assert reading.saturated_part == pytest.approx(1 / 6, rel=1e-3)
    assert reading.sharpness > 0


def test_the_truth_of_a_simulation_is_kept(
    press: Press, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    (tmp_path / "scene.toml").write_text(SCENE, encoding="utf-8")
    file = tmp_path / "press.mcap"
    with pytest.warns(fingervision.NoteWarning, match="solving 7 frames"):
        fingervision.command("record", f"sim:{tmp_path / 'scene.toml'}?draft", file, "--frames-only")
    truths = fingervision.Recording(file).truths()
    expected = np.genfromtxt(press.folder / "truth/force.csv", delimiter=",", names=True)
    assert truths["sequence"].tolist() == expected["frame"].tolist()
    assert truths["force_n"].shape == (len(expected), 3)
    assert truths["force_n"].dtype == truths["depth_mm"].dtype == truths["torque_nmm"].dtype == np.float64
    for name in ("depth_mm", "torque_nmm"):
        column = name.replace("torque", "torque_z")
        assert truths[name].tolist() == pytest.approx(expected[column].tolist(), abs=1e-6), name
    for axis, name in enumerate(("force_x_n", "force_y_n", "force_z_n")):
        assert truths["force_n"][:, axis].tolist() == pytest.approx(expected[name].tolist(), abs=1e-6), name
    assert truths["force_n"][-1, 2] > 1


def test_a_real_sensor_has_no_truth(file: Path) -> None:
    truths = fingervision.Recording(file).truths()
    assert {name: len(values) for name, values in truths.items()} == dict.fromkeys(truths, 0)
    assert truths["force_n"].shape == (0, 3)


def test_a_recording_is_tracked_as_its_source(
    press: Press, file: Path, tracked: list[fingervision.Reading]
) -> None:
    with fingervision.open(file) as readings:
        assert readings.profile.name == fingervision.Profile.load(press.profile).name
        for reading, other in zip(readings, tracked, strict=True):
            assert reading.depth.tobytes() == other.depth.tobytes()
    options: Any = {"fields": ["flow"], "set": {"flow.colour": False}}
    with fingervision.Recording(file).track(**options) as readings, fingervision.open(file, **options) as others:
        assert readings.profile == others.profile
        for reading, other in zip(readings, others, strict=True):
            assert reading.fields == other.fields
            assert reading.flow.tobytes() == other.flow.tobytes()


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
    recording = fingervision.Recording(file)
    for use in (recording.frames, recording.readings, recording.truths, recording.capture_times_s):
        with pytest.raises(fingervision.RecordingError, match="middle"):
            use("middle")
    with pytest.raises(fingervision.RecordingError, match="middle"):
        recording.track(sensor="middle")
    with pytest.raises(fingervision.RecordingError):
        fingervision.Recording(tmp_path / "none.mcap")
