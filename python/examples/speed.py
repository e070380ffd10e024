"""How fast is a tracker in Python, and do several of them use all processors?

    python speed.py                                      # a simulated press, a small mesh
    python speed.py --recording press.mcap --profile sensor.toml --rounds 20

Prints what a call takes beyond the tracking itself, and the rate of four trackers in one thread after another and in threads
side by side. The preparation of a tracker uses all processors in either case, so it is not part of the rates.
"""

from __future__ import annotations

import argparse
import os
import statistics
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

import fingervision

TRACKERS = 4


class Sensor:
    """A tracker and the images that it tracks again and again."""

    def __init__(self, images: list[NDArray[Any]], profile: fingervision.Profile) -> None:
        """Makes the tracker with the first image as reference."""
        self.images = images
        channels = "rgb" if images[0].ndim == 3 else None
        self.tracker = fingervision.Tracker(profile, channels=channels)
        self.tracker.track(images[0])

    def track(self, rounds: int) -> list[float]:
        """Tracks the images forward and backward; returns what the calls took beyond the tracking itself, ms."""
        overheads: list[float] = []
        for image in rounds * (self.images + self.images[::-1]):
            begin = time.perf_counter()
            reading = self.tracker.track(image)
            overheads.append(1e3 * (time.perf_counter() - begin) - reading.latency_ms)
        return overheads


def rate(sensors: list[Sensor], threads: int, rounds: int) -> float:
    """Frames per second of all sensors together."""
    frames = len(sensors) * rounds * 2 * len(sensors[0].images)
    with ThreadPoolExecutor(threads) as pool:
        begin = time.perf_counter()
        for work in [pool.submit(sensor.track, rounds) for sensor in sensors]:
            work.result()
    return frames / (time.perf_counter() - begin)


def main() -> None:
    """Measures overhead and rates."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--recording", default="sim:letter?draft")
    parser.add_argument("--profile")
    parser.add_argument("--rounds", type=int, default=2)
    options = parser.parse_args()

    with fingervision.open(options.recording, options.profile) as readings:
        profile = readings.profile
        images = [np.array(reading.image) for reading in readings]
    sensors = [Sensor(images, profile) for _ in range(TRACKERS)]
    overheads = sensors[0].track(options.rounds)
    height, width = images[0].shape[:2]
    print(f"{width}x{height}, a call takes {statistics.median(overheads):.2f} ms more than the tracking")
    one = rate(sensors, 1, options.rounds)
    print(f"one thread: {one:.1f} frames/s")
    for threads in (2, TRACKERS):
        side_by_side = rate(sensors, threads, options.rounds)
        print(f"{threads} threads on {os.cpu_count()} processors: {side_by_side:.1f} frames/s, {side_by_side / one:.2f} times")


if __name__ == "__main__":
    main()
