"""Fits the network to solved presses.

The seed fixes the first weights and all that is drawn. With `--steps` a run can be repeated bit by bit on the same machine and
version of PyTorch; with `--minutes` its length, and with it the rate of every step, depends on how fast the machine is.
"""

import argparse
import copy
import pathlib
import time
import tomllib

import numpy
import torch
from torch.nn import functional

import golden
from frames import SIZE_MM, drawn, mirrored, mirrored_seen, packed, tracked
from network import MESHES, ContactNetwork

BATCH = 8
MEAN_STEPS = 2000  # over which weights are averaged
LEAN = 2.0  # weight of the mean error in contact
SHARES = {"draft": 0.08, "medium": 0.52, "fine": 0.4}  # of the frames of a batch, by mesh
SHARES_WITHOUT_DRAG = {"draft": 0.3, "medium": 0.5, "fine": 0.2}  # the same with `--without-drag`
DEEP_MM = 1.5  # contact that is less deep on average counts more
MOST_SHALLOW = 2.5  # times as much at most
TRACKED_SHARE = 0.85  # of them as a tracker saw them; the others as any camera would, under formulas for blur and noise
JUDGED = "%s; unseen presses: depth %.4f mm, in contact %.3f mm (%+.1f %%), overlap %.3f, error over predicted %.2f"


def load(folder, without_drag):
    """Frames to train on, by mesh, and frames to judge by: displacement, contact, gel (thickness, ν, coarseness of its mesh), what
    cameras saw; of those where shear and twist were subtracted, what is left of both."""
    train, judge = {}, []
    for press in sorted(pathlib.Path(folder).glob("*/seen.npy")):
        about = tomllib.loads((press.parent / "press.toml").read_text())
        scale = SIZE_MM / about["gel"]["size_mm"][0]  # elasticity knows no scale
        gel = torch.tensor([scale * about["gel"]["thickness_mm"], about["gel"]["poissons_ratio"], MESHES[about["mesh"]]])
        names = ("displacement", "contact", "dragged" if without_drag else "seen")
        displacement, contact, seen = (numpy.load(press.parent / f"{name}.npy") for name in names)
        seen[:, :, :2] *= scale
        frames = judge if int(press.parent.name) % 20 == 7 else train.setdefault(about["mesh"], [])
        for frame in range(len(displacement)):
            moved, touched = scale * displacement[frame].transpose(2, 0, 1), torch.from_numpy(contact[frame])
            if not without_drag:
                frames.append((torch.from_numpy(moved), touched, gel, torch.from_numpy(seen[:, frame].copy())))
                continue
            for camera in seen[numpy.isfinite(seen[:, frame]).all((1, 2, 3)), frame]:
                left = moved.copy()
                left[2] -= scale * camera[4]
                frames.append((torch.from_numpy(left), touched, gel, torch.from_numpy(camera[None, :4].copy())))
    train = {mesh: frames for mesh, frames in train.items() if frames}
    if not train or not judge:
        raise SystemExit(f"{folder}: {len(judge)} frames to judge by, and to train on those of {len(train)} meshes; both are needed")
    return train, judge


def cost(estimated, depth, contact):
    """Absolute error of depth, rounded at 0.01 mm, weighted most in contact and at its border; the mean
    error in contact, which determines the error of the force; both with a larger weight where contact is shallow. Cross entropy of
    contact; and how well the error is predicted, as that of a Laplace distribution, without a gradient to the depth."""
    error = estimated[:, 0] - depth
    touched = (contact > 0.02).float()
    border = touched * (contact < 0.98)
    count = touched.sum((1, 2))
    mean_depth = (touched * depth).sum((1, 2)) / (count + 1)
    shallow = torch.where(count < 8, 1.0, (DEEP_MM / (mean_depth + 1e-3)).clamp(1, MOST_SHALLOW))
    weight = 0.7 + 4 * shallow.sqrt()[:, None, None] * touched + 3 * border
    absolute = (weight * ((error * error + 1e-4).sqrt() - 0.01)).mean()
    lean = LEAN * (shallow * ((touched + border) * error).mean((1, 2)).abs()).mean()
    surprise = (error.detach().abs() * torch.exp(-estimated[:, 2]) + estimated[:, 2]).mean()
    return absolute + lean + 0.1 * functional.binary_cross_entropy_with_logits(estimated[:, 1], contact) + 0.002 * surprise


