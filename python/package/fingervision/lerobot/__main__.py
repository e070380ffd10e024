"""``fingervision export --lerobot`` and ``python -m fingervision.lerobot``."""

from __future__ import annotations

import argparse
import json
import sys
from typing import TYPE_CHECKING, Any

from fingervision._errors import ArgumentError, Error
from fingervision.lerobot._export import export_lerobot

if TYPE_CHECKING:
    from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command and returns its exit code."""
    options = _parser().parse_args(arguments)
    try:
        summary = export_lerobot(
            options.recordings,
            options.out,
            task=options.task,
            profile=options.profile,
            fields=options.fields.split(",") if options.fields else None,
            images=not options.no_images,
            frames_per_second=options.frames_per_second,
            set=dict(map(_setting, options.set)) or None,
        )
    except (Error, OSError) as error:
        message, hint = error.args[-1] if error.args else str(error), getattr(error, "hint", None)
        if options.json:
            print(json.dumps({"error": str(message), "hint": hint}), file=sys.stderr)
        else:
            print(f"error: {message}" + (f"\nhint: {hint}" if hint else ""), file=sys.stderr)
        return 1
    if options.json:
        print(json.dumps(summary))
    elif not options.quiet:
        print(f"exported {summary['folder']}: {summary['episodes']} episodes, {summary['frames']} frames")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="fingervision export --lerobot",
        description="Write runs and recordings as a LeRobot data set, format v3.0: an episode for each.",
        allow_abbrev=False,
    )
    parser.add_argument("recordings", metavar="RUN|FILE.mcap", nargs="+", help="folders of `track`, or recordings")
    parser.add_argument("--out", required=True, metavar="DIR", help="the folder to write; it must not exist")
    parser.add_argument("--task", default="touch", help="what is done in the recordings, in words")
    parser.add_argument("--fields", metavar="NAMES", help="fields to export, separated by commas")
    parser.add_argument("--no-images", action="store_true", help="leave the camera images out")
    parser.add_argument("--frames-per-second", type=int, metavar="N", help="the rate, instead of the recording's own")
    parser.add_argument("--profile", metavar="FILE", help="the profile, instead of the recorded one")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="set a value of the profile")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    parser.add_argument("-q", "--quiet", action="store_true", help="print only errors")
    return parser


def _setting(text: str) -> tuple[str, Any]:
    name, is_given, value = text.partition("=")
    if not is_given:
        raise ArgumentError(f"--set {text} has no value: write it as KEY=VALUE")
    try:
        return name, json.loads(value)
    except ValueError:
        return name, value


if __name__ == "__main__":
    sys.exit(main())
