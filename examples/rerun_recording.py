"""Shows a recording in Rerun: pictures, the surface as points, the force over time.

    pip install rerun-sdk
    python rerun_recording.py press.mcap
"""

import sys

import rerun as rr

rr.init("fingervision", spawn=True)
rr.log_file_from_path(sys.argv[1])
