"""Sends the numbers of a running `fingervision live` to Rerun, as they come.

    pip install rerun-sdk websockets
    python rerun_live.py ws://127.0.0.1:8090/ws              # opens the viewer
    python rerun_live.py ws://127.0.0.1:8090/ws live.rrd     # writes a file that `rerun live.rrd` opens
"""

import json
import sys
from contextlib import suppress

import rerun as rr
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

address, *saved = sys.argv[1:]
rr.init("fingervision", spawn=not saved)
if saved:
    rr.save(saved[0])
# The program closes the connection when it ends.
with suppress(ConnectionClosed), connect(address) as page:
    for message in page:
        readings = json.loads(message).get("readings", []) if isinstance(message, str) else []
        for reading in readings:
            rr.set_time("captured", duration=reading["captured_s"])
            for name in ("depth_mm", "force_n", "torque_nmm", "sharpness"):
                if reading[name] is not None:
                    rr.log(f"sensor{reading['sensor']}/{name}", rr.Scalars(reading[name]))
