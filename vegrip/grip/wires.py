"""How states come and commands leave, for the finger step: what is called, with which arguments."""

from collections.abc import Mapping
from typing import Final, NamedTuple

from vegrip.c99 import BYTES, LONG, LONGS, MEMORY
from vegrip.c99.kinds import Kind
from vegrip.transport.codec.line import CLASSIC, FD, TOPIC

MESSAGE: Final = ""
"""No wire: states come as messages alone, from a map, in restored order, or from a program."""

ENTRIES: Final = {
    "finger_step": (MEMORY, LONGS, MEMORY, BYTES, LONG, LONG, LONG, BYTES),
    "finger_tick": (MEMORY, LONGS, MEMORY, LONG, BYTES),
    "finger_receive": (MEMORY, LONGS, MEMORY, BYTES, LONG, LONG, LONG, BYTES),
    "finger_report": (MEMORY, LONGS, LONG, BYTES, BYTES, BYTES),
}
"""What is called from outside where a state is one frame, with the kinds of its arguments."""

_JUDGED: Final = (MEMORY, LONGS, MEMORY, MEMORY, LONG, LONG, LONG)
_TIMED: Final = (MEMORY, LONGS, MEMORY, LONG)
MESSAGE_ENTRIES: Final[Mapping[str, tuple[Kind, ...]]] = {
    **dict.fromkeys(("finger_message", "finger_sense", "finger_judge"), _JUDGED),
    **dict.fromkeys(
        ("finger_take", "finger_bound", "finger_need", "finger_settle", "finger_watch", "finger_ride_out"),
        _TIMED,
    ),
}  # fmt: skip
"""What a node calls of every finger (:mod:`vegrip.grip.kernels.finger_message`)."""


NODE_ENTRIES: Final[Mapping[str, tuple[Kind, ...]]] = {
    **ENTRIES,
    "finger_part": (MEMORY, LONGS, MEMORY, BYTES, LONG, LONG, LONG, BYTES),
    "finger_values": (MEMORY, LONGS, MEMORY, MEMORY, LONG, LONG, LONG, LONG),
    **MESSAGE_ENTRIES,
}
"""What is called of the module of a finger in a node, whatever its wire."""

NODE_KERNELS: Final = (
    "reports", "part_protection", "receive_part", "finger_part", "finger_values", "finger_message",
)  # fmt: skip


class Wire(NamedTuple):
    """One way of states and commands.

    Args:
        step: what answers a state: one of the entries.
        writes: whether the step writes the bytes of commands.
        reports: what a node calls besides the step: of the entries those that pack reports.

    """

    step: str
    writes: bool = True
    reports: tuple[str, ...] = ()


WIRES: Final[Mapping[str, Wire]] = {
    FD: Wire("finger_step", reports=("finger_report",)),
    CLASSIC: Wire("finger_part"),
    TOPIC: Wire("finger_values", writes=False),
    MESSAGE: Wire("finger_message", writes=False),
}
"""By the name that a line has (:mod:`vegrip.transport.codec.line`)."""
