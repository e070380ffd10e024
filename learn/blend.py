"""Writes the weighted mean of two exported networks: `python blend.py old.bin new.bin 0.7 blended.bin`, here 0.7 of the new one.

Weights that were trained further are better on presses like the new ones and often worse on others. Their mean with the weights
from which that training started keeps most of both [Wortsman2022].
"""

import sys

import numpy

HEADER = 12  # bytes: three numbers of channels


def main(old, new, share, target):
    old, new = (open(file, "rb").read() for file in (old, new))
    assert old[:HEADER] == new[:HEADER] and len(old) == len(new), "two networks of the same layers"
    before, after = (numpy.frombuffer(data, "<f4", offset=HEADER) for data in (old, new))
    with open(target, "wb") as file:
        file.write(old[:HEADER] + (before + float(share) * (after - before)).astype("<f4").tobytes())


if __name__ == "__main__":
    main(*sys.argv[1:])
