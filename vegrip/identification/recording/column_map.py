"""Column maps: how a table from elsewhere becomes a recording, as a small TOML file.

::

    [table]                       # all optional
    delimiter = ","
    [time]
    column = "time_s"
    [channels.normal_force]
    column = "force_mN"
    unit = "mN"
    zero = "baseline"             # mean of the first [baseline] duration is zero
    [channels.displacement]
    column = "height_nm"          # falls while pressing
    unit = "nm"
    scale = -1
    compliance = 16.4             # [m/N] of the cantilever: its bending is not indentation
    zero = "contact"              # at the last rise of the force through the threshold before its peak
    [baseline]
    duration = 1.0
    [contact]
    threshold = 2e-9
    [fingertip]
    radius = 18.64e-6             # leave out when unknown

In the map of a rosbag a column is ``/topic:field.of.the.message``, and ``[bag]`` says whose time it has.
"""

import contextlib
import dataclasses
import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any

from vegrip.config import build, parameter, read_toml, replace
from vegrip.errors import ConfigError, RecordingError, UsageError, suggestion
from vegrip.identification.recording.channels import IMPORTED, STEP_QUANTITIES
from vegrip.identification.recording.data import Fingertip
from vegrip.identification.recording.units import to_si

AT_END = re.compile(r"_([A-Za-zµ°]+)$")
TWO_AT_END = re.compile(r"_([A-Za-zµ°]+[/_][A-Za-zµ°]+)$")  # mm/s, mm_s
CALLED = {"time": "t"}
WEIGHTS = {"g": "gf", "kg": "kgf"}
"""Masses that stand for forces."""
IN_BRACKETS = re.compile(r"[\[(]\s*([^\[\]()]+?)\s*[\])]$")


@dataclass(frozen=True)
class ChannelMap:
    """Where one channel comes from: ``SI(column) * scale + offset``, then compliance, then zero."""

    column: str = parameter(doc="name of the column in the table")
    unit: str = parameter("", doc="unit of the column; left out: that in brackets in its name, else SI")
    scale: float = parameter(1.0, unit="1", doc="factor, -1 turns the sign")
    offset: float = parameter(0.0, doc="added after the conversion, in SI")
    zero: str = parameter(
        "none", choices=("none", "first", "baseline", "contact"), doc="what is subtracted, trial by trial"
    )
    compliance: float = parameter(0.0, unit="m/N", low=0.0, doc="displacement only: what gives way in series")
    noise: float = parameter(0.0, low=0.0, doc="standard deviation, SI; 0: measured in the baseline if any")


@dataclass(frozen=True)
class TimeMap:
    """The column of the time."""

    column: str = parameter("t", doc="name of the column")
    unit: str = parameter("", doc="unit; left out: that in brackets in its name, else seconds")
    spread: bool = parameter(False, doc="rows of one time stamp are spread evenly until the next")


@dataclass(frozen=True)
class EpisodeMap:
    """The column that separates the trials; any text, numbered in order of appearance."""

    column: str = parameter("", doc="name of the column; empty: all is one trial")
    gap: float = parameter(5.0, unit="s", low=0.0, doc="put between trials whose time begins anew")


@dataclass(frozen=True)
class BaselineMap:
    """The stretch without contact at the start of every trial."""

    duration: float = parameter(0.0, unit="s", low=0.0, doc="its length")


@dataclass(frozen=True)
class ContactMap:
    """The force at which contact begins."""

    threshold: float = parameter(
        0.0, unit="N", low=0.0, doc="normal force of first contact; 0: five times the noise of the baseline"
    )


@dataclass(frozen=True)
class TableMap:
    """The form of the table."""

    delimiter: str = parameter("", doc="between fields; empty: found")
    decimal: str = parameter("", choices=("", ".", ","), doc="decimal sign; empty: found")
    skip: int = parameter(-1, low=-1, doc="lines before the header; -1: found")
    section: str = parameter(
        "", doc="the line above each table, in a file of several; their number is the column `section`"
    )
    thousands: str = parameter("", doc="between thousands; empty: what can be nothing else; none: nothing")


@dataclass(frozen=True)
class BagMap:
    """The rule by which several topics of a rosbag become rows."""

    time: str = parameter("", doc="topic whose messages make the rows; may be left out when there is one")
    stamp: str = parameter("header", choices=("header", "receive"), doc="whose clock; no header: receive")
    largest_age: float = parameter(
        0.0, unit="s", low=0.0, high=1e9, doc="how long a value of another topic is held; older is missing"
    )
    frame: str = parameter("", doc="frame_id of the messages to take, where a topic has several")
    definitions: str = parameter("", doc="ROS release whose types a bag without definitions has: ros2_humble")


@dataclass(frozen=True)
class ColumnMap:
    """The whole map."""

    channels: Mapping[str, ChannelMap] = field(default_factory=dict)
    time: TimeMap = field(default_factory=TimeMap)
    episode: EpisodeMap = field(default_factory=EpisodeMap)
    baseline: BaselineMap = field(default_factory=BaselineMap)
    contact: ContactMap = field(default_factory=ContactMap)
    table: TableMap = field(default_factory=TableMap)
    fingertip: Fingertip = field(default_factory=Fingertip)
    bag: BagMap = field(default_factory=BagMap)
    name: str = ""  # of the file it was read from


