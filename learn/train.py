"""Fits the network to solved presses."""

import argparse
import pathlib
import time

import numpy
import torch
from torch.nn import functional

from frames import SIZE_MM, drawn, mirrored
from network import ContactNetwork

BATCH = 8
DRAFT_SHARE = 0.25  # of the frames of a batch, on the draft mesh
FINE_COPIES = 3  # of a frame on the fine mesh, for one on the medium mesh


def load(folder):
    """Frames to train on, those on the draft mesh and those on finer ones, and frames to judge by: displacement, contact,
    gel."""
    draft, finer, judge = [], [], []
    for file in sorted(pathlib.Path(folder).glob("*.npz")):
        press = numpy.load(file)
        scale = SIZE_MM / float(press["size"])  # elasticity knows no scale
        gel = torch.tensor([scale * float(press["h"]), float(press["nu"])])
        frames = judge if int(file.stem) % 20 == 7 else draft if press["mesh"] == "draft" else finer
        copies = FINE_COPIES if press["mesh"] == "fine" and frames is finer else 1
        for displacement, contact in copies * list(zip(press["disp"], press["contact"])):
            frames.append((torch.from_numpy(scale * displacement.transpose(2, 0, 1)), torch.from_numpy(contact), gel))
    return draft, finer, judge


def cost(told, depth, contact):
    """Absolute error of depth, rounded at 0.01 mm, most of all in contact and at its border; cross entropy of contact; and
    how well the error is foretold, as that of a Laplace distribution, which the depth does not heed."""
    error = told[:, 0] - depth
    border = (contact > 0.02) & (contact < 0.98)
    weight = 0.35 + 4 * (contact > 0.02) + 3 * border
    absolute = (weight * ((error * error + 1e-4).sqrt() - 0.01)).mean()
    surprise = (error.detach().abs() * torch.exp(-told[:, 2]) + told[:, 2]).mean()
    return absolute + 0.1 * functional.binary_cross_entropy_with_logits(told[:, 1], contact) + 0.002 * surprise


def judged(network, frames):
    """Mean error of depth over the image and in contact, mm, the overlap of contact, and the mean error over the mean of
    what is foretold."""
    errors, told_errors, inner, overlaps = 0.0, 0.0, [], []
    with torch.random.fork_rng(), torch.no_grad():
        torch.manual_seed(0)
        for displacement, contact, gel in frames:
            told = network(*drawn(displacement[None], gel[None]))[0]
            error, is_in, is_told = (told[0] - displacement[2]).abs(), contact > 127, told[1] > 0
            errors += error.mean().item() / len(frames)
            told_errors += told[2].exp().mean().item() / len(frames)
            if is_in.any():
                inner.append(error[is_in].mean().item())
                overlaps.append(((is_in & is_told).sum() / (is_in | is_told).sum()).item())
    return errors, numpy.mean(inner), numpy.mean(overlaps), errors / told_errors


def draw_one(draw, frames):
    return frames[draw.integers(0, len(frames))]


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("presses")
    arguments.add_argument("--out", required=True)
    arguments.add_argument("--minutes", type=float, default=60)
    arguments.add_argument("--rate", type=float, default=2e-3)
    arguments.add_argument("--start", help="weights to begin with")
    arguments = arguments.parse_args()
    draft, finer, judge = load(arguments.presses)
    share = DRAFT_SHARE if finer else 1
    network = ContactNetwork().to(memory_format=torch.channels_last)
    if arguments.start:
        network.load_state_dict(torch.load(arguments.start))
    optimizer = torch.optim.AdamW(network.parameters(), arguments.rate, weight_decay=1e-2)
    draw, begin, step = numpy.random.default_rng(), time.time(), 0
    while (part := (time.time() - begin) / (60 * arguments.minutes)) < 1:
        step += 1
        warm = min(1, step / 200)
        for group in optimizer.param_groups:
            group["lr"] = arguments.rate * warm * (0.01 + 0.5 * (1 + numpy.cos(numpy.pi * part)))
        frames = [draw_one(draw, draft if draw.random() < share else finer) for _ in range(BATCH)]
        ways = draw.integers(0, 8, BATCH)
        turned = [mirrored(d, c.float() / 255, int(way)) for (d, c, _), way in zip(frames, ways)]
        displacement, contact = (torch.stack(part) for part in zip(*turned))
        cells, constants = drawn(displacement, torch.stack([gel for _, _, gel in frames]))
        told = network(cells.contiguous(memory_format=torch.channels_last), constants)
        loss = cost(told, displacement[:, 2], contact)
        optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        optimizer.step()
        if step % 500 == 0:
            print(f"step {step}: loss {loss.item():.4f}, unseen presses: depth %.4f mm, in contact %.3f mm, overlap %.3f, error over foretold %.2f"
                  % judged(network, judge), flush=True)
            torch.save(network.state_dict(), arguments.out)
    torch.save(network.state_dict(), arguments.out)


if __name__ == "__main__":
    main()
