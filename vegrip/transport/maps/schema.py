"""The file of a foreign hand (``hand.toml``): which of its signals make up our messages.

::

    database = "theirs.dbc"                  # beside this file; .dbc .kcd .sym .arxml, or .eds with [nodes]

    [messages.Tip1]                          # what protects a message; all of it optional
    counter = "Cnt"
    checksum = { kind = "crc8", signal = "Crc", polynomial = 0x2F, start = 0xFF, final = 0xFF }

    [fingers.thumb]
    trigger = "Tip1"                         # each of these completes a state
    [fingers.thumb.normal_force]
    signal = "Tip1.Fz"                       # MESSAGE.SIGNAL; over ZeroMQ TOPIC:PATH
    unit = "gf"                              # instead of that of the database
    sign = -1

    [fingers.thumb.command]
    kind = "force"
    signal = "Set1.Grip"

    [fingers."*"]                            # what holds for all fingers, with {finger} and {number} in it

The keys of a channel are those of :class:`SourceMap`, of a command those of :class:`CommandMap`. Instead of
``database``, ``[packets]`` describes the bytes of a device (:mod:`vegrip.transport.maps.packets`), and
``[device]`` says what is sent to it (:mod:`vegrip.transport.maps.dialogue`).
"""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from vegrip.config import build, parameter, read_toml
from vegrip.errors import ConfigError, suggestion
from vegrip.grip.safety.drive import DriveLimits
from vegrip.transport.maps.checksums import ChecksumMap
from vegrip.transport.maps.conditions import ConditionMap
from vegrip.transport.maps.dialogue import DeviceMap
from vegrip.transport.maps.map_text import whole
from vegrip.transport.maps.modbus import with_registers
from vegrip.transport.maps.packets import PacketMap, read_packets
from vegrip.transport.maps.signals import expanded
from vegrip.transport.maps.units import SI

MAPPED_CHANNELS: Final = tuple(SI)
FORMATS: Final = ("json", "msgpack", "protobuf")
SILENCE: Final = ("holds", "opens", "unknown")
UNKNOWN: Final = "?"  # a value that is to be measured
POLAR: Final = frozenset({"tangential_magnitude", "tangential_direction"})
REPORTED: Final = ("device_slip_state", "device_friction", "device_grip_force")
"""The channels of a DeviceReport, in the order of its values."""
ALL: Final = "*"  # the finger whose keys hold for all
COMMAND_KINDS: Final = ("force", "increment", "position", "current")


@dataclass(frozen=True)
class SourceMap:
    """Where one channel of a finger comes from.

    The value is ``gain * sign * (scale * s - zero + offset)``, where ``s`` is the signal, or the weighted
    sum of the signals, in ``unit``; then the ``table``.
    """

    signal: str = parameter("", doc="MESSAGE.SIGNAL of the database, or TOPIC:PATH")
    signals: tuple[str, ...] = parameter((), doc="several, summed; NAME{1..16} stands for sixteen")
    weights: tuple[float, ...] = parameter((), doc="of the signals; none: 1 each")
    unit: str = parameter("", doc="of the signal; empty: that of the database, else SI")
    raw: bool = parameter(False, doc="take the raw count, without scale and offset of the database")
    scale: float = parameter(1.0, doc="beside (raw: instead of) that of the database")
    offset: float = parameter(0.0, doc="in the unit, added after the scale")
    zero: float = parameter(0.0, doc="in the unit: what is read when the quantity is zero")
    sign: int = parameter(1, doc="-1 turns it round")
    gain: str = parameter("", doc="to our quantity, with its unit, as '2.5 N/A' or '40 mm/rad'")
    table: tuple[Any, ...] = parameter((), doc="pairs [value in unit, our value in table_unit], ascending")
    table_unit: str = parameter("", doc="of our value; empty: SI")
    invalid: tuple[int, ...] = parameter(
        (), doc="raw values that say: not measured; none: those that the database names"
    )
    all_is_measured: bool = parameter(
        False, doc="also raw values that the database names invalid, and those beyond its range, are measured"
    )
    above: float = parameter(float("nan"), doc="1 above this, else 0; for a slip channel that is not 0 and 1")
    stated: str = parameter("", doc="instead of a signal: a constant of yours, as '1.5 N'")
    noise: float = parameter(0.0, low=0.0, doc="standard deviation at rest, SI; 0: not known")
    zero_is_measured: bool = parameter(False, doc="a value that has always been zero counts as measured")

    def __post_init__(self) -> None:
        given = [key for key in ("signal", "signals", "stated") if getattr(self, key)]
        if len(given) != 1:
            both = " and ".join(repr(key) for key in given)
            raise ConfigError(f"give one of 'signal', 'signals' and 'stated', not {both or 'none of them'}")
        if self.weights and len(self.weights) != len(self.names):
            raise ConfigError(f"'weights' has {len(self.weights)} numbers for {len(self.names)} signals")
        if self.sign not in (1, -1):
            raise ConfigError(f"'sign' is {self.sign}; it must be 1 or -1")
        if self.table:
            if len(self.table) < 2 or not all(_are_numbers(row, 2) for row in self.table):
                raise ConfigError("'table' must be two or more pairs [their value, our value]")
            if not all(one[0] < other[0] for one, other in itertools.pairwise(self.table)):
                raise ConfigError("'table' must ascend in its first column")

    @property
    def names(self) -> tuple[str, ...]:
        return expanded(self.signals) if self.signals else (self.signal,) if self.signal else ()


