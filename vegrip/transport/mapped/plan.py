"""What a map means: every signal found, every unit brought to SI, ready to be compiled.

The values of all signals stand in one list of *slots*, already scaled. A channel is the sum of some slots,
through a table where it has one. Which slots a message fills, and what a finger makes of them, is all that
is left.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from vegrip.errors import ConfigError, suggestion
from vegrip.identification.recording.channels import CHANNELS as MEASURED
from vegrip.transport.maps import schema
from vegrip.transport.maps.checksums import Protection, protection
from vegrip.transport.maps.database import Database, read_dbc
from vegrip.transport.maps.packet_database import packet_database
from vegrip.transport.maps.signals import ForeignMessage, Signal, expanded
from vegrip.transport.maps.units import SI, conversion, in_si, worth

UNITY: Final = 1e-12


@dataclass(frozen=True, slots=True)
class Slot:
    """One signal that is read: ``raw * scale + offset``."""

    number: int
    message: str
    signal: str  # its name, or the path in a topic
    place: Signal | None  # None in a topic
    scale: float
    offset: float
    invalid: tuple[int, ...] = ()
    bounds: tuple[float, float] | None = None  # raw values beyond are not measured


@dataclass(frozen=True, slots=True)
class ChannelPlan:
    """One channel of one finger, in the frame of the hand's maker."""

    slots: tuple[int, ...]
    constant: float = 0.0
    table: tuple[tuple[float, float], ...] = ()
    above: float = math.nan
    stated: bool = False
    gated: bool = True  # missing until its raw value has been another than zero


@dataclass(frozen=True, slots=True)
class TaxelPlan:
    """The torque of a tactile array about its centre of pressure."""

    normal: tuple[int, ...]
    x: tuple[int, ...]
    y: tuple[int, ...]
    positions: tuple[tuple[float, float], ...]  # [m]


@dataclass(frozen=True, slots=True)
class FingerPlan:
    """One finger."""

    name: str
    channels: Mapping[str, ChannelPlan]
    torque: TaxelPlan | None
    rotation: tuple[tuple[float, ...], ...]
    trigger: str  # message
    trigger_slots: tuple[int, ...]  # of these any must be in a frame of a multiplexed trigger; () = any frame
    max_age: float  # [s]

    @property
    def is_drive(self) -> bool:
        """Whether it only presses: what is felt comes from sensors with maps of their own."""
        return not self.channels

    @property
    def measured(self) -> frozenset[str]:
        """The channels of :class:`~vegrip.messages.FingertipState` that this finger gives."""
        given = set(self.channels)
        if self.torque is not None:
            given.add("torque_z")
        if given >= schema.POLAR:
            given.update(VECTORS[0][:2])
        if self.rotation:
            given = _turned(given, self.rotation)
        return frozenset(given) & frozenset(MEASURED)


@dataclass(frozen=True, slots=True)
class Plan:
    """A hand."""

    hand: schema.HandMap
    database: Database
    slots: tuple[Slot, ...]
    fingers: tuple[FingerPlan, ...]
    feedback: Mapping[str, int] = field(default_factory=dict)  # finger -> slot of its position, in its unit

    @property
    def messages(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(slot.message for slot in self.slots))

    def guard_of(self, name: str) -> Protection | None:
        """Return how frames of the message ``name`` are protected, None when they are not."""
        where = f"{self.hand.path} [messages.{name}.checksum]"
        spec = self.hand.messages.get(name)
        return None if spec is None else protection(spec.checksum, self.database.messages[name], where)

    def modulus_of(self, name: str) -> int:
        """Return what the counter in frames of the message ``name`` counts to, 1 without one."""
        spec = self.hand.messages.get(name)
        if spec is None or not spec.counter:
            return 1
        return spec.modulus or 1 << self.database.messages[name].signals[spec.counter].length


VECTORS: Final = (
    ("tangential_force_x", "tangential_force_y", "normal_force"),
    ("torque_x", "torque_y", "torque_z"),
)


