"""Writes a data set: the files of each episode, then those that describe all of them."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fingervision._errors import ArgumentError
from fingervision.lerobot._columns import column, feature, library
from fingervision.lerobot._episodes import Episode, Tracking, open_episode
from fingervision.lerobot._statistics import Statistics

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy.typing as npt

    import fingervision

    _Path = str | os.PathLike[str]

_FRAMES_PER_GROUP = 8
_FILES_PER_CHUNK = 1000
_PARQUET = {"compression": "zstd", "compression_level": 1, "use_dictionary": False}
_NUMBERING = ("frame_index", "episode_index", "index", "task_index")


def export_lerobot(
    recordings: _Path | Sequence[_Path],
    folder: _Path,
    *,
    task: str = "touch",
    profile: fingervision.Profile | _Path | None = None,
    fields: Sequence[str] | None = None,
    images: bool = True,
    frames_per_second: int | None = None,
    prefix: str = "observation.touch",
    set: dict[str, Any] | None = None,  # noqa: A002
) -> dict[str, Any]:
    """Writes a LeRobot data set, format v3.0, into a new folder: an episode for each recording or run.

    ``recordings`` are folders of ``fingervision track`` or recordings ``FILE.mcap``, which are tracked with ``profile``,
    ``fields`` and ``set`` as by ``fingervision.open``. Every frame is kept, at its native rate. ``timestamp`` is the index
    divided by the rate, as LeRobot requires; the time of capture is the feature ``PREFIX.capture_time_ns``. Fields are
    arrays ``PREFIX.depth``, ``PREFIX.flow`` and so on, without loss, in the units of ``fingervision.Reading``. Camera
    images of recordings are the feature ``PREFIX.image``, without loss, unless ``images`` is false. ``task`` describes
    what is done. ``frames_per_second`` is the rate, by default that of the first recording, rounded.

    Returns the numbers of episodes and frames and the rate. Raises ``ArgumentError`` if the folder exists, or recordings
    differ in rate or in features, and the errors of ``fingervision.open``.
    """
    for name in ("pyarrow", "PIL.Image"):
        library(name)
    target = Path(folder)
    if target.exists():
        raise ArgumentError(f"{target} exists already: choose a new name")
    listed = [recordings] if isinstance(recordings, (str, os.PathLike)) else list(recordings)
    if not listed:
        raise ArgumentError("no recording is given: name at least one")
    tracking = Tracking(profile, fields, images, set)
    episodes = [open_episode(recording, tracking) for recording in listed]
    rate = _common_rate(episodes) if frames_per_second is None else frames_per_second
    if rate < 1:
        raise ArgumentError(f"a rate of {rate} frames per second is too low: LeRobot needs at least 1")
    target.parent.mkdir(parents=True, exist_ok=True)
    work = Path(tempfile.mkdtemp(prefix=f".{target.name}-", dir=target.parent))
    try:
        data_set = _DataSet(work, rate, task, prefix)
        for episode in episodes:
            data_set.add(episode)
        summary = data_set.finish()
        work.chmod(0o755)
        work.rename(target)
    except BaseException:
        shutil.rmtree(work, ignore_errors=True)
        raise
    return {"folder": str(target), **summary}


def _common_rate(episodes: list[Episode]) -> int:
    rates = [_native_rate(episode) for episode in episodes]
    for episode, rate in zip(episodes, rates, strict=True):
        if rate != rates[0]:
            message = f"{episodes[0].source} has {rates[0]} frames per second, {episode.source} has {rate}"
            raise ArgumentError(f"{message}: export them separately, or give frames_per_second")
    return rates[0]


def _native_rate(episode: Episode) -> int:
    intervals = np.diff(episode.times_s)
    if len(intervals) == 0 or not np.median(intervals) > 0:
        raise ArgumentError(f"{episode.source} has no rate, its times do not increase: give frames_per_second")
    return round(1 / float(np.median(intervals)))


class _DataSet:
    def __init__(self, folder: Path, rate: int, task: str, prefix: str) -> None:
        self._folder, self._rate, self._task, self._prefix = folder, rate, task, prefix
        self._features: dict[str, dict[str, Any]] = {}
        self._statistics: dict[str, Statistics] = {}
        self._episodes: list[dict[str, Any]] = []
        self._frames = 0

    def add(self, episode: Episode) -> None:
        """Writes the data of an episode."""
        number = len(self._episodes)
        chunk, file = divmod(number, _FILES_PER_CHUNK)
        path = self._folder / f"data/chunk-{chunk:03}/file-{file:03}.parquet"
        path.parent.mkdir(parents=True, exist_ok=True)
        first, own = self._frames, dict[str, Statistics]()
        writer: Any = None
        group: list[dict[str, npt.NDArray[Any]]] = []
        try:
            for index, values in enumerate(episode.frames()):
                frame = self._numbered(values, index, number)
                self._look(frame, episode, own)
                group.append(frame)
                if len(group) == _FRAMES_PER_GROUP:
                    writer, group = self._write(writer, path, group), []
            if group:
                writer = self._write(writer, path, group)
        finally:
            if writer is not None:
                writer.close()
        if writer is None:
            raise ArgumentError(f"{episode.source} has no frames")
        profile = self._folder / f"meta/fingervision/episode-{number:06}.toml"
        profile.parent.mkdir(parents=True, exist_ok=True)
        profile.write_text(episode.profile.to_toml(), encoding="utf-8")
        places = {"data/chunk_index": chunk, "data/file_index": file}
        length = self._frames - first
        row = {"episode_index": number, "tasks": [self._task], "length": length, **places}
        row |= {"dataset_from_index": first, "dataset_to_index": self._frames}
        row |= {"meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0}
        for name, statistics in own.items():
            row |= {f"stats/{name}/{key}": value for key, value in statistics.result().items()}
        self._episodes.append(row)

    def _numbered(self, values: dict[str, npt.NDArray[Any]], index: int, episode: int) -> dict[str, npt.NDArray[Any]]:
        numbers = dict(zip(_NUMBERING, (index, episode, self._frames, 0), strict=True))
        frame = {f"{self._prefix}.{name}": value for name, value in values.items()}
        frame["timestamp"] = np.array([index / self._rate], np.float32)
        self._frames += 1
        return frame | {name: np.array([number], np.int64) for name, number in numbers.items()}

    def _look(self, frame: dict[str, npt.NDArray[Any]], episode: Episode, own: dict[str, Statistics]) -> None:
        """Compares a frame's features with those of the first frame, and adds it to the statistics."""
        features = {name: feature(name.removeprefix(f"{self._prefix}."), value) for name, value in frame.items()}
        self._features = self._features or features
        if features != self._features:
            different = sorted(name for name in features | self._features if features.get(name) != self._features.get(name))
            message = f"{episode.source} has other features than the first frame: {', '.join(different)}"
            raise ArgumentError(f"{message}; export it separately, or give fields that all have")
        for name, value in frame.items():
            for statistics in (own, self._statistics):
                if name not in statistics:
                    statistics[name] = Statistics(value.shape, is_image=features[name]["dtype"] == "image")
                statistics[name].add(value)

    def _write(self, writer: Any, path: Path, group: list[dict[str, npt.NDArray[Any]]]) -> Any:
        columns = {
            name: column([frame[name] for frame in group], is_image=entry["dtype"] == "image")
            for name, entry in self._features.items()
        }
        table = library("pyarrow").table(columns)
        writer = writer or library("pyarrow.parquet").ParquetWriter(path, table.schema, **_PARQUET)
        writer.write_table(table)
        return writer

    def finish(self) -> dict[str, Any]:
        """Writes what describes the episodes."""
        arrow, parquet, meta = library("pyarrow"), library("pyarrow.parquet"), self._folder / "meta"
        (meta / "episodes/chunk-000").mkdir(parents=True)
        parquet.write_table(arrow.Table.from_pylist(self._episodes), meta / "episodes/chunk-000/file-000.parquet")
        parquet.write_table(_tasks(arrow, self._task), meta / "tasks.parquet")
        _write_json(meta / "stats.json", {name: found.result() for name, found in self._statistics.items()})
        _write_json(meta / "info.json", self._info())
        return {"episodes": len(self._episodes), "frames": self._frames, "frames_per_second": self._rate}

    def _info(self) -> dict[str, Any]:
        return {
            "codebase_version": "v3.0",
            "robot_type": None,
            "total_episodes": len(self._episodes),
            "total_frames": self._frames,
            "total_tasks": 1,
            "chunks_size": _FILES_PER_CHUNK,
            "data_files_size_in_mb": 100,
            "video_files_size_in_mb": 200,
            "fps": self._rate,
            "splits": {"train": f"0:{len(self._episodes)}"},
            "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
            "video_path": None,
            "features": self._features,
        }


def _tasks(arrow: Any, task: str) -> Any:
    """The table of tasks; pandas, which LeRobot reads it with, takes the second column as the index."""
    table = arrow.table({"task_index": arrow.array([0], arrow.int64()), "task": [task]})
    kinds = [("task_index", "int64", "int64"), ("task", "unicode", "object")]
    columns = [
        {"name": name, "field_name": name, "pandas_type": kind, "numpy_type": numpy, "metadata": None}
        for name, kind, numpy in kinds
    ]
    described = {"index_columns": ["task"], "column_indexes": [], "columns": columns, "pandas_version": "2.0.0"}
    return table.replace_schema_metadata({"pandas": json.dumps(described)})


def _write_json(path: Path, value: Any) -> None:
    path.write_text(json.dumps(value, indent=4), encoding="utf-8")
