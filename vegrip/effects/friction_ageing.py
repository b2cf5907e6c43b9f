"""Friction that grows while the contact rests: ``mu_eff = mu [1 + beta ln(1 + t_c / t_0)]``.

``t_c' = 1 - v t_c / D_c``: the age of the contact, [Dieterich1979]_, [Ruina1983]_. At rest it is the time in
contact; sliding by D_c (in x_ref) replaces the aged places by fresh ones, and at a steady speed
``t_c = D_c / v``. A contact that is met in the middle counts as fresh, on the safe side.
"""

import math

from vegrip.effects.contract import Effect, State, hook
from vegrip.parameters import Parameter


def age(force: float, slip_speed: float, dt: float, reference_depth: float, D_c: float, t_c: float) -> float:
    """Return the age of the contact [s], exact for a constant speed; 0 out of contact."""
    if force <= 0.0:
        return 0.0
    slid = abs(slip_speed) * dt / (D_c * reference_depth)
    left = math.exp(-slid)
    grown = -math.expm1(-slid) / slid if slid > 0.0 else 1.0
    return t_c * left + dt * grown


def friction(friction: float, beta_t: float, t_0: float, t_c: float) -> float:
    """Return the friction coefficient."""
    return friction * max(1.0 + beta_t * math.log1p(t_c / t_0), 0.01)


EFFECT = Effect(
    name="friction_ageing",
    summary="static friction grows with the logarithm of the time at rest",
    residual="ratio at slip grows with time at rest, in force and torque alike",
    cites=("Dieterich1979", "Ruina1983"),
    parameters=(
        Parameter("beta_t", "1", 0.04, 0.03, -0.05, 0.5, "growth per e-fold of time", null=0.0),
        Parameter("t_0", "s", 0.1, 1.5, 1e-5, 1e3, "time when it starts", transform="log"),
        Parameter(
            "D_c", "1", 0.01, 1.5, 1e-6, 100.0, "slip that renews it, in x_ref", transform="log", of="x_ref"
        ),
    ),
    states=(State("t_c", "s", "age of the contact"),),
    hooks=(hook(age, stage="force", gives=""), hook(friction)),
    channels=("tangential_force", "torque_z"),
    confounded=("load_dependent_friction", "wet_contact", "rate_dependent_friction"),
    experiment="slips after short and long holds, each at several loads",
)
