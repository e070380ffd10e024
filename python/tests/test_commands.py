"""The command in the wheel, and commands as functions."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import fingervision
from conftest import Press

PROGRAM = Path(sys.executable).parent / "fingervision"


def program(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """Runs the installed command."""
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, check=False)


def test_the_command_is_installed() -> None:
    done = program("--version")
    assert (done.returncode, done.stdout.split()) == (0, ["fingervision", fingervision.__version__])
    assert "calibrate" in program("--help").stdout
    wrong = program("track")
    assert (wrong.returncode, "--out" in wrong.stderr) == (2, True)
    failed = program("track", "nowhere", "--out", "run")
    assert (failed.returncode, failed.stderr.splitlines()[0][:6]) == (1, "error:")


def test_a_run_is_evaluated(press: Press, tmp_path: Path) -> None:
    result = fingervision.evaluate(press.run, press.folder, out=tmp_path / "evaluation")
    assert (tmp_path / "evaluation" / "evaluation.png").is_file()
    assert result["frames"] == 7


def test_a_pattern_is_written(tmp_path: Path) -> None:
    file = tmp_path / "pattern.svg"
    result = fingervision.pattern(file, size_mm=(12.0, 8.0), cell_mm=0.5, seed=3)
    assert "<svg" in file.read_text(encoding="utf-8")
    assert result
    with pytest.raises(fingervision.CommandError, match="exists already") as raised:
        fingervision.pattern(file)
    assert raised.value.hint is not None
    assert "overwrite" in raised.value.hint
    fingervision.pattern(file, kind="dots", dots=(3, 4), overwrite=True)


def test_a_depth_law_is_fitted(tmp_path: Path, press: Press) -> None:
    profile = tmp_path / "sensor.toml"
    plain = fingervision.Profile.load(press.profile).replace({"depth.method": "density"})
    plain.save(profile)
    result = fingervision.calibrate_depth("calibration-centre-1mm", profile=profile, draft=True, method="line")
    assert result
    assert fingervision.Profile.load(profile) != plain


def test_a_failure_is_an_exception(press: Press, tmp_path: Path) -> None:
    with pytest.raises(fingervision.UsageError, match="nonsense"):
        fingervision.command("nonsense")
    with pytest.raises(ValueError, match="kind"):
        fingervision.pattern(tmp_path / "a.svg", kind="stripes")  # type: ignore[arg-type]
    with pytest.raises(fingervision.CommandError, match="nowhere"):
        fingervision.evaluate(press.run, "nowhere")
    with pytest.raises(fingervision.CommandError):
        fingervision.calibrate_gel("nowhere", profile=press.profile)
    with pytest.raises(fingervision.CommandError):
        fingervision.calibrate_camera(tmp_path, profile=tmp_path / "s.toml", step_mm=0.5)


def test_a_name_like_an_option_is_a_path(press: Press) -> None:
    with pytest.raises(fingervision.CommandError, match="--out") as raised:
        fingervision.evaluate("--out", press.folder)
    assert not isinstance(raised.value, fingervision.UsageError)
