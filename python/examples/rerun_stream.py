"""How do I see it in Rerun? `pip install rerun-sdk`, then `python rerun_stream.py camera --profile sensor.toml`."""

import argparse

import rerun as rr

import fingervision

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("source")
parser.add_argument("--profile")
parser.add_argument("--save", help="write a file instead of opening the viewer")
options = parser.parse_args()

rr.init("fingervision", spawn=options.save is None)
if options.save:
    rr.save(options.save)
with fingervision.open(options.source, options.profile) as readings:
    for reading in readings:
        rr.set_time("capture_time", duration=reading.capture_time_s)
        rr.log("camera", rr.Image(reading.image))
        rr.log("depth", rr.DepthImage(reading.depth.clip(0.0), meter=1000.0))
        rr.log("force", rr.Scalars(reading.force))
