"""Messages as Foxglove and PlotJuggler read them: a channel a topic, typed, with the unit of every field.

The fields are the columns of a recording, so that live data and an MCAP file of ``vegrip export`` have the
same paths: ``/hand/thumb/slip_margin.lower_bound``. There are two encodings of the same rows:

* ``json`` with a JSON schema, for Foxglove; what was not measured is left out, infinity is ``1e999``
* ``cdr`` with a ROS 2 message definition, which PlotJuggler's reader insists on; what was not measured is NaN
"""

import json
import struct
from typing import Any, Final

from vegrip.bridges import ros2_types as ros2
from vegrip.bridges.ros2_types import COLUMNS, LOG_LEVELS, TYPES, row_of
from vegrip.identification.recording.mcap import json_schema, to_json
from vegrip.messages import Message

ALARMS: Final = "/vegrip/alarms"
"""Topic of the log."""
MESSAGE_DATA: Final = struct.Struct("<BIQ")  # opcode, subscription, time [ns]; the payload follows
Channel = dict[str, Any]
"""What is advertised of a topic."""


def channel_of(number: int, topic: str, encoding: str, name: str, schema: str) -> Channel:
    schemas = {"json": "jsonschema", "cdr": "ros2msg"}
    said = {"id": number, "topic": topic, "encoding": encoding, "schemaName": name}
    return {**said, "schemaEncoding": schemas[encoding], "schema": schema}


def frame(subscription: int, stamp: int, payload: bytes) -> bytes:
    """Return a message for one subscription; ``stamp`` [ns] since 1970."""
    return MESSAGE_DATA.pack(1, subscription, stamp) + payload


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
        return channel_of(number, topic, "cdr", ros2.own_type(kind), ros2.own_lines(kind))

    def message(self, message: Message, start: int) -> bytes:
        return ros2.own_message(type(message), row_of(message, start))

    def log_channel(self, number: int, topic: str) -> Channel:
        return channel_of(number, topic, "cdr", ros2.LOG, ros2.definition(ros2.LOG))

    def log(self, stamp: int, level: str, name: str, text: str) -> bytes:
        return ros2.log_message(stamp, level, name, text)


Encoding = Json | Cdr
