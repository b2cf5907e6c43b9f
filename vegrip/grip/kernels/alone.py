"""A finger that works alone: friction as its own estimate has it, the load as it is felt, the margin grip.

In the place of :mod:`vegrip.grip.kernels.friction_shared` and :mod:`vegrip.grip.kernels.choice`.
"""

import math

from vegrip.grip.grasp_memory import GraspMemory
from vegrip.grip.kernels.generated import *
from vegrip.grip.kernels.margin_grip import forget_grip, wanted_force
from vegrip.grip.kernels.share import balanced_force


def hide_unsound(_f: Floats, _t: Wholes, _g: GraspMemory) -> None:
    """Leave the state as it is: its flag is taken as sound."""


def prepare_friction(f: Floats, _t: Wholes, _g: GraspMemory) -> None:
    """Ask for margin and confidence as they are set."""
    f.asked.margin, f.asked.quantile = f.rule.wanted_margin, f.rule.quantile


def update_shared_friction(_f: Floats, _t: Wholes, _g: GraspMemory) -> None:
    """Keep what was learned: there is no other finger."""


def load_to_answer(
    _f: Floats, _t: Wholes, _g: GraspMemory, x: float, y: float, torque: float
) -> tuple[float, float]:
    """Return tangential force [N] and torque [N m] of a load that counts."""
    return math.sqrt(x * x + y * y), torque


def is_slipping(f: Floats, _t: Wholes, _g: GraspMemory) -> bool:
    """Return whether the finger slips by its flag."""
    return f.state.slip >= SLIDES


def stated_friction(_f: Floats, _t: Wholes, mu: float, std: float) -> tuple[float, float]:
    """Return the friction coefficient and its std as they are believed."""
    return mu, std


def restore_slip(_f: Floats, _t: Wholes) -> None:
    """Leave the state as it is: nothing was taken out of it."""


def asks_least_force(_t: Wholes) -> bool:
    """Return whether the policy looks at the least force."""
    return True


def forget_policy(f: Floats, t: Wholes) -> None:
    """Forget the past of the need."""
    forget_grip(f, t)


def asked_force(f: Floats, t: Wholes, base: float, dt: float) -> tuple[float, int]:
    """Return the normal force [N] that the policy asks for, and its reason."""
    return wanted_force(f, t, base, dt)


def shared_force(_f: Floats, t: Wholes, g: GraspMemory) -> float:
    """Return this finger's share of the grasp [N]."""
    return balanced_force(t, g)


def note_command(_f: Floats, _t: Wholes, _g: GraspMemory) -> None:
    """Keep what this finger is commanded: no other asks for it."""


def pressed_by_others(_t: Wholes, _g: GraspMemory) -> float:
    """Return NaN: what presses against this finger is not known."""
    return math.nan
