"""The ``fingervision`` command."""

import sys

from fingervision._native import run


def main() -> int:
    """Runs the command with the arguments of the process."""
    arguments = sys.argv[1:]
    if arguments[:1] == ["export"] and "--lerobot" in arguments:
        from fingervision.lerobot.__main__ import main as export_lerobot  # noqa: PLC0415  NumPy is slow to import

        return export_lerobot([argument for argument in arguments[1:] if argument != "--lerobot"])
    return run(["fingervision", *arguments])


if __name__ == "__main__":
    sys.exit(main())
