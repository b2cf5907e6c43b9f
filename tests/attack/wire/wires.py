"""The two wires as bytes, from ``proto/`` alone: CAN FD by cantools and the DBC, ZeroMQ by msgpack and TOML.

Nothing here is of vegrip: a mistake in its codec that encoder and decoder share is not shared by this.
"""

import math
import tomllib
import zlib
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import cantools
import msgpack
from autosar import is_sound_p04, is_sound_p05, protected_p04, protected_p05

PROTO = Path(__file__).parents[3] / "proto"
FINGERS = ("thumb", "index")
QUANTITIES = (
    "normal_force",
    "tangential_force_x",
    "tangential_force_y",
    "torque_z",
    "displacement",
    "temperature",
    "slip",
    "slip_speed",
    "contact_radius",
)
LARGEST = {"can": 3.4e38, "zmq": 1e308}  # of the floats that travel


class Sent(NamedTuple):
    """What goes over a wire: a CAN frame or a message on a topic."""

    place: int | str  # identifier or topic
    data: bytes


class Command(NamedTuple):
    """A force command as the hand reads it."""

    finger: int
    force: float  # [N]
    reason: int
    lifetime: float  # [s]


class Health(NamedTuple):
    """What the node thinks of a finger's input."""

    finger: int
    condition: int


class Refusals(NamedTuple):
    """What the node counts."""

    counts: dict[str, int]


Heard = Command | Health | Refusals | None


class Wire(Protocol):
    """States to bytes, and what the node says from bytes."""

    name: str

    def state(
        self,
        finger: int,
        seq: int,
        stamp: int,
        values: dict[str, float],
        *,
        version: int = 1,
        place_of: int | None = None,
        named: int | None = None,
    ) -> Sent:
        """Return a state; ``place_of`` protects it as another finger's, ``named`` says another's name."""

    def read(self, sent: Sent) -> Heard:
        """Return what a message of the node says, None for others; raise ValueError for a broken one."""


class CanFd:
    """Hand 0 on CAN FD."""

    name = "can"

    def __init__(self) -> None:
        self._base = cantools.database.load_file(PROTO / "fingertip.dbc", frame_id_mask=0x7C0)
        self._state = self._base.get_message_by_name("FingertipStateFd")

    def state(
        self,
        finger: int,
        seq: int,
        stamp: int,
        values: dict[str, float],
        *,
        version: int = 1,
        place_of: int | None = None,
        named: int | None = None,  # noqa: ARG002 (a frame has no names)
    ) -> Sent:
        micros = stamp // 1000 % 2**32
        fields = {"crc": 0, "seq": seq % 2**32, "version": version, "time": micros, **values}
        data = self._state.encode(fields, strict=False, padding=False)
        identifier = self._state.frame_id + finger
        data_id = self._state.frame_id + (finger if place_of is None else place_of)
        return Sent(identifier, protected_p05(data, data_id))

    def read(self, sent: Sent) -> Heard:
        identifier, data = sent
        if not is_sound_p05(data, int(identifier)):
            raise ValueError("checksum")
        message = self._base.get_message_by_frame_id(identifier)
        fields: Any = message.decode(data, decode_choices=False)
        finger = int(identifier) & 7
        if message.name == "ForceCommandFd":
            return Command(finger, fields["normal_force"], fields["reason"], fields["expires"])
        if message.name == "ModelHealthFd":
            return Health(finger, fields["condition"])
        if message.name == "NodeStatusFd":
            return Refusals(
                {name[9:]: count for name, count in fields.items() if name.startswith("rejected_")}
            )
        return None


class Msgpack:
    """A hand in the namespace ``left``."""

    name = "zmq"

    def __init__(self) -> None:
        declared = tomllib.loads((PROTO / "messages.toml").read_text())
        self._kinds = {}
        for kind, table in declared.items():
            if kind == "version":
                continue
            for finger, name in enumerate(FINGERS):
                self._kinds["/left" + table["topic"].replace("{finger}", name)] = (kind, finger)
        self._topic = "/left" + declared["FingertipState"]["topic"]

    def state(
        self,
        finger: int,
        seq: int,
        stamp: int,
        values: dict[str, float],
        *,
        version: int = 1,
        place_of: int | None = None,
        named: int | None = None,
    ) -> Sent:
        topic, name = self._topic_of(finger), FINGERS[finger if named is None else named]
        known = {key: value for key, value in values.items() if not math.isnan(value)}
        body = {"version": version, "stamp": stamp, "finger": name, "seq": seq % 2**32, **known}
        data_id = zlib.crc32(self._topic_of(finger if place_of is None else place_of).encode())
        return Sent(topic, protected_p04(msgpack.packb(body), data_id, seq % 2**16))

    def read(self, sent: Sent) -> Heard:
        topic, data = sent
        if not is_sound_p04(data, zlib.crc32(str(topic).encode())):
            raise ValueError("checksum")
        kind, finger = self._kinds[str(topic)]
        body = msgpack.unpackb(data[12:])
        if body["version"] != 1:
            raise ValueError("version")
        if kind == "ForceCommand":
            lifetime = (body["expires"] - body["stamp"]) / 1e9
            return Command(finger, body["normal_force"], body["reason"], lifetime)
        if kind == "ModelHealth":
            return Health(finger, body["condition"])
        if kind == "NodeStatus":
            return Refusals(body["rejected"])
        return None

    def _topic_of(self, finger: int) -> str:
        return str(self._topic).replace("{finger}", FINGERS[finger])


WIRES: dict[str, Wire] = {"can": CanFd(), "zmq": Msgpack()}
