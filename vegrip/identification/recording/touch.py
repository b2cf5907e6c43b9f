"""Touch data of others: data sets of LeRobot (v2 and v3), HDF5 and ``.npz``, as a recording of each finger.

Without a map a fingertip is found by names of LeRobot or of the Open-Tactile-Schema
(EltonChang1/tactile-data-toolkit at 153048f), each a row a frame::

    observation.tactile.thumb.wrench    (T, 6) fx, fy, fz [N], tx, ty, tz [N m]; observation.wrench too
    observation.tactile.normal_force    (T, N) of N elements, whose sum is the force of the fingertip
    observation.tactile.shear_force     (T, N, 2)
    observation.tactile.thumb.slip      (T,) and other channels of a recording
    timestamp  episode_index            [s] and number; ``timestamps`` in HDF5 and .npz

``/observation/tactile/normal_force``, ``normal_force`` and ``thumb/normal_force`` mean the same. A map says
what any other column is: ``normal_force=observation.state[6]``, or ``.fz`` where the set names its axes.
"""

import dataclasses
import json
import math
import re
import zipfile
import zlib
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from vegrip.errors import RecordingError
from vegrip.identification.recording.channels import CHANNELS
from vegrip.identification.recording.checks import MAX_SAMPLE_PERIOD_S, MIN_SAMPLE_PERIOD_S
from vegrip.identification.recording.column_map import (
    ChannelMap,
    ColumnMap,
    EpisodeMap,
    header_units,
    own_columns,
)
from vegrip.identification.recording.data import Fingertip, Recording
from vegrip.identification.recording.extras import extra_library
from vegrip.identification.recording.import_csv import recording_of
from vegrip.identification.recording.report import Kind, LoadReport
from vegrip.identification.recording.table import Table
from vegrip.identification.recording.units import to_si
from vegrip.identification.recording.writer import folder_name
from vegrip.types import Floats

TOUCH: Final = "observation.tactile."
WRENCH: Final = ("tangential_force_x", "tangential_force_y", "normal_force", "", "", "torque_z")
SCHEMA_NAMES: Final = ("normal_force", "shear_force", "wrench")
TIME, EPISODE = "timestamp", "episode_index"
HDF5: Final = (".h5", ".hdf5")
WHOLE: Final = re.compile(r"(.+?)((?:\[\d{1,9}\])*)")
OFF_RATE: Final = 2.0  # times the period of ``info.json`` or less, by which rows may come (origin: rule)
MOST_SHOWN: Final = 12  # columns in a sentence
BROKEN: Final = (
    *(OSError, ValueError, LookupError, TypeError, AttributeError, RuntimeError, MemoryError),
    *(OverflowError, EOFError, SyntaxError, zlib.error, zipfile.BadZipFile),
)
"""What numpy, h5py and pyarrow raise on damaged bytes."""

Wanted = Callable[[str], bool]
"""Whether a column is to be read; images are not."""


@dataclass
class Frames:
    """What a file holds, a row a frame."""

    columns: dict[str, Any] = field(default_factory=dict)  # name -> (T, ...)
    there: dict[str, str] = field(default_factory=dict)  # name of every column -> its shape, in words
    axes: dict[str, list[str]] = field(default_factory=dict)  # names of the last dimension
    radii: dict[str, float] = field(default_factory=dict)  # [m] by finger
    rate: float = math.nan  # [1/s] as the file says
    said: int = 0  # frames that the file says it has


def is_touch(path: Path) -> bool:
    """Return whether ``path`` is touch data by its name, or a folder that is laid out as a data set."""
    if path.is_dir():
        return (
            _is_zarr(path)
            or (path / "meta" / "info.json").is_file()
            or all((path / one).is_dir() for one in ("meta", "data"))
        )
    return path.suffix.lower() in (".npz", *HDF5)


def _is_zarr(path: Path) -> bool:
    return path.suffix.lower() == ".zarr" or any((path / one).is_file() for one in ("zarr.json", ".zgroup"))


