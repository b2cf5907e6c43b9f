"""Rolling: a tangential load turns the fingertip on its elastic joint, and the sensor with it.

``th = rho T / K`` [rad], T the measured tangential force; the sensor shows ``N / cos th - T tan th`` as
normal force, and the contact slips at the measured ``T = u N`` with ``u = mu cos th(u) + sin th(u)`` (the
uphill case of :mod:`vegrip.effects.inclination`).

A fingertip that rolls by an angle of its joint moves its contact by R times that angle, [Montana1988]_. No
message and no recording carries joint angles, so the angle is what the load itself makes of it, through the
compliance rho of the joint (in rad per K). Rolling that the drive commands cannot be seen and is not
modelled.
"""

import math

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter

FARTHEST = 0.7  # [rad] beyond which a fingertip does not roll
ROUNDS = 12  # of the fixed point, each better by the factor rho N / K


def angle(ratio: float, force: float, K: float, rho: float) -> float:
    """Return the rolled angle [rad] at the tangential force ``ratio`` N."""
    return min(max(rho * ratio * force / K, -FARTHEST), FARTHEST)


def sense(sensed_force: float, tangential_force: float, K: float, rho: float) -> float:
    """Return the force [N] along the sensor's axis."""
    if rho == 0.0:
        return sensed_force
    th = angle(1.0, tangential_force, K, rho)
    return sensed_force / math.cos(th) - tangential_force * math.tan(th)


def friction(friction: float, force: float, K: float, rho: float) -> float:
    """Return the ratio of measured tangential to normal force at slip."""
    if rho == 0.0:
        return friction
    u = friction
    for _ in range(ROUNDS):
        th = angle(u, force, K, rho)
        u = friction * math.cos(th) + math.sin(th)
    return u


EFFECT = Effect(
    name="rolling",
    summary="the tangential force rolls the tip on its elastic joint",
    residual="as the tangential force, growing with it",
    cites=("Montana1988",),
    parameters=(Parameter("rho", "rad", 0.05, 0.05, 0.0, 0.5, "angle at a tangential force of K", null=0.0),),
    hooks=(hook(sense), hook(friction)),
    channels=("normal_force", "tangential_force"),
    confounded=("inclination", "cross_talk", "load_dependent_friction"),
    experiment="pulls with the joint locked and free",
)
