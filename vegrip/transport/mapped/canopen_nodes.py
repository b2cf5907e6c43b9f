"""What the nodes of a foreign CANopen hand need besides PDOs: heartbeat, restart, emergency, polling by SDO.

A node that has been switched off and on says so by its boot-up message and then waits for NMT start; it gets
it. Objects that are in no PDO are asked for one after the other, one request of a node at a time, as an SDO
server expects (CiA 301, expedited upload).
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final

from vegrip.clock import NS
from vegrip.transport.codec import Frame

HEARTBEAT: Final = 0x700
EMERGENCY: Final = 0x080
ANSWER: Final = 0x580
REQUEST: Final = 0x600
UPLOAD: Final = 0x40
ABORT: Final = 0x80
BOOT_UP, OPERATIONAL = 0x00, 0x05
START: Final = 1
SDO_TIMEOUT_NS: Final = NS // 20  # [ns] for an answer by SDO
NEVER: Final = -(1 << 62)


@dataclass(slots=True)
class _Poll:
    """The objects of one node that are asked for in turn: index and sub-index as bytes."""

    node: int
    objects: tuple[bytes, ...]
    turn: int = 0
    asked: int = NEVER  # [ns] when last
    waits: bool = False

    def next(self) -> Frame:
        """Return the next request."""
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
        """Those of all frames that are looked at."""
        own = {kind + node for node in self.nodes for kind in (HEARTBEAT, EMERGENCY)}
        return own | self._polls.keys()

    def take(self, frame: Frame) -> bool:
        """Look at a frame; return whether it is one of these."""
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
