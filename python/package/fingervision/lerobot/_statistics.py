"""Statistics of a feature, as LeRobot keeps them to normalise it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

_QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}
_SAMPLES_PER_FRAME = 512


class Statistics:
    """Of the finite values of a feature: of each channel of a field or an image, of each component of a vector.

    Quantiles are those of at most 512 values of a channel per frame. Pixels of images are scaled to 0 to 1. A channel
    without a finite value has zeros.
    """

    def __init__(self, shape: tuple[int, ...], *, is_image: bool) -> None:
        """Prepares for values of a shape: `(n,)`, `(H, W)` or `(H, W, C)`."""
        self._channels = shape[-1] if len(shape) != 2 else 1
        self._shape = (self._channels, 1, 1) if is_image else (1,) * (len(shape) - 1) + (self._channels,)
        self._scale = 1 / 255 if is_image else 1.0
        self._frames = 0
        self._counts = np.zeros(self._channels)
        self._sums = np.zeros((2, self._channels))
        self._limits = np.full((2, self._channels), [[np.inf], [-np.inf]])
        self._samples: list[npt.NDArray[np.float32]] = []

    def add(self, values: npt.NDArray[Any]) -> None:
        """Adds a frame."""
        rows = np.asarray(values, np.float64).reshape(-1, self._channels) * self._scale
        finite = np.isfinite(rows)
        known = np.where(finite, rows, 0.0)
        self._frames += 1
        self._counts += finite.sum(axis=0)
        self._sums += [known.sum(axis=0), (known * known).sum(axis=0)]
        self._limits[0] = np.minimum(self._limits[0], np.where(finite, rows, np.inf).min(axis=0))
        self._limits[1] = np.maximum(self._limits[1], np.where(finite, rows, -np.inf).max(axis=0))
        step = -(-len(rows) // _SAMPLES_PER_FRAME)
        self._samples.append(np.where(finite, rows, np.nan)[::step].astype(np.float32))

    def result(self) -> dict[str, Any]:
        """The statistics as nested lists; ``count`` is the number of frames."""
        counts = np.maximum(self._counts, 1)
        mean = self._sums[0] / counts
        deviation = np.sqrt(np.maximum(self._sums[1] / counts - mean * mean, 0.0))
        limits = np.where(self._counts > 0, self._limits, 0.0)
        found = {"min": limits[0], "max": limits[1], "mean": mean, "std": deviation}
        samples = np.concatenate(self._samples)
        columns = [column[np.isfinite(column)] for column in samples.T]
        for name, part in _QUANTILES.items():
            found[name] = np.array([_quantile(column, part) for column in columns])
        return {name: value.reshape(self._shape).tolist() for name, value in found.items()} | {"count": [self._frames]}


def _quantile(values: npt.NDArray[np.float32], part: float) -> float:
    """The quantile of some values; 0 without values."""
    return float(np.quantile(values, part)) if len(values) else 0.0
