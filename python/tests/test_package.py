"""What the package contains."""

from __future__ import annotations

import importlib.metadata
import importlib.resources
import subprocess
import sys

import fingervision


def test_every_name_is_documented() -> None:
    for name in fingervision.__all__:
        if name not in ("FLAGS", "__version__"):
            assert getattr(fingervision, name).__doc__, name


def test_every_member_is_documented() -> None:
    for name in fingervision.__all__:
        kind = getattr(fingervision, name)
        if isinstance(kind, type) and kind.__module__ == "fingervision":
            for member, value in vars(kind).items():
                assert member.startswith("_") or value.__doc__, f"{name}.{member}"


def test_the_version_is_that_of_the_distribution() -> None:
    assert importlib.metadata.version("fingervision") == fingervision.__version__


def test_types_are_part_of_the_package() -> None:
    files = {file.name for file in importlib.resources.files("fingervision").iterdir()}
    assert {"py.typed", "_native.pyi", "__init__.py"} <= files


def test_numpy_is_imported_when_it_is_needed() -> None:
    code = "import sys, fingervision; sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_every_exception_is_an_error() -> None:
    for name in fingervision.__all__:
        kind = getattr(fingervision, name)
        if name.endswith("Error"):
            assert issubclass(kind, fingervision.Error), name