@dataclass(frozen=True)
class TaxelMap:
    """A tactile array: forces summed, torque about the centre of pressure."""

    normal: tuple[str, ...] = parameter(doc="signals, one for each taxel; NAME{1..16} stands for sixteen")
    x: tuple[str, ...] = parameter((), doc="tangential forces along x, if there are any")
    y: tuple[str, ...] = parameter((), doc="and along y")
    positions: tuple[Any, ...] = parameter((), doc="[x, y] of each taxel; needed for the torque")
    position_unit: str = parameter("mm", doc="of the positions")
    unit: str = parameter("", doc="of the forces; empty: that of the database")
    raw: bool = parameter(False, doc="take raw counts")
    scale: float = parameter(1.0, doc="of the forces")
    zero: float = parameter(0.0, doc="of each taxel, in the unit")
    sign: int = parameter(1, doc="-1: pressure is negative")
    noise: float = parameter(0.0, low=0.0, doc="of the summed force, standard deviation [N]; 0: not known")


@dataclass(frozen=True)
class CommandMap:
    """Into which signal a ForceCommand goes."""

    signal: str = parameter(doc="MESSAGE.SIGNAL, or TOPIC:PATH")
    kind: str = parameter("force", choices=COMMAND_KINDS, doc="what their signal means")
    unit: str = parameter("", doc="of the signal; empty: that of the database, else SI")
    raw: bool = parameter(False, doc="send the raw count")
    sign: int = parameter(1, doc="-1: theirs is negative when it closes")
    scale: float = parameter(1.0, doc="the signal is scale * value + offset, in the unit")
    offset: float = parameter(0.0, doc="in the unit")
    gain: str = parameter(
        "", doc="what of the signal is for a force, as '0.4 A/N' or '4 %/N'; current needs it"
    )
    stiffness: str = parameter("", doc="kind position: of finger and object, as '2 N/mm'")
    feedback: str = parameter("", doc="kind position: the signal of the present position")
    low: float = parameter(float("nan"), doc="smallest value to send, in the unit")
    high: float = parameter(float("nan"), doc="largest value to send, in the unit")
    set: dict[str, float] = parameter({}, doc="SIGNAL = physical value: what else stands in the message")
    shares: dict[str, float] = parameter({}, doc="SIGNAL = ratio: joints that get so much of the value")
    motion: str = parameter("", doc="the signal of the position asked for, where a force needs a motion")
    closed: tuple[int, ...] = parameter(
        (), doc="raw positions asked for in turn, each new force with the next"
    )
    opened: int = parameter(0, doc="the raw position asked for with a force of zero")

    def __post_init__(self) -> None:
        needed = {"position": ("stiffness", "feedback"), "current": ("gain",)}.get(self.kind, ())
        for key in needed:
            if not getattr(self, key):
                raise ConfigError(f"a command of kind {self.kind!r} needs {key!r}")
        if self.sign not in (1, -1):
            raise ConfigError(f"'sign' is {self.sign}; it must be 1 or -1")
        if self.motion and (not self.closed or math.isnan(self.low)):
            raise ConfigError("a command with 'motion' needs 'closed', and 'low': what is sent as it opens")

    def range_or(self, low: float, high: float) -> tuple[float, float]:
        """Return the least and largest value that are stated, ``low`` and ``high`` where they are not."""
        return low if math.isnan(self.low) else self.low, high if math.isnan(self.high) else self.high


