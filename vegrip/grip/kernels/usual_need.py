"""The usual need of the last seconds: a median in slots, to which short errors of a sensor do not matter."""

import math

from vegrip.grip.kernels.generated import *


def forget_usual(f: Floats, t: Wholes) -> None:
    """Begin anew, with the window that is set now."""
    f[GRIP_SLOT] = f[RULE_USUAL_TIME] / float(USUAL_SLOTS)
    f[GRIP_PRESENT] = f[GRIP_MEDIAN] = -math.inf
    f[GRIP_FILLED] = 0.0
    f[GRIP_PROVEN], f[GRIP_PROVEN_TIME] = math.inf, f[RULE_PROVEN_TIME]
    t[TURN_SLOTS] = t[TURN_NEXT_SLOT] = 0


def add_need(f: Floats, t: Wholes, need: float, dt: float) -> float:
    """Take in a ``need`` [N] that lasted ``dt`` [s]; return the usual one [N]."""
    if f[GRIP_SLOT] <= 0.0:
        return need
    f[GRIP_PRESENT] = max(f[GRIP_PRESENT], need)
    f[GRIP_FILLED] += dt
    if f[GRIP_FILLED] >= f[GRIP_SLOT]:
        f[LARGEST0 + t[TURN_NEXT_SLOT]] = f[GRIP_PRESENT]
        t[TURN_NEXT_SLOT] = (t[TURN_NEXT_SLOT] + 1) % USUAL_SLOTS
        t[TURN_SLOTS] = min(t[TURN_SLOTS] + 1, USUAL_SLOTS)
        f[GRIP_PRESENT], f[GRIP_FILLED] = -math.inf, 0.0
        f[GRIP_MEDIAN] = median_of_slots(f, t)
        if t[TURN_SLOTS] > USUAL_SLOTS // 2:
            prove_need(f)
    if t[TURN_SLOTS] <= USUAL_SLOTS // 2:
        return max(f[GRIP_MEDIAN], need)
    return min(f[GRIP_MEDIAN], f[GRIP_PROVEN])


def prove_need(f: Floats) -> None:
    """Keep the lowest median, and let it rise to the present one."""
    if f[GRIP_PROVEN_TIME] > 0.0:
        part = min(f[GRIP_SLOT] / f[GRIP_PROVEN_TIME], 1.0)
        usual, proven = f[GRIP_MEDIAN], f[GRIP_PROVEN]
        rise = part * (usual - proven) if proven < usual else 0.0
        f[GRIP_PROVEN] = min(usual, proven + rise)


def median_of_slots(f: Floats, t: Wholes) -> float:
    """Return the median of the slots, their largest until half of the window has been seen."""
    for i in range(USUAL_SLOTS):
        if i < t[TURN_SLOTS]:
            insert_ordered(f, i, f[LARGEST0 + i])
    half = t[TURN_SLOTS] // 2 if t[TURN_SLOTS] > USUAL_SLOTS // 2 else t[TURN_SLOTS] - 1
    return f[ORDERED0 + half]


def insert_ordered(f: Floats, known: int, value: float) -> None:
    """Put ``value`` among the first ``known`` ordered ones."""
    at = known
    while at > 0 and f[ORDERED0 + at - 1] > value:
        f[ORDERED0 + at] = f[ORDERED0 + at - 1]
        at -= 1
    f[ORDERED0 + at] = value
