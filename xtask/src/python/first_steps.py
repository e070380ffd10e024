"""Loads the extension module and measures a displacement that is known. Prints the processor and the median error, px."""

import platform

import numpy as np

import fingervision

noise = np.random.default_rng(1).random((200, 260), dtype=np.float32)
smooth = sum(np.roll(noise, (row, column), (0, 1)) for row in range(4) for column in range(4))
texture = ((smooth - smooth.min()) / np.ptp(smooth) * 255).astype(np.uint8)
before, after = texture[10:170, 10:210], texture[10:170, 8:208]
error = fingervision.FlowEstimator(before).estimate(after).flow - np.float32([2, 0])
median = float(np.median(np.linalg.norm(error, axis=2)))
assert median < 0.05, f"the flow is wrong by {median} px"
print(f"{platform.machine()}, Python {platform.python_version()}: flow to {median:.4f} px")