def make_plan(hand: schema.HandMap, database: Database, fingers: tuple[str, ...]) -> Plan:
    """Return what ``hand`` means for the ``fingers`` of a configuration."""
    missing = [name for name in fingers if name not in hand.fingers]
    if missing:
        raise ConfigError(
            f"{hand.path}: there is no [fingers.{missing[0]}]; mapped are "
            f"{', '.join(hand.fingers)}, so name those in `fingers`"
        )
    maker = _Maker(hand, database)
    plans = tuple(maker.finger(name, hand.fingers[name]) for name in fingers)
    for name, spec in hand.messages.items():
        _check_protection(hand, database, name, spec)
    return Plan(hand, database, tuple(maker.slots), plans, maker.feedback)


def find_signal(database: Database, name: str, where: str) -> tuple[ForeignMessage, Signal]:
    """Return the message and the signal that ``name`` (MESSAGE.SIGNAL) names."""
    head, dot, tail = name.partition(".")
    if not dot:
        raise ConfigError(f"{where}: {name!r} must be MESSAGE.SIGNAL, both names of {database.name}")
    message = _find_message(database, head, where)
    signal = message.signals.get(tail)
    if signal is None:
        raise ConfigError(
            f"{where}: {head} has no signal {tail!r}; {suggestion(tail, message.signals, 'it has')}"
        )
    return message, signal


def _find_message(database: Database, name: str, where: str) -> ForeignMessage:
    message = database.messages.get(name)
    if message is None:
        raise ConfigError(
            f"{where}: {database.name} has no message {name!r}; "
            f"{suggestion(name, database.messages, 'it has')}"
        )
    return message


