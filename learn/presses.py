"""Draws random presses, has the simulator solve them and keeps a few frames of each."""

import argparse
import dataclasses
import math
import pathlib
import shutil
import subprocess
import tempfile

import numpy
from PIL import Image

CELLS = 120
PIXELS = 480  # the simulator's frame, each cell 4 by 4 of it
FRAMES_KEPT = 5
PATIENCE_S = 300  # a few presses do not settle
MESHES = ["draft", "medium", "fine"]
SHAPES = {
    "circle": 0.14, "rectangle": 0.14, "triangle": 0.1, "polygon": 0.2, "crossing": 0.08,
    "sphere": 0.08, "ring": 0.08, "pins": 0.06, "letter": 0.06, "height-map": 0.06,
}


@dataclasses.dataclass(frozen=True)
class Kind:
    """The distribution of presses: the share that is moved along the surface, and of those the share that is sheared and not
    twisted; the shares that stick and that have friction, while the others slide (none: it depends on mesh and motion); the
    ranges of depth, mm, the largest shear along each axis, mm, the shapes, and the radii of balls, mm."""

    moved: float = 0.3
    sheared: float = 0.6
    laws: tuple[float, float] | None = None
    # The depth of deep sliding faces is the hardest to estimate.
    depths_mm: tuple = ((0.4, 2.4), (1.6, 2.4), (1.6, 2.4))
    most_shear_mm: float = 1.8
    shapes: tuple = tuple(SHAPES)
    ball_mm: tuple[float, float] = (2.5, 25)
    is_late: bool = False  # what sticks does so after its first step


FLAT = tuple(shape for shape in SHAPES if shape not in ("sphere", "height-map"))
PARTS = ("crossing", "ring", "pins", "letter")
LIGHT_MM = ((0.08, 0.6),)
KINDS = {
    "any": Kind(),
    "sliding": Kind(moved=0.12, laws=(0.2, 0)),
    "light": Kind(moved=0.1, depths_mm=LIGHT_MM),
    "light-ball": Kind(moved=0.1, depths_mm=((0.08, 0.8),), shapes=("sphere",)),
    "parts": Kind(shapes=PARTS),
    "light-parts": Kind(moved=0.1, depths_mm=LIGHT_MM, shapes=PARTS),
    "sliding-parts": Kind(moved=0.12, laws=(0.2, 0), shapes=PARTS),
    "late": Kind(moved=0.15, laws=(1, 0), shapes=FLAT, is_late=True),
    "late-parts": Kind(moved=0.15, laws=(1, 0), shapes=PARTS, is_late=True),
    "light-late": Kind(moved=0.1, laws=(1, 0), depths_mm=LIGHT_MM, shapes=FLAT, is_late=True),
    "dragged": Kind(moved=1, laws=(0.25, 0.6), depths_mm=((0.4, 1.5),), most_shear_mm=2.1),
    "dragged-ball": Kind(
        moved=1, sheared=0.9, laws=(0.2, 0.8), depths_mm=((0.4, 1.0),), most_shear_mm=2.1, shapes=("sphere",), ball_mm=(6, 30)
    ),
}


def height_map(draw, folder):
    """A few smooth hills, some sharp, some blunt."""
    y, x = numpy.mgrid[-1:1:161j, -1:1:161j]
    height = numpy.full(x.shape, -1.0)
    for _ in range(draw.integers(1, 5)):
        (x0, y0), (a, b) = draw.uniform(-0.5, 0.5, 2), draw.uniform(0.15, 0.7, 2)
        turn, top = draw.uniform(0, math.pi), draw.uniform(-0.25, 0)
        u = (x - x0) * math.cos(turn) + (y - y0) * math.sin(turn)
        v = (y - y0) * math.cos(turn) - (x - x0) * math.sin(turn)
        height = numpy.maximum(height, top - 0.6 * ((u / a) ** 2 + (v / b) ** 2) ** draw.choice([1, 2, 0.5]))
    grey = numpy.clip(height - height.max() + 1, 0, 1) * 65535
    Image.fromarray(grey.astype(numpy.uint16)).save(folder / "relief.png")
    side = draw.uniform(6, 14)
    return f'file = "relief.png"\nsize_mm = [{side:.3f}, {side:.3f}]\nheight_mm = {draw.uniform(1.5, 5):.3f}'


