"""The nodes of a CANopen hand: the frames that their EDS declares, and what they need besides PDOs.

Each finger is a node. The frames of a finger are called ``<finger>_TPDO1`` .. and ``<finger>_RPDO1`` .., as
the PDO mapping of the EDS says, their signals as the objects are in the EDS. Objects that are in no PDO are
read as signals of ``<finger>_SDO``, the answers of its SDO server, and written as signals of
``<finger>_SDO_WRITE``: frames that are multiplexed by command, index and sub-index.

A node that has been switched off and on sends its boot-up message and then waits for NMT start; it gets it.
Objects that are in no PDO are asked for one after the other, one request of a node at a time, as an SDO
server expects (CiA 301, expedited upload).
"""

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from vegrip.clock import NS
from vegrip.errors import ConfigError
from vegrip.transport.codec import Frame
from vegrip.transport.mapped.database import Database, ForeignMessage, Signal
from vegrip.transport.mapped.plan import NOT_YET

PDOS: Final = {
    "TPDO": (0x1800, 0x1A00, (0x180, 0x280, 0x380, 0x480)),
    "RPDO": (0x1400, 0x1600, (0x200, 0x300, 0x400, 0x500)),
}
SIGNED: Final = (0x02, 0x03, 0x04, 0x15, 0x10)
FLOATS: Final = (0x08, 0x11)
START: Final = 1  # NMT command
SIZES: Final = {1: (0x4F, 0x2F), 2: (0x4B, 0x2B), 3: (0x47, 0x27), 4: (0x43, 0x23)}
"""Bytes -> command of an expedited upload's answer and of a download."""

OBJECT: Final = "object"
"""The multiplexer of frames of SDO: command, index and sub-index."""

ANY_SIZE: Final = 0x42  # an answer that does not say its size
WHOLE: Final = {
    kind: bits
    for bits, kinds in {8: (1, 2, 5), 16: (3, 6), 24: (0x10, 0x16), 32: (4, 7, 8)}.items()
    for kind in kinds
}
"""Data types of at most four bytes -> bits."""

FIRST_DEVICE_INDEX: Final = 0x2000  # where the objects of the maker and of device profiles begin
UNUSED: Final = 1 << 31
"""Bit of a COB-ID that says: this PDO is not there."""


def read_eds(path: Path, nodes: Mapping[str, int]) -> Database:
    """Return the frames of the ``nodes``, all of which are what the EDS at ``path`` says.

    Raises:
        ConfigError: no such file, no EDS, no node, or a mapping that cannot be.

    """
    import canopen  # noqa: PLC0415 (only for a CANopen hand)

    if not nodes:
        raise ConfigError(
            f"{path}: the map does not say which node is which finger; add nodes = {{ thumb = 32, ... }}, or "
            "--nodes thumb=32,index=33 to vegrip connect"
        )
    messages: dict[str, ForeignMessage] = {}
    for finger, node in nodes.items():
        if not 1 <= node <= 127:
            raise ConfigError(f"{path}: the node-ID of {finger} is {node}; it must lie in 1 .. 127")
        try:
            with path.open() as text:
                objects: Any = canopen.import_od(text, node_id=node)
        except FileNotFoundError:
            raise ConfigError(f"{path}: there is no such file; 'database' is relative to the map") from None
        except Exception as error:  # noqa: BLE001 (the parser has errors of its own)
            raise ConfigError(
                f"{path}: cannot be read as an EDS ({str(error)[:200] or type(error).__name__})"
            ) from None
        for kind in PDOS:
            for message in _messages(objects, kind, finger, node, path):
                messages[message.name] = message
        messages |= {message.name: message for message in _asked(objects, finger, node)}
    if not messages:
        raise ConfigError(
            f"{path}: maps no object into a PDO and describes none that SDO reads; ask the maker for the EDS "
            "of the delivered hand"
        )
    opening = tuple((0, bytes((START, node))) for node in nodes.values())
    return Database(path.name, messages, opening)


