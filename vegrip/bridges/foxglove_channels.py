"""Messages as Foxglove and PlotJuggler read them: a channel a topic, typed, with the unit of every field.

The fields are the columns of a recording, so that live data and an MCAP file of ``vegrip export`` have the
same paths: ``/hand/thumb/slip_margin.lower_bound``. There are two encodings of the same rows:

* ``json`` with a JSON schema, for Foxglove; what was not measured is left out, infinity is ``1e999``
* ``cdr`` with a ROS 2 message definition, which PlotJuggler's reader insists on; what was not measured is NaN
"""

import json
import struct
from collections.abc import Mapping
from typing import Any, Final

from vegrip.identification.recording.mcap import json_schema, properties, to_json
from vegrip.identification.recording.writer import csv_header, csv_row
from vegrip.messages import Message
from vegrip.transport.codec.schema import CLASSES

Row = Mapping[str, str]
"""Column -> what stands in the cell, "" = not known."""
ALARMS: Final = "/vegrip/alarms"
"""Topic of the log."""
LITTLE_ENDIAN: Final = b"\x00\x01\x00\x00"  # CDR_LE and no options: RTPS 2.3, 10.2.1.2
MESSAGE_DATA: Final = struct.Struct("<BIQ")  # opcode, subscription, time [ns]; the payload follows
LOG_LEVELS: Final = {"info": 2, "warning": 3, "error": 4}
"""Of foxglove.Log."""


COLUMNS: Final = {kind: tuple(csv_header(kind).split(",")) for kind in CLASSES.values()}
TYPES: Final = {kind: {name: properties(kind)[name] for name in names} for kind, names in COLUMNS.items()}
"""Kind of message -> column -> JSON schema, whose description is the unit."""
Channel = dict[str, Any]
"""What is advertised of a topic."""


def channel_of(number: int, topic: str, encoding: str, name: str, schema: str) -> Channel:
    schemas = {"json": "jsonschema", "cdr": "ros2msg"}
    said = {"id": number, "topic": topic, "encoding": encoding, "schemaName": name}
    return {**said, "schemaEncoding": schemas[encoding], "schema": schema}


def frame(subscription: int, stamp: int, payload: bytes) -> bytes:
    """Return a message for one subscription; ``stamp`` [ns] since 1970."""
    return MESSAGE_DATA.pack(1, subscription, stamp) + payload


def row_of(message: Message, start: int) -> Row:
    """Return ``message`` as the recorder writes it; ``start`` [ns] is the stamp of t = 0."""
    return dict(zip(COLUMNS[type(message)], csv_row(message, start).split(","), strict=True))


class Json:
    """JSON with a JSON schema whose descriptions are the units."""

    def channel(self, number: int, topic: str, kind: type[Message]) -> Channel:
        schema = json_schema(kind, COLUMNS[kind]).decode()
        return channel_of(number, topic, "json", f"vegrip.{kind.__name__}", schema)

    def message(self, message: Message, start: int) -> bytes:
        return to_json(row_of(message, start), TYPES[type(message)])

    def log_channel(self, number: int, topic: str) -> Channel:
        time = {name: {"type": "integer"} for name in ("sec", "nsec")}
        fields = {
            "timestamp": {"type": "object", "title": "time", "properties": time},
            "level": {"type": "integer"},
            **{name: {"type": "string"} for name in ("message", "name", "file")},
            "line": {"type": "integer"},
        }
        schema = json.dumps({"title": "foxglove.Log", "type": "object", "properties": fields})
        return channel_of(number, topic, "json", "foxglove.Log", schema)

    def log(self, stamp: int, level: str, name: str, text: str) -> bytes:
        sec, nsec = divmod(stamp, 10**9)
        time = {"sec": sec, "nsec": nsec}
        said = {"timestamp": time, "level": LOG_LEVELS[level], "message": text, "name": name}
        return json.dumps({**said, "file": "", "line": 0}).encode()


class Cdr:
    """CDR with a ROS 2 message definition whose comments are the units."""

    def channel(self, number: int, topic: str, kind: type[Message]) -> Channel:
        lines = [
            f"string {name}" if one["type"] == "string" else f"float64 {name}  # {one['description']}"
            for name, one in TYPES[kind].items()
        ]
        name = f"vegrip_msgs/msg/{kind.__name__}"
        return channel_of(number, topic, "cdr", name, "\n".join(lines) + "\n")

    def message(self, message: Message, start: int) -> bytes:
        known = TYPES[type(message)]
        body = bytearray()
        for name, cell in row_of(message, start).items():
            if known[name]["type"] == "string":
                _put_text(body, cell)
            else:
                _put(body, "<d", float(cell or "nan"))
        return LITTLE_ENDIAN + body

    def log_channel(self, number: int, topic: str) -> Channel:
        lines = ["builtin_interfaces/Time timestamp", "uint8 level", "string message", "string name"]
        lines += ["string file", "uint32 line", "=" * 80, "MSG: builtin_interfaces/Time"]
        text = "\n".join([*lines, "int32 sec", "uint32 nanosec"]) + "\n"
        return channel_of(number, topic, "cdr", "foxglove_msgs/msg/Log", text)

    def log(self, stamp: int, level: str, name: str, text: str) -> bytes:
        body = bytearray(struct.pack("<iIB", *divmod(stamp, 10**9), LOG_LEVELS[level]))
        for words in (text, name, ""):
            _put_text(body, words)
        _put(body, "<I", 0)
        return LITTLE_ENDIAN + body


Encoding = Json | Cdr


def _put(body: bytearray, form: str, value: float) -> None:
    body += bytes(-len(body) % struct.calcsize(form)) + struct.pack(form, value)


def _put_text(body: bytearray, text: str) -> None:
    data = text.encode() + b"\x00"
    _put(body, "<I", len(data))
    body += data