class _Maker:
    def __init__(self, hand: schema.HandMap, database: Database) -> None:
        self.slots: list[Slot] = []
        self.feedback: dict[str, int] = {}
        self._hand = hand
        self._database = database
        self._owner: dict[str, tuple[str, str]] = {}  # signal -> finger and what it is for

    def finger(self, name: str, mapped: schema.FingerMap) -> FingerPlan:
        where = f"{self._hand.path} [fingers.{name}"
        channels = {
            key: self._channel(name, key, source, f"{where}.{key}]")
            for key, source in mapped.channels.items()
        }
        polar = schema.POLAR & channels.keys()
        if polar and (polar != schema.POLAR or channels.keys() & set(VECTORS[0][:2])):
            raise ConfigError(
                f"{where}]: a tangential force is either tangential_magnitude and tangential_direction, or x "
                "and y"
            )
        torque = None
        if mapped.taxels is not None:
            torque = self._taxels(name, mapped.taxels, channels, f"{where}.taxels]")
            if torque is not None and "torque_z" in channels:
                raise ConfigError(
                    f"{where}]: torque_z comes from the taxels and from a signal; give one of them"
                )
        if mapped.command is not None and mapped.command.feedback:
            command = mapped.command
            slot = self._slot(command.feedback, 1.0, 0.0, f"{where}.command]", raw=command.raw)
            self.feedback[name] = slot
        is_drive = not channels and mapped.command is not None  # no state is ever complete
        trigger, chosen = ("", ()) if is_drive else self._trigger(mapped.trigger, channels, f"{where}]")
        given = set(channels) | set(VECTORS[0][:2] if channels.keys() >= schema.POLAR else ())
        _check_rotated(mapped.rotation, given, f"{where}]")
        return FingerPlan(name, channels, torque, mapped.rotation, trigger, chosen, mapped.max_age)

    def _channel(self, finger: str, name: str, source: schema.SourceMap, where: str) -> ChannelPlan:
        if source.stated:
            value = in_si(source.stated, SI[name], where)
            return ChannelPlan((), constant=value, stated=True, gated=False)
        for each in source.names:
            self._claim(each, finger, name, where)
        unit = source.unit or self._unit(source.names[0], where)
        if name == "tangential_direction" and not (unit or source.gain or source.table):
            raise ConfigError(f'{where}: nothing says the unit of this angle: \'unit\' = "deg" or "rad"')
        scale, offset = _to_si(name, source, unit, where)
        weights = source.weights or (1.0,) * len(source.names)
        slots = [
            self._slot(each, scale * weight, 0.0, where, raw=source.raw, source=source)
            for each, weight in zip(source.names, weights, strict=True)
        ]
        gated = not source.zero_is_measured and name not in ("tangential_direction", *schema.REPORTED)
        own, first = conversion(source.table_unit, SI[name], f"{where}: 'table_unit'")
        table = tuple((float(x), float(y) * own + first) for x, y in source.table)
        return ChannelPlan(tuple(slots), offset, table, source.above, gated=gated)

    def _taxels(
        self, finger: str, taxels: schema.TaxelMap, channels: dict[str, ChannelPlan], where: str
    ) -> TaxelPlan | None:
        groups = {
            "normal_force": taxels.normal,
            "tangential_force_x": taxels.x,
            "tangential_force_y": taxels.y,
        }
        made: dict[str, tuple[int, ...]] = {}
        for name, signals in groups.items():
            names = expanded(signals)
            if not names:
                continue
            for each in names:
                self._claim(each, finger, f"taxels.{name}", where)
            scale, _ = conversion(taxels.unit or self._unit(names[0], where), "N", where)
            sign = taxels.sign if name == "normal_force" else 1
            scale *= taxels.scale * sign
            zero = taxels.zero * scale / taxels.scale if name == "normal_force" else 0.0
            made[name] = tuple(self._slot(each, scale, -zero, where, raw=taxels.raw) for each in names)
            channels[name] = ChannelPlan(made[name])
        if not (taxels.x and taxels.y and taxels.positions):
            return None
        metre, _ = conversion(taxels.position_unit, "m", where)
        positions = tuple((x * metre, y * metre) for x, y in taxels.positions)
        return TaxelPlan(
            made["normal_force"], made["tangential_force_x"], made["tangential_force_y"], positions
        )

    def _claim(self, signal: str, finger: str, what: str, where: str) -> None:
        taken = self._owner.setdefault(signal, (finger, what))
        if taken != (finger, what):
            raise ConfigError(
                f"{where}: {signal} is already the {what if taken[1] == what else taken[1]} of {taken[0]}; "
                "a signal belongs to one finger and one channel"
            )

    def _unit(self, name: str, where: str) -> str:
        if self._hand.format:
            return ""
        return find_signal(self._database, name, where)[1].unit

    def _slot(
        self,
        name: str,
        scale: float,
        offset: float,
        where: str,
        *,
        raw: bool,
        source: schema.SourceMap | None = None,
    ) -> int:
        number, invalid = len(self.slots), source.invalid if source is not None else ()
        if self._hand.format:
            topic, colon, path = name.partition(":")
            if not (colon and topic.strip() and path.strip()):
                raise ConfigError(
                    f"{where}: {name!r} must be TOPIC:PATH, as in 'hand/state:fingers[0].force'"
                )
            self.slots.append(Slot(number, topic.strip(), path.strip(), None, scale, offset, invalid))
            return number
        message, signal = find_signal(self._database, name, where)
        if not raw:
            scale, offset = scale * signal.scale, offset + scale * signal.offset
        bounds = None
        if source is not None and not source.all_is_measured:
            invalid, bounds = invalid or signal.invalid, signal.bounds
        self.slots.append(Slot(number, message.name, signal.name, signal, scale, offset, invalid, bounds))
        return number

    def _trigger(
        self, given: str, channels: Mapping[str, ChannelPlan], where: str
    ) -> tuple[str, tuple[int, ...]]:
        own = [slot for plan in channels.values() for slot in plan.slots]
        if not own:
            raise ConfigError(f"{where}: all channels are stated; one at least must be measured")
        main = next(channels[name] for name in ("normal_force", "displacement") if name in channels)
        if not given:
            slot = self.slots[(main.slots or tuple(own))[0]]
            return slot.message, main.slots or tuple(own)
        message, dot, signal = given, "", ""
        is_framed = not self._hand.format and given.partition(".")[0] in self._database.messages
        if is_framed:
            message, dot, signal = given.partition(".")
            if dot:
                find_signal(self._database, given, where)
        of_it = [number for number in own if self.slots[number].message == message]
        of_it = [number for number in of_it if not dot or self.slots[number].signal == signal]
        if not of_it and is_framed:
            raise ConfigError(
                f"{where}: the trigger {given} carries no channel of this finger; take the "
                "last message of its cycle"
            )
        if not of_it:
            known = dict.fromkeys(self.slots[number].message for number in own)
            raise ConfigError(
                f"{where}: the trigger {given!r} is no message of this finger; "
                f"{suggestion(given, known, 'it has')}"
            )
        return message, tuple(of_it) if dot else ()