SECTIONS: dict[str, Any] = {
    f.name: f.default_factory for f in dataclasses.fields(ColumnMap) if f.name not in ("channels", "name")
}


def read_column_map(path: Path | str) -> ColumnMap:
    """Read a map; a key, type or value that cannot be right raises :class:`RecordingError`."""
    path = Path(path)
    try:
        return _built(read_toml(path), path)
    except ConfigError as error:
        raise RecordingError(str(error)) from None


def with_columns(
    base: ColumnMap,
    columns: Sequence[str],
    units: Sequence[str],
    negated: Sequence[str] = (),
    zeros: Sequence[str] = (),
) -> ColumnMap:
    """Return ``base`` with what the command line says: ``normal_force=force_N``, ``displacement=mm``.

    The sign of the channels in ``negated`` is turned; ``zeros`` are like ``displacement=contact``.
    """
    for name, column in map(_pair, columns):
        base = _changed(base, name, "column", column)
    for key, pairs in (("unit", units), ("zero", zeros)):
        for name, value in map(_pair, pairs):
            if name == "episode" or (name == "t" and key == "zero"):
                raise UsageError(f"--{key} {name}={value}: {name} has no {key}")
            base = _changed(base, name, key, value)
    for name in negated:
        if name not in IMPORTED:
            raise UsageError(f"there is no channel {name!r}; {suggestion(name, IMPORTED)}")
        entry = base.channels.get(name, ChannelMap(name))
        turned = dataclasses.replace(entry, scale=-entry.scale)
        base = dataclasses.replace(base, channels={**base.channels, name: turned})
    return base


def own_columns(base: ColumnMap, header: Sequence[str]) -> ColumnMap:
    """Return ``base`` with every column taken as what it is called, unless it says otherwise.

    Behind its name may stand a unit, as in ``normal_force [mN]``, ``slip_speed_mm_s`` or ``time_s``.
    """
    said = {base.time.column, base.episode.column, *(entry.column for entry in base.channels.values())}
    for name in header:
        if name in IMPORTED and name not in base.channels and name not in said:
            base = _changed(base, name, "column", name)
    for name in header:
        for pattern in (IN_BRACKETS, TWO_AT_END, AT_END):
            if (unit := pattern.search(name)) is None or name in said:
                continue
            called = CALLED.get(name[: unit.start()].strip(), name[: unit.start()].strip())
            is_free = base.time.column == "t" not in header if called == "t" else called not in base.channels
            if (called == "t" or called in IMPORTED) and is_free and _is_unit(unit[1], called):
                base = _changed(base, called, "column", name)
    if not base.episode.column and "episode" in header and "episode" not in said:
        base = _changed(base, "episode", "column", "episode")
    return base


def step_columns(base: ColumnMap, header: Sequence[str]) -> ColumnMap:
    """Return ``base`` with the columns of a unit step as they are called: time, modulus or compliance."""
    said = {base.time.column, *(entry.column for entry in base.channels.values())}
    for name in header:
        words = name.lower()
        for step in STEP_QUANTITIES:
            if step in words and name not in said and not STEP_QUANTITIES.keys() & base.channels.keys():
                base = _changed(base, step, "column", name)
        if words.startswith("time") and base.time.column == "t" not in header:
            base = _changed(base, "t", "column", name)
    return base


def header_units(base: ColumnMap) -> tuple[ColumnMap, list[str]]:
    """Return ``base`` with the units that columns have in their names, and which.

    As in ``Force [mN]`` or, behind the name of the channel, ``normal_force_mN``. A column of which a unit or
    a scale is said keeps that.
    """
    found = []
    ends = [one for one in _named_units(base, TWO_AT_END, AT_END) if one[2] and _is_called(base, one[0])]
    for name, unit, _ in [*_named_units(base, IN_BRACKETS), *ends]:
        base = _changed(base, name, "unit", unit)
        found.append(f"{name} in {unit}")
    return base, found


def row_units(
    base: ColumnMap, header: Sequence[str], cells: Sequence[str], path: Path
) -> tuple[ColumnMap, list[str]]:
    """Return ``base`` with the units that stand below the names of the columns, and what to say of them.

    Raises:
        RecordingError: what stands there is no unit of the channel, and none was said.

    """
    found, below = [], dict(zip(header, cells, strict=False))
    entries: dict[str, TimeMap | ChannelMap] = {"t": base.time, **base.channels}
    for name, entry in entries.items():
        unit = _spoken(below.get(entry.column, "").strip("[](){}<> "), name)
        if unit in ("", "-", "/", "1") and not _si(name):
            continue
        scale = None
        with contextlib.suppress(RecordingError):
            scale = to_si(unit, _si(name), name)
        if unit and not entry.unit and scale is None:
            raise RecordingError(
                f"{path}: the line below the header says that {entry.column!r} is in {unit!r}, which is no "
                f"unit of {name} that is known; say it with --unit {name}=UNIT"
            )
        if unit and not entry.unit:
            base = _changed(base, name, "unit", unit)
            found.append(f"{name} in {unit}")
        elif unit and scale is not None and scale != to_si(entry.unit, _si(name), name):
            found.append(f"{name} in {entry.unit} as said, not in {unit}")
    return base, found