def read_touch(path: Path, chart: ColumnMap, *, radius: float = math.nan) -> dict[str, Recording]:
    """Return the recording of every finger in ``path``; of one, where ``chart`` says what the columns are.

    Args:
        path: folder of a data set of LeRobot, or an ``.npz`` or HDF5 file.
        chart: of columns and units; without channels they are found by their names.
        radius: of the fingertips [m], where the data set does not say it.

    Raises:
        RecordingError: another layout, damaged, or without touch; names what is there.
        UsageError: pyarrow or h5py is not installed.

    """
    columns_said = (*(one.column for one in chart.channels.values()), chart.time.column, chart.episode.column)
    keys = {_plain(column) for column in columns_said}

    def wanted(name: str) -> bool:
        is_known = name.startswith((TOUCH, "observation.wrench")) or name in (TIME, EPISODE, *CHANNELS)
        return is_known or any(key == name or key.startswith((f"{name}.", f"{name}[")) for key in keys)

    frames = _read(path, wanted)
    fingers = {} if chart.channels else _by_finger(path, frames)
    if fingers:
        unused = frames.columns.keys() - {TIME, EPISODE}.union(*(used for _, used in fingers.values()))
        return {
            finger: _recording(path, frames, chart, channels, radius, finger, unused)
            for finger, (channels, _) in fingers.items()
        }
    if not chart.channels and not (chart := own_columns(chart, list(frames.columns))).channels:
        there = [f"{name} {shape}".strip() for name, shape in frames.there.items()]
        more = f" and {len(there) - MOST_SHOWN} more" if len(there) > MOST_SHOWN else ""
        raise RecordingError(
            f"{path}: there is no touch by its name; say which column is what, as in --map "
            f"normal_force=observation.state[6]; there are {', '.join(there[:MOST_SHOWN])}{more}"
        )
    chart, units = header_units(chart)
    columns = {name: _picked(path, frames, one.column) for name, one in chart.channels.items()}
    finger = chart.fingertip.name
    return {finger: _recording(path, frames, chart, columns, radius, finger, units=units)}


def _plain(name: str) -> str:
    """Return a name as those of the columns are: ``/observation/x`` is ``observation.x``."""
    return name.strip("/").replace("/", ".")


def _named(name: str) -> str:
    """Return under which name a column of HDF5 or ``.npz`` goes."""
    name = _plain(name)
    place, _, last = name.rpartition(".")
    last = last.removeprefix("tactile_")  # as tactile-data-toolkit shortens its paths in HDF5
    if last in (TIME, "timestamps"):
        return TIME if place in ("", "observation", "observation.tactile") else name
    if last in (*SCHEMA_NAMES, *CHANNELS) and not name.startswith("observation."):
        return TOUCH + (f"{place}." if place not in ("", "obs") else "") + last
    return name


def _key(frames: Frames, name: str) -> str:
    """Return the column that a map calls ``name``, as it is called here or in the file."""
    plain = _plain(name)
    return plain if plain in frames.columns else _named(plain)


def _read(path: Path, wanted: Wanted) -> Frames:
    if _is_zarr(path):
        raise RecordingError(
            f"{path}: is Zarr, which is not read; write its arrays with numpy.savez, or as HDF5"
        )
    if not path.exists():
        raise RecordingError(f"{path}: there is no such file")
    read = _read_set if path.is_dir() else _read_npz if path.suffix.lower() == ".npz" else _read_hdf5
    frames = read(path, wanted)
    for name, values in frames.columns.items():
        if values.dtype.kind not in "biuf":
            kind = "complex" if values.dtype.kind == "c" else f"of the kind {values.dtype}"
            raise RecordingError(f"{path}: {name} is {kind}, and no plain number")
    return frames


def _first_line(error: BaseException) -> str:
    return next(iter(str(error).splitlines()), "") or type(error).__name__


def _add(path: Path, frames: Frames, name: str, key: str, values: Any, wanted: Wanted) -> None:
    if name in frames.there:
        raise RecordingError(f"{path}: {key} is there twice under names that mean the same")
    frames.there[name] = _shape(values.shape)
    if wanted(name):
        frames.columns[name] = np.asarray(values[()])


def _shape(shape: Sequence[int]) -> str:
    return f"({', '.join(map(str, shape[1:]))})" if len(shape) > 1 else ""


