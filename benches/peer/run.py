"""Times the OpenCV pipeline on a folder of frames and prints one JSON object.

The first frame is the reference. Frames are read into memory before the clock starts, and the first pass over the
sequence, in which the splat is compiled and buffers are touched for the first time, is not timed.
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter_ns

import cv2
import numba
import numpy as np
from cv2.typing import MatLike as Image

from pipeline import PRESETS, Density, DepthLine, Flow, GuidedFilter, Params

BORDER_PX = 16
"""Left out of the accuracy on each side, px."""


class Clock:
    """Collects the times of named stages, ms."""

    def __init__(self) -> None:
        self.stages: dict[str, list[float]] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Times what happens inside."""
        begin = perf_counter_ns()
        yield
        self.stages.setdefault(name, []).append((perf_counter_ns() - begin) / 1e6)


class Pipeline:
    """All stages, from a colour frame to depth."""

    def __init__(self, reference: Image, params: Params) -> None:
        height, width = reference.shape[:2]
        self._flow = Flow(grey(reference), params.preset)
        self._density = Density(height, width, params.sigma_px)
        self._filter = GuidedFilter(height, width, params)
        self._line = DepthLine(params.slope_mm, params.intercept_mm)

    def process(self, frame: Image, clock: Clock) -> tuple[Image, Image]:
        """Flow in px and depth in mm of one frame."""
        with clock.stage("frame"):
            with clock.stage("grey"):
                current = grey(frame)
            with clock.stage("flow"):
                flow = self._flow.estimate(current)
            with clock.stage("density"):
                feature = self._density.feature(flow)
            with clock.stage("filter"):
                filtered = self._filter.filter(feature)
            with clock.stage("line"):
                depth = self._line.depth(filtered)
        return flow, depth


def grey(frame: Image) -> Image:
    """The frame's luminance."""
    return cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)


def use_one_thread() -> None:
    """Keeps OpenCV and Numba to the calling thread."""
    cv2.setNumThreads(1)
    numba.set_num_threads(1)


def read_frames(folder: Path) -> list[Image]:
    """All PNG files of a folder by name, in colour."""
    frames = []
    for path in sorted(folder.glob("*.png")):
        frame = cv2.imread(str(path), cv2.IMREAD_COLOR)
        if frame is None:
            sys.exit(f"error: {path} is not an image")
        frames.append(frame)
    if len(frames) < 2:
        sys.exit(f"error: {folder} holds {len(frames)} PNG files, a reference and one more are needed")
    return frames


def read_truth(folder: Path, frames: Sequence[Image]) -> Image:
    """The true flow of every frame, `[frame][row][column][x, y]`, px."""
    truth: Image = np.load(folder / "flow.npy", mmap_mode="r")
    expected = (len(frames), *frames[0].shape[:2], 2)
    if truth.shape != expected:
        sys.exit(f"error: {folder / 'flow.npy'} has shape {truth.shape}, {expected} is needed")
    return truth


def end_point_error(flow: Image, truth: Image) -> float:
    """Mean distance between estimated and true displacement inside the border, px."""
    inside = slice(BORDER_PX, -BORDER_PX)
    miss = (flow - truth)[inside, inside].astype(np.float64)
    return float(np.hypot(miss[..., 0], miss[..., 1]).mean())


def accuracy(pipeline: Pipeline, frames: Sequence[Image], truth: Image) -> dict[str, object]:
    """Mean end-point error of each frame behind the reference, of all, and of the last, px."""
    errors = [
        end_point_error(pipeline.process(frame, Clock())[0], true)
        for frame, true in zip(frames[1:], truth[1:], strict=True)
    ]
    return {"mean": float(np.mean(errors)), "final": errors[-1], "per_frame": [round(error, 5) for error in errors]}


def percentiles(values: Sequence[float]) -> dict[str, float]:
    """Median, tenth and ninetieth percentile."""
    p10, median, p90 = np.percentile(values, [10, 50, 90])
    return {"median": round(float(median), 4), "p10": round(float(p10), 4), "p90": round(float(p90), 4)}


def measure(frames: Sequence[Image], params: Params, passes: int, truth: Image | None) -> dict[str, object]:
    """Runs the pipeline over the sequence and gathers every figure."""
    pipeline = Pipeline(frames[0], params)
    for frame in frames[1:]:
        pipeline.process(frame, Clock())
    clock = Clock()
    for _ in range(passes):
        for frame in frames[1:]:
            pipeline.process(frame, clock)
    whole = clock.stages.pop("frame")
    return {
        "frame_ms": percentiles(whole),
        "fps": round(1e3 / float(np.median(whole)), 2),
        "stages_ms": {name: percentiles(times) for name, times in clock.stages.items()},
        "epe_px": None if truth is None else accuracy(pipeline, frames, truth),
    }


def versions() -> dict[str, str]:
    """What ran."""
    return {
        "python": platform.python_version(),
        "opencv": cv2.__version__,
        "numpy": np.__version__,
        "numba": numba.__version__,
    }


def arguments() -> argparse.Namespace:
    """What was typed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("frames", type=Path, help="folder of PNG frames, the reference first")
    parser.add_argument("--truth", type=Path, metavar="DIR", help="folder with flow.npy, for the accuracy")
    parser.add_argument("--preset", choices=PRESETS, default="medium", help="preset of the flow (default: medium)")
    parser.add_argument("--passes", type=int, default=3, help="timed passes over the sequence (default: 3)")
    return parser.parse_args()


def main() -> None:
    """Measures and prints."""
    args = arguments()
    use_one_thread()
    frames = read_frames(args.frames)
    truth = None if args.truth is None else read_truth(args.truth, frames)
    height, width = frames[0].shape[:2]
    sequence = {"width": width, "height": height, "frames": len(frames), "passes": args.passes, "preset": args.preset}
    measured = measure(frames, Params(preset=args.preset), args.passes, truth)
    report = {"sequence": sequence, **measured, "versions": versions()}
    json.dump(report, sys.stdout, indent=2)
    print()


if __name__ == "__main__":
    main()
