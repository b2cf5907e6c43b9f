"""Rosbag 1 (``.bag``) and rosbag 2 (folder, ``.db3``, ``.mcap``): topics on the time of one, then a table.

A column is a field of a topic: ``/finger/wrench:wrench.force.z``, ``/joints:effort[2]``.
"""

import math
import re
import struct
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray

from vegrip.clock import NS
from vegrip.errors import RecordingError, suggestion
from vegrip.identification.recording.checks import usable_rows
from vegrip.identification.recording.column_map import BagMap, ColumnMap, EpisodeMap, TableMap, TimeMap
from vegrip.identification.recording.data import Recording
from vegrip.identification.recording.extras import extra_library
from vegrip.identification.recording.import_csv import recording_of
from vegrip.identification.recording.report import Kind, LoadReport
from vegrip.identification.recording.table import Table
from vegrip.types import Floats

bag_library = partial(extra_library, extra="bags")
COLUMN: Final = re.compile(r"(?P<topic>[^:\s]+):(?P<path>\w+(\[\d+\])*(\.\w+(\[\d+\])*)*)")
SAID_BY: Final = {"time": "--map t", "episode": "--map episode", "table": "--decimal and --thousands"}
"""Sections of a map that bags do not have -> the options that say them."""
LONGEST_INDEX: Final = 9  # digits
PATH_STEP: Final = re.compile(r"\w+|\[\d+\]")
BROKEN: Final = (
    *(OSError, ValueError, LookupError, AssertionError, TypeError, AttributeError, RuntimeError, MemoryError),
    *(OverflowError, struct.error),
)
"""What rosbags and the libraries beneath it raise on damaged bytes besides their own errors."""


@dataclass(frozen=True, slots=True)
class BagField:
    """One number in the messages of one topic."""

    column: str  # as the map has it
    topic: str
    steps: tuple[str | int, ...]

    @classmethod
    def parse(cls, column: str, channel: str) -> Self:
        """Read ``/topic:field.field[index]``; ``channel`` is named in the complaint."""
        match = COLUMN.fullmatch(column)
        if match is None:
            raise RecordingError(
                f"{channel}: {column!r} names no field; write it like /finger/wrench:wrench.force.z"
            )
        steps = [step.strip("[]") for step in PATH_STEP.findall(match["path"])]
        if any(step.isdigit() and (len(step) > LONGEST_INDEX or not step.isascii()) for step in steps):
            raise RecordingError(f"{channel}: {column[:80]!r} has an index that no array has")
        return cls(column, match["topic"], tuple(int(step) if step.isdigit() else step for step in steps))

    def value(self, message: Any) -> float:
        """Return the number in ``message``.

        Raises:
            RecordingError: the type has no such field, or it is not a number.
            IndexError: the array of this message is too short.

        """
        for step in self.steps:
            message = _element(message, step) if isinstance(step, int) else _member(message, step)
        if not isinstance(message, bool | int | float | np.bool_ | np.integer | np.floating):
            raise RecordingError(f"{self.column} is {_kind(message)}, not a number")
        return float(message)


