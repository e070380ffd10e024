"""The ``fingervision`` command."""

import sys

from fingervision._native import run


def main() -> int:
    """Runs the command with the arguments of the process."""
    return run(["fingervision", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
