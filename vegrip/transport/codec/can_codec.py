"""Messages <-> CAN frames, classic or FD, as ``proto/fingertip.dbc`` lays them out."""

from collections.abc import Collection, Sequence
from typing import Final

from vegrip.errors import ConfigError
from vegrip.messages import OF_NODES, FingertipState, Message, NodeStatus
from vegrip.transport.codec.database import Layouts, layouts
from vegrip.transport.codec.frame import Frame
from vegrip.transport.codec.frame_codec import FrameCodec, HandClock, Line
from vegrip.transport.codec.schema import message_set

NODES: Final = ("grasp_force", "virtual_hand", "monitor", "record", "replay")
"""Nodes whose NodeStatus travels, in the order of their numbers in its identifier."""

FOREIGN_COUNT: Final = "foreign"


class CanCodec(FrameCodec):
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
        use_sender_time: stamp decoded FD messages with the time of the sender, which must run on the same
            monotonic clock (one machine, or synchronised). Otherwise the receive time is the stamp.
        hand_clock: from the hand's stamp and the receive time [ns] to the time on our clock, for states in FD
            frames of a hand whose clock is its own; goes before ``use_sender_time``.
        reach: by how many of its kind an FD message may be overtaken and is still taken, out of order.

    """

    def __init__(
        self,
        fingers: Sequence[str],
        *,
        fd: bool,
        hand: int = 0,
        use_sender_time: bool = False,
        hand_clock: HandClock | None = None,
        reach: int = 0,
    ) -> None:
        plan = layouts()
        if not 0 <= hand < plan.hands:
            raise ConfigError(
                f"hand {hand} does not fit into the identifier; it must lie in 0 .. {plan.hands - 1}"
            )
        super().__init__(_names(fingers, plan.fingers))
        self.foreign = 0
        self._hand = hand
        self._refusals = _refusals(plan, hand, fd)
        self._has_line = fd and hand_clock is None and not reach
        for layout in (one for one in plan.layouts if one.fd == fd):
            clock = hand_clock if layout.schema.cls is FingertipState else None
            for number, owner in enumerate(NODES if layout.schema.cls is NodeStatus else self.fingers):
                offset = hand * plan.hand_stride + number * plan.finger_stride
                self.add_stream(layout, owner, offset, use_sender_time, clock, reach)

    def encode(self, message: Message) -> list[Frame]:
        """Return the frames of ``message``, in the order they must be sent.

        The counter on the wire is ``seq``: sending a message twice is a repeat for the receiver. A quantity
        beyond the range of its signal is sent as "not measured" (a force command: as the end of the range,
        never more than asked for) and counted. A message that cannot be sent at all - a command that is not
        finite, a finger or node that is not configured - gives no frame and is counted. A kind of message
        that is not sent on CAN gives none either, and is not counted.
        """
        if not message_set().messages[type(message)].on_can:
            return []
        # a node is known without its namespace: on CAN the number of the hand is that
        owner = message.node.rpartition("/")[2] if isinstance(message, OF_NODES) else message.finger
        return self.encode_as(message, owner)

    def decode(self, frame: Frame, known_as: int | None = None) -> Message | None:
        """Return the message that ``frame`` completes, None when there is none (yet).

        ``known_as`` is its identifier on a bus where it has another one.
        """
        identifier = frame.arbitration_id if known_as is None else known_as
        refusal = "" if identifier in self._decoders else self._refusals.get(identifier, "unknown_id")
        if refusal == FOREIGN_COUNT:
            self.foreign += 1
            return None
        return self.decode_as(identifier, frame, refusal)

    def filters(self, kinds: Collection[type[Message]]) -> list[tuple[int, int]]:
        return acceptance_filters(layouts(), self._hand, kinds)

    def line(self, finger: str) -> Line | None:
        return super().line(finger) if self._has_line else None


def _refusals(plan: Layouts, hand: int, fd: bool) -> dict[int, str]:
    found: dict[int, str] = {}
    for layout in plan.layouts:
        for part in layout.parts:
            for other in range(plan.hands):
                name = FOREIGN_COUNT if other != hand else "finger" if layout.fd == fd else "layout"
                found |= dict.fromkeys(plan.block(part.base, other), name)
    return found


def _names(names: Sequence[str], limit: int) -> tuple[str, ...]:
    if len(names) > limit or len(set(names)) != len(names):
        raise ConfigError(f"fingers {list(names)} must be at most {limit} different names")
    return tuple(names)


IDENTIFIER_BITS = 11


def acceptance_filters(plan: Layouts, hand: int, kinds: Collection[type[Message]]) -> list[tuple[int, int]]:
    """Return identifiers and masks (11 bits) that let through what ``hand`` is sent of ``kinds``.

    What is left out is known to be of no use: messages of other kinds, and those of other hands. All else
    comes through, also identifiers that are in no table, so that a fault is still noticed and counted.
    """
    unwanted = {
        identifier
        for layout in plan.layouts
        for part in layout.parts
        for other in range(plan.hands)
        if other != hand or layout.schema.cls not in kinds
        for identifier in plan.block(part.base, other)
    }
    return _cover(unwanted, 0, IDENTIFIER_BITS)


def _cover(unwanted: set[int], first: int, free: int) -> list[tuple[int, int]]:
    """Return the filters for the block of ``2**free`` identifiers from ``first`` on, without ``unwanted``."""
    inside = {identifier for identifier in unwanted if identifier >> free == first >> free}
    if not inside:
        return [(first, (1 << IDENTIFIER_BITS) - (1 << free))]
    if free == 0:
        return []
    half = 1 << (free - 1)
    return [*_cover(inside, first, free - 1), *_cover(inside, first + half, free - 1)]
