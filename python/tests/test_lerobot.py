"""LeRobot data sets: what is exported is read back, from the files and, where it is installed, with LeRobot itself."""

from __future__ import annotations

import importlib
import io
import json
import sys
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import fingervision
from conftest import Press
from fingervision.lerobot import export_lerobot

if TYPE_CHECKING:
    from pathlib import Path

    import numpy.typing as npt

pytest.importorskip("pyarrow")
pillow = pytest.importorskip("PIL.Image")
PREFIX = "observation.touch."


@pytest.fixture(scope="module")
def data_set(file: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The recording twice: two episodes."""
    folder = tmp_path_factory.mktemp("lerobot") / "set"
    result = fingervision.command("export", file, file, "--lerobot", "--out", folder, "--task", "press")
    assert result == {"folder": str(folder), "episodes": 2, "frames": 14, "frames_per_second": 30}
    return folder


def column(folder: Path, episode: int, name: str) -> Any:
    """A column of an episode's file, without its nesting."""
    parquet: Any = importlib.import_module("pyarrow.parquet")
    table = parquet.read_table(folder / f"data/chunk-000/file-{episode:03}.parquet", columns=[name])
    values = table[name].combine_chunks()
    while str(values.type).startswith("list"):
        values = values.flatten()
    return values


def numbers(folder: Path, episode: int, name: str) -> npt.NDArray[Any]:
    """The values of a column of numbers, one after another."""
    return column(folder, episode, name).to_numpy(zero_copy_only=False)


def test_every_array_is_kept(file: Path, data_set: Path) -> None:
    readings = list(fingervision.open(file))
    for name in (*readings[0].fields, "valid", "force"):
        expected = np.stack([getattr(reading, name) for reading in readings])
        found = numbers(data_set, 1, PREFIX + name)
        assert found.dtype == expected.dtype, name
        assert found.tobytes() == expected.tobytes(), name
    expected_ns = [round(reading.capture_time_s * 1e9) for reading in readings]
    assert numbers(data_set, 1, PREFIX + "capture_time_ns").tolist() == expected_ns
    assert numbers(data_set, 1, "timestamp").tolist() == np.float32(np.arange(7) / 30).tolist()
    assert numbers(data_set, 1, "index").tolist() == list(range(7, 14))
    assert numbers(data_set, 1, "frame_index").tolist() == list(range(7))


def test_images_are_kept(file: Path, data_set: Path) -> None:
    found = column(data_set, 0, PREFIX + "image").to_pylist()
    for stored, frame in zip(found, fingervision.Recording(file).frames(), strict=True):
        with pillow.open(io.BytesIO(stored["bytes"])) as picture:
            assert picture.format == "PNG"
            assert np.asarray(picture).tobytes() == frame.image.tobytes()


def test_a_missing_library_is_named(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for module, package in {"PIL.Image": "Pillow", "pyarrow": "pyarrow"}.items():
        monkeypatch.setitem(sys.modules, module, None)
        with pytest.raises(fingervision.Error, match=f"need {package}, which"):
            export_lerobot(file, tmp_path / "set")
    assert list(tmp_path.iterdir()) == []


def test_a_run_has_the_same_arrays(press: Press, tmp_path: Path) -> None:
    result = fingervision.command("export", press.run, "--lerobot", "--out", tmp_path / "set")
    assert result["frames"] == 7
    for name in ("flow", "depth", "contact", "traction"):
        expected = np.load(press.run / f"{name}.npy")
        found = numbers(tmp_path / "set", 0, PREFIX + name)
        assert found.astype(expected.dtype).tobytes() == expected.tobytes(), name


def test_the_statistics_are_those_of_the_values(file: Path, data_set: Path) -> None:
    statistics = json.loads((data_set / "meta/stats.json").read_text(encoding="utf-8"))
    depth = np.stack([reading.depth for reading in fingervision.open(file)]).astype(np.float64)
    found = statistics[PREFIX + "depth"]
    assert found["mean"] == [[pytest.approx(depth.mean())]]
    assert found["std"] == [[pytest.approx(depth.std())]]
    assert found["max"] == [[pytest.approx(depth.max())]]
    assert found["count"] == [14]


def test_wrong_use_is_refused(press: Press, file: Path, data_set: Path, tmp_path: Path) -> None:
    refused = [
        ([file, "--out", data_set], "exists already"),
        ([tmp_path / "none.mcap", "--out", tmp_path / "set"], "there is no"),
        ([press.profile, "--out", tmp_path / "set"], "neither a run nor a recording"),
        ([press.run, file, "--out", tmp_path / "set"], "other features"),
        ([press.run, "--profile", press.profile, "--out", tmp_path / "set"], "tracked already"),
    ]
    for arguments, message in refused:
        with pytest.raises(fingervision.CommandError, match=message):
            fingervision.command("export", "--lerobot", *arguments)
    assert list(tmp_path.iterdir()) == []


def test_lerobot_reads_it(file: Path, data_set: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("HF_HOME", str(tmp_path))
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    lerobot: Any = pytest.importorskip("lerobot.datasets.lerobot_dataset")
    data = lerobot.LeRobotDataset("local/touch", root=data_set)
    assert (len(data), data.num_episodes, data.fps) == (14, 2, 30)
    for index, reading in enumerate(fingervision.open(file)):
        item = data[7 + index]
        assert item["task"] == "press"
        assert item[PREFIX + "depth"].numpy().tobytes() == reading.depth.tobytes()
        image: np.ndarray[Any, np.dtype[np.float32]] = item[PREFIX + "image"].numpy().transpose(1, 2, 0)
        assert np.round(image * 255).astype(np.uint8).tobytes() == reading.image.tobytes()
