"""A recording or session as a data set of LeRobot, layout v3.0; :mod:`.touch` reads it back.

::

    meta/info.json  meta/stats.json  meta/tasks.parquet  meta/episodes/chunk-000/file-000.parquet
    meta/vegrip.json                    the version that was written, and the radius of every fingertip
    data/chunk-000/file-000.parquet     a row a frame

Features of a finger: ``observation.tactile.thumb.wrench`` (6) as fx, fy, fz [N], tx, ty, tz [N m] in the
contact frame, compression positive along z; ``.displacement``, ``.slip`` and so on as measured; ``.margin``,
``.lower_bound``, ``.friction``, ``.friction_std`` and ``.command`` [N] as the nodes said. LeRobot has no
names for touch yet; ``observation.tactile.*`` is what lerobot#4469 proposes, which is open. Frames are evenly
spaced, and each has what was known last, NaN where nothing came for so long that it is a gap.
"""

import json
import math
import tempfile
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

import vegrip
from vegrip.clock import NS
from vegrip.errors import RecordingError, UsageError
from vegrip.identification.recording.channels import CHANNELS
from vegrip.identification.recording.data import Recording
from vegrip.identification.recording.extras import extra_library
from vegrip.identification.recording.mcap import TextTable, read_all, tables_of
from vegrip.identification.recording.report import GAP_STEPS, LEAST_GAP_S, LoadReport
from vegrip.identification.recording.touch import TOUCH, WRENCH
from vegrip.messages import ContactEstimate, FingertipState, ForceCommand, SlipMargin
from vegrip.types import Floats
from vegrip.whole_file import writing

SET_LAYOUT: Final = "v3.0"
SCHEMA: Final = "observation.tactile.*, version 1"
SAID: Final = {
    SlipMargin: {"margin": "margin", "lower_bound": "lower_bound"},
    ContactEstimate: {"friction": "friction_coefficient", "friction_std": "friction_coefficient_std"},
    ForceCommand: {"command": "normal_force"},
}
"""What nodes said: feature -> column."""
COUNTERS: Final = ("frame_index", "episode_index", "index", "task_index")
DATA: Final = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
EPISODES: Final = "meta/episodes/chunk-000/file-000.parquet"
OURS: Final = "meta/vegrip.json"
ROUNDING_NS: Final = 1000  # [ns] by which a row may be later than its frame: times are written in decimals
MOST_SET_FRAMES: Final = 10_000_000  # a day at 100 a second; some gigabytes of five fingers


@dataclass(frozen=True, slots=True)
class Instants:
    """When the frames of all episodes are."""

    stamps: NDArray[np.int64]  # [ns]
    episode: NDArray[np.int64]
    number: NDArray[np.int64]  # within its episode


@dataclass(frozen=True, slots=True)
class Written:
    """What went into a data set: its ``info.json``, and what of the recordings did not."""

    info: dict[str, Any]
    reports: list[LoadReport]  # of the recordings that were read
    between: int  # rows of states that no frame has, because frames are fewer
    gaps: Mapping[str, int]  # finger -> frames at which nothing had come from it for too long: NaN


