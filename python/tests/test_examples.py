"""Every example runs. An example whose library is missing is skipped."""

from __future__ import annotations

import importlib.util
import os
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import fingervision
from conftest import Press

EXAMPLES = Path(__file__).parent.parent / "examples"
RECORDINGS = 20 if importlib.util.find_spec("ray") else 6


@pytest.fixture(autouse=True)
def _cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """Solved presses of the examples are shared, but not with the user's."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.getbasetemp() / "cache"))
    monkeypatch.setenv("MPLBACKEND", "agg")


def example(name: str, *arguments: object, folder: Path) -> str:
    """Runs an example in a folder and returns what it prints."""
    command = [sys.executable, str(EXAMPLES / f"{name}.py"), *map(str, arguments)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_first_touch(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    example("first_touch", folder=tmp_path)
    assert (tmp_path / "depth.png").read_bytes().startswith(b"\x89PNG")


def test_plot_press(press: Press, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    example("plot_press", press.frames, "--profile", press.profile, folder=tmp_path)
    assert (tmp_path / "press.png").read_bytes().startswith(b"\x89PNG")


def test_calibrate_folder(press: Press, tmp_path: Path) -> None:
    profile = tmp_path / "sensor.toml"
    before = fingervision.Profile.load(press.profile)
    before.save(profile)
    assert "written:" in example("calibrate_folder", press.folder, "--profile", profile, folder=tmp_path)
    assert "slope_mm" in fingervision.Profile.load(profile).to_toml()
    assert "slope_mm" not in before.to_toml()


def test_evaluate_simulation(tmp_path: Path) -> None:
    lines = example("evaluate_simulation", "circle", "--draft", folder=tmp_path).splitlines()[1:]
    errors = np.array([[float(cell) for cell in line.split()] for line in lines])
    assert len(errors) > 5
    assert errors[:, 1].max() < 0.1
    assert errors[:, 2].max() < 0.05
    assert errors[-1, 3] == pytest.approx(errors[-1, 4], rel=0.15)


def test_speed(press: Press, tmp_path: Path) -> None:
    lines = example(
        "speed", "--recording", press.frames, "--profile", press.profile, "--rounds", 1, folder=tmp_path
    ).splitlines()
    assert len(lines) == 4
    overhead_ms = float(lines[0].split(" takes ")[1].split(" ", 1)[0])
    assert 0.0 < overhead_ms < 100.0
    rates = [float(line.split(": ")[1].split(" ", 1)[0]) for line in lines[1:]]
    assert min(rates) > 0.0


def test_torch_loop(tmp_path: Path) -> None:
    pytest.importorskip("torch")
    lines = example("torch_loop", folder=tmp_path).splitlines()
    rewards = [float(line.rsplit(" ", 1)[1]) for line in lines]
    assert rewards[-1] > -0.4


def test_rerun_stream(press: Press, tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    file = tmp_path / "press.rrd"
    example("rerun_stream", press.frames, "--profile", press.profile, "--save", file, folder=tmp_path)
    assert file.read_bytes().startswith(b"RRF2")


@pytest.fixture(scope="module")
def recordings(press: Press, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Folders of images: the press, from another image on each."""
    images = sorted(press.frames.iterdir())
    base = tmp_path_factory.mktemp("recordings")
    folders = [base / f"press{number:02}" for number in range(RECORDINGS)]
    for number, folder in enumerate(folders):
        folder.mkdir()
        for image in [images[0], *images[1 + number % 5 :][:2]]:
            os.link(image, folder / image.name)
    return folders


@pytest.fixture(scope="module")
def one_after_another(press: Press, recordings: list[Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The features of the recordings, made in this process."""
    folder = tmp_path_factory.mktemp("features")
    features = runpy.run_path(str(EXAMPLES / "dataset.py"))["features"]
    for recording in recordings:
        features(str(recording), str(press.profile), str(folder))
    return folder


@pytest.mark.parametrize("pool", ["multiprocessing", "ray"])
def test_dataset(press: Press, recordings: list[Path], one_after_another: Path, tmp_path: Path, pool: str) -> None:
    if pool == "ray":
        pytest.importorskip("ray")
    together = ["--ray"] if pool == "ray" else []
    options = ["--profile", press.profile, "--workers", "2", *together]
    printed = example("dataset", *recordings, "--out", tmp_path / "two", *options, folder=tmp_path)
    assert len(printed.splitlines()) >= RECORDINGS
    for recording in recordings:
        alone = np.load(one_after_another / f"{recording.name}.npz")
        other = np.load(tmp_path / "two" / f"{recording.name}.npz")
        assert sorted(alone) == sorted(other)
        for name in alone:
            assert alone[name].tobytes() == other[name].tobytes(), (recording, name)
