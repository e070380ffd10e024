"""A depth map of a simulated press. `pip install fingervision matplotlib`"""

import matplotlib.pyplot as plt

import fingervision

with fingervision.open("sim:letter?draft") as readings:
    deepest = max(readings, key=lambda reading: reading.max_depth_mm)
plt.imshow(deepest.depth)
plt.colorbar(label="depth, mm")
plt.savefig("depth.png")