def write_lerobot(folder: Path, output: Path, *, fps: int = 0, task: str = "hold an object") -> Written:
    """Write the recording or session in ``folder`` as a data set to ``output``; replace one written before.

    Args:
        folder: of the recording or session.
        output: folder of the data set.
        fps: frames a second; 0 = as many as there are rows.
        task: what is done, in words.

    Raises:
        RecordingError: no recording, a damaged table, or something else in ``output``.
        UsageError: pyarrow is not installed, or there are too many frames.

    """
    pa = extra_library("pyarrow", "lerobot")
    _refuse_others(output)
    recordings = read_all(folder)
    tables = list(tables_of(folder, recordings))
    first = next(iter(recordings.values()))
    rate = fps or max(round(1.0 / float(np.median(np.diff(first.t)))) if len(first) > 1 else 1, 1)
    instants = _instants(first, tables[0], rate)
    touch, between, gaps = _features(tables, instants)
    length, total = np.bincount(instants.episode), len(instants.stamps)
    counters = (instants.number, instants.episode, np.arange(total), np.zeros(total, np.int64))
    columns: dict[str, Any] = touch | {"timestamp": (instants.number / rate).astype(np.float32)}
    columns |= {name: values.astype(np.int64) for name, values in zip(COUNTERS, counters, strict=True)}
    info = {
        "codebase_version": SET_LAYOUT, "robot_type": "vegrip", "total_episodes": len(length),
        "total_frames": total, "total_tasks": 1, "chunks_size": 1000, "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200, "fps": rate, "splits": {"train": f"0:{len(length)}"},
        "data_path": DATA, "video_path": None,
        "features": {name: _feature(name, values) for name, values in columns.items()},
    }  # fmt: skip
    ends = np.cumsum(length)
    nothing = [0] * len(length)
    episodes = {
        "episode_index": list(range(len(length))), "tasks": [[task]] * len(length), "length": length.tolist(),
        "data/chunk_index": nothing, "data/file_index": nothing, "meta/episodes/chunk_index": nothing,
        "meta/episodes/file_index": nothing, "dataset_from_index": (ends - length).tolist(),
        "dataset_to_index": ends.tolist(),
    }  # fmt: skip
    radii = {one.fingertip.name: one.fingertip.radius for one in recordings.values()}
    radii = {name: radius for name, radius in radii.items() if math.isfinite(radius)}
    about = {"version": vegrip.__version__, "layout": SET_LAYOUT, "schema": SCHEMA, "radius_m": radii}
    texts = {"info": info, "stats": {name: _stats(one) for name, one in columns.items()}, "vegrip": about}
    tasks = pa.table({"task_index": pa.array([0], pa.int64()), "task": [task]})
    parts = {
        "meta/tasks.parquet": tasks.replace_schema_metadata({"pandas": json.dumps(_PANDAS)}),
        EPISODES: pa.table(episodes),
        DATA.format(chunk_index=0, file_index=0): pa.table({n: _column(pa, v) for n, v in columns.items()}),
    }
    _write(output, parts, texts)
    return Written(info, [one.report for one in recordings.values()], between, gaps)


def _refuse_others(output: Path) -> None:
    there = {one.name for one in output.iterdir()} if output.is_dir() else set()
    if there and not (there <= {"meta", "data"} and (output / OURS).is_file()):
        raise RecordingError(f"{output}: holds something else than a data set that vegrip wrote")


def _write(output: Path, parts: Mapping[str, Any], texts: Mapping[str, Any]) -> None:
    pq = extra_library("pyarrow.parquet", "lerobot")
    with writing(output, RecordingError):
        output.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{output.name}-", dir=output.parent) as scratch:
            made, aside = Path(scratch) / "made", Path(scratch) / "before"
            for name, part in parts.items():
                (made / name).parent.mkdir(parents=True, exist_ok=True)
                pq.write_table(part, made / name)
            for name, text in texts.items():
                path = made / "meta" / f"{name}.json"
                path.write_text(json.dumps(text, indent=2) + "\n", encoding="utf-8")
            if output.exists():
                output.rename(aside)
            made.rename(output)


_PANDAS: Final[Any] = {
    "index_columns": ["task"],
    "column_indexes": [],
    "columns": [
        {"name": name, "field_name": name, "pandas_type": kind, "numpy_type": numpy, "metadata": None}
        for name, kind, numpy in (("task_index", "int64", "int64"), ("task", "unicode", "object"))
    ],
    "pandas_version": "2.2.0",
}
"""So that pandas takes the task as the index, by which LeRobot looks it up."""


