"""Numbers out of rosbag 1 (``.bag``) and rosbag 2 (folder, ``.db3``, ``.mcap``), topic by topic."""

import struct
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from vegrip.clock import NS
from vegrip.errors import RecordingError
from vegrip.identification.recording.checks import usable_rows
from vegrip.identification.recording.column_map import BagMap
from vegrip.identification.recording.extras import bag_library
from vegrip.identification.recording.report import Kind, LoadReport
from vegrip.identification.recording.rosbag_fields import BagField, header_stamp, is_infinite
from vegrip.spelling import suggestion
from vegrip.types import Floats

BROKEN: Final = (
    *(OSError, ValueError, LookupError, AssertionError, TypeError, AttributeError, RuntimeError, MemoryError),
    *(OverflowError, struct.error),
)
"""What rosbags and the libraries beneath it raise on damaged bytes besides their own errors."""


@dataclass(slots=True)
class Series:
    """Chosen fields of the messages of one topic.

    Attributes:
        topic: its name.
        fields: which numbers are taken.
        index: which message of the topic each entry came from, from 0.
        stamps: [ns] since the epoch of the sender.
        values: one list of numbers per message, in the order of ``fields``.
        received: messages without a header, which have the time at which the bag received them.
        messages: how many the bag holds.

    """

    topic: str
    fields: list[BagField]
    index: list[int] = field(default_factory=list)
    stamps: list[int] = field(default_factory=list)
    values: list[list[float]] = field(default_factory=list)
    received: int = 0
    messages: int = 0


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
            _take(path, series, reader, connection.msgtype, data, received, chart, report)
        for series in found.values():
            _note_lost(series, connections, report)
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


def _take(
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
    try:
        values = [each.value(message) for each in series.fields]
    except IndexError:
        report.add(Kind.FIELDS, series.topic, [number])
        return
    except RecordingError as error:
        raise RecordingError(f"{path}: {series.topic} [{kind}]: message {number}: {error}") from None
    if is_infinite(values):
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
                f"{path}: the bag does not define its messages; name the ROS release in the map: "
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
