"""Times `fingervision` against the OpenCV pipeline on the same frames, alternately, and records the ratio.

Needs only Python's standard library: the peer's packages go into a virtual environment under `target/`. All programs
run on one processor. Each round runs ours, then the peer with the preset MEDIUM, then with FAST, so all see the same state
of the machine; the ratios are taken round by round. The record goes to
`benches/record/<date>-<time>-<commit>.json`.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import platform
import shutil
import statistics
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()

ONE_THREAD = dict.fromkeys(["NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS"], "1")

Report = dict[str, Any]


def output(command: Sequence[str | Path]) -> str:
    """What a command prints; ends the program with its message if it fails."""
    done = subprocess.run(command, cwd=ROOT, env=os.environ | ONE_THREAD, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"error: {' '.join(map(str, command))}\n{done.stderr.strip()}")
    return done.stdout.strip()


def pinned(cpu: int) -> list[str]:
    """What keeps a command to one processor; nothing where the system cannot."""
    return ["taskset", "-c", str(cpu)] if shutil.which("taskset") else []


def build_ours() -> Path:
    """The release build of the command line."""
    output(["cargo", "build", "--release", "--locked", "--bin", "fingervision"])
    return TARGET / "release" / "fingervision"


def make_peer() -> Path:
    """The interpreter of a virtual environment that holds the pinned packages."""
    folder = TARGET / "peer-venv"
    python = folder / "bin" / "python"
    if not python.exists():
        output([sys.executable, "-m", "venv", folder])
    output([python, "-m", "pip", "install", "--quiet", "--requirement", HERE / "requirements.txt"])
    return python


def write_press(ours: Path) -> Path:
    """A folder with the press as `frames/*.png` and `truth/flow.npy`."""
    folder = TARGET / "peer-press"
    shutil.rmtree(folder, ignore_errors=True)
    output([ours, "bench", "--write-frames", folder])
    return folder


def frame_ms(report: Report) -> float:
    """Median time of a whole frame, ms."""
    return float(report["frame_ms"]["median"])


def spread(ratios: Sequence[float]) -> Report:
    """Smallest, median and largest ratio."""
    return {"min": min(ratios), "median": round(statistics.median(ratios), 3), "max": max(ratios)}


def compare(ours: Sequence[str | Path], peer: Sequence[str | Path], rounds: int) -> Report:
    """Runs all rounds, printing each, and gathers them with the last report of each program."""
    rows = []
    programs = {"ours": ours, "peer": peer, "fast": [*peer, "--preset", "fast"]}
    for number in range(1, rounds + 1):
        reports = {name: json.loads(output(command)) for name, command in programs.items()}
        times = {name: frame_ms(report) for name, report in reports.items()}
        ratio, ratio_fast = (round(times[name] / times["ours"], 3) for name in ("peer", "fast"))
        rows.append({f"{name}_ms": ms for name, ms in times.items()} | {"ratio": ratio, "ratio_fast": ratio_fast})
        line = ", ".join(f"{name} {ms:.2f} ms" for name, ms in times.items())
        print(f"round {number}: {line}, ratio {ratio:.2f}, with FAST {ratio_fast:.2f}", flush=True)
    ratios = {name: spread([row[name] for row in rows]) for name in ("ratio", "ratio_fast")}
    return ratios | {"rounds": rows} | reports


def machine(cpu: int) -> Report:
    """What the figures were measured on."""
    models = []
    if Path("/proc/cpuinfo").exists():
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return {
        "cpu": models[0] if models else platform.processor(),
        "cores": os.cpu_count(),
        "pinned_to": cpu if pinned(cpu) else None,
        "system": f"{platform.system()} {platform.machine()}",
        "load_before": round(os.getloadavg()[0], 2),
    }


def commit() -> str:
    """The commit that ran, with a mark if tracked files differ from it."""
    return output(["git", "describe", "--always", "--dirty", "--exclude", "*"])


def print_summary(result: Report) -> None:
    """The ratios and all accuracies, in words."""
    for name, ratio in (("peer", result["ratio"]), ("fast", result["ratio_fast"])):
        print(f"frame rate, ours over {name}: min {ratio['min']}, median {ratio['median']}, max {ratio['max']}")
    for name in ("ours", "peer", "fast"):
        error = result[name]["epe_px"]
        print(
            f"mean end-point error, {name}: {error['mean']:.4f} px over the press, {error['final']:.4f} px at its end"
        )


def write_record(record: Report) -> Path:
    """Writes the record and says where."""
    folder = HERE.parent / "record"
    folder.mkdir(exist_ok=True)
    path = folder / f"{record['date']}-{record['time'].replace(':', '')}-{record['commit']}.json"
    path.write_text(json.dumps(record, indent=2) + "\n")
    return path


def arguments() -> argparse.Namespace:
    """What was typed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=7, help="runs of each program (default: 7)")
    parser.add_argument("--cpu", type=int, default=0, help="processor to run on (default: 0)")
    return parser.parse_args()


def main() -> None:
    """Prepares, compares, records."""
    args = arguments()
    now = datetime.datetime.now(datetime.UTC)
    record: Report = {"date": now.date().isoformat(), "time": f"{now:%H:%M}", "commit": commit()}
    ours, python = build_ours(), make_peer()
    press = write_press(ours)
    record |= {"machine": machine(args.cpu), "rustc": output(["rustc", "--version"])}
    record |= compare(
        [*pinned(args.cpu), ours, "bench", "--json"],
        [*pinned(args.cpu), python, "-B", HERE / "run.py", press / "frames", "--truth", press / "truth"],
        args.rounds,
    )
    print_summary(record)
    print(f"record: {write_record(record)}")


if __name__ == "__main__":
    main()
