"""Simulated presses: their frames and truth are those of the command."""

from __future__ import annotations

import csv
from typing import TYPE_CHECKING

import numpy as np
import pytest

import fingervision
from conftest import SCENE, Press

if TYPE_CHECKING:
    import numpy.typing as npt


def test_truth_is_that_of_the_files(press: Press, simulation: fingervision.Simulation) -> None:
    truth = {name: np.load(press.folder / "truth" / f"{name}.npy") for name in ("flow", "depth", "displacement")}
    masks = {name: np.load(press.folder / "truth" / f"{name}.npy") for name in ("contact", "visible")}
    with (press.folder / "truth" / "force.csv").open(encoding="utf-8", newline="") as file:
        forces = list(csv.DictReader(file))
    assert len(simulation) == len(forces) == 7
    for index in (0, 3, -1):
        frame = simulation[index]
        for name, arrays in truth.items():
            assert getattr(frame, name).tobytes() == arrays[index].tobytes(), name
        for name, arrays in masks.items():
            assert getattr(frame, name).astype(np.uint8).tobytes() == arrays[index].tobytes(), name
        assert frame.force[2] == pytest.approx(float(forces[index]["force_z_n"]), rel=1e-5, abs=1e-9)
        assert frame.depth_mm == pytest.approx(float(forces[index]["depth_mm"]), rel=1e-5, abs=1e-9)


def test_images_are_those_of_the_files(
    simulation: fingervision.Simulation, images: list[npt.NDArray[np.uint8]]
) -> None:
    for frame, image in zip(simulation, images, strict=True):
        assert frame.image.tobytes() == image.tobytes()


def test_a_simulated_press_is_tracked_with_its_own_profile(simulation: fingervision.Simulation) -> None:
    tracker = fingervision.Tracker(simulation.profile, channels="rgb")
    readings = [tracker.track(simulation[index].image) for index in range(len(simulation))]
    truth = simulation[-1]
    error = np.abs(readings[-1].depth - truth.depth)[readings[-1].depth_valid & np.isfinite(truth.depth)]
    assert error.mean() < 0.02
    assert readings[-1].force[2] == pytest.approx(truth.force[2], rel=0.15)


def test_frames_end_at_the_last(simulation: fingervision.Simulation) -> None:
    with pytest.raises(IndexError, match="frame 7 of 7"):
        _ = simulation[7]
    with pytest.raises(IndexError):
        _ = simulation[-8]
    assert simulation[-7].image.tobytes() == simulation[0].image.tobytes()


def test_scenes_are_named_and_wrong_ones_refused() -> None:
    assert "letter" in fingervision.scenes()
    with pytest.raises(ValueError, match="no-such-scene"):
        fingervision.simulate("no-such-scene")
    with pytest.raises(ValueError, match="a scene or toml is needed"):
        fingervision.simulate()
    with pytest.raises(ValueError, match="a scene or toml is needed"):
        fingervision.simulate("letter", toml="")
    with pytest.raises(fingervision.SceneError):
        fingervision.simulate("circle", set={"gel.poissons_ratio": 0.7})


def test_values_and_seed_are_set(simulation: fingervision.Simulation) -> None:
    other = fingervision.simulate(toml=SCENE, draft=True, cache=False, seed=7, set={"gel.thickness_mm": 8.0})
    assert simulation[0].image.tobytes() != other[0].image.tobytes()
    assert "thickness_mm = 8.0" in other.profile.to_toml()
    assert "thickness_mm = 8.0" in other.to_toml()
