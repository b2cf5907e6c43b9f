"""The nodes of a CANopen hand: the frames that their EDS declares, and what they need besides PDOs.

Each finger is a node. The frames of a finger are called ``<finger>_TPDO1`` .. and ``<finger>_RPDO1`` .., as
the PDO mapping of the EDS says, their signals as the objects are in the EDS. Objects that are in no PDO are
read as signals of ``<finger>_SDO``, the answers of its SDO server, and written as signals of
``<finger>_SDO_WRITE``: frames that are multiplexed by command, index and sub-index.

A node that has been switched off and on sends its boot-up message and then waits for NMT start; it gets it.
So does one that falls back to pre-operational, as CiA 301 has it for communication errors, or that never ran:
at once, then ever more rarely, until it runs.
Objects that are in no PDO are asked for one after the other, one request of a node at a time, as an SDO
server expects (CiA 301, expedited upload).
"""

import io
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from vegrip.clock import NOT_YET, NS
from vegrip.errors import ConfigError, first_line
from vegrip.text_encoding import decoded
from vegrip.transport.codec import Frame
from vegrip.transport.maps.database import Database
from vegrip.transport.maps.signals import ForeignMessage, Signal

PDOS: Final = {"TPDO": (0x1800, 0x1A00, 0x180), "RPDO": (0x1400, 0x1600, 0x200)}
"""First index of communication and of mapping, and the usual identifier of the first; then 0x100 further."""
USUAL_PDOS: Final = 4  # PDOs that have one
START: Final = 1  # NMT command
SIZES: Final = {1: (0x4F, 0x2F), 2: (0x4B, 0x2B), 3: (0x47, 0x27), 4: (0x43, 0x23)}
"""Bytes -> command of an expedited upload's answer and of a download."""
ANY_SIZE: Final = 0x42  # an answer that does not say its size
OBJECT: Final = "object"
"""The multiplexer of frames of SDO: command, index and sub-index."""
FIRST_DEVICE_INDEX: Final = 0x2000  # where the objects of the maker and of device profiles begin
FIRST_OBJECT: Final = 0x20  # below stand the dummies of a mapping, which only fill
UNUSED: Final = 1 << 31
"""Bit of a COB-ID that says: this PDO is not there."""


def read_eds(path: Path, nodes: Mapping[str, int]) -> Database:
    """Return the frames of the ``nodes``, all of which are what the EDS at ``path`` says."""
    import canopen  # noqa: PLC0415 (only for a CANopen hand)

    if not nodes:
        raise ConfigError(
            f"{path}: the map does not say which node is which finger; add nodes = {{ thumb = 32, ... }}"
        )
    messages: list[ForeignMessage] = []
    left_out: dict[int, str] = {}
    for finger, node in nodes.items():
        if not 1 <= node <= 127:
            raise ConfigError(f"{path}: the node-ID of {finger} is {node}; it must lie in 1 .. 127")
        try:
            text = io.StringIO(decoded(path.read_bytes()))
            text.name = f"{path.stem}.eds"  # by which canopen knows what it is
            objects: Any = canopen.import_od(text, node_id=node)
        except FileNotFoundError:
            raise ConfigError(f"{path}: there is no such file; 'database' is relative to the map") from None
        except Exception as error:  # noqa: BLE001 (the parser has errors of its own)
            raise ConfigError(f"{path}: cannot be read as an EDS ({first_line(error)[:200]})") from None
        for kind in PDOS:
            messages += _pdos(objects, kind, finger, node, path, left_out)
        messages += _asked(objects, finger, node)
    if not messages:
        raise ConfigError(
            f"{path}: maps no object into a PDO and describes none that SDO reads; ask the maker for the EDS "
            f"of the delivered hand{''.join(f'; {why}' for why in left_out.values())}"
        )
    opening = tuple((0, bytes((START, node))) for node in nodes.values())
    named = {message.name: message for message in messages}
    return Database(path.name, named, opening, left_out=left_out)


