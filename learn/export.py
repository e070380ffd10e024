"""Writes trained weights in the order in which the sensor reads them.

Several files of weights, that trainings from one start led to, become their mean. Three numbers of channels as little-endian
u32, then for each layer its weights `[output][input][row][column]` and its biases, f32.
"""

import struct
import sys

import torch

from network import LAYERS


def main(*sources, target):
    trained = [torch.load(source, map_location="cpu") for source in sources]
    weights = {name: sum(each[name] for each in trained) / len(trained) for name in trained[0]}
    with open(target, "wb") as file:
        file.write(struct.pack("<3I", *(len(weights[f"{name}.bias"]) for name in ("enter0", "down0", "deep0"))))
        for name in LAYERS:
            for part in ("weight", "bias"):
                file.write(weights[f"{name}.{part}"].contiguous().numpy().astype("<f4").tobytes())


if __name__ == "__main__":
    main(*sys.argv[1:-1], target=sys.argv[-1])
