"""How accurate is it? A simulated press is tracked and compared with its exact truth.

    python evaluate_simulation.py circle --draft
"""

import argparse

import numpy as np

import fingervision


def main() -> None:
    """Prints the errors of every frame."""
    parser = argparse.ArgumentParser()
    parser.add_argument("scene", choices=sorted(fingervision.scenes()))
    parser.add_argument("--draft", action="store_true", help="a coarse mesh: seconds instead of minutes")
    options = parser.parse_args()

    press = fingervision.simulate(options.scene, draft=options.draft)
    tracker = fingervision.Tracker(press.profile, channels="rgb")
    print("frame  flow, px  depth, mm  force, N  true force, N")
    for number in range(len(press)):
        truth = press[number]
        reading = tracker.track(truth.image)
        flow_error = np.linalg.norm(reading.flow - truth.flow, axis=2)[reading.valid & truth.visible]
        depth_error = np.abs(reading.depth - truth.depth)[reading.depth_valid & truth.visible]
        means = f"{np.nanmean(flow_error):8.4f}  {np.nanmean(depth_error):9.4f}"
        print(f"{number:5}  {means}  {reading.force[2]:8.3f}  {truth.force[2]:13.3f}")


if __name__ == "__main__":
    main()