def header_stamp(message: Any) -> int | None:
    """Return the stamp of the header [ns], None when the message has no header."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    if stamp is None:
        return None
    return int(stamp.sec) * NS + int(stamp.nanosec)


def _member(message: Any, name: str) -> Any:
    names = [key for key in getattr(message, "__dataclass_fields__", {}) if not key.startswith("__")]
    if name not in names:
        there = f"there are {', '.join(names)}" if names else f"it is {_kind(message)}"
        raise RecordingError(f"has no field {name!r}; {there}")
    return getattr(message, name)


def _element(message: Any, index: int) -> Any:
    if not isinstance(message, np.ndarray | list | tuple):
        raise RecordingError(f"has no element [{index}]; it is {_kind(message)}")
    return message[index]


def _kind(value: Any) -> str:
    if isinstance(value, np.ndarray | list | tuple):
        return f"an array of {len(value)}: say which with [index]"
    if isinstance(value, str):
        return f"the text {value[:40]!r}"
    names = getattr(value, "__dataclass_fields__", {})
    return f"a message with {', '.join(key for key in names if not key.startswith('__'))}"


@dataclass(slots=True)
class Series:
    """Chosen fields of the messages of one topic."""

    topic: str  # its name
    fields: list[BagField]  # which numbers are taken
    index: list[int] = field(default_factory=list)  # which message of the topic each entry came from, from 0
    stamps: list[int] = field(default_factory=list)  # [ns] since the epoch of the sender
    # one list of numbers per message, in the order of ``fields``
    values: list[list[float]] = field(default_factory=list)
    received: int = 0  # messages without a header, which have the time at which the bag received them
    messages: int = 0  # how many the bag holds
    others: int = 0  # of a frame that is not asked for
    frames: set[str] = field(default_factory=set)  # frame_ids


@dataclass(frozen=True, slots=True)
class Samples:
    """A series in order of time: (n,) stamps [ns], (n,) message numbers, and (n,) values by column."""

    stamps: NDArray[np.int64]
    index: NDArray[np.int64]
    columns: Mapping[str, Floats]


def read_series(
    path: Path, fields: Sequence[BagField], chart: BagMap, report: LoadReport
) -> dict[str, Series]:
    """Return the topics of ``fields``, each with its fields; messages that cannot be used are reported.

    Raises:
        RecordingError: no bag, damaged, a topic or field that it does not have, or a field that is no number.
        UsageError: the library rosbags is not installed.

    """
    found: dict[str, Series] = {}
    for each in dict.fromkeys(fields):
        found.setdefault(each.topic, Series(each.topic, [])).fields.append(each)
    with _opened(path, chart.definitions) as reader:
        connections = _connections(path, reader, found)
        for connection, received, data in reader.messages(connections):
            series = found[connection.topic]
            _add_message(path, series, reader, connection.msgtype, data, received, chart, report)
        for series in found.values():
            _note_lost(series, connections, report)
            _check_frames(path, series, chart, report)
    return found


def in_order(series: Series, report: LoadReport) -> Samples:
    """Return the longest run of ``series`` in which time increases; what is left out is reported.

    A stamp of zero was not set: no time.
    """
    stamps = np.array(series.stamps, dtype=np.int64)
    index = np.array(series.index, dtype=np.int64)
    values = np.array(series.values, dtype=np.float64).reshape(len(stamps), len(series.fields))
    stamped = stamps > 0
    seconds = (stamps - stamps.min(where=stamped, initial=np.iinfo(np.int64).max)) / NS
    keep = usable_rows(np.where(stamped, seconds, np.nan), index, report, series.topic)
    columns = {each.column: values[keep, i] for i, each in enumerate(series.fields)}
    return Samples(stamps[keep], index[keep], columns)


def _add_message(
    path: Path,
    series: Series,
    reader: Any,
    kind: str,
    data: bytes,
    received: int,
    chart: BagMap,
    report: LoadReport,
) -> None:
    """Take one message; one that is damaged, too short or infinite is left out and reported."""
    number, series.messages = series.messages, series.messages + 1
    try:
        message = reader.deserialize(data, kind)
    except _failures():
        report.add(Kind.DECODE, series.topic, [number])
        return
    frame = str(getattr(getattr(message, "header", None), "frame_id", ""))
    series.frames.add(frame)
    if chart.frame and frame != chart.frame:
        series.others += 1
        return
    try:
        values = [each.value(message) for each in series.fields]
    except IndexError:
        report.add(Kind.FIELDS, series.topic, [number])
        return
    except RecordingError as error:
        raise RecordingError(f"{path}: {series.topic} [{kind}]: message {number}: {error}") from None
    if any(map(math.isinf, values)):
        report.add(Kind.INFINITE, series.topic, [number])
        return
    stamp = header_stamp(message) if chart.stamp == "header" else None
    series.received += stamp is None
    series.stamps.append(received if stamp is None else stamp)
    series.index.append(number)
    series.values.append(values)


def _note_lost(series: Series, connections: Sequence[Any], report: LoadReport) -> None:
    """Report when the bag's own count of messages is another than what is in it."""
    said = sum(each.msgcount for each in connections if each.topic == series.topic)
    if said != series.messages:
        there = f"{series.messages} of the {said} messages that the bag counts are there"
        report.add(Kind.NOTE, f"{series.topic}: {there}")