def _to_si(name: str, source: schema.SourceMap, unit: str, where: str) -> tuple[float, float]:
    """Return scale and offset from the signal to the channel, or to the first column of its table."""
    if not source.gain and (source.table or (source.raw and not source.unit) or not math.isnan(source.above)):
        scale, offset = 1.0, 0.0
    else:
        scale, offset = worth(unit, source.gain, SI[name], where)
    scale *= source.sign
    return scale * source.scale, scale * (source.offset - source.zero) + offset


def _check_rotated(rotation: tuple[tuple[float, ...], ...], given: set[str], where: str) -> None:
    if not rotation:
        return
    turned = _turned(given, rotation)
    lost = sorted((given & {*VECTORS[0]}) - turned)
    if "normal_force" in lost or ("normal_force" not in turned and "displacement" not in given):
        raise ConfigError(
            f"{where}: our normal force is made of components that are not mapped; map all three "
            "forces before turning them"
        )


def _turned(given: set[str], rotation: tuple[tuple[float, ...], ...]) -> set[str]:
    """Return what is given after the rotation: a component needs all that go into it."""
    result = given - {*VECTORS[0], *VECTORS[1]}
    for vector in VECTORS:
        for name, row in zip(vector, rotation, strict=True):
            needed = {other for other, weight in zip(vector, row, strict=True) if abs(weight) > UNITY}
            if needed <= given:
                result.add(name)
    return result


def _check_protection(hand: schema.HandMap, database: Database, name: str, spec: schema.MessageMap) -> None:
    where = f"{hand.path} [messages.{name}]"
    if hand.format:
        if spec.checksum.kind != "none":
            raise ConfigError(f"{where}: a checksum is of frames; messages of a network have none here")
        return
    _find_message(database, name, where)
    if spec.counter:
        find_signal(database, f"{name}.{spec.counter}", f"{where}: 'counter'")


def read_database(hand: schema.HandMap) -> Database:
    if hand.packets:
        return packet_database(hand.packets, str(hand.path), hand.device.offset)
    if hand.file is None:
        return Database("", {})
    if hand.format:
        return _descriptors(hand.file)
    if hand.nodes and hand.file.suffix.lower() not in EDS:
        raise ConfigError(f"{hand.path}: 'nodes' belongs to an .eds, not to {hand.file.name}")
    return read_frames(hand.file, hand.nodes)


EDS: Final = (".eds", ".dcf")


def read_frames(path: Path, nodes: Mapping[str, int]) -> Database:
    """Read the database at ``path``, an .eds for ``nodes``."""
    if path.suffix.lower() not in EDS:
        return read_dbc(path)
    from vegrip.transport.mapped.canopen_nodes import read_eds  # noqa: PLC0415 (a CANopen hand only)

    return read_eds(path, nodes)


def _descriptors(path: Path) -> Database:
    if find_spec("google") is None or find_spec("google.protobuf") is None:
        raise ConfigError(f"{path}: protobuf needs its library; pip install 'vegrip[protobuf]'")
    try:
        return Database(path.name, {}, descriptors=path.read_bytes())
    except OSError as error:
        raise ConfigError(
            f"{path}: cannot be read ({error.strerror}); 'database' is relative to the map"
        ) from None


def open_plan(path: Path | str, fingers: tuple[str, ...] | None = None) -> Plan:
    hand = schema.read_map(path)
    return make_plan(hand, read_database(hand), tuple(hand.fingers) if fingers is None else fingers)