def _pdos(
    objects: Any, kind: str, finger: str, node: int, path: Path, left_out: dict[int, str]
) -> Iterator[ForeignMessage]:
    communication, mapping, usual = PDOS[kind]
    for number in range(512):
        if mapping + number not in objects:
            continue
        signals = _signals(objects, mapping + number, path)
        identifier = usual + 0x100 * number + node if number < USUAL_PDOS else 0
        if communication + number in objects and 1 in objects[communication + number]:
            identifier = _value(objects[communication + number][1]) or identifier
        name = f"{finger}_{kind}{number + 1}"
        if identifier & UNUSED and kind == "TPDO":
            left_out[identifier & 0x7FF] = (
                f"{name} is switched off (bit 31 of its COB-ID) in this EDS; give the .dcf of the node as set"
            )
        elif not signals and identifier and kind == "TPDO":
            left_out[identifier & 0x7FF] = (
                f"{name} maps no object (sub-index 0 of {mapping + number:04X} is 0) in this EDS; give the "
                ".dcf of the node as set"
            )
        if not signals or not identifier or identifier & UNUSED:
            continue
        bits = max(signal.start + signal.length for signal in signals.values())
        if bits > 64:
            raise ConfigError(f"{path}: {kind}{number + 1} maps {bits} bits; a frame has 64")
        yield ForeignMessage(name, identifier & 0x7FF, (bits + 7) // 8, False, signals)


def _signals(objects: Any, index: int, path: Path) -> dict[str, Signal]:
    signals: dict[str, Signal] = {}
    start = 0
    for sub in range(1, _value(objects[index][0]) + 1):
        word = _value(objects[index][sub]) if sub in objects[index] else 0
        if not word:
            break
        main, part, length = word >> 16, word >> 8 & 0xFF, word & 0xFF
        if main >= FIRST_OBJECT:
            try:
                _add(signals, objects, main, part, start, length)
            except KeyError:
                raise ConfigError(
                    f"{path}: the object {main:04X}:{part:02X} is mapped into a PDO and not described"
                ) from None
        start += length
    return signals


def _asked(objects: Any, finger: str, node: int) -> Iterator[ForeignMessage]:
    from canopen.objectdictionary import datatypes  # noqa: PLC0415

    numbers = (datatypes.BOOLEAN, *datatypes.NUMBER_TYPES)
    answers: dict[str, Signal] = {}
    requests: dict[str, Signal] = {}
    for entry in objects.values():
        for variable in [entry] if hasattr(entry, "data_type") else entry.values():
            is_asked = variable.index >= FIRST_DEVICE_INDEX and variable.data_type in numbers
            if not is_asked or len(variable) // 8 not in SIZES:
                continue
            answer, download = SIZES[len(variable) // 8]
            about = objects, variable.index, variable.subindex, 32, len(variable)
            place = variable.index << 8 | variable.subindex << 24
            if variable.access_type != "wo":
                _add(answers, *about, (answer | place, ANY_SIZE | place))
            if variable.access_type not in ("ro", "const"):
                _add(requests, *about, (download | place,))
    for name, base, signals in (("SDO", 0x580, answers), ("SDO_WRITE", 0x600, requests)):
        if signals:
            whole = {OBJECT: Signal(OBJECT, 0, 32), **signals}
            yield ForeignMessage(f"{finger}_{name}", base + node, 8, False, whole, asked=True)


def _add(
    signals: dict[str, Signal],
    objects: Any,
    main: int,
    part: int,
    start: int,
    bits: int,
    selectors: tuple[int, ...] = (),
) -> None:
    """Add the object ``main``, ``part`` to ``signals``; KeyError: there is none."""
    from canopen.objectdictionary import datatypes  # noqa: PLC0415

    entry = objects[main]
    variable = entry if hasattr(entry, "data_type") else entry[part]
    name = entry.name if variable is entry else f"{entry.name}_{variable.name}"
    name = re.sub(r"\W+", "_", name).strip("_")
    name = name if name not in signals else f"{name}_{len(signals)}"
    signals[name] = Signal(
        name,
        start,
        bits,
        is_signed=variable.data_type in datatypes.SIGNED_TYPES,
        is_float=variable.data_type in datatypes.FLOAT_TYPES,
        scale=float(variable.factor or 1),
        unit=str(variable.unit or ""),
        selected_by=OBJECT if selectors else "",
        selectors=selectors,
    )


def _value(entry: Any) -> int:
    return int((entry.default if entry.value is None else entry.value) or 0)


HEARTBEAT: Final = 0x700
EMERGENCY: Final = 0x080
ANSWER: Final = 0x580
REQUEST: Final = 0x600
UPLOAD: Final = 0x40
ABORT: Final = 0x80
BOOT_UP, OPERATIONAL = 0x00, 0x05
FIRST_WAIT_NS, LONGEST_WAIT_NS = NS // 4, 4 * NS
"""[ns] between two NMT starts of a node that does not run: doubled each time, up to the longest."""
STEADY_NS: Final = 5 * NS  # [ns] of running after which the waits begin anew
AWAY_NS: Final = 2 * NS  # [ns] without a frame of a node, after which it is named
SDO_TIMEOUT_NS: Final = NS // 20  # [ns] for an answer by SDO


@dataclass(slots=True)
class _Poll:
    """The objects of one node that are asked for in turn: index and sub-index as bytes."""

    node: int
    objects: tuple[bytes, ...]
    turn: int = 0
    asked: int = NOT_YET  # [ns] when last
    waits: bool = False

    def next(self) -> Frame:
        frame = Frame(REQUEST + self.node, bytes((UPLOAD,)) + self.objects[self.turn] + bytes(4))
        self.turn = (self.turn + 1) % len(self.objects)
        return frame


@dataclass(slots=True)
class _Starts:
    """When one node is started: at its boot-up, and as long as it does not run, ever more rarely."""

    node: int
    name: str
    is_running: bool = False  # it said so, or sent a PDO
    is_booted: bool = False  # it has just said so
    is_received: bool = False  # since the last look
    is_away: bool = False
    received: int = NOT_YET  # [ns] last
    started: int = NOT_YET
    wait: int = FIRST_WAIT_NS

    def is_due(self, now: int) -> bool:
        if self.is_received or self.received == NOT_YET:
            self.received, self.is_received, self.is_away = now, False, False
        if self.started == NOT_YET:  # the endpoint has just sent the first
            self.started = now
        if self.is_running and now - self.started > STEADY_NS:
            self.wait = FIRST_WAIT_NS
        if not self.is_booted and (self.is_running or now - self.started < self.wait):
            return False
        self.wait = self.wait if self.is_booted else min(2 * self.wait, LONGEST_WAIT_NS)
        self.started, self.is_booted = now, False
        return True


@dataclass(slots=True)
class CanopenNodes:
    """All nodes of a hand.

    Counts in ``rejected``: ``restarted`` (a boot-up message: the node is started again), ``not_operational``
    (heartbeats of a node that sends no PDOs), ``started_again`` (NMT starts of a node that did not run),
    ``away_<finger>`` (nothing came of the node), ``emergency``, ``sdo_abort`` and ``sdo_timeout``.
    """

    nodes: Iterable[int]
    objects: Iterable[tuple[int, int, int]]  # node-ID, index, sub-index of what is asked for
    period: int  # [ns] between two requests to a node
    rejected: Counter[str]
    names: Mapping[int, str] = field(default_factory=dict)  # of the fingers
    pdos: Mapping[int, int] = field(default_factory=dict)  # identifier -> node
    _polls: Mapping[int, _Poll] = field(init=False)
    _starts: Mapping[int, _Starts] = field(init=False)

    def __post_init__(self) -> None:
        self.nodes = frozenset(self.nodes)
        self.begin()
        wanted: dict[int, list[bytes]] = {}
        for node, index, sub in dict.fromkeys(self.objects):
            wanted.setdefault(node, []).append(index.to_bytes(2, "little") + bytes((sub,)))
        self._polls = {ANSWER + node: _Poll(node, tuple(each)) for node, each in wanted.items()}

    def begin(self) -> None:
        """Know nothing of the nodes: the bus has just been opened, and each was sent a start."""
        self._starts = {node: _Starts(node, self.names.get(node, str(node))) for node in self.nodes}

    @property
    def identifiers(self) -> set[int]:
        own = {kind + node for node in self.nodes for kind in (HEARTBEAT, EMERGENCY)}
        return own | self._polls.keys()

    def receive(self, frame: Frame) -> bool:
        """Count and answer a frame of a node; return whether it is a heartbeat, an emergency or an answer."""
        identifier, data = frame.arbitration_id, frame.data
        kind, node = identifier & ~0x7F, identifier & 0x7F
        if identifier in self.pdos:
            self._starts[self.pdos[identifier]].is_received = self._starts[
                self.pdos[identifier]
            ].is_running = True
            return False
        if node in self._starts and kind in (HEARTBEAT, ANSWER, EMERGENCY):
            self._starts[node].is_received = True
        if identifier in self._polls:
            self._polls[identifier].waits = False
            self._starts[node].is_running = True
            self.rejected["sdo_abort"] += data[:1] == bytes((ABORT,))
        elif kind == HEARTBEAT and node in self.nodes and data:
            state = data[0] & 0x7F
            self._starts[node].is_running = state == OPERATIONAL
            if state == BOOT_UP:
                self.rejected["restarted"] += 1
                self._starts[node].is_booted = True
            self.rejected["not_operational"] += state not in (BOOT_UP, OPERATIONAL)
        elif kind == EMERGENCY and node in self.nodes:
            self.rejected["emergency"] += any(data[:2])  # code 0 ends one
        else:
            return False
        return True

    def due(self, now: int) -> list[Frame]:
        """Return the frames to send at ``now`` [ns]."""
        frames = []
        for one in self._starts.values():
            is_repeated = not one.is_booted
            if one.is_due(now):
                frames.append(Frame(0, bytes((START, one.node))))
                self.rejected["started_again"] += is_repeated
            if now - one.received > AWAY_NS and not one.is_away:
                one.is_away = True
                self.rejected[f"away_{one.name}"] += 1
        for poll in self._polls.values():
            if now - poll.asked < (SDO_TIMEOUT_NS if poll.waits else self.period):
                continue
            self.rejected["sdo_timeout"] += poll.waits
            poll.asked, poll.waits = now, True
            frames.append(poll.next())
        return frames
