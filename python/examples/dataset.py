"""How do I process many recordings? One worker per processor, on this machine or on a Ray cluster.

    python dataset.py recordings/*.mcap --out features/          # this machine
    python dataset.py recordings/*.mcap --out features/ --ray    # the Ray cluster that RAY_ADDRESS names, or a local one

Each recording becomes a file of arrays, one row for each frame. The result does not depend on the number of workers.
"""

from __future__ import annotations

import argparse
import functools
import multiprocessing
from pathlib import Path
from typing import Any

import numpy as np

import fingervision

COLUMNS = ("sequence", "capture_time_s", "max_depth_mm", "contact_area_mm2", "torque")


def features(recording: str, profile: str | None, out: str) -> str:
    """Tracks one recording and writes its features; returns their file."""
    with fingervision.open(recording, profile) as source:
        readings = list(source)
    table = {name: np.array([getattr(reading, name) for reading in readings]) for name in COLUMNS}
    table["force"] = np.stack([reading.force for reading in readings])
    table["deepest"] = max(readings, key=lambda reading: reading.max_depth_mm).depth
    file = Path(out) / (Path(recording).stem + ".npz")
    np.savez(file, allow_pickle=False, **table)
    return str(file)


def main() -> None:
    """Distributes the recordings."""
    parser = argparse.ArgumentParser()
    parser.add_argument("recordings", nargs="+")
    parser.add_argument("--profile")
    parser.add_argument("--out", required=True)
    parser.add_argument("--ray", action="store_true")
    parser.add_argument("--workers", type=int)
    options = parser.parse_args()
    Path(options.out).mkdir(parents=True, exist_ok=True)

    work = functools.partial(features, profile=options.profile, out=options.out)
    pool: Any
    if options.ray:
        from ray.util.multiprocessing import Pool as RayPool  # noqa: PLC0415

        pool = RayPool(options.workers)
    else:
        # The library's threads do not survive a fork.
        pool = multiprocessing.get_context("spawn").Pool(options.workers)
    with pool:
        for file in pool.imap_unordered(work, options.recordings):
            print(file)


if __name__ == "__main__":
    main()
