"""A finger's share of the grasp: balance against a thumb (:mod:`vegrip.grip.allocation.balance`).

``g[i]`` is the force [N] that finger ``i`` needs, NaN while it has no command. Every finger writes its own;
whatever is known of the whole grasp has its place between :func:`tell_need` and :func:`shared_force`.
"""

import math

from vegrip.grip.kernels.generated import (
    GRIP_REQUIRED,
    SETUP_FINGER,
    SETUP_FINGERS,
    SETUP_THUMB,
    TURN_STARTED,
    Floats,
    Wholes,
)


def tell_need(f: Floats, t: Wholes, g: Floats) -> None:
    """Tell the grasp what this finger needs."""
    g[t[SETUP_FINGER]] = f[GRIP_REQUIRED] if t[TURN_STARTED] == 1 else math.nan


def shared_force(t: Wholes, g: Floats) -> float:
    """Return the force [N] of this finger with which the grasp balances and every need is met."""
    own, thumb = g[t[SETUP_FINGER]], t[SETUP_THUMB]
    pressed, others = 0.0, 0.0
    for i in range(t[SETUP_FINGERS]):
        if i != thumb and not math.isnan(g[i]):
            pressed += g[i]
            others += 1.0
    if thumb < 0 or others == 0.0 or math.isnan(g[max(thumb, 0)]):
        return own
    total = max(g[thumb], pressed)
    if t[SETUP_FINGER] == thumb:
        return total
    return total * (own / pressed) if pressed > 0.0 else total / others