def _messages(objects: Any, kind: str, finger: str, node: int, path: Path) -> list[ForeignMessage]:
    communication, mapping, usual = PDOS[kind]
    found = []
    for number in range(512):
        if mapping + number not in objects:
            continue
        signals = _signals(objects, mapping + number, path)
        identifier = _identifier(objects, communication + number, usual[number] + node if number < 4 else 0)
        if signals and identifier is not None:
            bits = max(signal.start + signal.length for signal in signals.values())
            if bits > 64:
                raise ConfigError(f"{path}: {kind}{number + 1} maps {bits} bits; a frame has 64")
            name = f"{finger}_{kind}{number + 1}"
            found.append(ForeignMessage(name, identifier, (bits + 7) // 8, False, signals))
    return found


def _asked(objects: Any, finger: str, node: int) -> list[ForeignMessage]:
    """Return the answers and the requests by SDO, with a signal for each object."""
    reads: dict[str, Signal] = {}
    writes: dict[str, Signal] = {}
    for name, variable in _variables(objects):
        bits, access = WHOLE.get(variable.data_type, 0), str(variable.access_type)
        if not bits or variable.index < FIRST_DEVICE_INDEX:
            continue
        answer, download = SIZES[bits // 8]
        place = variable.index << 8 | variable.subindex << 24
        if access != "wo":
            _add(reads, name, variable, 32, bits, (answer | place, ANY_SIZE | place))
        if access not in ("ro", "const"):
            _add(writes, name, variable, 32, bits, (download | place,))
    found = []
    for name, base, signals in (("SDO", 0x580, reads), ("SDO_WRITE", 0x600, writes)):
        if signals:
            whole = {OBJECT: Signal(OBJECT, 0, 32), **signals}
            found.append(ForeignMessage(f"{finger}_{name}", base + node, 8, False, whole, asked=True))
    return found


def _variables(objects: Any) -> list[tuple[str, Any]]:
    found = []
    for entry in objects.values():
        if hasattr(entry, "data_type"):
            found.append((_plain(entry.name), entry))
        else:
            found += [(_plain(f"{entry.name}_{part.name}"), part) for part in entry.values()]
    return found


def _add(
    signals: dict[str, Signal],
    name: str,
    variable: Any,
    start: int,
    bits: int,
    selectors: tuple[int, ...] = (),
) -> None:
    name = name if name not in signals else f"{name}_{len(signals)}"
    signals[name] = Signal(
        name,
        start,
        bits,
        is_signed=variable.data_type in SIGNED,
        is_float=variable.data_type in FLOATS,
        scale=float(getattr(variable, "factor", 1) or 1),
        unit=str(getattr(variable, "unit", "") or ""),
        selected_by=OBJECT if selectors else "",
        selectors=selectors,
    )


def _identifier(objects: Any, index: int, usual: int) -> int | None:
    if index not in objects or 1 not in objects[index]:
        return usual or None
    entry = objects[index][1]
    value = entry.value if entry.value is not None else entry.default
    if value is None:
        return usual or None
    return None if int(value) & UNUSED else int(value) & 0x7FF


def _signals(objects: Any, index: int, path: Path) -> dict[str, Signal]:
    signals: dict[str, Signal] = {}
    start = 0
    count = _value(objects[index][0])
    for sub in range(1, count + 1):
        if sub not in objects[index]:
            break
        word = _value(objects[index][sub])
        main, part, length = word >> 16, word >> 8 & 0xFF, word & 0xFF
        if not word:
            break
        if main >= 0x20:  # below stand the dummies, which only fill
            name, variable = _variable(objects, main, part, path)
            _add(signals, name, variable, start, length)
        start += length
    return signals


def _variable(objects: Any, main: int, part: int, path: Path) -> tuple[str, Any]:
    try:
        entry = objects[main]
        if hasattr(entry, "data_type"):
            return _plain(entry.name), entry
        return _plain(f"{entry.name}_{entry[part].name}"), entry[part]
    except KeyError:
        raise ConfigError(
            f"{path}: the object {main:04X}:{part:02X} is mapped into a PDO and not described"
        ) from None


def _plain(name: str) -> str:
    return re.sub(r"\W+", "_", name).strip("_")


def _value(entry: Any) -> int:
    value = entry.value if entry.value is not None else entry.default
    return int(value or 0)


HEARTBEAT: Final = 0x700
EMERGENCY: Final = 0x080
ANSWER: Final = 0x580
REQUEST: Final = 0x600
UPLOAD: Final = 0x40
ABORT: Final = 0x80
BOOT_UP, OPERATIONAL = 0x00, 0x05
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
class CanopenNodes:
    """All nodes of a hand.

    Counts in ``rejected``: ``restarted`` (a boot-up message: the node is started again), ``not_operational``
    (heartbeats of a node that sends no PDOs), ``emergency``, ``sdo_abort`` and ``sdo_timeout``.

    Args:
        nodes: node-IDs.
        objects: what is asked for: node-ID, index, sub-index.
        period: between two requests to a node [ns].
        rejected: where it is counted.

    """

    nodes: Iterable[int]
    objects: Iterable[tuple[int, int, int]]
    period: int
    rejected: Counter[str]
    _polls: Mapping[int, _Poll] = field(init=False)
    _start: list[Frame] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.nodes = frozenset(self.nodes)
        wanted: dict[int, list[bytes]] = {}
        for node, index, sub in dict.fromkeys(self.objects):
            wanted.setdefault(node, []).append(index.to_bytes(2, "little") + bytes((sub,)))
        self._polls = {ANSWER + node: _Poll(node, tuple(each)) for node, each in wanted.items()}

    @property
    def identifiers(self) -> set[int]:
        """Identifiers of the frames that :meth:`receive` reads."""
        own = {kind + node for node in self.nodes for kind in (HEARTBEAT, EMERGENCY)}
        return own | self._polls.keys()

    def receive(self, frame: Frame) -> bool:
        """Count and answer a frame of a node; return whether it is a heartbeat, an emergency or an answer."""
        identifier, data = frame.arbitration_id, frame.data
        kind, node = identifier & ~0x7F, identifier & 0x7F
        if identifier in self._polls:
            self._polls[identifier].waits = False
            self.rejected["sdo_abort"] += data[:1] == bytes((ABORT,))
        elif kind == HEARTBEAT and node in self.nodes and data:
            self._beat(node, data[0] & 0x7F)
        elif kind == EMERGENCY and node in self.nodes:
            self.rejected["emergency"] += any(data[:2])  # code 0 ends one
        else:
            return False
        return True

    def due(self, now: int) -> list[Frame]:
        """Return the frames to send at ``now`` [ns]."""
        frames, self._start = self._start, []
        for poll in self._polls.values():
            if now - poll.asked < (SDO_TIMEOUT_NS if poll.waits else self.period):
                continue
            self.rejected["sdo_timeout"] += poll.waits
            poll.asked, poll.waits = now, True
            frames.append(poll.next())
        return frames

    def _beat(self, node: int, state: int) -> None:
        if state == BOOT_UP:
            self.rejected["restarted"] += 1
            self._start.append(Frame(0, bytes((START, node))))
        self.rejected["not_operational"] += state not in (BOOT_UP, OPERATIONAL)