def judged(network, frames):
    """Mean error of depth over the image and in contact, mm, the bias of depth in contact, the overlap of contact, and the mean
    error over the mean predicted error."""
    errors, predicted_errors, inner, biases, overlaps = [], [], [], [], []
    with torch.no_grad():
        for displacement, contact, gel, cameras in frames:
            for seen in cameras:
                estimated = network(*packed(seen[None], *gel[None, :2].unbind(1)), gel[2:])[0]
                error, is_in, is_estimated = estimated[0] - displacement[2], contact > 127, estimated[1] > 0
                errors.append(error.abs().mean().item())
                predicted_errors.append(estimated[2].exp().mean().item())
                if is_in.any():
                    inner.append(error[is_in].abs().mean().item())
                    biases.append((error[is_in].mean() / displacement[2][is_in].mean()).item())
                    overlaps.append(((is_in & is_estimated).sum() / (is_in | is_estimated).sum()).item())
    mean = numpy.mean
    return mean(errors), mean(inner), 100 * mean(biases), mean(overlaps), mean(errors) / mean(predicted_errors)


def batch(draw, train, shares, tracked_share):
    """Inputs, constants, coarseness of the mesh, depth and contact of frames drawn at random."""
    meshes = [mesh for mesh in shares if mesh in train]
    shares = numpy.array([shares[mesh] for mesh in meshes])
    parts = []
    for mesh in draw.choice(meshes, BATCH, p=shares / shares.sum()):
        displacement, contact, gel, cameras = train[mesh][draw.integers(0, len(train[mesh]))]
        way, seen = int(draw.integers(0, 8)), cameras[draw.integers(0, len(cameras))]
        parts.append((*mirrored(displacement, contact.float() / 255, way), gel, mirrored_seen(seen, way)))
    displacement, contact, gel, seen = (torch.stack(part) for part in zip(*parts))
    is_tracked = torch.rand(BATCH) < tracked_share
    inputs = tracked(seen, gel[:, :2])
    if tracked_share == 1:
        return *inputs, gel[:, 2], displacement[:, 2], contact
    choices = zip(inputs, drawn(displacement, gel[:, :2]))
    cells, constants = (torch.where(is_tracked.view(-1, *[1] * (a.dim() - 1)), a, b) for a, b in choices)
    return cells, constants, gel[:, 2], displacement[:, 2], contact


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("presses")
    arguments.add_argument("--out", required=True)
    length = arguments.add_mutually_exclusive_group()
    length.add_argument("--minutes", type=float, default=60)
    length.add_argument("--steps", type=int, help="how many steps, instead of minutes")
    arguments.add_argument("--seed", type=int, default=0)
    arguments.add_argument("--rate", type=float, default=2e-3)
    arguments.add_argument("--without-drag", action="store_true", help="train on frames from which shear and twist were subtracted")
    arguments.add_argument("--start", help="weights to begin with: of an earlier training, or exported ones (.bin)")
    arguments = arguments.parse_args()
    torch.manual_seed(arguments.seed)
    torch.use_deterministic_algorithms(True)
    train, judge = load(arguments.presses, arguments.without_drag)
    # Cameras drawn at random do not subtract anything.
    shares, tracked_share = (SHARES_WITHOUT_DRAG, 1) if arguments.without_drag else (SHARES, TRACKED_SHARE)
    network = ContactNetwork().to(memory_format=torch.channels_last)
    if arguments.start:
        exported = arguments.start.endswith(".bin")
        network.load_state_dict(golden.load(arguments.start).float().state_dict() if exported else torch.load(arguments.start))
    mean = copy.deepcopy(network)  # of the weights of the last steps: what is kept
    optimizer = torch.optim.AdamW(network.parameters(), arguments.rate, weight_decay=1e-2)
    draw, begin, step = numpy.random.default_rng(arguments.seed), time.time(), 0

    def passed():
        """Which part of the training is over."""
        return step / arguments.steps if arguments.steps else (time.time() - begin) / (60 * arguments.minutes)

    if arguments.start:
        print(JUDGED % ("before", *judged(network, judge)), flush=True)
    while (part := passed()) < 1:
        step += 1
        warm = min(1, step / 200)
        for group in optimizer.param_groups:
            group["lr"] = arguments.rate * warm * (0.01 + 0.5 * (1 + numpy.cos(numpy.pi * part)))
        cells, constants, coarseness, depth, contact = batch(draw, train, shares, tracked_share)
        estimated = network(cells.contiguous(memory_format=torch.channels_last), constants, coarseness)
        loss = cost(estimated, depth, contact)
        optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        optimizer.step()
        with torch.no_grad():
            share = max(1 / MEAN_STEPS, 10 / (step + 10))
            for kept, last in zip(mean.parameters(), network.parameters()):
                kept.lerp_(last, share)
        if step % 500 == 0:
            print(JUDGED % (f"step {step}: loss {loss.item():.4f}", *judged(mean, judge)), flush=True)
            torch.save(mean.state_dict(), arguments.out)
    torch.save(mean.state_dict(), arguments.out)


if __name__ == "__main__":
    main()
