"""Messages <-> CAN frames, classic or FD, as ``proto/fingertip.dbc`` lays them out."""

from collections import Counter
from collections.abc import Collection, Sequence
from typing import Any, Final

from vegrip.errors import ConfigError
from vegrip.messages import (
    OF_NODES,
    ContactEstimate,
    FingertipState,
    ForceCommand,
    Message,
    NodeStatus,
    SlipMargin,
)
from vegrip.transport.codec.acceptance import acceptance_filters
from vegrip.transport.codec.assembly import Assembly
from vegrip.transport.codec.database import layouts
from vegrip.transport.codec.decoder import Decoder, HandClock
from vegrip.transport.codec.encoder import Encoder
from vegrip.transport.codec.frame import Frame
from vegrip.transport.codec.layout import Layout, Layouts
from vegrip.transport.codec.line import Line
from vegrip.transport.codec.schema import message_set

NODES: Final = ("grasp_force", "virtual_hand", "monitor", "record", "replay")
"""The numbers of nodes in the identifier of NodeStatus, unless told otherwise."""

FOREIGN_COUNT: Final = "foreign"
WHOLE: Final = frozenset({"counter", "incomplete"})
"""Why a frame is refused that is whole: it is old, or another one is missing."""


class CanCodec:
    """One hand on one bus, in one of the two layouts.

    Nothing that comes from the bus raises: :meth:`decode` returns None and counts in ``rejected`` under

    ==============  =================================================================================
    ``unknown_id``  no message has this identifier
    ``layout``      a frame of the other layout, or a classic frame where an FD frame belongs
    ``finger``      the identifier of a finger (or node) that is not configured
    ``length``      not the number of bytes of this message
    ``checksum``    the E2E checksum fails
    ``version``     another version of the message set
    ``counter``     a repeat, or older than the last one
    ``incomplete``  a part whose predecessor is missing
    ``value``       a raw value without a meaning, or infinite where that is none
    ==============  =================================================================================

    ``lost`` counts messages that never arrived, ``foreign`` frames for other hands (neither is a fault of a
    frame), ``broken`` by finger the frames of its states that could not be understood. :meth:`encode` counts
    in ``clipped``, by field, values the layout cannot carry.

    Args:
        fingers: names in the order of their numbers in the identifier, at most 8.
        fd: CAN FD layout, else classic.
        hand: number of this hand on the bus, 0 to 7.
        nodes: names of the nodes whose NodeStatus travels, in the order of their numbers, at most 8.
        use_sender_time: stamp decoded FD messages with the time of the sender, which must run on the same
            monotonic clock (one machine, or synchronised). Otherwise the receive time is the stamp.
        hand_clock: from the hand's stamp and the receive time [ns] to the time on our clock, for states in FD
            frames of a hand whose clock is its own; goes before ``use_sender_time``.
        reach: by how many of its kind an FD message may be overtaken and is still taken, out of order.

    Raises:
        ConfigError: more fingers, nodes or hands than the identifier holds, or a name twice.

    """

    def __init__(
        self,
        fingers: Sequence[str],
        *,
        fd: bool,
        hand: int = 0,
        nodes: Sequence[str] = NODES,
        use_sender_time: bool = False,
        hand_clock: HandClock | None = None,
        reach: int = 0,
    ) -> None:
        plan = layouts()
        if not 0 <= hand < plan.hands:
            raise ConfigError(
                f"hand {hand} does not fit into the identifier; it must lie in 0 .. {plan.hands - 1}"
            )
        self.fingers = _names("fingers", fingers, plan.fingers)
        self.nodes = _names("nodes", nodes, plan.fingers)
        self.fd = fd
        self._hand = hand
        self.rejected: Counter[str] = Counter()
        self.broken: Counter[str] = Counter()
        self.clipped: Counter[str] = Counter()
        self.foreign = 0
        self._encoders: dict[tuple[type[Any], str], Encoder] = {}
        self._decoders: dict[int, Decoder] = {}
        self._faults = _faults(plan, hand, fd)
        self._hand_clock, self._reach = hand_clock, reach
        for layout in plan.layouts:
            if layout.fd == fd:
                self._add(plan, layout, use_sender_time)

    @property
    def lost(self) -> int:
        """Messages that never arrived or not whole, over all streams."""
        return sum({id(d.assembly): d.assembly.lost for d in self._decoders.values()}.values())

    def encode(self, message: Message) -> list[Frame]:
        """Return the frames of ``message``, in the order they must be sent.

        The counter on the wire is ``seq``: sending a message twice is a repeat for the receiver. A quantity
        beyond the range of its signal is sent as "not measured" (a force command: as the end of the range,
        never more than asked for) and counted. A message that cannot be sent at all - a command that is not
        finite, a finger or node that is not configured - gives no frame and is counted. A kind of message
        that is not told on CAN gives none either, and is not counted.
        """
        kind = type(message)
        # a node is known without its namespace: on CAN the number of the hand is that
        owner = message.node.rpartition("/")[2] if isinstance(message, OF_NODES) else message.finger
        encoder = self._encoders.get((kind, owner))
        if encoder is None and not message_set().messages[kind].on_can:
            return []
        if encoder is None:
            self.clipped["finger"] += 1
            return []
        return encoder.encode(message)

    def decode(self, frame: Frame, known_as: int | None = None) -> Message | None:
        """Return the message that ``frame`` completes, None when there is none (yet).

        ``known_as`` is its identifier on a bus where it has another one.
        """
        identifier = frame.arbitration_id if known_as is None else known_as
        decoder = self._decoders.get(identifier)
        if decoder is None:
            self._refuse(self._faults.get(identifier, "unknown_id"))
            return None
        result = decoder.decode(frame)
        if isinstance(result, str):
            self._refuse(result)
            if decoder.kind is FingertipState and result not in WHOLE:
                self.broken[decoder.owner] += 1
            return None
        return result

    def filters(self, kinds: Collection[type[Message]]) -> list[tuple[int, int]]:
        """Return identifiers and masks of acceptance filters for messages of ``kinds`` to this hand."""
        return acceptance_filters(layouts(), self._hand, kinds)

    def line(self, finger: str) -> Line | None:
        """Return how states and commands of ``finger`` travel, for a program that reads and writes the bytes.

        None where that takes more than the bytes of one frame: in classic frames, with a clock of the hand,
        or with messages out of order.
        """
        if not self.fd or self._hand_clock is not None or self._reach or finger not in self.fingers:
            return None
        states = next(d for d in self._decoders.values() if d.owner == finger and d.kind is FingertipState)
        reports = [self._encoders[kind, finger] for kind in (ContactEstimate, SlipMargin)]
        return Line(states, self._encoders[ForceCommand, finger], reports)

    def reset(self) -> None:
        """Forget all counters: what comes next begins new streams (a replay that starts over)."""
        for decoder in self._decoders.values():
            decoder.assembly.reset()

    def _refuse(self, name: str) -> None:
        if name == FOREIGN_COUNT:
            self.foreign += 1
        else:
            self.rejected[name] += 1

    def _add(self, plan: Layouts, layout: Layout, use_sender_time: bool) -> None:
        for number, owner in enumerate(self.nodes if layout.schema.cls is NodeStatus else self.fingers):
            offset = self._hand * plan.hand_stride + number * plan.finger_stride
            self._encoders[layout.schema.cls, owner] = Encoder(layout, offset, plan.version, self.clipped)
            assembly = Assembly(layout.parts, self._reach)
            clock = self._hand_clock if layout.schema.cls is FingertipState else None
            for part in layout.parts:
                identifier = part.base + offset
                self._decoders[identifier] = Decoder(
                    layout, part, assembly, identifier, owner, plan.version, use_sender_time, clock
                )


def _faults(plan: Layouts, hand: int, fd: bool) -> dict[int, str]:
    """Return what is wrong with each identifier that the database knows and this codec does not decode."""
    faults: dict[int, str] = {}
    for layout in plan.layouts:
        for part in layout.parts:
            for other in range(plan.hands):
                name = FOREIGN_COUNT if other != hand else "finger" if layout.fd == fd else "layout"
                first = part.base + other * plan.hand_stride
                faults |= dict.fromkeys(range(first, first + plan.fingers * plan.finger_stride), name)
    return faults


def _names(what: str, names: Sequence[str], limit: int) -> tuple[str, ...]:
    if len(names) > limit or len(set(names)) != len(names):
        raise ConfigError(f"{what} {list(names)} must be at most {limit} different names")
    return tuple(names)
