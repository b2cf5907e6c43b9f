"""Recordings as a data set of LeRobot (layout v3.0) and back, and touch in the Open-Tactile-Schema.

::

    meta/info.json  meta/stats.json  meta/tasks.parquet  meta/episodes/chunk-000/file-000.parquet
    meta/vegrip.json                    the version that was written, and the radius of every fingertip
    data/chunk-000/file-000.parquet     a row a frame

Features of a finger: ``observation.tactile.thumb.wrench`` (6) as fx, fy, fz [N], tx, ty, tz [N m] in the
contact frame, compression positive along z; ``.displacement``, ``.slip`` and so on as measured; ``.margin``,
``.lower_bound``, ``.friction``, ``.friction_std`` and ``.command`` [N] as the nodes said. LeRobot has no
names for touch yet; ``observation.tactile.*`` is what lerobot#4469 proposes, which is open. Frames are evenly
spaced, and each has what was known last.

The Open-Tactile-Schema (EltonChang1/tactile-data-toolkit at 153048f) has ``normal_force`` (T, N) and
``shear_force`` (T, N, 2) of N elements, whose sums are the forces of the fingertip, or ``wrench`` (T, 6).
"""

import importlib
import json
import math
import re
import zipfile
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
from vegrip.identification.recording.data import Fingertip, Recording
from vegrip.identification.recording.mcap import TextTable, read_all, tables_of
from vegrip.messages import ContactEstimate, FingertipState, ForceCommand, SlipMargin
from vegrip.types import Floats
from vegrip.whole_file import filled_folder, reading

SET_LAYOUT: Final = "v3.0"
SCHEMA: Final = "observation.tactile.*, version 1"
TOUCH: Final = "observation.tactile."
WRENCH: Final = ("tangential_force_x", "tangential_force_y", "normal_force", "", "", "torque_z")
SAID: Final = {
    SlipMargin: {"margin": "margin", "lower_bound": "lower_bound"},
    ContactEstimate: {"friction": "friction_coefficient", "friction_std": "friction_coefficient_std"},
    ForceCommand: {"command": "normal_force"},
}
"""What nodes said: feature -> column."""
COUNTERS: Final = ("frame_index", "episode_index", "index", "task_index")
DATA: Final = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
EPISODES: Final = "meta/episodes/chunk-000/file-000.parquet"
PAUSE_S: Final = 1.0  # [s] between two episodes that are joined
ROUNDING_NS: Final = 1000  # [ns] by which a row may be later than its frame: times are written in decimals
OPEN_KEYS: Final = ("normal_force", "shear_force", "wrench", "timestamps")


def _arrow(module: str) -> Any:
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError:
        raise UsageError("a data set of LeRobot needs pyarrow: pip install 'vegrip[lerobot]'") from None


@dataclass(frozen=True, slots=True)
class Frames:
    """The instants of all episodes."""

    stamps: NDArray[np.int64]  # [ns]
    episode: NDArray[np.int64]
    number: NDArray[np.int64]  # within its episode


def write_lerobot(
    folder: Path, output: Path, *, fps: int = 0, task: str = "hold an object"
) -> dict[str, Any]:
    """Write the recording or session in ``folder`` as a data set to ``output``; return its ``info.json``.

    Args:
        folder: of the recording or session.
        output: folder of the data set.
        fps: frames a second; 0 = as many as there are rows.
        task: what is done, in words.

    Raises:
        RecordingError: no recording, or a damaged table.
        UsageError: pyarrow is not installed.

    """
    pa, pq = _arrow("pyarrow"), _arrow("pyarrow.parquet")
    recordings = read_all(folder)
    tables = list(tables_of(folder, recordings))
    first = next(iter(recordings.values()))
    rate = fps or max(round(1.0 / float(np.median(np.diff(first.t)))) if len(first) > 1 else 1, 1)
    frames = _frames(first, tables[0], rate)
    touch = _features(tables, frames)
    length, total = np.bincount(frames.episode), len(frames.stamps)
    counters = (frames.number, frames.episode, np.arange(total), np.zeros(total, np.int64))
    columns: dict[str, Any] = touch | {"timestamp": (frames.number / rate).astype(np.float32)}
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
    with filled_folder(output):
        for name, part in parts.items():
            (output / name).parent.mkdir(parents=True, exist_ok=True)
            pq.write_table(part, output / name)
        for name, text in texts.items():
            (output / "meta" / f"{name}.json").write_text(json.dumps(text, indent=2) + "\n", encoding="utf-8")
    return info


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