def _read_npz(path: Path, wanted: Wanted) -> Frames:
    frames = Frames()
    try:
        with path.open("rb") as stream, np.load(stream) as file:
            for key in file.files:
                _add(path, frames, _named(key), key, file[key], wanted)
    except BROKEN as error:
        raise RecordingError(f"{path}: is no .npz file of plain numbers ({_first_line(error)})") from None
    return frames


def _read_hdf5(path: Path, wanted: Wanted) -> Frames:
    """Read all arrays, or those of every ``data/demo_N``, which are episodes."""
    h5py = extra_library("h5py", "hdf5")
    try:
        with h5py.File(path) as file:
            data = file.get("data")
            is_demos = isinstance(data, h5py.Group) and "demo_0" in data
            demos = [data[name] for name in sorted(data, key=_numbered)] if is_demos else [file]
            parts = [_read_demo(path, h5py, demo, wanted) for demo in demos]
    except BROKEN as error:
        raise RecordingError(f"{path}: is no HDF5 file that can be read ({_first_line(error)})") from None
    first = parts[0]
    lengths = [len(next(iter(part.columns.values()), ())) for part in parts]
    for part in parts[1:]:
        if part.columns.keys() != first.columns.keys():
            lacking = ", ".join(sorted(part.columns.keys() ^ first.columns.keys()))
            raise RecordingError(f"{path}: only some of its episodes have {lacking}")
    joined = {name: np.concatenate([part.columns[name] for part in parts]) for name in first.columns}
    episodes = {EPISODE: np.repeat(np.arange(len(parts)), lengths)} if is_demos else {}
    return dataclasses.replace(first, columns=episodes | joined)


def _read_demo(path: Path, h5py: Any, group: Any, wanted: Wanted) -> Frames:
    frames = Frames()

    def visit(key: str, one: Any) -> None:
        if isinstance(one, h5py.Dataset) and one.ndim:
            _add(path, frames, _named(str(one.attrs.get("schema_path", key))), key, one, wanted)

    group.visititems(visit)
    return frames


def _numbered(name: object) -> list[object]:
    """Return a key that sorts ``demo_10`` behind ``demo_9``."""
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", str(name))]


def _read_set(path: Path, wanted: Wanted) -> Frames:
    pa = extra_library("pyarrow", "lerobot")
    pq = extra_library("pyarrow.parquet", "lerobot")
    try:
        info = json.loads((path / "meta" / "info.json").read_text(encoding="utf-8"))
        version, features = str(info["codebase_version"]), info.get("features", {})
        rate, said = float(info.get("fps", "nan")), int(info.get("total_frames", 0))
        axes = {name: _axes(one.get("names")) for name, one in features.items()}
        about = path / "meta" / "vegrip.json"
        radii = json.loads(about.read_text(encoding="utf-8"))["radius_m"] if about.exists() else {}
    except FileNotFoundError:
        raise RecordingError(f"{path}: looks like a data set of LeRobot, and lacks meta/info.json") from None
    except BROKEN as error:
        raise RecordingError(f"{path}: meta/info.json is damaged ({_first_line(error)})") from None
    if not version.startswith(("v2.", "v3.")):
        raise RecordingError(f"{path}: has layout {version}; v2 and v3 are read, convert it with LeRobot")
    files = sorted((path / "data").rglob("*.parquet"), key=_numbered)
    if not files:
        raise RecordingError(f"{path}: there is no data/chunk-*/*.parquet")
    parts = []
    for file in files:
        try:
            names = [name for name in pq.read_schema(file).names if wanted(name)]
            parts.append(pq.read_table(file, columns=names))
            there = {one.name: one.type for one in pq.read_schema(file)}
        except (pa.ArrowException, *BROKEN) as error:
            raise RecordingError(f"{file}: cannot be read ({_first_line(error)})") from None
    if any(part.column_names != parts[0].column_names for part in parts):
        raise RecordingError(f"{path}: not all of its {len(files)} files of data have the same columns")
    try:
        table = pa.concat_tables(parts, promote_options="permissive")
    except pa.ArrowException as error:
        raise RecordingError(f"{path}: its files of data do not fit ({_first_line(error)})") from None
    if table.column_names and not table.num_rows:
        raise RecordingError(f"{path}: there is no row in its {len(files)} files of data")
    columns = {name: _values(path, name, table[name], pa) for name in table.column_names}
    shapes = {name: _shape((0, *_list(features.get(name, {}).get("shape")))) for name in there}
    return Frames(columns, shapes, axes, radii, rate, said)


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) and value != [1] else []


