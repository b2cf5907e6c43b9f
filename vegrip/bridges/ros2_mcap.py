"""MCAP of ROS 2 types, of a recording or of running hands: what rosbags, Foxglove and PlotJuggler read.

::

    /hand/thumb/state           vegrip_msgs/msg/FingertipState, and so on: every topic, the columns as fields
    /hand/thumb/wrench          geometry_msgs/msg/WrenchStamped, what the fingertip feels, frame ``thumb``
    /hand/thumb/wrench_command  geometry_msgs/msg/WrenchStamped, the commanded normal force along z
    /diagnostics                diagnostic_msgs/msg/DiagnosticArray, nodes and the health of every finger
    /vegrip/events              foxglove_msgs/msg/Log: slip begins and ends, what the model fails to explain,
                                verdicts of `vegrip diagnose`
    metadata ``vegrip``         hand, pad, date, version, verdicts; again when another hand is heard

Chunks are a few hundred messages and are not compressed, so a file whose writer was killed is whole up to the
last of them.
"""

import heapq
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from itertools import repeat
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Final, Self

import vegrip
from vegrip.bridges import ros2_types as ros2
from vegrip.bridges.node_topics import NodeTopics, node_parameters
from vegrip.bridges.ros2_types import Row
from vegrip.clock import NS
from vegrip.identification.recording.data import Recording
from vegrip.identification.recording.mcap import read_all, tables_of
from vegrip.identification.recording.report import LoadReport
from vegrip.identification.recording.rosbag import bag_library
from vegrip.messages import FingertipState, Message, ModelHealth
from vegrip.whole_file import whole_file

EVENTS: Final = "/vegrip/events"
Event = tuple[str, str, str]
"""Level of a log, finger or recording, and text."""
CHUNK_BYTES: Final = (
    8192  # of messages that a kill may cost: 0.1 s of a finger at 200 Hz with all that is said
)
FLUSH_PERIOD_S: Final = 0.2  # [s] until what is written is with the system
LOOK_PERIOD_S: Final = 1.0  # [s] between two looks at which topics there are


class Ros2Mcap:
    """A writer; used with ``with``.

    Args:
        file: to write to.
        about: of the metadata record, see :func:`about`.

    Raises:
        UsageError: the library mcap is not installed.

    """

    def __init__(self, file: BinaryIO, about: Mapping[str, str]) -> None:
        library = bag_library("mcap.writer")
        none = library.CompressionType.NONE
        self._writer = library.Writer(file, chunk_size=CHUNK_BYTES, compression=none, enable_data_crcs=True)
        self._writer.start(profile="ros2", library="vegrip")
        self.describe(about)
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._before: dict[str, str] = {}  # what the last events said, by topic
        self._file = file
        self._flush_due = 0.0
        self.messages = 0
        """Written so far."""

    def describe(self, about: Mapping[str, str]) -> None:
        """Write a record of metadata, which holds from here on."""
        self._writer.add_metadata("vegrip", dict(about))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._writer.finish()

    def add(self, topic: str, kind: type[Message], row: Row, stamp: int) -> None:
        """Write a message with what belongs to it; ``stamp`` [ns], not negative."""
        for end, name in ros2.ends_of(topic, kind).items():
            self._put(end, name, ros2.message_of(name, topic, kind, row, stamp), stamp)
        for level, text in self._events(topic, kind, row):
            self.event(stamp, level, ros2.hand_of(topic).rpartition("/")[2], text)

    def event(self, stamp: int, level: str, finger: str, text: str) -> None:
        self._put(EVENTS, ros2.LOG, ros2.log_message(stamp, level, finger, text), stamp)

    def flush(self) -> None:
        """Hand what is written to the system, now and then."""
        if time.monotonic() >= self._flush_due:
            self._file.flush()
            self._flush_due = time.monotonic() + FLUSH_PERIOD_S

    def _events(self, topic: str, kind: type[Message], row: Row) -> Iterator[tuple[str, str]]:
        """Yield what has begun or ended with this message."""
        if kind is FingertipState and row.get("slip"):
            said = "slip" if float(row["slip"]) > 0.0 else ""
        elif kind is ModelHealth:
            said = (
                "" if float(row["consistent"] or 1.0) > 0.0 else f"the model fails: {row['suspect'] or '?'}"
            )
        else:
            return
        before = self._before.get(topic, "")
        self._before[topic] = said
        if said != before:
            yield ("warning", said) if said else ("info", f"over: {before}")

    def _put(self, topic: str, name: str, data: bytes, stamp: int) -> None:
        if topic not in self._channels:
            if name not in self._schemas:
                text = ros2.definition(name).encode()
                self._schemas[name] = self._writer.register_schema(name, "ros2msg", text)
            self._channels[topic] = self._writer.register_channel(topic, "cdr", self._schemas[name])
        self._writer.add_message(self._channels[topic], stamp, data, stamp)
        self.messages += 1


