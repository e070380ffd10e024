"""Writes trained weights in the order in which the sensor reads them.

The network takes the mesh size as an input in training only; for the sensor it is set to that of the medium mesh, which
has the smallest error on unseen presses. Three numbers of channels as little-endian u32, then for each layer its weights
`[output][input][row][column]` and its biases, f32.
"""

import struct
import sys

import torch

from network import LAYERS, MESHES


def main(source, target):
    weights = torch.load(source, map_location="cpu")
    weights["enter0.bias"] += MESHES["medium"] * weights["mesh"]
    with open(target, "wb") as file:
        file.write(struct.pack("<3I", *(len(weights[f"{name}.bias"]) for name in ("enter0", "down0", "deep0"))))
        for name in LAYERS:
            for part in ("weight", "bias"):
                file.write(weights[f"{name}.{part}"].contiguous().numpy().astype("<f4").tobytes())


if __name__ == "__main__":
    main(*sys.argv[1:])
