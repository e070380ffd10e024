"""Profiles."""

from __future__ import annotations

import pickle
from typing import TYPE_CHECKING

import numpy as np
import pytest

import fingervision
from conftest import Press

if TYPE_CHECKING:
    from pathlib import Path


def test_values_of_every_type_are_set() -> None:
    values = {
        "name": "left",
        "flow.finest_level": 1,
        "flow.colour": False,
        "flow.noise_levels": np.float32(1.5),
        "image.region_of_interest": (1, 2, 100, np.int64(80)),
    }
    profile = fingervision.Profile(set=values)
    assert profile.name == "left"
    for line in ("finest_level = 1", "colour = false", "noise_levels = 1.5"):
        assert line in profile.to_toml()
    assert profile == fingervision.Profile.from_toml(profile.to_toml())


def test_a_profile_is_a_value(press: Press, tmp_path: Path) -> None:
    profile = fingervision.Profile.load(press.profile)
    assert profile == fingervision.Profile.load(str(press.profile))
    assert profile != profile.replace({"gel.thickness_mm": 9.0})
    assert pickle.loads(pickle.dumps(profile)) == profile
    profile.save(tmp_path / "copy.toml")
    assert fingervision.Profile.load(tmp_path / "copy.toml") == profile
    assert fingervision.Profile.load(press.run / "run.toml") == profile
    assert profile.depth_method == "elastic"
    with pytest.raises(AttributeError):
        profile.name = "other"  # type: ignore[misc]
    with pytest.raises(fingervision.SourceError):
        profile.save(tmp_path / "no" / "such" / "folder.toml")


def test_the_region_of_interest_is_the_shape(press: Press) -> None:
    with fingervision.open(press.frames, set={"image.region_of_interest": [40, 60, 300, 200]}) as readings:
        assert readings.shape == (200, 300)
        assert readings.frame_count == 7
        reading = next(readings)
    assert reading.flow.shape == (200, 300, 2)
    assert reading.image.shape == (480, 480, 3)
