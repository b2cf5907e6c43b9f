"""Inclination: the fingertip meets a surface that is not square to its axis.

With ``n`` the surface normal in the frame of the sensor, ``n = (n_x, n_y, n_z)``, ``|n| = 1``, and e the
direction of the measured tangential force T: ``x = delta n_z``; the sensor shows ``(N - T . n) / n_z`` as
normal force; and the contact slips at the measured ``T = u N``, where the true force ``N n + (tangential)``
reaches Coulomb's cone,

    ``(1 + c^2 / n_z^2) u^2 - 2 (c / n_z^2) u + 1 / n_z^2 - 1 - mu^2 = 0``,   ``c = e . n``

which uphill is ``u = mu cos th + sin th`` and downhill ``mu cos th - sin th``; forces measured in one frame
and a contact in another is the setting of [BicchiSalisburyBrock1993]_. Until a tangential force gives a
direction it is the downhill one. The contact of a sphere stays a circle. That the sensor's centre is not
above the contact, and so reads a share of T as torque, is left out: it needs the mount.
"""

import math

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter

LEAST = 1e-3  # of mu: an incline steeper than the friction angle slides by itself


def upright(tilt_x: float, tilt_y: float) -> float:
    """Return n_z, the cosine of the inclination."""
    if tilt_x == 0.0 and tilt_y == 0.0:
        return 1.0
    return math.sqrt(1.0 - math.sin(tilt_x) * math.sin(tilt_x) - math.sin(tilt_y) * math.sin(tilt_y))


def tip(x: float, tilt_x: float, tilt_y: float) -> float:
    """Return the indentation [m] along the surface normal."""
    return x * upright(tilt_x, tilt_y)


def sense(
    sensed_force: float,
    tangential_force_x: float,
    tangential_force_y: float,
    tilt_x: float,
    tilt_y: float,
) -> float:
    """Return the force [N] along the sensor's axis."""
    if tilt_x == 0.0 and tilt_y == 0.0:
        return sensed_force
    along = tangential_force_x * math.sin(tilt_x) + tangential_force_y * math.sin(tilt_y)
    return (sensed_force - along) / upright(tilt_x, tilt_y)


def friction(
    friction: float, tangential_force_x: float, tangential_force_y: float, tilt_x: float, tilt_y: float
) -> float:
    """Return the ratio of measured tangential to normal force at slip."""
    n_x, n_y, n_z = math.sin(tilt_x), math.sin(tilt_y), upright(tilt_x, tilt_y)
    size = math.sqrt(tangential_force_x * tangential_force_x + tangential_force_y * tangential_force_y)
    c = -math.sqrt(n_x * n_x + n_y * n_y)
    if size > 0.0:
        c = (tangential_force_x * n_x + tangential_force_y * n_y) / size
    squared = n_z * n_z  # not n_z**2: Python's power rounds otherwise than C's
    A, B = 1.0 + c * c / squared, c / squared
    C = 1.0 / squared - 1.0 - friction * friction
    u = (B + math.sqrt(max(B * B - A * C, 0.0))) / A
    return max(u, LEAST * friction)


EFFECT = Effect(
    name="inclination",
    summary="the surface is inclined to the axis of the sensor",
    residual="offset with the direction of pull",
    cites=("BicchiSalisburyBrock1993",),
    parameters=(
        Parameter("tilt_x", "rad", 0.1, 0.1, -0.7, 0.7, "inclination towards +x", null=0.0),
        Parameter("tilt_y", "rad", 0.0, 0.1, -0.7, 0.7, "inclination towards +y", null=0.0),
    ),
    hooks=(hook(tip), hook(sense), hook(friction)),
    channels=("normal_force", "tangential_force"),
    confounded=("cross_talk", "rolling"),
    experiment="pulls to slip in four directions; repeat with the opposite tilt",
)
