"""ROS 2 types without ROS: definitions as ``.msg`` has them, and CDR bytes (plain CDR, RTPS 2.3, 10.2).

Standard types are those of ROS 2 Humble. Ours, ``vegrip_msgs/msg/*``, have the columns of a recording as
fields; their ``.msg`` files are in ``proto/ros2``.
"""

import struct
from collections.abc import Mapping
from typing import Final

from vegrip.clock import NS
from vegrip.identification.recording.mcap import properties
from vegrip.identification.recording.writer import csv_header, csv_row
from vegrip.messages import FingertipState, ForceCommand, Message, ModelHealth, NodeStatus
from vegrip.transport.codec.schema import CLASSES

Row = Mapping[str, str]
"""Column -> what stands in the cell, "" = not known."""
COLUMNS: Final = {kind: tuple(csv_header(kind).split(",")) for kind in CLASSES.values()}
TYPES: Final = {kind: {name: properties(kind)[name] for name in names} for kind, names in COLUMNS.items()}
"""Kind of message -> column -> JSON schema, whose description is the unit."""
LITTLE_ENDIAN: Final = b"\x00\x01\x00\x00"  # CDR_LE and no options: RTPS 2.3, 10.2.1.2
WRENCH: Final = "geometry_msgs/msg/WrenchStamped"
DIAGNOSTICS: Final = "diagnostic_msgs/msg/DiagnosticArray"
JOINTS: Final = "sensor_msgs/msg/JointState"
LOG: Final = "foxglove_msgs/msg/Log"
LOG_LEVELS: Final = {"info": 2, "warning": 3, "error": 4}
"""Of foxglove_msgs/msg/Log."""
OK, WARN, ERROR, STALE = range(4)
"""Of diagnostic_msgs/msg/DiagnosticStatus."""
COMMANDED: Final = dict.fromkeys(("tangential_force_x", "tangential_force_y", "torque_z"), "0")
"""What a command has beside its normal force."""
STANDARD: Final = {
    "builtin_interfaces/msg/Time": "int32 sec\nuint32 nanosec\n",
    "std_msgs/msg/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
    "geometry_msgs/msg/Vector3": "float64 x\nfloat64 y\nfloat64 z\n",
    "geometry_msgs/msg/Wrench": "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n",
    WRENCH: "std_msgs/Header header\ngeometry_msgs/Wrench wrench\n",
    JOINTS: (
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n"
    ),
    "diagnostic_msgs/msg/KeyValue": "string key\nstring value\n",
    "diagnostic_msgs/msg/DiagnosticStatus": (
        "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\nstring message\n"
        "string hardware_id\ndiagnostic_msgs/KeyValue[] values\n"
    ),
    DIAGNOSTICS: "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n",
    LOG: (
        "builtin_interfaces/Time timestamp\nuint8 level\nstring message\nstring name\nstring file\n"
        "uint32 line\n"
    ),
}
"""Type -> its own lines, without those of its parts."""


def own_type(kind: type[Message]) -> str:
    """Return the name of our type of ``kind``."""
    return f"vegrip_msgs/msg/{kind.__name__}"


def own_lines(kind: type[Message]) -> str:
    """Return the ``.msg`` text of our type; the comments are the units."""
    lines = [
        f"string {name}" if one["type"] == "string" else f"float64 {name}  # {one['description']}"
        for name, one in TYPES[kind].items()
    ]
    return "\n".join(lines) + "\n"


PARTS: Final = STANDARD | {own_type(kind): own_lines(kind) for kind in TYPES}
"""Type -> its own lines; :func:`definition` adds those of its parts."""


def ends_of(topic: str, kind: type[Message]) -> dict[str, str]:
    """Return the topics, with their types, on which messages of ``kind`` go out."""
    ends = {} if kind is NodeStatus else {topic: own_type(kind)}  # ROS has a type of its own for those
    if kind in (FingertipState, ForceCommand):
        ends[hand_of(topic) + ("/wrench" if kind is FingertipState else "/wrench_command")] = WRENCH
    if kind in (ModelHealth, NodeStatus):
        ends["/diagnostics"] = DIAGNOSTICS
    return ends


def hand_of(topic: str) -> str:
    return topic.rpartition("/")[0]


