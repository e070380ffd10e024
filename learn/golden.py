"""Writes what PyTorch computes with the exported weights, for the test of the sensor's own forward pass.

`python golden.py contact.bin golden.bin`: the input is seeded noise, partly smooth, so that all layers are active; the
forward pass is in double precision. The file, all little-endian: columns and rows as u32, then f32: the constants, the
inputs `[channel][row][column]` and the outputs `[channel][row][column]`.
"""

import struct
import sys

import numpy
import torch
from torch.nn import functional

from network import CONSTANTS, INPUTS, LAYERS, ContactNetwork

COLUMNS, ROWS = 56, 48  # unequal, so that exchanged axes show
SEED = 20


def load(file):
    """The network of an exported file."""
    data = open(file, "rb").read()
    network = ContactNetwork(struct.unpack_from("<3I", data))
    values, taken = torch.from_numpy(numpy.frombuffer(data, "<f4", offset=12).copy()), 0
    with torch.no_grad():
        for name in LAYERS:
            for part in ("weight", "bias"):
                target = getattr(getattr(network, name), part)
                target.copy_(values[taken : taken + target.numel()].view_as(target))
                taken += target.numel()
    assert taken == len(values), f"{file} holds {len(values)} numbers, the network {taken}"
    return network.double().eval()


def inputs():
    """Seeded values of the size that a press has: `[1, channel, row, column]`."""
    draw = torch.Generator().manual_seed(SEED)
    coarse = torch.randn(1, INPUTS, ROWS // 8, COLUMNS // 8, generator=draw)
    smooth = functional.interpolate(coarse, size=(ROWS, COLUMNS), mode="bicubic", align_corners=False)
    return 0.5 * smooth + 0.05 * torch.randn(1, INPUTS, ROWS, COLUMNS, generator=draw)


def main(weights, target):
    cells, constants = inputs(), torch.tensor([[0.24, -0.5]])
    assert constants.shape[1] == CONSTANTS
    with torch.no_grad():
        # The exported biases hold the mesh already.
        outputs = load(weights)(cells.double(), constants.double(), torch.zeros(1, dtype=torch.float64))
    with open(target, "wb") as file:
        file.write(struct.pack("<2I", COLUMNS, ROWS))
        for part in (constants, cells, outputs):
            file.write(part[0].contiguous().numpy().astype("<f4").tobytes())


if __name__ == "__main__":
    main(*sys.argv[1:])
