"""How do I analyse a recording? Force and area over time, and depth where it is largest, with Matplotlib.

    python plot_press.py press.mp4 --profile sensor.toml --out press.png
"""

from __future__ import annotations

import argparse

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt

import fingervision


def main() -> None:
    """Tracks the recording and draws it."""
    parser = argparse.ArgumentParser()
    parser.add_argument("source")
    parser.add_argument("--profile")
    parser.add_argument("--out", default="press.png")
    options = parser.parse_args()

    times: list[float] = []
    areas: list[float] = []
    forces: list[npt.NDArray[np.float32]] = []
    deepest: fingervision.Reading | None = None
    with fingervision.open(options.source, options.profile) as readings:
        for reading in readings:
            if "lost" in reading.flags:
                continue
            times.append(reading.capture_time_s)
            forces.append(reading.force)
            areas.append(reading.contact_area_mm2)
            if deepest is None or reading.max_depth_mm > deepest.max_depth_mm:
                deepest = reading
    if deepest is None:
        raise SystemExit(f"the gel is lost in every frame of {options.source}")

    figure, (over_time, map_of_depth) = plt.subplots(1, 2, figsize=(11, 4), layout="constrained")
    over_time.plot(times, np.stack(forces), label=["x", "y", "z"])
    over_time.set(xlabel="time, s", ylabel="force, N")
    over_time.twinx().plot(times, areas, "k:", label="area")
    over_time.legend()
    # Depth is 0 where it is not valid: those pixels are left white.
    depth = np.where(deepest.depth_valid, deepest.depth, np.nan)
    drawn = map_of_depth.imshow(depth)
    map_of_depth.contour(deepest.contact, [0.5], colors="w")
    map_of_depth.set_title(f"frame {deepest.sequence}")
    figure.colorbar(drawn, label="depth, mm")
    figure.savefig(options.out)


if __name__ == "__main__":
    main()
