"""Sends the numbers of a running `fingervision live` to Rerun, as they come.

    pip install rerun-sdk websockets
    python rerun_live.py ws://127.0.0.1:8090/ws
"""

import json
import sys

import rerun as rr
from websockets.sync.client import connect

rr.init("fingervision", spawn=True)
with connect(sys.argv[1]) as page:
    for message in page:
        readings = json.loads(message).get("readings", []) if isinstance(message, str) else []
        for reading in readings:
            rr.set_time("captured", duration=reading["captured_s"])
            for name in ("depth_mm", "force_n", "torque_nmm", "sharpness"):
                if reading[name] is not None:
                    rr.log(f"sensor{reading['sensor']}/{name}", rr.Scalars(reading[name]))