def _check_frames(path: Path, series: Series, chart: BagMap, report: LoadReport) -> None:
    """Report a topic on which several sensors speak, each in a frame of its own."""
    named = sorted(series.frames)
    if chart.frame and chart.frame not in named:
        raise RecordingError(
            f"{path}: {series.topic} has no frame {chart.frame!r}; it has {', '.join(named)}"
        )
    if len(named) > 1 and not chart.frame:
        report.add(
            Kind.AMBIGUOUS,
            f"{series.topic} has messages of the frames {', '.join(map(repr, named))}; say which "
            f"are meant: --frame {named[-1]}",
        )


def _connections(path: Path, reader: Any, wanted: Mapping[str, Series]) -> list[Any]:
    kinds: dict[str, set[str]] = {}
    for connection in reader.connections:
        kinds.setdefault(connection.topic, set()).add(connection.msgtype)
    for topic in wanted:
        if topic not in kinds:
            there = ", ".join(f"{name} [{min(kind)}]" for name, kind in sorted(kinds.items())) or "none"
            near = suggestion(topic, kinds).rpartition("did you mean ")
            asked = f"; did you mean {near[2]}" if near[1] else ""
            raise RecordingError(f"{path}: there is no topic {topic}; there are {there}{asked}")
        if len(kinds[topic]) > 1:
            raise RecordingError(f"{path}: {topic} has messages of {' and '.join(sorted(kinds[topic]))}")
    return [connection for connection in reader.connections if connection.topic in wanted]


@contextmanager
def _opened(path: Path, definitions: str) -> Iterator[Any]:
    library = bag_library("rosbags.highlevel")
    if not path.exists():
        raise RecordingError(f"{path}: there is no such file")
    types = _types(path, definitions)
    try:
        with library.AnyReader([path], default_typestore=types) as reader:
            yield reader
    except library.AnyReaderError as error:
        if "no type definitions" in str(error):
            raise RecordingError(
                f"{path}: the bag does not define its messages; name the ROS release in a --map-file: "
                '[bag] definitions = "ros2_humble"'
            ) from None
        raise RecordingError(f"{path}: is not a bag that can be read ({error})") from None
    except _failures() as error:
        raise RecordingError(
            f"{path}: is not a bag that can be read ({str(error) or type(error).__name__})"
        ) from None


def _types(path: Path, release: str) -> Any:
    library = bag_library("rosbags.typesys")
    if not release:
        return None
    known = {store.value: store for store in library.Stores if store.value.startswith("ros")}
    if release not in known:
        raise RecordingError(
            f"{path}: [bag] definitions: no release {release!r}; there are {', '.join(known)}"
        )
    return library.get_typestore(known[release])


def _failures() -> tuple[type[Exception], ...]:
    return (
        *BROKEN,
        bag_library("rosbags.highlevel").AnyReaderError,
        bag_library("rosbags.rosbag1").ReaderError,
        bag_library("rosbags.rosbag2").ReaderError,
        bag_library("rosbags.typesys").TypesysError,
        bag_library("apsw").Error,
        bag_library("compression.zstd" if sys.version_info >= (3, 14) else "backports.zstd").ZstdError,
    )