def suspect_units(base: ColumnMap) -> Iterator[str]:
    """Yield which columns are taken as SI although their names end like a unit, as ``force_g``."""
    for name, unit, is_other in _named_units(base, TWO_AT_END, AT_END):
        if is_other:
            column = (base.time if name == "t" else base.channels[name]).column
            yield (
                f"the column {column!r} is taken in {_si(name)}, and ends like a unit; if its numbers are in "
                f"it, import with --unit {name}={unit}"
            )


def _named_units(base: ColumnMap, *patterns: re.Pattern[str]) -> Iterator[tuple[str, str, bool]]:
    """Yield channel, unit and whether that is not SI, of columns that name a unit where none is said."""
    entries: dict[str, TimeMap | ChannelMap] = {"t": base.time, **base.channels}
    for (name, entry), pattern in product(entries.items(), patterns):
        match = pattern.search(entry.column)
        if match and not entry.unit and abs(getattr(entry, "scale", 1.0)) == 1.0:
            unit = _spoken(match[1], name)
            with contextlib.suppress(RecordingError):  # a remark
                yield name, unit, to_si(unit, _si(name), name) != (1.0, 0.0)


def unread_force(base: ColumnMap, unused: Sequence[str]) -> str:
    """Return a sentence for the first unused column in a unit of force, where there is no normal force."""
    units = ((name, pattern.search(name)) for name in unused for pattern in (IN_BRACKETS, AT_END))
    forces = [name for name, unit in units if unit and _is_unit(unit[1], "normal_force")]
    if not forces or "displacement" not in base.channels or "normal_force" in base.channels:
        return ""
    option = shlex.quote(f"normal_force={forces[0]}")
    return f"no column is normal_force; if it is {forces[0]!r}, import with --map {option}"


def _is_called(base: ColumnMap, name: str) -> bool:
    """Whether the column of a channel is called like it, but for a unit."""
    column = (base.time if name == "t" else base.channels[name]).column
    called = [pattern.sub("", column) for pattern in (TWO_AT_END, AT_END)]
    return name in [CALLED.get(one, one) for one in called]


def _is_unit(unit: str, name: str) -> bool:
    with contextlib.suppress(RecordingError):
        to_si(_spoken(unit, name), _si(name), name)
        return True
    return False


def _spoken(unit: str, name: str) -> str:
    if "/" in _si(name):
        return unit.replace("_", "/")
    return WEIGHTS.get(unit, unit) if _si(name) == "N" else unit


def _si(name: str) -> str:
    return IMPORTED[name].unit if name in IMPORTED else "s"


def _built(table: Mapping[str, Any], path: Path) -> ColumnMap:
    for key in table:
        if key != "channels" and key not in SECTIONS:
            raise ConfigError(
                f"{path}: unknown section [{key}]; {suggestion(key, ['channels', *SECTIONS], 'known are')}"
            )
    for key, section in table.items():
        if not isinstance(section, Mapping):
            raise ConfigError(f"{path}: {key!r} must be a table, [{key}]")
    channels = {}
    for name, entry in table.get("channels", {}).items():
        where = f"{path} [channels.{name}]"
        if name not in IMPORTED:
            raise ConfigError(f"{where}: there is no such channel; {suggestion(name, IMPORTED)}")
        if not isinstance(entry, Mapping):
            raise ConfigError(f"{where}: must be a table with the key 'column'")
        channels[name] = build(ChannelMap, entry, where)
        if channels[name].compliance and name != "displacement":
            raise ConfigError(f"{where}: 'compliance' belongs to displacement only")
    sections = {
        name: build(cls, table[name], f"{path} [{name}]") for name, cls in SECTIONS.items() if name in table
    }
    return ColumnMap(channels, name=path.name, **sections)


def _changed(base: ColumnMap, name: str, key: str, value: str) -> ColumnMap:
    if name == "t":
        return dataclasses.replace(base, time=replace(base.time, key, value))
    if name == "episode":
        return dataclasses.replace(base, episode=replace(base.episode, key, value))
    if name not in IMPORTED:
        raise UsageError(f"there is no channel {name!r}; {suggestion(name, ['t', 'episode', *IMPORTED])}")
    channel = replace(base.channels.get(name, ChannelMap(name)), key, value, f"--{key} {name}={value}")
    return dataclasses.replace(base, channels={**base.channels, name: channel})


def _pair(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not (name and equals and value):
        raise UsageError(f"{text!r} is not NAME=VALUE; write for example --map normal_force=force_N")
    return name.strip(), value.strip()