def definition(name: str) -> str:
    """Return a type with all its parts, as ``ros2msg`` schemas have them."""
    text, waiting, done = PARTS[name], _parts(PARTS[name]), {name}
    while waiting:
        part = waiting.pop(0)
        if part not in done:
            done.add(part)
            text += f"{'=' * 80}\nMSG: {part.replace('/msg/', '/')}\n{PARTS[part]}"
            waiting += _parts(PARTS[part])
    return text


def _parts(text: str) -> list[str]:
    kinds = [line.split()[0].removesuffix("[]") for line in text.splitlines()]
    return [kind.replace("/", "/msg/") for kind in kinds if "/" in kind]


def row_of(message: Message, start: int) -> Row:
    """Return ``message`` as the recorder writes it; ``start`` [ns] is the stamp of t = 0."""
    return dict(zip(COLUMNS[type(message)], csv_row(message, start).split(","), strict=True))


class Cdr:
    """The bytes of one message, little-endian; each value stands at a multiple of its size."""

    def __init__(self) -> None:
        self._body = bytearray()

    def put(self, form: str, *values: float) -> "Cdr":
        """Add values of one ``struct`` character."""
        for value in values:
            self._body += bytes(-len(self._body) % struct.calcsize(form)) + struct.pack(f"<{form}", value)
        return self

    def text(self, text: str) -> "Cdr":
        data = text.encode() + b"\x00"
        self.put("I", len(data))
        self._body += data
        return self

    def header(self, stamp: int, frame: str) -> "Cdr":
        """Add a std_msgs/Header; ``stamp`` [ns]."""
        return self.time(stamp).text(frame)

    def time(self, stamp: int) -> "Cdr":
        seconds, rest = divmod(stamp, NS)
        return self.put("i", seconds).put("I", rest)

    def done(self) -> bytes:
        return LITTLE_ENDIAN + self._body


def message_of(name: str, topic: str, kind: type[Message], row: Row, stamp: int) -> bytes:
    """Return the message of the type ``name`` for a ``row`` that came on ``topic`` at ``stamp`` [ns]."""
    finger = hand_of(topic).rpartition("/")[2]
    if name == DIAGNOSTICS:
        return diagnostics(f"vegrip{hand_of(topic).replace('/hand/', '/')}", row, stamp)
    if name != WRENCH:
        return own_message(kind, row)
    return wrench_of(row if kind is FingertipState else COMMANDED | dict(row), stamp, finger)


def diagnostics(name: str, row: Row, stamp: int) -> bytes:
    """Return the state of a node, or of what a finger feels, as ``rqt_robot_monitor`` shows it."""
    said, good = row.get("condition", ""), ("ok", "1")
    if "node" in row:
        name, said, good = row["node"], row["state"], ("active", "")
    level = OK if (said, row.get("consistent", "")) == good else WARN
    cdr = Cdr().header(stamp, "").put("I", 1).put("B", level).text(name).text(said).text("vegrip")
    cdr.put("I", len(row))
    for key, cell in row.items():
        cdr.text(key).text(cell)
    return cdr.done()


def own_message(kind: type[Message], row: Row) -> bytes:
    """Return our type of ``kind``; what is not known is NaN."""
    cdr = Cdr()
    for name, one in TYPES[kind].items():
        cell = row.get(name, "")
        if one["type"] == "string":
            cdr.text(cell)
        else:
            cdr.put("d", float(cell or "nan"))
    return cdr.done()


def log_message(stamp: int, level: str, name: str, text: str) -> bytes:
    """Return a line of a log; ``stamp`` [ns]."""
    return Cdr().time(stamp).put("B", LOG_LEVELS[level]).text(text).text(name).text("").put("I", 0).done()


def wrench_of(row: Row, stamp: int, frame: str) -> bytes:
    """Return a WrenchStamped in the contact frame; compression is positive along z, NaN not known."""
    names = ("tangential_force_x", "tangential_force_y", "normal_force")
    force = [float(row.get(name, "") or "nan") for name in names]
    torque = float(row.get("torque_z", "") or "nan")
    return Cdr().header(stamp, frame).put("d", *force, 0.0, 0.0, torque).done()