@dataclass(frozen=True)
class FingerMap:
    """One finger."""

    trigger: str = parameter("", doc="message that completes a state; empty: that of the normal force")
    max_age: float = parameter(
        0.1, unit="s", low=0.0, high=10.0, doc="older values of other messages are missing"
    )
    axes: tuple[str, ...] = parameter((), doc='our x, y, z in theirs, as ["-y", "x", "z"]')
    rotation: tuple[Any, ...] = parameter((), doc="three rows of a rotation from their frame to ours")
    channels: Mapping[str, SourceMap] = field(default_factory=dict)
    taxels: TaxelMap | None = None
    command: CommandMap | None = None


FINGER_KEYS: Final = ("trigger", "max_age", "axes", "rotation")
"""What stands in a finger's table beside the tables of channels, taxels and command."""


@dataclass(frozen=True)
class MessageMap:
    """What protects one of their messages."""

    counter: str = parameter("", doc="signal with a counter")
    modulus: int = parameter(0, low=0, high=1 << 32, doc="of the counter; 0: what its bits hold")
    type: str = parameter("", doc="protobuf: full name of the message, as 'acme.HandState'")
    checksum: ChecksumMap = parameter(ChecksumMap(), doc="kind, and what it needs")


@dataclass(frozen=True)
class SendingMap:
    """``[command]``: how commands are sent."""

    period: float = parameter(
        0.02, unit="s", low=0.001, high=1.0, doc="the last command is repeated so often"
    )
    poll: float = parameter(
        0.005, unit="s", low=0.001, high=1.0, doc="CANopen: between two requests by SDO to a node"
    )
    silence: str = parameter("unknown", choices=SILENCE, doc="what the hand does when commands stop")


@dataclass(frozen=True)
class HandKeys:
    """The keys of a whole file."""

    like: str = parameter("", doc="a product in the box, of which all holds that is not said here")
    database: str = parameter("", doc="file with their messages, beside this one")
    format: str = parameter("", choices=("", *FORMATS), doc="of messages on a network")
    nodes: dict[str, int] = parameter({}, doc="CANopen: node-ID by finger")
    rate: float = parameter(0.0, unit="Hz", low=0.0, high=1e5, doc="of states; 0: not known")
    messages: dict[str, Any] = parameter({})
    fingers: dict[str, Any] = parameter({})
    command: SendingMap = field(default_factory=SendingMap)
    drive: DriveLimits = field(default_factory=DriveLimits)
    transport: dict[str, Any] = parameter({}, doc="for vegrip launch; any launch file goes before it")
    friction: dict[str, Any] = parameter({}, doc="how friction is learned: parameters of grasp_force")
    sensors: dict[str, Any] = parameter({}, doc="gains of the sensors: parameters of grasp_force")
    limits: dict[str, Any] = parameter({}, doc="bounds of its grip: parameters of grasp_force")
    packets: dict[str, Any] = parameter({}, doc="bytes of a device: see vegrip.transport.maps.packets")
    device: DeviceMap = field(default_factory=DeviceMap)
    modbus: dict[str, Any] = parameter({}, doc="registers: see vegrip.transport.maps.modbus")
    conditions: dict[str, Any] = parameter({}, doc="what it says of itself: see ...maps.conditions")
    product: dict[str, Any] = parameter({}, doc="what it is, for vegrip connect --list")


@dataclass(frozen=True)
class HandMap(HandKeys):
    """A whole file, its tables read."""

    messages: dict[str, MessageMap] = parameter({})
    fingers: dict[str, FingerMap] = parameter({})
    packets: dict[str, PacketMap] = parameter({})
    conditions: dict[str, ConditionMap] = parameter({})
    path: Path = Path()
    open: Mapping[str, str] = field(default_factory=dict)  # what is not known yet -> how to measure it

    @property
    def file(self) -> Path | None:
        """The database."""
        return self.path.parent / self.database if self.database else None


