"""Acceptance filters of 11 bits let through all identifiers but those that are of no use, each once."""

import pytest

from vegrip.messages import FingertipState, ForceCommand, NodeStatus
from vegrip.transport.codec.can_codec import CanCodec, _cover
from vegrip.transport.codec.database import layouts

EVERY = range(1 << 11)


def useless(hand: int, kinds: set[type]) -> set[int]:
    """Return the identifiers of other kinds and of other hands, one by one."""
    plan = layouts()
    return {
        part.base + other * plan.hand_stride + finger * plan.finger_stride + low
        for layout in plan.layouts
        for part in layout.parts
        for other in range(plan.hands)
        if other != hand or layout.schema.cls not in kinds
        for finger in range(plan.fingers)
        for low in range(plan.finger_stride)
    }


@pytest.mark.parametrize("hand", [0, 2])
@pytest.mark.parametrize("kinds", [{ForceCommand}, {FingertipState, NodeStatus}, set()])
def test_filters_let_through_all_but_what_is_useless(hand: int, kinds: set[type]) -> None:
    filters = CanCodec((), fd=True, hand=hand).filters(kinds)
    assert all(0 <= first <= 0x7FF and 0 <= mask <= 0x7FF for first, mask in filters)
    passing = [sum(identifier & mask == first & mask for first, mask in filters) for identifier in EVERY]
    assert set(passing) <= {0, 1}
    assert {identifier for identifier in EVERY if not passing[identifier]} == useless(hand, kinds)


def test_where_all_is_useful_one_filter_lets_everything_through() -> None:
    assert _cover(set(), 0, 11) == [(0, 0)]
    assert _cover({3}, 0, 2) == [(0, 0x7FE), (2, 0x7FF)]
