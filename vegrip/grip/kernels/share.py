"""Balance of the internal forces of a grasp: the thumb carries what the fingers press.

The fingers press the object against the thumb, so at rest the normal forces obey (no weight along the normal)

    N_thumb = sum_i N_i .

Given the least force ``m`` that each finger needs on its own, the smallest forces that obey it and give every
finger at least its need are

    S = max(m_thumb, sum_i m_i),      N_i = S m_i / sum_i m_i,      N_thumb = S .

Every finger's minimum comes first: nothing is ever lowered to reach the balance. What the balance adds is
internal force that the wrench does not need; it is the price of one thumb.

Fingers whose needs fall are lowered at a limited rate. The thumb presses as much as they are commanded
meanwhile, and is lowered as they are together: its own rate would leave it pressing alone.

``g[i]`` is the force [N] that finger ``i`` needs, NaN while it has no command. Every finger writes its own;
whatever is known of the whole grasp has its place between :func:`share_need` and :func:`balanced_force`.
"""

import math

from vegrip.grip.grasp_memory import GraspMemory
from vegrip.grip.kernels.generated import *


def share_need(f: Floats, t: Wholes, g: GraspMemory) -> None:
    """Let the grasp know what this finger needs."""
    g[t.setup.finger] = f.grip.required if t.turn.started == 1 else math.nan


def balanced_force(t: Wholes, g: GraspMemory) -> float:
    """Return the force [N] of this finger with which the grasp balances and every need is met."""
    own, thumb = g[t.setup.finger], t.setup.thumb
    pressed, others = 0.0, 0.0
    for i in range(t.setup.fingers):
        if i != thumb and not math.isnan(g[i]):
            pressed += g[i]
            others += 1.0
    if thumb < 0 or others == 0.0 or math.isnan(g[max(thumb, 0)]):
        return own
    total = max(g[thumb], pressed)
    if t.setup.finger == thumb:
        return total
    return total * (own / pressed) if pressed > 0.0 else total / others
