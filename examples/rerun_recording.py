"""Shows a recording in Rerun: pictures, the surface as points, and the force over time.

    pip install rerun-sdk
    python rerun_recording.py press.mcap               # opens the viewer
    python rerun_recording.py press.mcap press.rrd     # writes a file that `rerun press.rrd` opens
"""

import sys

import rerun as rr
from rerun.chunk import McapReader

READING = "fingervision.Reading:message"

recording, *saved = sys.argv[1:]
rr.init("fingervision", spawn=not saved)
if saved:
    rr.save(saved[0])
rr.log_file_from_path(recording)
for chunk in McapReader(recording, include_topic_regex=["/reading$"]).stream():
    batch = chunk.to_record_batch()
    if READING not in batch.schema.names:
        continue
    for time, rows in zip(batch["message_log_time"].to_numpy(), batch[READING].to_pylist()):
        rr.set_time("message_log_time", timestamp=time)
        if (force := rows[0].get("force_z_n")) is not None:
            rr.log(f"{chunk.entity_path}/force_z_n", rr.Scalars(force))