def _axes(names: Any) -> list[str]:
    """Return the names of an array's elements: a list, or a dict of one list."""
    if isinstance(names, Mapping):
        names = next(iter(names.values()), None)
    return [str(one) for one in names] if isinstance(names, list) else []


def _values(path: Path, name: str, column: Any, pa: Any) -> Any:
    if not (pa.types.is_list(column.type) or pa.types.is_fixed_size_list(column.type)):
        return column.to_numpy()
    try:
        return np.array(column.to_pylist())
    except ValueError:
        raise RecordingError(f"{path}: {name} has not as many numbers in every row") from None


Found = tuple[dict[str, Any], set[str]]
"""Channels of a finger, and the columns that they are of."""


def _by_finger(path: Path, frames: Frames) -> dict[str, Found]:
    groups: dict[str, dict[str, str]] = {}
    for key in frames.columns:
        if key.startswith(TOUCH):
            finger, _, name = key.removeprefix(TOUCH).rpartition(".")
            groups.setdefault(folder_name(finger or "finger"), {})[name] = key
    if "observation.wrench" in frames.columns and not groups.get("finger", {}).keys() & {*SCHEMA_NAMES}:
        groups.setdefault("finger", {})["wrench"] = "observation.wrench"
    found = {finger: _channels(path, names, frames.columns) for finger, names in groups.items()}
    return {finger: one for finger, one in found.items() if "normal_force" in one[0]}


def _channels(path: Path, names: Mapping[str, str], columns: Mapping[str, Any]) -> Found:
    found: dict[str, Any] = {}
    used = {names[name] for name in names if name in SCHEMA_NAMES or name in CHANNELS}
    if "wrench" in names:
        wrench = _shaped(path, names["wrench"], columns, 2, 6)
        each = zip(WRENCH, wrench.T, strict=True)
        found = {name: column for name, column in each if name and np.isfinite(column).any()}
    elif "normal_force" in names:
        normal = _shaped(path, names["normal_force"], columns, min(columns[names["normal_force"]].ndim, 2))
        found = {"normal_force": normal if normal.ndim == 1 else normal.sum(axis=1)}
        if "shear_force" in names:
            shear = _shaped(path, names["shear_force"], columns, 1 + normal.ndim, 2)
            both = shear if shear.ndim == 2 else shear.sum(axis=1)
            found |= {"tangential_force_x": both[:, 0], "tangential_force_y": both[:, 1]}
    for name in names.keys() & CHANNELS.keys() - found.keys():
        found[name] = _shaped(path, names[name], columns, 1)
    return found, used


def _shaped(path: Path, key: str, columns: Mapping[str, Any], ndim: int, last: int = 0) -> Floats:
    values = columns[key]
    if values.ndim != ndim or (last and values.shape[-1] != last):
        wanted = {1: "(T,)", 2: f"(T, {last or 'N'})", 3: f"(T, N, {last})"}[ndim]
        shape = f"({', '.join(map(str, values.shape))})"
        raise RecordingError(f"{path}: {key} has the shape {shape}; {wanted} is needed")
    return np.asarray(values, dtype=np.float64)


def _picked(path: Path, frames: Frames, column: str) -> Floats:
    """Return the column that ``column`` names: ``observation.state[6]``, ``observation.force.fz``."""
    match = WHOLE.fullmatch(_plain(column))
    key, index = (_key(frames, match[1]), match[2]) if match else (column, "")
    at = [int(one) for one in re.findall(r"\d+", index)]
    if key not in frames.columns:
        base, _, name = key.rpartition(".")
        if base not in frames.columns or name not in frames.axes.get(base, ()):
            there = ", ".join(list(frames.there)[:MOST_SHOWN])
            raise RecordingError(f"{path}: there is no column {column!r}; there are {there}")
        key, at = base, [frames.axes[base].index(name), *at]
    values = frames.columns[key]
    if len(at) != values.ndim - 1 or any(i >= n for i, n in zip(at, values.shape[1:], strict=True)):
        last = "".join(f"[{n - 1}]" for n in values.shape[1:])
        first = "[0]" * (values.ndim - 1)
        say = f"say which number, {first} to {last}" if first else "leave the index away"
        raise RecordingError(f"{path}: {key} has {_shape(values.shape) or 'a number'} in a row; {say}")
    return np.asarray(values[(slice(None), *at)], dtype=np.float64)