def read_map(path: Path | str) -> HandMap:
    path = Path(path)
    return parse_map(read_toml(path), path)


def parse_map(table: Mapping[str, Any], path: Path) -> HandMap:
    """Return the map in ``table``; ``path`` names it in complaints, and its folder has the database."""
    table = with_registers(whole(table, str(path)), str(path))
    top = _built(HandKeys, table, str(path))
    if top.format == "protobuf" and not top.database:
        raise ConfigError(
            f"{path}: format = 'protobuf' needs database = 'hand.desc', which protoc --include_imports "
            "--descriptor_set_out=hand.desc hand.proto writes"
        )
    described = [bool(top.database and top.format != "protobuf"), bool(top.format), bool(top.packets)]
    if sum(described) != 1:
        raise ConfigError(
            f"{path}: give 'database' (CAN), 'format' (a network) or [packets] (bytes), and only one of them"
        )
    if not set(top.fingers) - {ALL}:
        raise ConfigError(f"{path}: there is no [fingers.NAME]; a map needs one finger at least")
    shared = _table(top.fingers.get(ALL, {}), path, "fingers.*")
    own = [name for name in top.fingers if name != ALL]
    unknown: dict[str, str] = {}
    fingers = {}
    for number, name in enumerate(own, 1):
        keys = {**shared, **_table(top.fingers[name], path, f"fingers.{name}")}
        known = _known(_filled(keys, name, number), top.product.get("measure", {}), unknown, path)
        fingers[name] = _finger(known, f"{path} [fingers.{name}]")
    messages = {
        name: build(MessageMap, _table(each, path, f"messages.{name}"), f"{path} [messages.{name}]")
        for name, each in top.messages.items()
    }
    packets = read_packets(top.packets, str(path))
    messages |= {
        name: MessageMap(counter=each.counter, checksum=each.checksum) for name, each in packets.items()
    }
    conditions = {
        name: _built(ConditionMap, _table(each, path, f"conditions.{name}"), f"{path} [conditions.{name}]")
        for name, each in top.conditions.items()
    }
    on_line = bool(packets) and all(each.identifier < 0 for each in packets.values())
    if (conditions or top.device.conditions) and not on_line:
        raise ConfigError(
            f"{path}: [conditions], 'ready', 'unless' and 'until' are of devices on UDP, TCP or a serial "
            "line; leave them out"
        )
    read = {"messages": messages, "fingers": fingers, "packets": packets, "conditions": conditions}
    return HandMap(**{**vars(top), **read}, path=path, open=unknown)


def _known(
    table: Mapping[str, Any], procedures: Mapping[str, Any], unknown: dict[str, str], path: Path
) -> dict[str, Any]:
    """Return ``table`` without channels of which a key is '?': to be measured, which ``unknown`` receives."""
    asked = [
        (name, key)
        for name, value in table.items()
        if isinstance(value, Mapping)
        for key, each in value.items()
        if each == UNKNOWN
    ]
    for name, key in asked:
        how = str(procedures.get(f"{name}.{key}", "see the data sheet of the device"))
        unknown[f"fingers.*.{name}.{key}"] = how
        is_drive = name == "command" and not table.keys() & {*MAPPED_CHANNELS, "taxels"}
        if is_drive or name in ("normal_force", "taxels"):
            raise ConfigError(
                f"{path}: {key} of {name} is not known: {how}; then --set 'fingers.*.{name}.{key}=VALUE', or "
                "write it there"
            )
    lost = {name for name, _ in asked}
    lost |= POLAR if lost & POLAR else set()
    return {name: value for name, value in table.items() if name not in lost}


def _filled(value: Any, finger: str, number: int) -> Any:
    if isinstance(value, str):
        return value.replace("{finger}", finger).replace("{number}", str(number))
    if isinstance(value, Mapping):
        return {key: _filled(one, finger, number) for key, one in value.items()}
    return [_filled(one, finger, number) for one in value] if isinstance(value, list) else value


