"""Which identifiers a node wants to hear, as acceptance filters for its CAN controller.

What is left out is known to be of no use: messages of other kinds, and those of other hands. All else comes
through, also identifiers that are in no table, so that a fault is still noticed and counted.
"""

from collections.abc import Collection

from vegrip.messages import Message
from vegrip.transport.codec.layout import Layouts

IDENTIFIER_BITS = 11


def acceptance_filters(plan: Layouts, hand: int, kinds: Collection[type[Message]]) -> list[tuple[int, int]]:
    """Return identifiers and masks (11 bits) that let through what ``hand`` is sent of ``kinds``."""
    unwanted = {
        identifier
        for layout in plan.layouts
        for part in layout.parts
        for other in range(plan.hands)
        if other != hand or layout.schema.cls not in kinds
        for identifier in _block(plan, part.base + other * plan.hand_stride)
    }
    return _cover(unwanted, 0, IDENTIFIER_BITS)


def _block(plan: Layouts, first: int) -> range:
    return range(first, first + plan.fingers * plan.finger_stride)


def _cover(unwanted: set[int], first: int, free: int) -> list[tuple[int, int]]:
    """Return the filters for the block of ``2**free`` identifiers from ``first`` on, without ``unwanted``."""
    inside = {identifier for identifier in unwanted if identifier >> free == first >> free}
    if not inside:
        return [(first, (1 << IDENTIFIER_BITS) - (1 << free))]
    if free == 0:
        return []
    half = 1 << (free - 1)
    return [*_cover(inside, first, free - 1), *_cover(inside, first + half, free - 1)]
