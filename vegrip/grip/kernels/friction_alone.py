"""Friction as the finger's own estimate has it, and the load as it is felt: a finger that shares nothing.

In the place of :mod:`vegrip.grip.kernels.friction_shared` where a finger works alone.
"""

import math

from vegrip.grip.kernels.generated import (
    ASKED_MARGIN,
    ASKED_QUANTILE,
    RULE_QUANTILE,
    RULE_WANTED_MARGIN,
    SLIDES,
    STATE_SLIP,
    Floats,
    Wholes,
)


def prepare_friction(f: Floats, _t: Wholes, _g: Floats) -> None:
    """Ask for margin and confidence as they are set."""
    f[ASKED_MARGIN], f[ASKED_QUANTILE] = f[RULE_WANTED_MARGIN], f[RULE_QUANTILE]


def update_shared_friction(_f: Floats, _t: Wholes, _g: Floats) -> None:
    """Keep what was learned: there is no other finger."""


def load_to_answer(
    _f: Floats, _t: Wholes, _g: Floats, x: float, y: float, torque: float
) -> tuple[float, float]:
    """Return tangential force [N] and torque [N m] of a load that counts."""
    return math.sqrt(x * x + y * y), torque


def is_slipping(f: Floats, _t: Wholes, _g: Floats) -> bool:
    """Return whether the finger slips by its flag."""
    return f[STATE_SLIP] >= SLIDES


def told_friction(_f: Floats, _t: Wholes, mu: float, std: float) -> tuple[float, float]:
    """Return the friction coefficient and its std as they are believed."""
    return mu, std


def restore_slip(_f: Floats, _t: Wholes) -> None:
    """Leave the state as it is: nothing was taken out of it."""