def _table(value: Any, path: Path, name: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise ConfigError(f"{path}: {name!r} is {value!r}; it must be a table")
    return value


def _finger(table: Mapping[str, Any], where: str) -> FingerMap:
    own = {key: value for key, value in table.items() if key in FINGER_KEYS}
    keys = build(FingerMap, own, where)
    channels, taxels, command = {}, None, None
    for key, value in table.items():
        if key in own:
            continue
        inside = f"{where[:-1]}.{key}]"
        known = (*MAPPED_CHANNELS, "taxels", "command", *FINGER_KEYS)
        if key not in known:
            raise ConfigError(f"{where}: unknown key {key!r}; {suggestion(key, known, 'known are')}")
        if not isinstance(value, Mapping):
            raise ConfigError(
                f'{where}: {key!r} is {value!r}; it must be a table, as {{ signal = "Message.Signal" }}'
            )
        if key == "taxels":
            taxels = _built(TaxelMap, value, inside)
        elif key == "command":
            command = _built(CommandMap, value, inside)
        else:
            channels[key] = _built(SourceMap, value, inside)
    if taxels is not None:
        _check_taxels(taxels, channels, where)
    is_drive = command is not None and not channels
    if taxels is None and not is_drive and not {"normal_force", "displacement"} & channels.keys():
        raise ConfigError(
            f"{where}: neither normal_force nor displacement is mapped; nothing can be estimated "
            "without one of them"
        )
    rotation = _rotation(keys, where)
    return replace(keys, rotation=rotation, channels=channels, taxels=taxels, command=command)


def _built(cls: Any, table: Mapping[str, Any], where: str) -> Any:
    try:
        return build(cls, table, where)
    except ConfigError as error:
        said = str(error)
        raise ConfigError(said if said.startswith(where) else f"{where}: {said}") from None


def _are_numbers(row: Any, count: int) -> bool:
    is_row = isinstance(row, list) and len(row) == count
    return is_row and all(isinstance(value, (int, float)) for value in row)


def _check_taxels(taxels: TaxelMap, channels: Mapping[str, SourceMap], where: str) -> None:
    count = len(expanded(taxels.normal))
    if count == 0:
        raise ConfigError(f"{where}.taxels: 'normal' names no taxel")
    for key in ("x", "y", "positions"):
        given = getattr(taxels, key)
        number = len(expanded(given)) if key != "positions" else len(given)
        if given and number != count:
            raise ConfigError(f"{where}.taxels: {key!r} has {number} entries for {count} taxels")
    if not all(_are_numbers(place, 2) for place in taxels.positions):
        raise ConfigError(f"{where}.taxels: 'positions' must be pairs [x, y]")
    made = {"normal_force": True, "tangential_force_x": bool(taxels.x), "tangential_force_y": bool(taxels.y)}
    twice = [name for name, given in made.items() if given and name in channels]
    if twice:
        raise ConfigError(f"{where}: {twice[0]} comes from the taxels and from a signal; give one of them")


def _rotation(keys: FingerMap, where: str) -> tuple[tuple[float, ...], ...]:
    if keys.axes and keys.rotation:
        raise ConfigError(f"{where}: give 'axes' or 'rotation', not both")
    if len(keys.axes or keys.rotation) not in (0, 3):
        raise ConfigError(f"{where}: 'axes' or 'rotation' must have three entries, one for each of our axes")
    if not all(_are_numbers(row, 3) for row in keys.rotation):
        raise ConfigError(f"{where}: 'rotation' must be three rows of three numbers")
    rows = [_axis(word, where) for word in keys.axes] or [tuple(map(float, row)) for row in keys.rotation]
    if not rows:
        return ()
    matrix = np.array(rows)
    if not np.allclose(matrix @ matrix.T, np.eye(3), rtol=0.0, atol=1e-3):
        raise ConfigError(f"{where}: the rows of 'rotation' must be of length 1 and at right angles")
    if np.linalg.det(matrix) < 0.0:
        raise ConfigError(
            f"{where}: this is a mirror image, not a rotation: a left-handed frame; turn one sign round "
            "by 'sign' of that channel instead"
        )
    return tuple(rows)


def _axis(word: str, where: str) -> tuple[float, ...]:
    sign, name = (-1.0, word[1:]) if word[:1] == "-" else (1.0, word.removeprefix("+"))
    if name not in ("x", "y", "z"):
        raise ConfigError(
            f"{where}: an axis is {word!r}; it must be x, y or z, with a minus in front if it is turned round"
        )
    return tuple(sign if name == axis else 0.0 for axis in "xyz")
