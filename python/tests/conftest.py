"""A simulated press, solved once, as files and in memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pytest

import fingervision

if TYPE_CHECKING:
    from pathlib import Path

    import numpy.typing as npt

SCENE = """
motion = { frames = 7 }
indenter = { shape = "sphere", radius_mm = 6.0 }
"""
ALL_FIELDS = ("flow", "density", "depth", "depth_deviation", "contact", "displacement", "traction", "deviation")


@dataclass(frozen=True)
class Press:
    """The files of a simulated press and of a run of the command over it."""

    folder: Path
    run: Path

    @property
    def frames(self) -> Path:
        """The camera's images."""
        return self.folder / "frames"

    @property
    def profile(self) -> Path:
        """The profile of the simulated sensor."""
        return self.folder / "profile.toml"


@pytest.fixture(scope="session")
def press(tmp_path_factory: pytest.TempPathFactory) -> Press:
    """A press, and what the command tracks in it."""
    base = tmp_path_factory.mktemp("press")
    (base / "scene.toml").write_text(SCENE, encoding="utf-8")
    made = Press(base / "sphere", base / "run")
    fingervision.command("simulate", base / "scene.toml", "--out", made.folder, "--draft", "--no-cache")
    options = ["--profile", made.profile, "--fields", ",".join(ALL_FIELDS), "--out", made.run]
    fingervision.command("track", made.frames, *options)
    return made


@pytest.fixture(scope="session")
def simulation() -> fingervision.Simulation:
    """The same press in memory."""
    return fingervision.simulate(toml=SCENE, draft=True, cache=False)


@pytest.fixture(scope="session")
def tracked(press: Press) -> list[fingervision.Reading]:
    """The readings of the press. Their arrays are shared: do not change them."""
    return list(fingervision.open(press.frames, press.profile))


@pytest.fixture
def images(tracked: list[fingervision.Reading]) -> list[npt.NDArray[np.uint8]]:
    """Copies of the camera's images."""
    return [reading.image.astype(np.uint8) for reading in tracked]


@pytest.fixture(scope="session")
def file(press: Press, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The press as a recording."""
    path = tmp_path_factory.mktemp("recording") / "press.mcap"
    fingervision.command("record", press.frames, path, "--profile", press.profile)
    return path
