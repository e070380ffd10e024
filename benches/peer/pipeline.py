"""The pipeline that users have today: dense flow, density, guided filter and depth line on OpenCV.

Optical flow is OpenCV's dense inverse search, preset MEDIUM or FAST, from the first frame to the current one, each frame on
its own. The density is a sum of Gaussians, one for each moved pixel: a cubic B-spline splat, then a separable Gaussian that
makes up the rest of the variance. The filter is He & Sun, "Fast Guided Filter", arXiv 1505.00996, 2015, self-guided.

Buffers that outlive a frame are made once; the splat, which neither NumPy nor OpenCV has, is compiled by Numba.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numba
import numpy as np
from cv2.typing import MatLike as Image

SPLINE_VARIANCE = 1.0 / 3.0
"""Variance of the cubic B-spline, px²."""

CUT_SIGMAS = 4.0
"""Where the Gaussian ends, in standard deviations; points this far outside the image still count."""


@dataclass(frozen=True)
class Params:
    """What the pipeline can be told."""

    preset: str = "medium"
    """Preset of the flow, one of `PRESETS`."""
    sigma_px: float = 2.0
    """Standard deviation of a point's Gaussian, px."""
    radius_px: int = 8
    """Reach of the guided filter's window, px of the full-size image."""
    epsilon: float = 1e-4
    """Penalty on the guided filter's slope, dimensionless: its root is the contrast that counts as an edge."""
    subsample: int = 4
    """Side of the cells on which the guided filter is fitted, px."""
    slope_mm: float = 15.2
    """Depth per unit of the feature `1 - density`, mm."""
    intercept_mm: float = 0.0
    """Depth at rest, mm."""


PRESETS = {"medium": cv2.DISOPTICAL_FLOW_PRESET_MEDIUM, "fast": cv2.DISOPTICAL_FLOW_PRESET_FAST}
"""Presets of the dense inverse search by name."""


class Flow:
    """Dense inverse search from one reference, with one of `PRESETS`."""

    def __init__(self, reference: Image, preset: str) -> None:
        self._reference = reference
        self._search = cv2.DISOpticalFlow.create(PRESETS[preset])

    def estimate(self, current: Image) -> Image:
        """Displacement of every reference pixel, `[row][column][x, y]`, px."""
        flow: Image = self._search.calc(self._reference, current, None)  # type: ignore[call-overload] # None: no start
        return flow


@numba.njit(fastmath=True)
def _spline_weights(t: np.float32) -> tuple[np.float32, np.float32, np.float32, np.float32]:
    """Cubic B-spline at the four pixels around a point that lies `t` px beyond the second."""
    sixth, half, two_thirds = np.float32(1 / 6), np.float32(0.5), np.float32(2 / 3)
    s = np.float32(1) - t
    first = s * s * s * sixth
    second = two_thirds - t * t * (np.float32(1) - half * t)
    third = two_thirds - s * s * (np.float32(1) - half * s)
    fourth = t * t * t * sixth
    return first, second, third, fourth


@numba.njit(fastmath=True)
def _splat(flow: Image, margin: int, density: Image) -> None:
    """Adds a cubic B-spline for each moved pixel to `density`, which begins `margin` px before the image."""
    height, width = density.shape
    density[:] = 0
    for row in range(flow.shape[0]):
        for column in range(flow.shape[1]):
            x = np.float32(column + margin) + flow[row, column, 0]
            y = np.float32(row + margin) + flow[row, column, 1]
            if not (x >= 1 and y >= 1 and x < width - 2 and y < height - 2):
                continue
            left, top = np.uint32(x), np.uint32(y)
            across = _spline_weights(x - np.float32(left))
            down = _spline_weights(y - np.float32(top))
            for j in range(4):
                for i in range(4):
                    density[top - 1 + j, left - 1 + i] += down[j] * across[i]


class Density:
    """Sum of Gaussians at the moved pixels, one where the surface is at rest."""

    def __init__(self, height: int, width: int, sigma_px: float) -> None:
        rest_sigma = float(np.sqrt(sigma_px**2 - SPLINE_VARIANCE))
        reach = int(np.ceil(CUT_SIGMAS * rest_sigma))
        self._kernel = cv2.getGaussianKernel(2 * reach + 1, rest_sigma, cv2.CV_32F)
        self._margin = reach + 2
        self._splatted = np.empty((height + 2 * self._margin, width + 2 * self._margin), np.float32)
        self._smoothed = np.empty_like(self._splatted)
        self._inverse_at_rest: Image = 1 / self._sum(np.zeros((height, width, 2), np.float32))

    def feature(self, flow: Image) -> Image:
        """The feature `1 - density` at each pixel of the current image, dimensionless."""
        feature = cv2.multiply(self._sum(flow), self._inverse_at_rest)
        return np.subtract(1, feature, out=feature)

    def _sum(self, flow: Image) -> Image:
        """The density, not normalised: it falls to a half at the border and to a quarter in the corners."""
        _splat(flow, self._margin, self._splatted)
        cv2.sepFilter2D(
            self._splatted, cv2.CV_32F, self._kernel, self._kernel, dst=self._smoothed, borderType=cv2.BORDER_CONSTANT
        )
        margin = self._margin
        return self._smoothed[margin:-margin, margin:-margin]


class GuidedFilter:
    """The fast guided filter, guided by its own input."""

    def __init__(self, height: int, width: int, params: Params) -> None:
        self._size = (width, height)
        self._cells = (-(-width // params.subsample), -(-height // params.subsample))
        side = 2 * round(params.radius_px / params.subsample) + 1
        self._window = (side, side)
        self._epsilon = params.epsilon

    def filter(self, image: Image) -> Image:
        """The line `a * image + b` that the windows around each pixel agree on."""
        cells = cv2.resize(image, self._cells, interpolation=cv2.INTER_AREA)
        mean = self._mean(cells)
        variance = self._mean(cells * cells) - mean * mean
        slope = variance / (variance + self._epsilon)
        offset = mean - slope * mean
        filtered = cv2.multiply(image, self._enlarged(self._mean(slope)))
        return cv2.add(filtered, self._enlarged(self._mean(offset)), dst=filtered)

    def _mean(self, cells: Image) -> Image:
        """Mean over the window around each cell."""
        return cv2.boxFilter(cells, cv2.CV_32F, self._window)

    def _enlarged(self, cells: Image) -> Image:
        """The cells at full size, linear between their centres."""
        return cv2.resize(cells, self._size, interpolation=cv2.INTER_LINEAR)


@dataclass(frozen=True)
class DepthLine:
    """The fitted line from the filtered feature to depth."""

    slope_mm: float
    intercept_mm: float

    def depth(self, feature: Image) -> Image:
        """Depth at each pixel, mm, positive pressed in."""
        depth = feature * np.float32(self.slope_mm)
        depth += np.float32(self.intercept_mm)
        return depth
