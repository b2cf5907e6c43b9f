"""How states come and commands leave, for the compiled step: which texts it has, and what is called."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final

from vegrip.c99 import BYTES, LONG, LONGS, MEMORY
from vegrip.c99.kinds import Kind
from vegrip.transport.codec.kernel_text import wire_text
from vegrip.transport.codec.line import CLASSIC, FD, TOPIC
from vegrip.transport.codec.part_text import part_text, payload_bytes

ENTRIES: Final = {
    "finger_step": (MEMORY, LONGS, MEMORY, BYTES, LONG, LONG, LONG, BYTES),
    "finger_tick": (MEMORY, LONGS, MEMORY, LONG, BYTES),
    "finger_receive": (MEMORY, LONGS, MEMORY, BYTES, LONG, LONG, LONG, BYTES),
    "finger_report": (MEMORY, LONGS, LONG, BYTES, BYTES, BYTES),
}
"""What is called from outside where a state is one frame, with the kinds of its arguments."""


@dataclass(frozen=True)
class Wire:
    """One way of states and commands.

    Args:
        step: what answers a state: one of the entries.
        entries: what is called from outside, with the kinds of its arguments.
        kernels: files beside those that every step has.
        text: gives the functions that are written from the DBC.
        part_bytes: gives the length of the values of all frames of a state, where several make one.
        writes: whether the step writes the bytes of commands.
        reports: what a node calls besides the step: of the entries those that pack reports.

    """

    step: str
    entries: Mapping[str, tuple[Kind, ...]]
    kernels: tuple[str, ...] = ()
    text: Callable[[], str] = wire_text
    part_bytes: Callable[[], int] = field(default=lambda: 0)
    writes: bool = True
    reports: tuple[str, ...] = ()


def _with_parts() -> str:
    return wire_text() + part_text()


WIRES: Final[Mapping[str, Wire]] = {
    FD: Wire("finger_step", ENTRIES, ("reports",), reports=("finger_report",)),
    CLASSIC: Wire(
        "finger_part",
        {"finger_part": (MEMORY, LONGS, MEMORY, BYTES, LONG, LONG, LONG, BYTES)},
        ("part_protection", "receive_part", "finger_part"),
        _with_parts,
        payload_bytes,
    ),
    TOPIC: Wire(
        "finger_values",
        {"finger_values": (MEMORY, LONGS, MEMORY, MEMORY, LONG, LONG, LONG, LONG)},
        ("finger_values",),
        writes=False,
    ),
}
"""By the name that a line has (:mod:`vegrip.transport.codec.line`)."""