def points(pairs):
    return "[" + ", ".join(f"[{x:.3f}, {y:.3f}]" for x, y in pairs) + "]"


def sizes(draw, shape, folder, ball_mm):
    uniform = draw.uniform
    match shape:
        case "circle":
            return f"radius_mm = {uniform(1.2, 6):.3f}"
        case "rectangle":
            return f"size_mm = [{uniform(2, 10):.3f}, {uniform(2, 10):.3f}]"
        case "triangle":
            return f"side_mm = {uniform(4, 11):.3f}"
        case "polygon":
            corners = draw.integers(3, 9)
            turn = numpy.linspace(0, 2 * math.pi, corners, endpoint=False)
            turn = turn + uniform(-0.3, 0.3, corners) * 2 * math.pi / corners
            reach = uniform(1.5, 6, corners)
            return f"points_mm = {points(zip(reach * numpy.cos(turn), reach * numpy.sin(turn)))}"
        case "crossing":
            return f"bar_mm = [{uniform(6, 13):.3f}, {uniform(1.5, 3.5):.3f}]"
        case "sphere":
            return f"radius_mm = {math.exp(uniform(*numpy.log(ball_mm))):.3f}"
        case "ring":
            inner = uniform(1.2, 4)
            return f"inner_radius_mm = {inner:.3f}\nouter_radius_mm = {inner + uniform(1, 3):.3f}"
        case "pins":
            corners = numpy.array([[-3, -3], [3, -3], [-3, 3], [3, 3]])[draw.permutation(4)[: draw.integers(1, 5)]]
            places = corners * uniform(0.8, 1.4) + uniform(-0.5, 0.5, corners.shape)
            return f"radius_mm = {uniform(0.8, 1.8):.3f}\ncentres_mm = {points(places)}"
        case "letter":
            return f'text = "{draw.choice(list("ABCDEFGHJKLMNPSTUVWXYZ2345678"))}"\nheight_mm = {uniform(6, 12):.3f}'
        case _:
            return height_map(draw, folder)


def gel(side, thickness, ratio):
    """The table of a gel, as scenes have it."""
    return f"[gel]\nsize_mm = [{side:.4f}, {side:.4f}]\nthickness_mm = {thickness:.4f}\npoissons_ratio = {ratio:.4f}"


def scene(draw, folder, mesh, kind):
    """Writes a random scene, one that takes few steps if the mesh is no draft; returns the gel's side, thickness and Poisson's
    ratio, and the number of frames."""
    uniform = draw.uniform
    side = 30.0 if draw.random() < 0.6 else uniform(24, 36)
    thickness = 10.0 if draw.random() < 0.6 else uniform(7, 13)
    ratio = draw.choice([0.35, 0.48]) if draw.random() < 0.3 else uniform(0.3, 0.495)
    chance, is_draft, is_moved = draw.random(), mesh == "draft", draw.random() < kind.moved
    stuck = 0.4 if is_moved or not is_draft else 0.15
    held_by_friction = 0.4 if is_moved else 0.15 if is_draft else 0
    if kind.laws:
        stuck, held_by_friction = kind.laws
    law = '"stick"' if chance < stuck else '"frictionless"'
    if chance > 1 - held_by_friction:
        law = f"{{ friction = {uniform(0.2, 1.2):.3f} }}"
    if kind.is_late and law == '"stick"':
        law = '"late-stick"'
    # Without friction the way down does not matter: few steps will do.
    pressed = 3 if "frictionless" in law else 10 if is_draft else 5
    x, y = uniform(-1, 1, 2) * 0.36 * side * draw.choice([0.3, 1])
    depth, tilt, more, frames = uniform(*draw.choice(kind.depths_mm)), "", "", pressed + 1
    if draw.random() < 0.25:
        tilt = f", tilt_rad = [{uniform(-0.1, 0.1):.4f}, {uniform(-0.1, 0.1):.4f}]"
    if is_moved:
        depth, frames = min(depth, 1.5 if is_draft else 2.1), pressed + (3 if "frictionless" in law and not is_draft else 6)
        if draw.random() < kind.sheared:
            x_mm, y_mm = kind.most_shear_mm * uniform(-1, 1, 2)
            more = f", {{ at = {frames - 1}, shear_mm = [{x_mm:.3f}, {y_mm:.3f}] }}"
        else:
            more = f", {{ at = {frames - 1}, twist_rad = {uniform(-0.35, 0.35):.4f} }}"
    shares = numpy.array([SHAPES[shape] for shape in kind.shapes])
    shape = draw.choice(kind.shapes, p=shares / shares.sum())
    focal_length = PIXELS / side * 25
    (folder / "scene.toml").write_text(f"""name = "press"
[camera]
focal_length_px = [{focal_length:.6f}, {focal_length:.6f}]
{gel(side, thickness, ratio)}
youngs_modulus_mpa = 0.6
[contact]
law = {law}
[indenter]
shape = "{shape}"
{sizes(draw, shape, folder, kind.ball_mm)}
fillet_mm = {uniform(0.15, 0.6):.3f}
rotation_rad = {uniform(0, 2 * math.pi):.4f}
[motion]
centre_mm = [{x:.3f}, {y:.3f}]
frames = {frames}
keyframes = [{{ at = {pressed}, depth_mm = {depth:.3f}{tilt} }}{more}]
[mesh]
resolution = "{mesh}"
""")
    return side, thickness, ratio, frames


