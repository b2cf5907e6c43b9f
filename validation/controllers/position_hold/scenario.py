"""Two holds of the same pads: what is carried, for how long, and how well friction is known.

The pads recover between the holds. The load is told before closing, the friction coefficient within
:data:`FRICTION_SPREAD`; the material is not. The need at an instant is the normal force at which the load
lies on the limit surface of the present contact, the same for every controller:

    ``gauge(k, f / (mu N), m / (mu N a)) = 1`` .
"""

import math
from dataclasses import dataclass

import numpy as np

from validation.controllers.position_hold.pad import HERTZ_EXPONENT, Pad, draw_pad
from vegrip.contact.limit_surface.fast import least_normal_force

DURATIONS_S = (30.0, 90.0)  # of a hold
FRICTION_SPREAD = 0.05  # std of ln mu about what is told
RECOVERY_S = 600.0  # between two holds
LIFT_START_S, LIFT_END_S = 0.3, 0.8  # after the gripper has closed


@dataclass(frozen=True)
class Load:
    """What one pad carries, and for how long."""

    tangential: float  # [N]
    torque: float  # [N m]
    duration: float  # [s] from closing on

    def need(self, friction: float, radius: float) -> float:
        """Return the least normal force [N] of a contact of ``radius`` [m]."""
        if not radius > 0.0:
            return math.inf
        f, torque = self.tangential, self.torque
        # all eight arguments: numba calls a function with defaults left out a hundred times as slowly
        return float(least_normal_force(f, torque, friction, radius, HERTZ_EXPONENT, 1.0, 0.0, 0.0))


@dataclass(frozen=True)
class PositionHold:
    """One pair of pads and what it holds, one after the other."""

    pad: Pad
    stated_friction: float  # [-]
    loads: tuple[Load, ...]
    seed: int  # of the sensors' noise


def draw_hold(material: int, seed: int) -> PositionHold:
    """Draw the holds ``seed`` of the pads ``material``; the pads follow from ``material`` alone."""
    pad = draw_pad(np.random.default_rng([material, 17]))
    rng = np.random.default_rng([material, seed, 18])
    told = pad.friction * math.exp(FRICTION_SPREAD * rng.standard_normal())
    loads = tuple(
        Load(
            tangential=(tangential := float(rng.uniform(0.5, 2.5))),
            torque=tangential * float(rng.uniform(0.0, 2e-3)),
            duration=float(rng.uniform(*DURATIONS_S)),
        )
        for _ in range(2)
    )
    return PositionHold(pad, told, loads, seed)
