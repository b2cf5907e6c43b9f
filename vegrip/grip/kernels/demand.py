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
    f.demand.least = f.demand.load = f.demand.torque = f.demand.bound = math.nan
    t.need.in_contact = t.need.slipping = t.need.trusted = 0


def demand_force(f: Floats, t: Wholes, g: GraspMemory) -> None:
    """Set the demand by the present state and the estimate; the bound of the margin is of the last look."""
    x, y = f.state.tangential_force_x, f.state.tangential_force_y
    f.demand.load, f.demand.torque = math.sqrt(x * x + y * y), abs(f.state.torque_z)
    t.need.slipping = 1 if is_slipping(f, t, g) else 0
    if not touches(f, t):
        f.demand.least, f.demand.bound = 0.0, math.nan
        t.need.in_contact, t.need.trusted = 0, 1 if is_force_known(f, t) else 0
        return
    f.demand.least, f.demand.bound = math.nan, f.taken.bound
    if asks_least_force(t) and (t.input.lost & LOADING) == 0:
        x, y, torque = f.state.tangential_force_x, f.state.tangential_force_y, f.state.torque_z
        x, y, torque = confirm_load(f, CONFIRMED0, x, y, torque, f.set.s_tangential, f.set.s_torque)
        load, torque = load_to_answer(f, t, g, x, y, torque)
        if is_sound(f, t):
            f.demand.least = least_force(f, load, torque, f.asked.margin, f.asked.quantile)
    t.need.in_contact, t.need.trusted = 1, 0 if math.isnan(f.demand.least) else 1


def hold_doubtful(f: Floats, t: Wholes) -> None:
    """While the normal force stands still: no less than is held, and no belief in air."""
    if t.input.doubtful == 1:
        f.demand.least = max(f.grip.held, f.demand.least)
        t.need.in_contact = 1
