"""The network: a U of three resolutions over the cells of the gel's surface."""

import torch
from torch import nn
from torch.nn import functional

CELLS = 120
INPUTS = 5  # apparent displacement (x, y), slope of the ray (x, y), divergence
CONSTANTS = 2  # Poisson's ratio, thickness
MESHES = {"draft": 2.0, "medium": 0.0, "fine": -1.0}  # how coarse the simulator's mesh is, in steps of 0.15 mm
OUTPUTS = 3  # depth, contact, error of the depth
LAYERS = ("enter0", "enter1", "down0", "down1", "deep0", "deep1", "deep2", "whole",
          "lift0", "up0", "up1", "lift1", "leave0", "leave1", "output")


class ContactNetwork(nn.Module):
    """Depth in mm, the logarithm of the odds of contact and that of the error expected of the depth: `[batch, 3, cells, cells]`, for
    presses solved on meshes of this coarseness (`MESHES`)."""

    def __init__(self, channels=(16, 32, 64)):
        super().__init__()
        fine, middle, coarse = channels

        def layer(inputs, outputs, side=3, stride=1):
            return nn.Conv2d(inputs, outputs, side, stride, side // 2)

        self.enter0, self.enter1 = layer(4 * INPUTS + CONSTANTS, fine), layer(fine, fine)
        self.down0, self.down1 = layer(fine, middle, stride=2), layer(middle, middle)
        self.deep0 = layer(middle, coarse, stride=2)
        self.deep1, self.deep2 = layer(coarse, coarse), layer(coarse, coarse)
        # Every cell gets the mean over the whole gel: how much of it moved, and how far.
        self.whole = layer(coarse, coarse, side=1)
        nn.init.zeros_(self.whole.weight)
        nn.init.zeros_(self.whole.bias)
        # What comes up is brought to the channels of its place before it grows: a third of the work of a 3 by 3 layer over both.
        self.lift0, self.up0, self.up1 = layer(coarse, middle, side=1), layer(middle, middle), layer(middle, middle)
        self.lift1, self.leave0, self.leave1 = layer(middle, fine, side=1), layer(fine, fine), layer(fine, fine)
        self.output = layer(fine, 4 * OUTPUTS, side=1)
        # On a coarse mesh the same motion gives a different press: this term is the difference.
        self.mesh = nn.Parameter(torch.zeros(fine))

    def forward(self, cells, constants, coarseness):
        relu, grow = functional.relu, lambda x: functional.interpolate(x, scale_factor=2, mode="nearest")
        x = functional.pixel_unshuffle(cells, 2)
        x = torch.cat([x, constants[:, :, None, None].expand(-1, -1, *x.shape[2:])], 1)
        fine = relu(self.enter0(x) + (coarseness[:, None] * self.mesh)[:, :, None, None])
        fine = relu(self.enter1(fine)) + fine
        middle = relu(self.down0(fine))
        middle = relu(self.down1(middle)) + middle
        x = relu(self.deep0(middle))
        x = relu(self.deep1(x)) + x
        x = relu(self.deep2(x)) + x
        x = relu(x + self.whole(x.mean((2, 3), keepdim=True)))
        x = relu(self.up0(middle) + grow(self.lift0(x)))
        x = relu(self.up1(x)) + x
        x = relu(self.leave0(fine) + grow(self.lift1(x)))
        x = relu(self.leave1(x)) + x
        return functional.pixel_shuffle(self.output(x), 2)