def about(hand: str, pads: Mapping[str, str], date: str) -> dict[str, str]:
    """Return the metadata of a file: the hand, its pads by finger, and when it was recorded."""
    header = {"hand": hand, "date": date, "version": vegrip.__version__}
    return header | {f"pad.{finger}": pad for finger, pad in pads.items()}


def write_ros2_mcap(folder: Path, path: Path, verdicts: Sequence[Event] = ()) -> tuple[int, list[LoadReport]]:
    """Write a recording or session to ``path``; return how many messages, and what could not be read.

    ``verdicts`` become events at the last message, when all that they are of has come.

    Raises:
        RecordingError: no recording, or a damaged table.
        UsageError: the library mcap is not installed.

    """
    bag_library("mcap.writer")
    recordings = read_all(folder)
    tables = list(tables_of(folder, recordings))
    stamp = min((table.stamps[0] for table in tables if table.stamps), default=0)
    earlier = max(NS - stamp, 0)  # in ROS a stamp of zero is none
    rows = heapq.merge(
        *(zip(one.stamps, repeat(one), one.rows, strict=False) for one in tables), key=lambda row: row[0]
    )
    told = {f"verdict.{name}": text for _, name, text in verdicts}
    with whole_file(path) as part, part.open("wb") as file:
        with Ros2Mcap(file, _about(folder, recordings) | told) as mcap:
            for stamp, table, cells in rows:
                row = dict(zip(table.columns, cells, strict=True))
                mcap.add(table.topic, table.kind, row, stamp + earlier)
            for verdict in verdicts:
                mcap.event(stamp + earlier, *verdict)
        return mcap.messages, [one.report for one in recordings.values()]


def running_hands() -> dict[str, str]:
    """Return hands and pads of the nodes that run, as their parameters say."""
    hands: list[str] = []
    pads: dict[str, str] = {}
    for entry, said in node_parameters():
        if "tip.radius" in said:
            hands.append(entry.name)
            model = f", model {said['tip.model']}" if said.get("tip.model") else ""
            pads |= dict.fromkeys(entry.fingers, f"radius {said['tip.radius']:g} m{model}")
    return about(" ".join(hands), pads, datetime.now(UTC).isoformat(timespec="seconds"))


def record_ros2_mcap(
    path: Path, source: NodeTopics, ends: float, hands: Callable[[], dict[str, str]] = running_hands
) -> Iterator[int]:
    """Write what running nodes say to ``path``, until ``ends`` [s] of the monotonic clock; yield the count.

    Stamps are those of the clock of the day. The file grows in place: what was written stays readable.
    """
    start = time.monotonic_ns()
    since_1970 = time.time_ns() - start
    topics = source.look()
    with path.open("wb") as file, Ros2Mcap(file, hands()) as mcap:
        look_due = 0.0
        while time.monotonic() < ends:
            if time.monotonic() >= look_due:
                known, topics, look_due = topics, source.look(), time.monotonic() + LOOK_PERIOD_S
                if topics.keys() != known.keys():
                    mcap.describe(hands())
            for topic, message in source.read(topics):
                stamp = max(message.stamp + since_1970, 0)
                mcap.add(topic, type(message), ros2.row_of(message, start), stamp)
            mcap.flush()
            yield mcap.messages


def _about(folder: Path, recordings: Mapping[Path, Recording]) -> dict[str, str]:
    pads, dates = {}, []
    for recording in recordings.values():
        tip = recording.fingertip
        pads[tip.name] = f"radius {tip.radius:g} m" if tip.radius > 0.0 else "radius not known"
        dates += [str(recording.source[key]) for key in ("date", "began") if key in recording.source]
    return about(folder.resolve().name, pads, next(iter(dates), ""))
