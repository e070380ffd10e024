"""Commands as functions: each runs ``fingervision COMMAND --json`` in a process of its own and returns its result.

Options have the names of the command line, ``fingervision COMMAND --help`` explains them.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import warnings
from typing import TYPE_CHECKING, Any

from fingervision._errors import CommandError, NoteWarning, UsageError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Literal, TypeAlias

    _Path: TypeAlias = str | os.PathLike[str]
    _Value: TypeAlias = str | os.PathLike[str] | float | Sequence[str | float] | None

__all__ = ["calibrate_camera", "calibrate_depth", "calibrate_gel", "command", "evaluate", "pattern"]

_WRONG_USAGE = 2


def command(*arguments: _Path) -> dict[str, Any]:
    """Runs a command and returns its JSON result, as in ``command("track", "press.mp4", "--out", "run")``.

    Its notes become warnings of the class ``NoteWarning``. Ctrl-C ends the command.

    Raises ``UsageError`` for wrong options and ``CommandError`` if the command fails.
    """
    return _called([os.fspath(argument) for argument in arguments])


def pattern(
    out: _Path,
    *,
    kind: Literal["colour", "dots", "speckle"] | None = None,
    size_mm: tuple[float, float] | None = None,
    cell_mm: float | None = None,
    dots: tuple[int, int] | None = None,
    dot_diameter_mm: float | None = None,
    speckle_diameter_mm: float | None = None,
    coverage: float | None = None,
    seed: int | None = None,
    levels: tuple[int, int] | None = None,
    page: Literal["a4", "letter"] | None = None,
    dpi: float | None = None,
    overwrite: bool = False,
) -> dict[str, Any]:
    """Writes a pattern at true scale to a ``.pdf``, ``.svg`` or ``.png`` file; returns what it contains.

    ``size_mm`` is width and height, ``dots`` columns and rows; ``coverage`` is a part, 0.05 to 0.9.

    Raises ``CommandError`` if the file exists, unless ``overwrite``.
    """
    options = _options(
        out=out,
        kind=kind,
        size_mm=size_mm,
        cell_mm=cell_mm,
        dots=dots,
        dot_diameter_mm=dot_diameter_mm,
        speckle_diameter_mm=speckle_diameter_mm,
        coverage=coverage,
        seed=seed,
        levels=levels,
        page=page,
        dpi=dpi,
        overwrite=overwrite,
    )
    return _called(["pattern", *options])


def calibrate_camera(
    boards: _Path | Sequence[_Path] = (),
    *,
    profile: _Path,
    step_mm: float | Sequence[float] | None = None,
    direction: str | None = None,
    priors: dict[str, tuple[float, float]] | None = None,
    corners: _Path | None = None,
    radial: Literal["brown", "printed"] | None = None,
    start: Literal["plain", "published"] | None = None,
    picture: _Path | None = None,
) -> dict[str, Any]:
    """Finds pose and lens of the camera from slides of a patterned board; writes ``[camera]`` of the profile's file.

    ``boards`` are folders or videos, one for each slide; ``corners`` is a table of checkerboard corners instead. ``priors``
    are values with their standard deviations, as in ``{"distance_mm": (25.0, 0.5)}``.

    Raises ``CommandError`` if nothing can be fitted.
    """
    prior = [f"--prior={name}={value}+-{deviation}" for name, (value, deviation) in (priors or {}).items()]
    options = _options(
        profile=profile,
        step_mm=step_mm,
        direction=direction,
        corners=corners,
        radial=radial,
        start=start,
        picture=picture,
    )
    return _called(["calibrate", "camera", *_several(boards), *options, *prior])


def calibrate_depth(
    presses: _Path | Sequence[_Path] = (),
    *,
    profile: _Path,
    simulated: bool = False,
    draft: bool = False,
    method: Literal["line", "origin", "perspective"] | None = None,
    maximum: Literal["plain", "robust"] | None = None,
    picture: _Path | None = None,
) -> dict[str, Any]:
    """Fits depth to the density feature of presses of known depth; writes ``depth.density`` of the profile's file.

    ``presses`` are folders with ``depth.csv``, or simulated scenes.

    Raises ``CommandError`` if nothing can be fitted.
    """
    options = _options(
        profile=profile, simulated=simulated, draft=draft, method=method, maximum=maximum, picture=picture
    )
    return _called(["calibrate", "depth", *_several(presses), *options])


def calibrate_gel(
    presses: _Path | Sequence[_Path],
    *,
    profile: _Path,
    draft: bool = False,
    fit: Sequence[Literal["poissons-ratio", "thickness", "youngs-modulus"]] | None = None,
    picture: _Path | None = None,
) -> dict[str, Any]:
    """Finds Poisson's ratio, thickness and Young's modulus of the gel; writes ``[gel]`` of the profile's file.

    ``presses`` are folders with ``depth.csv``, or simulated scenes. ``fit`` lists the values to find.

    Raises ``CommandError`` if the presses do not determine them.
    """
    options = _options(profile=profile, draft=draft, fit=fit, picture=picture)
    return _called(["calibrate", "gel", *_several(presses), *options])


def evaluate(
    run: _Path, truth: _Path, *, out: _Path | None = None, common_frames: bool = False, overwrite: bool = False
) -> dict[str, Any]:
    """Compares a run with its truth: errors of flow, depth and force by region; writes a picture.

    ``run`` is the folder of ``track --out`` or any other with ``flow.npy`` or ``depth.npy``, ``truth`` the folder of
    ``simulate --out``.

    Raises ``CommandError`` if they do not fit together.
    """
    options = _options(out=out, common_frames=common_frames, overwrite=overwrite)
    return _called(["evaluate", *_several([run, truth]), *options])


def _several(paths: _Path | Sequence[_Path]) -> list[str]:
    """Paths as arguments that cannot be taken for options."""
    listed = [paths] if isinstance(paths, (str, os.PathLike)) else paths
    texts = [os.fspath(path) for path in listed]
    return [os.path.join(os.curdir, text) if text.startswith("-") else text for text in texts]


def _options(**values: _Value) -> list[str]:
    """Options by their Python names; absent and false ones are left out."""
    options: list[str] = []
    for name, value in values.items():
        option = "--" + name.replace("_", "-")
        if value is True:
            options.append(option)
        elif isinstance(value, (str, os.PathLike)):
            options.append(f"{option}={os.fspath(value)}")
        elif isinstance(value, (int, float)):
            options += [f"{option}={value}"] if value is not False else []
        elif value is not None:
            options.append(f"{option}={','.join(map(str, value))}")
    return options


def _called(arguments: list[str]) -> dict[str, Any]:
    program = [sys.executable, "-m", "fingervision", *arguments, "--json"]
    done = subprocess.run(program, capture_output=True, check=False, encoding="utf-8", errors="replace")
    error: dict[str, Any] | None = None
    for line in done.stderr.splitlines():
        try:
            message: dict[str, Any] = json.loads(line)
        except ValueError:
            message = {"note": line}
        if "error" in message:
            error = message
        else:
            warnings.warn(str(message.get("note")), NoteWarning, stacklevel=3)
    if done.returncode == 0:
        return json.loads(done.stdout) if done.stdout.strip() else {}
    kind = UsageError if done.returncode == _WRONG_USAGE else CommandError
    raised = kind(error["error"] if error else f"fingervision {' '.join(arguments)} ended with {done.returncode}")
    raised.hint = error["hint"] if error else None
    raise raised