def _recording(
    path: Path,
    frames: Frames,
    chart: ColumnMap,
    columns: Mapping[str, Floats],
    radius: float,
    finger: str,
    unused: Collection[str] = (),
    units: Sequence[str] = (),
) -> Recording:
    """Return the recording of ``columns`` (T,), in the units of ``chart``."""
    name = _key(frames, chart.time.column) if chart.time.column != "t" else TIME
    t = frames.columns.get(name)
    asked = chart.episode.column
    episode = _picked(path, frames, asked) if asked else frames.columns.get(EPISODE)
    if t is None or t.ndim != 1 or not len(t):
        raise RecordingError(
            f"{path}: there are no times; {TIME} (or timestamps) is needed, in s, or --map t=COLUMN"
        )
    lengths = {len(t), *map(len, columns.values()), *([] if episode is None else [len(episode)])}
    if len(lengths) > 1:
        counts = ", ".join(f"{key} {len(one)}" for key, one in ({name: t} | dict(columns)).items())
        raise RecordingError(f"{path}: the columns differ in length: {counts}")
    report = LoadReport(rows_read=max(len(t), frames.said), place="row")
    if frames.said > len(t):
        said = f"meta/info.json says {frames.said} frames, {len(t)} are there"
        report.add(Kind.UNSEEN, said, count=frames.said - len(t))
    for key in sorted(unused):
        report.add(Kind.COLUMN, key)
    if units:
        report.add(Kind.NOTE, f"units taken from the names of the columns: {', '.join(units)}")
    seconds = np.round(t.astype(np.float64), 6)  # LeRobot's times are float32
    _suspect_unit(seconds, episode, chart.time.unit, frames.rate, report)
    own = {one: ChannelMap(one) for one in columns} | dict(chart.channels)
    own = {one: dataclasses.replace(entry, column=one) for one, entry in own.items()}
    tip = radius if math.isfinite(radius) else frames.radii.get(finger, chart.fingertip.radius)
    chart = dataclasses.replace(
        chart,
        channels=own,
        time=dataclasses.replace(chart.time, column="t"),
        episode=EpisodeMap("" if episode is None else EPISODE, chart.episode.gap),
        fingertip=Fingertip(tip, name=finger),
    )
    words = {} if episode is None else {EPISODE: [f"{one:.15g}" for one in episode.tolist()]}
    lines: NDArray[np.int64] = np.arange(len(t), dtype=np.int64)
    table = Table({"t": seconds, **columns}, words, lines)
    found = recording_of(path, table, chart, report, tip)
    return dataclasses.replace(found, name=f"{path.stem}-{finger}")


def _suspect_unit(
    t: Floats, episode: NDArray[Any] | None, unit: str, rate: float, report: LoadReport
) -> None:
    """Report where the times advance otherwise than seconds do."""
    same = np.diff(episode) == 0 if episode is not None else np.ones(max(len(t) - 1, 0), dtype=bool)
    steps = np.diff(t)[same] * to_si(unit, "s", TIME)[0]
    step = float(np.nanmedian(steps)) if np.isfinite(steps).any() else math.nan
    if step > 0.0 and rate > 0.0 and not 1.0 / OFF_RATE <= step * rate <= OFF_RATE:
        says = f", where meta/info.json says {rate:g} frames a second"
    elif step > 0.0 and not MIN_SAMPLE_PERIOD_S <= step <= MAX_SAMPLE_PERIOD_S:
        says = ""
    else:
        return
    if not unit:
        said = f"the time advances by {step:.4g} s a row{says}; say its unit, as in --unit t=ms"
        report.add(Kind.AMBIGUOUS, said)