def _instants(first: Recording, table: TextTable, rate: int) -> Instants:
    stamps = np.array(table.stamps, np.int64)
    of_episode = [stamps[first.episode == episode] for episode in np.unique(first.episode)]
    counts = [int((int(one[-1] - one[0]) + ROUNDING_NS) * rate // NS) + 1 for one in of_episode]
    if sum(counts) > MOST_SET_FRAMES:
        raise UsageError(f"{sum(counts)} frames at {rate} a second are too many; give a lower --fps")
    numbers = [np.arange(count, dtype=np.int64) for count in counts]
    at = [one[0] + number * NS // rate for one, number in zip(of_episode, numbers, strict=True)]
    return Instants(np.concatenate(at), np.repeat(np.arange(len(at)), counts), np.concatenate(numbers))


def _features(
    tables: Sequence[TextTable], instants: Instants
) -> tuple[dict[str, Floats], int, Mapping[str, int]]:
    """Return the features, how many rows of states no frame has, and how many frames lie in gaps of whom."""
    found: dict[str, Floats] = {}
    between, gaps = 0, Counter[str]()
    for table in tables:
        finger = table.topic.rsplit("/", 2)[-2]
        last, is_gap = _last_rows(np.array(table.stamps, np.int64), instants.stamps)
        if table.kind is FingertipState:
            between += len(table.rows) - len(np.unique(last[last >= 0]))
            gaps[finger] += int(is_gap.sum())
            none = np.zeros(len(instants.stamps), np.float32)
            wrench = [_sampled(table, last, name) if name else none for name in WRENCH]
            found[f"{TOUCH}{finger}.wrench"] = np.stack(wrench, axis=1)
            for name in (CHANNELS.keys() - set(WRENCH)) & set(table.columns):
                found[f"{TOUCH}{finger}.{name}"] = _sampled(table, last, name)
        for feature, column in SAID.get(table.kind, {}).items():
            found[f"{TOUCH}{finger}.{feature}"] = _sampled(table, last, column)
    return dict(sorted(found.items())), between, {finger: count for finger, count in gaps.items() if count}


def _sampled(table: TextTable, rows: NDArray[np.int64], column: str) -> Floats:
    """Return ``column`` at ``rows``, NaN where a row is -1 or there is no such column."""
    at = table.columns.index(column) if column in table.columns else None
    cells = [] if at is None else [float(row[at] or "nan") for row in table.rows]
    values = np.array([*cells, math.nan])  # the last one stands for what is not known
    return values[np.where((rows >= 0) & bool(cells), rows, len(cells))].astype(np.float32)


def _last_rows(
    stamps: NDArray[np.int64], at: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return the last row at each instant [ns], -1 where there is none, and whether because of a gap."""
    last = np.searchsorted(stamps, at + ROUNDING_NS, "right") - 1
    step = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
    oldest = max(LEAST_GAP_S * NS, GAP_STEPS * step)
    is_gap = (last >= 0) & (at - stamps[np.maximum(last, 0)] > oldest) if len(stamps) else last >= 0
    return np.where(is_gap, -1, last), is_gap


def _feature(name: str, values: Any) -> dict[str, Any]:
    axes = ["fx", "fy", "fz", "tx", "ty", "tz"] if name.endswith(".wrench") else None
    return {"dtype": str(values.dtype), "shape": list(values.shape[1:]) or [1], "names": axes}


def _stats(values: Any) -> dict[str, list[float]]:
    rows = values.reshape(len(values), -1).astype(float)
    known = np.where(np.isfinite(rows).any(axis=0), rows, 0.0)  # a column that was never known: zeros
    figures: dict[str, Any] = {"min": np.nanmin, "max": np.nanmax, "mean": np.nanmean, "std": np.nanstd}
    return {name: figure(known, axis=0).tolist() for name, figure in figures.items()} | {"count": [len(rows)]}


def _column(pa: Any, values: Any) -> Any:
    if values.ndim == 1:
        return pa.array(values)
    return pa.FixedSizeListArray.from_arrays(pa.array(values.ravel()), values.shape[1])
