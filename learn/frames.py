"""What a camera measures of a surface with known displacement, as input of the network."""

import torch
from torch.nn import functional

from network import CELLS

SIZE_MM = 30.0  # side of the gel that all others are scaled to
NOISE_MM = 0.0006  # of a cell's mean flow, seen from 25 mm
WAVY_NOISE_MM = 0.0045  # before it is smoothed over two cells
EXTRA_NOISE_MM = 0.0003  # on top of what was tracked


def smoothed(planes, sigma):
    """`[batch, channel, row, column]` after a Gaussian of this width in cells, one for each of the batch."""
    reach = torch.arange(-4, 5.0)
    taps = torch.exp(-0.5 * (reach[None] / sigma[:, None].clamp(min=0.05)) ** 2)
    taps = taps / taps.sum(1, keepdim=True)
    batch, channels, rows, columns = planes.shape
    planes = functional.pad(planes, (4, 4, 4, 4), mode="replicate").reshape(1, batch * channels, rows + 8, columns + 8)
    taps = taps.repeat_interleave(channels, 0)
    planes = functional.conv2d(planes, taps[:, None, :, None], groups=batch * channels)
    planes = functional.conv2d(planes, taps[:, None, None, :], groups=batch * channels)
    return planes.reshape(batch, channels, rows, columns)


def seen(displacement, distance_mm, centre_mm):
    """Apparent displacement and slope of the ray, for a camera at a place over the gel: `[batch, 4, row, column]`."""
    along = (((torch.arange(CELLS) + 0.5) / CELLS - 0.5) * SIZE_MM)[None]
    x, y = along[:, None, :].expand(1, CELLS, -1), along[:, :, None].expand(1, -1, CELLS)
    per_height = 1 / (distance_mm[:, None, None] - displacement[:, 2])
    slope_x = (x + displacement[:, 0] - centre_mm[:, 0, None, None]) * per_height
    slope_y = (y + displacement[:, 1] - centre_mm[:, 1, None, None]) * per_height
    depth = displacement[:, 2]
    return torch.stack([displacement[:, 0] + slope_x * depth, displacement[:, 1] + slope_y * depth, slope_x, slope_y], 1)


def packed(planes, thickness_mm, poissons_ratio):
    """The network's inputs, scaled to about one."""
    x, y, slope_x, slope_y = planes.unbind(1)
    divergence = (torch.gradient(x, dim=2)[0] + torch.gradient(y, dim=1)[0]) / (SIZE_MM / CELLS)
    cells = torch.stack([2 * x, 2 * y, slope_x, slope_y, 3 * divergence], 1)
    return cells, torch.stack([(poissons_ratio - 0.42) * 8, (thickness_mm - 10) / 3], 1)


def mirrored(displacement, contact, way):
    """One of the eight mirrors and quarter turns of a square."""
    if way & 1:
        displacement, contact = displacement.flip(-1) * torch.tensor([-1, 1, 1.0])[:, None, None], contact.flip(-1)
    if way & 2:
        displacement, contact = displacement.flip(-2) * torch.tensor([1, -1, 1.0])[:, None, None], contact.flip(-2)
    if way & 4:
        displacement, contact = displacement.transpose(-1, -2)[[1, 0, 2]], contact.transpose(-1, -2)
    return displacement, contact


def mirrored_seen(planes, way):
    """The same for the measurements of a camera: apparent displacement and slope."""
    if way & 1:
        planes = planes.flip(-1) * torch.tensor([-1, 1, -1, 1.0])[:, None, None]
    if way & 2:
        planes = planes.flip(-2) * torch.tensor([1, -1, 1, -1.0])[:, None, None]
    if way & 4:
        planes = planes.transpose(-1, -2)[[1, 0, 3, 2]]
    return planes


def inputs_of(planes, noise, gel):
    """Inputs with noise on the apparent displacement, of a gel as a profile may have it. `gel`: thickness, ν."""
    planes = torch.cat([planes[:, :2] + noise, planes[:, 2:]], 1)
    thickness_mm, poissons_ratio = gel.unbind(1)
    thickness_mm = thickness_mm * (1 + 0.025 * torch.randn(len(gel)))
    return packed(planes, thickness_mm, poissons_ratio + 0.008 * torch.randn(len(gel)))


def tracked(planes, gel):
    """Inputs from tracked frames, with a little noise so that no two frames are identical."""
    return inputs_of(planes, EXTRA_NOISE_MM * torch.randn(len(planes), 2, CELLS, CELLS), gel)


def drawn(displacement, gel):
    """Inputs under cameras drawn at random, blurred and noisy as tracked flow is. `gel`: thickness, ν."""
    batch = len(displacement)
    is_default = torch.rand(batch) < 0.5
    distance_mm = torch.where(is_default, 25.0, 14 + 24 * torch.rand(batch))
    centre_mm = torch.where(is_default[:, None], torch.tensor(0.0), 3 * torch.rand(batch, 2) - 1.5)
    planes = smoothed(seen(displacement, distance_mm, centre_mm), 0.1 + torch.rand(batch))
    wavy = smoothed(torch.randn(batch, 2, CELLS, CELLS), torch.full((batch,), 2.0)) * torch.rand(batch, 1, 1, 1)
    noise = NOISE_MM * torch.randn(batch, 2, CELLS, CELLS) + WAVY_NOISE_MM * wavy
    return inputs_of(planes, noise * (distance_mm / 25)[:, None, None, None], gel)