def cells(plane):
    """The mean of each cell's pixels."""
    part = PIXELS // CELLS
    return numpy.asarray(plane, numpy.float32).reshape(CELLS, part, CELLS, part, -1).mean((1, 3))


def solve(seed, command, out, mesh, kind):
    draw = numpy.random.default_rng(seed)
    folder = pathlib.Path(tempfile.mkdtemp(prefix="press"))
    try:
        side, thickness, ratio, frames = scene(draw, folder, mesh, kind)
        arguments = ["simulate", folder / "scene.toml", "--truth-only", "--no-cache", "--quiet"]
        try:
            done = subprocess.run([command, *arguments, "--out", folder / "run"], capture_output=True, text=True, timeout=PATIENCE_S)
        except subprocess.TimeoutExpired:
            print(f"seed {seed}: not solved in {PATIENCE_S} s", flush=True)
            return
        if done.returncode != 0:
            print(f"seed {seed}: {done.stderr.strip().splitlines()[0]}", flush=True)
            return
        kept = sorted({frames - 1, *(1 + draw.permutation(frames - 1)[: FRAMES_KEPT - 1])})
        displacement = numpy.load(folder / "run/truth/displacement.npy", mmap_mode="r")
        contact = numpy.load(folder / "run/truth/contact.npy", mmap_mode="r")
        press = out / f"{seed:05d}"
        press.mkdir(exist_ok=True)
        numpy.save(press / "displacement.npy", numpy.stack([cells(displacement[frame]) for frame in kept]))
        shares = numpy.stack([255 * cells(contact[frame])[..., 0] for frame in kept])
        numpy.save(press / "contact.npy", shares.astype(numpy.uint8))
        # Last: a press that says what it is is whole.
        (press / "press.toml").write_text(f'mesh = "{mesh}"\n{gel(side, thickness, ratio)}\n')
    finally:
        shutil.rmtree(folder)


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("first", type=int, help="the first seed")
    arguments.add_argument("end", type=int, help="the seed after the last")
    arguments.add_argument("--out", type=pathlib.Path, required=True)
    arguments.add_argument("--mesh", choices=MESHES, default="draft", help="on finer ones presses take few steps")
    arguments.add_argument("--kind", choices=KINDS, default="any", help="what presses are drawn")
    arguments.add_argument("--command", default="target/release/fingervision")
    arguments = arguments.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    for seed in range(arguments.first, arguments.end):
        if not (arguments.out / f"{seed:05d}" / "press.toml").exists():
            solve(seed, arguments.command, arguments.out, arguments.mesh, KINDS[arguments.kind])


if __name__ == "__main__":
    main()