def _frames(first: Recording, table: TextTable, rate: int) -> Frames:
    stamps = np.array(table.stamps, np.int64)
    of_episode = [stamps[first.episode == episode] for episode in np.unique(first.episode)]
    counts = [int((one[-1] - one[0] + ROUNDING_NS) * rate // NS) + 1 for one in of_episode]
    numbers = [np.arange(count, dtype=np.int64) for count in counts]
    at = [one[0] + number * NS // rate for one, number in zip(of_episode, numbers, strict=True)]
    return Frames(np.concatenate(at), np.repeat(np.arange(len(at)), counts), np.concatenate(numbers))


def _features(tables: Sequence[TextTable], frames: Frames) -> dict[str, Floats]:
    found: dict[str, Floats] = {}
    for table in tables:
        finger = table.topic.rsplit("/", 2)[-2]
        names = {table.columns[i]: i for i in range(len(table.columns))}
        last = np.searchsorted(np.array(table.stamps, np.int64), frames.stamps + ROUNDING_NS, "right") - 1

        def sampled(column: str, table: TextTable = table, names: Any = names, last: Any = last) -> Floats:
            cells = [float(row[names[column]] or "nan") for row in table.rows] if column in names else []
            values = np.array([*cells, math.nan])  # the last one stands for what is not known
            return values[np.where((last >= 0) & bool(cells), last, len(cells))].astype(np.float32)

        if table.kind is FingertipState:
            none = np.zeros(len(frames.stamps), np.float32)
            wrench = [sampled(name) if name else none for name in WRENCH]
            found[f"{TOUCH}{finger}.wrench"] = np.stack(wrench, axis=1)
            for name in (CHANNELS.keys() - set(WRENCH)) & names.keys():
                found[f"{TOUCH}{finger}.{name}"] = sampled(name)
        for feature, column in SAID.get(table.kind, {}).items():
            found[f"{TOUCH}{finger}.{feature}"] = sampled(column)
    return dict(sorted(found.items()))


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


def read_touch(path: Path, radius: float = math.nan) -> dict[str, Recording]:
    """Return the recordings of all fingers of a data set of LeRobot, or of the one in a ``.npz`` file.

    Args:
        path: folder of the data set, or a ``.npz`` with the names of the Open-Tactile-Schema.
        radius: of the fingertips [m], where the data set does not say it.

    Raises:
        RecordingError: another layout, damaged, or without touch; names what was looked for.
        UsageError: pyarrow is not installed.

    """
    columns, radii = _read_npz(path) if path.suffix.lower() == ".npz" else _read_set(path)
    t, episode = _times(path, columns)
    fingers = _by_finger(path, columns)
    found = {}
    for finger, channels in fingers.items():
        tip = Fingertip(radius if math.isfinite(radius) else radii.get(finger, math.nan), name=finger)
        source: dict[str, str | bool] = {"file": path.name, "recovered": True}
        found[finger] = Recording(f"{path.stem}-{finger}", t, episode, channels, tip, source=source)
        report = found[finger].report
        report.rows_read = report.rows_kept = len(t)
    return found


def _read_npz(path: Path) -> tuple[dict[str, Any], dict[str, float]]:
    with reading(path, RecordingError):
        try:
            with path.open("rb") as stream, np.load(stream) as file:
                named = {re.split(r"[/.]", name)[-1]: file[name] for name in file.files}
        except (ValueError, EOFError, zipfile.BadZipFile) as error:
            raise RecordingError(f"{path}: is no .npz file of plain numbers ({error})") from None
    columns = {TOUCH + name: named[name] for name in OPEN_KEYS if name in named}
    return columns | {"timestamp": columns.pop(f"{TOUCH}timestamps", np.zeros(0))}, {}


def _read_set(path: Path) -> tuple[dict[str, Any], dict[str, float]]:
    pa, pq = _arrow("pyarrow"), _arrow("pyarrow.parquet")
    with reading(path, RecordingError):
        try:
            info = json.loads((path / "meta" / "info.json").read_text(encoding="utf-8"))
            version = str(info["codebase_version"])
            about = path / "meta" / "vegrip.json"
            radii = json.loads(about.read_text(encoding="utf-8"))["radius_m"] if about.exists() else {}
        except (ValueError, LookupError, TypeError) as error:
            raise RecordingError(f"{path}: meta/info.json is damaged ({error})") from None
        if not version.startswith("v3."):
            raise RecordingError(
                f"{path}: has layout {version}; convert it to {SET_LAYOUT} with LeRobot's program"
            )
        files = sorted((path / "data").glob("chunk-*/file-*.parquet"))
        if not files:
            raise RecordingError(f"{path}: there is no data/chunk-*/file-*.parquet")
        try:
            table = pa.concat_tables([pq.read_table(file) for file in files])
            names = [n for n in table.column_names if n.startswith((TOUCH, "observation.wrench"))]
            names += {"timestamp", "episode_index"} & set(table.column_names)
            columns = {name: np.array(table[name].to_pylist()) for name in names}
        except (pa.ArrowException, ValueError) as error:
            raise RecordingError(f"{path}: data cannot be read ({str(error).splitlines()[0]})") from None
    return columns, radii


def _times(path: Path, columns: Mapping[str, Any]) -> tuple[Floats, NDArray[np.int64]]:
    """Return the time of every row [s], which increases over the episodes, and its episode."""
    t = np.asarray(columns.get("timestamp", ()), dtype=np.float64)
    episode = np.asarray(columns.get("episode_index", np.zeros(len(t))), dtype=np.int64)
    if not len(t) or len(episode) != len(t) or t.ndim != 1:
        raise RecordingError(f"{path}: there are no times; timestamp (or timestamps) is needed, in s")
    begins = np.flatnonzero(np.diff(episode, prepend=episode[:1] - 1))
    offset, at = np.zeros(len(t)), 0.0
    for begin, end in zip(begins, [*begins[1:], len(t)], strict=True):
        offset[begin:end] = at - t[begin]
        at += t[end - 1] - t[begin] + PAUSE_S
    return np.round(t + offset, 6), episode  # LeRobot's times are float32


def _by_finger(path: Path, columns: Mapping[str, Any]) -> dict[str, dict[str, Floats]]:
    found: dict[str, dict[str, Floats]] = {}
    for key, values in columns.items():
        finger, _, name = key.removeprefix(TOUCH).partition(".")
        if key.startswith(TOUCH) and name == "wrench" and np.ndim(values) == 2 and values.shape[1] == 6:
            found[finger] = _of_wrench(values)
    for key, values in columns.items():
        finger, _, name = key.removeprefix(TOUCH).partition(".")
        if finger in found and name in CHANNELS:
            found[finger][name] = np.asarray(values, dtype=np.float64)
    if found:
        return found
    normal, shear = (columns.get(f"{TOUCH}{name}") for name in ("normal_force", "shear_force"))
    wrench = columns.get(f"{TOUCH}wrench", columns.get("observation.wrench"))
    if normal is not None and np.ndim(normal) == 2:
        channels = {"normal_force": normal.sum(axis=1, dtype=np.float64)}
        if shear is not None and np.ndim(shear) == 3 and shear.shape[2] == 2:
            x, y = shear.sum(axis=1, dtype=np.float64).T
            channels |= {"tangential_force_x": x, "tangential_force_y": y}
        return {"finger": channels}
    if wrench is not None and np.ndim(wrench) == 2 and wrench.shape[1] == 6:
        return {"finger": _of_wrench(wrench)}
    sought = f"{TOUCH}FINGER.wrench (T, 6), {TOUCH}normal_force (T, N) or observation.wrench (T, 6)"
    raise RecordingError(f"{path}: there is no touch; looked for {sought}")


def _of_wrench(values: Any) -> dict[str, Floats]:
    columns = zip(WRENCH, np.asarray(values, dtype=np.float64).T, strict=True)
    return {name: column for name, column in columns if name and np.isfinite(column).any()}
