"""What is called of the module of a finger from outside, with the kinds of the arguments."""

from collections.abc import Mapping
from typing import Final

from vegrip.c99 import BYTES, LONG, LONGS, MEMORY
from vegrip.c99.kinds import Kind

LEFT_ALONE: Final = 0
"""The step did not take the frame, and changed nothing."""
COMMANDED: Final = 2
"""Bit of a step after which there is a command."""
REPORT: Final = 4
"""Bit of a step after which something is due to be reported."""

STATE_BYTES: Final = 48
COMMAND_BYTES: Final = 24
REPORT_BYTES: Final = (64, 64, 48)
"""Of the frames of a report: both of a contact, and that of a slip margin."""

ENTRIES: Final = {
    "finger_step": (MEMORY, LONGS, MEMORY, BYTES, LONG, LONG, LONG, BYTES),
    "finger_tick": (MEMORY, LONGS, MEMORY, LONG, BYTES),
    "finger_receive": (MEMORY, LONGS, MEMORY, BYTES, LONG, LONG, LONG, BYTES),
    "finger_report": (MEMORY, LONGS, LONG, BYTES, BYTES, BYTES),
}
"""Where a state is one frame."""

FRAME_ENTRIES: Final = ("finger_step", "finger_report")
"""What a node calls of them."""

_JUDGED: Final = (MEMORY, LONGS, MEMORY, MEMORY, LONG, LONG, LONG)
_TIMED: Final = (MEMORY, LONGS, MEMORY, LONG)
MESSAGE_ENTRIES: Final[Mapping[str, tuple[Kind, ...]]] = {
    **dict.fromkeys(("finger_message", "finger_sense", "finger_judge"), _JUDGED),
    **dict.fromkeys(
        ("finger_take", "finger_bound", "finger_need", "finger_settle", "finger_watch", "finger_hold_last"),
        _TIMED,
    ),
}  # fmt: skip
"""What a node calls besides, of every finger (:mod:`vegrip.grip.kernels.finger_message`)."""

NODE_ENTRIES: Final[Mapping[str, tuple[Kind, ...]]] = {**ENTRIES, **MESSAGE_ENTRIES}
"""All of a finger in a node."""