def import_rosbag(path: Path | str, chart: ColumnMap, *, radius: float = math.nan) -> Recording:
    """Read the bag ``path`` as ``chart`` says: a row per message of the topic ``[bag] time``.

    Values of other topics are the last ones at the row's time, at most ``[bag] largest_age`` old, else NaN;
    nothing is interpolated or filtered. The numbers in the report count the messages of a topic from 0.

    Args:
        path: rosbag 1 (``.bag``) or 2 (folder, ``.db3``, ``.mcap``).
        chart: its columns are ``/topic:field.of.the.message``.
        radius: of the fingertip [m]; overrides the map's.

    Raises:
        RecordingError: unreadable, or a topic, field, unit or age that does not fit; names topic and message.
        UsageError: the library rosbags is not installed.

    """
    bag_library("rosbags")  # first, so that no map is corrected in vain
    path, report = Path(path), LoadReport(place="message")
    fields = {name: BagField.parse(entry.column, name) for name, entry in chart.channels.items()}
    _check(path, chart)
    leader = _leader(path, fields, chart.bag)
    found = read_series(path, list(fields.values()), chart.bag, report)
    _note_clocks(found, chart.bag, report)
    report.rows_read = found[leader].messages - found[leader].others
    rows = in_order(found[leader], report)
    if not len(rows.stamps):
        raise RecordingError(f"{path}: no usable message on {leader}; {report.summary()}")
    columns = dict(rows.columns)
    for topic, series in found.items():
        if topic != leader:
            columns |= _held(path, series, rows.stamps, chart.bag.largest_age, report)
    origin = int(rows.stamps[0])
    t = (rows.stamps - origin) / NS
    table = Table({chart.time.column: t, **columns}, {}, rows.index)
    return recording_of(path, table, chart, report, radius, origin)


def hold(
    stamps: NDArray[np.int64], values: Floats, at: NDArray[np.int64], largest_age: int
) -> tuple[Floats, NDArray[np.int64]]:
    """Return the last of ``values`` at each time, and its age [ns]; NaN and -1 where there is none.

    Args:
        stamps: (n,) [ns] increasing.
        values: (n,) taken at ``stamps``.
        at: (m,) [ns] times to know the value at.
        largest_age: [ns] a value older than this is not used.

    """
    last = np.searchsorted(stamps, at, side="right") - 1
    age = np.where(last >= 0, at - stamps[np.maximum(last, 0)], -1)
    good = (age >= 0) & (age <= largest_age)
    return np.where(good, values[np.maximum(last, 0)], np.nan), np.where(good, age, -1)


def _check(path: Path, chart: ColumnMap) -> None:
    if not chart.channels:
        raise RecordingError(
            f"{path}: say which field is what, with --map-file or --map normal_force=/topic:wrench.force.z"
        )
    given = {"time": chart.time != TimeMap(), "episode": chart.episode != EpisodeMap()}
    for section, there in (given | {"table": chart.table != TableMap()}).items():
        if there:
            where = f"[{section}]" if chart.name else SAID_BY[section]
            raise RecordingError(
                f"{path}: a bag has no {where}; its topics and time are said in [bag] of a --map-file"
            )


def _leader(path: Path, fields: dict[str, BagField], bag: BagMap) -> str:
    topics = list(dict.fromkeys(each.topic for each in fields.values()))
    if bag.time and bag.time not in topics:
        raise RecordingError(f"{path}: [bag] time = {bag.time!r} must be one of {', '.join(topics)}")
    if len(topics) > 1 and not (bag.time and bag.largest_age):
        raise RecordingError(
            f"{path}: the topics {', '.join(topics)} need [bag] time = one of them, and "
            "largest_age [s], in a --map-file"
        )
    return bag.time or topics[0]


def _held(
    path: Path, series: Series, at: NDArray[np.int64], largest_age: float, report: LoadReport
) -> dict[str, Floats]:
    """Return the columns of ``series`` at the times ``at``; what is too old becomes NaN, and is counted."""
    samples: Samples = in_order(series, report)
    limit = round(largest_age * NS)
    ages = np.full(len(at), -1, dtype=np.int64)
    columns = {}
    for column, values in samples.columns.items():
        if len(samples.stamps):
            columns[column], ages = hold(samples.stamps, values, at, limit)
    used = ages >= 0
    if not np.any(used):
        raise RecordingError(
            f"{path}: {series.topic} has no value within {largest_age:g} s before any row; "
            "its clock may be another one: try [bag] stamp = 'receive' in a --map-file"
        )
    held, oldest = np.count_nonzero(used), ages.max() / NS
    report.add(Kind.NOTE, f"{series.topic}: known in {held} of {len(at)} rows, at most {oldest:.3g} s old")
    return columns


def _note_clocks(found: dict[str, Series], bag: BagMap, report: LoadReport) -> None:
    for topic, series in found.items():
        if series.received and bag.stamp == "header":
            report.add(Kind.NOTE, f"{topic} has no header: its time is that of reception")
