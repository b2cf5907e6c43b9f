"""What one finger needs: the least force for its load, bounded and doubted as its input deserves."""

import math

from vegrip.estimator.kernels.forecast import least_force
from vegrip.estimator.kernels.sense import is_force_known, is_sound, touches
from vegrip.grip.confirmed_load import confirm_load
from vegrip.grip.kernels.choice import asks_least_force
from vegrip.grip.kernels.friction_shared import is_slipping, load_to_answer
from vegrip.grip.kernels.generated import *


def demand_nothing(f: Floats, t: Wholes) -> None:
    """Set the demand of a finger whose input is not believed."""
    f[DEMAND_LEAST] = f[DEMAND_LOAD] = f[DEMAND_TORQUE] = f[DEMAND_BOUND] = math.nan
    t[NEED_IN_CONTACT] = t[NEED_SLIPPING] = t[NEED_TRUSTED] = 0


def demand_force(f: Floats, t: Wholes, g: Floats) -> None:
    """Set the demand by the present state and the estimate; the bound of the margin is of the last look."""
    x, y = f[STATE_TANGENTIAL_FORCE_X], f[STATE_TANGENTIAL_FORCE_Y]
    f[DEMAND_LOAD], f[DEMAND_TORQUE] = math.sqrt(x * x + y * y), abs(f[STATE_TORQUE_Z])
    t[NEED_SLIPPING] = 1 if is_slipping(f, t, g) else 0
    if not touches(f, t):
        f[DEMAND_LEAST], f[DEMAND_BOUND] = 0.0, math.nan
        t[NEED_IN_CONTACT], t[NEED_TRUSTED] = 0, 1 if is_force_known(f, t) else 0
        return
    f[DEMAND_LEAST], f[DEMAND_BOUND] = math.nan, f[TAKEN_BOUND]
    if asks_least_force(t) and (t[INPUT_LOST] & LOADING) == 0:
        x, y, torque = f[STATE_TANGENTIAL_FORCE_X], f[STATE_TANGENTIAL_FORCE_Y], f[STATE_TORQUE_Z]
        x, y, torque = confirm_load(f, CONFIRMED0, x, y, torque, f[SET_S_TANGENTIAL], f[SET_S_TORQUE])
        load, torque = load_to_answer(f, t, g, x, y, torque)
        if is_sound(f, t):
            f[DEMAND_LEAST] = least_force(f, load, torque, f[ASKED_MARGIN], f[ASKED_QUANTILE])
    t[NEED_IN_CONTACT], t[NEED_TRUSTED] = 1, 0 if math.isnan(f[DEMAND_LEAST]) else 1


def hold_doubtful(f: Floats, t: Wholes) -> None:
    """While the normal force stands still: no less than is held, and no belief in air."""
    if t[INPUT_DOUBTFUL] == 1:
        f[DEMAND_LEAST] = max(f[GRIP_HELD], f[DEMAND_LEAST])
        t[NEED_IN_CONTACT] = 1
