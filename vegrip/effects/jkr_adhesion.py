"""Adhesion of soft surfaces, [JohnsonKendallRoberts1971]_: one work of adhesion w, wide contact, early jump.

A contact of radius a is a Hertzian one of depth ``x_H = a^2 / R`` less a flat punch pulled by d:

    ``x = x_H - d``,   ``d = sqrt(2 pi w a / E*) = c x_H^(1/4)``,
    ``N = N_e(x_H) - S d``,   ``S = dN_e / dx_H``

N_e with its memory, S d without. For a sphere (p = 3/2) that is their theory; for another power law the
radius and d are the sphere's. The drive imposes x: surfaces touch at x = 0, with -8/9 of F, and part where
``dx / dx_H = 0``, at ``x = -3 (c / 4)^(4/3)``. With ``u = (4 / c)^(1/3) x_H^(1/4)`` the depth is the root
u > 1 of ``u^4 - 4 u = x / (c / 4)^(4/3)``, here in Ferrari's closed form.

``F = 1.5 pi w R``, the pull-off force under a dead load, is in units of K, the elastic force at x_ref:
``c = (4/3) sqrt(F / K) x_ref^(3/4)``. While x falls at speed v the work grows,
``w = w_0 [1 + g (v / x_ref)^n]``, [MaugisBarquins1978]_ (with the speed of x for that of the edge).
"""

import math

from vegrip.effects.contract import Effect, State, hook
from vegrip.parameters import Parameter

LEAST = 1e-9  # of K: weaker than any sensor, and the root's cube still fits single precision


def scale(speed: float, reference_depth: float, w_J: float, g_J: float, n_J: float) -> float:
    """Return ``(c / 4)^(4/3)`` [x_ref]."""
    grown = w_J
    if g_J > 0.0 and speed < 0.0:
        grown = w_J * (1.0 + g_J * (-speed / reference_depth) ** n_J)
    return float((grown / 9.0) ** (2.0 / 3.0))


def root(y: float) -> float:
    """Return the root u >= 1 of ``u^4 - 4 u = y``, for y >= -3."""
    third = y / 3.0
    plus = (1.0 + math.sqrt(max(1.0 + third * third * third, 0.0))) ** (1.0 / 3.0)
    minus = third / plus
    m = math.sqrt(4.0 / (plus * plus + third + minus * minus))  # sqrt(2 m), m^3 + y m = 2
    return 0.5 * (m + math.sqrt(max(8.0 / m - m * m, 0.0)))


def tip(
    x: float, speed: float, reference_depth: float, w_J: float, g_J: float, n_J: float, joined: float
) -> tuple[float, float]:
    """Return the depth x_H [m] and whether the surfaces are joined (1) or not (0)."""
    if w_J <= LEAST:
        return x, 0.0
    size = scale(speed, reference_depth, w_J, g_J, n_J) * reference_depth
    if x >= 0.0:
        joined = 1.0
    elif x < -3.0 * size:
        joined = 0.0
    if joined < 0.5:
        return x, joined
    u = root(x / size)
    return size * u * u * u * u, joined


def force(
    adhesion: float,
    x: float,
    stiffness: float,
    speed: float,
    reference_depth: float,
    w_J: float,
    g_J: float,
    n_J: float,
    joined: float,
) -> tuple[float, float]:
    """Return the pull S d [N], and whether the surfaces are joined."""
    if joined < 0.5 or x <= 0.0:
        return adhesion, joined
    size = scale(speed, reference_depth, w_J, g_J, n_J) * reference_depth
    return adhesion + stiffness * 4.0 * size * math.sqrt(math.sqrt(x / size)), joined


EFFECT = Effect(
    name="jkr_adhesion",
    summary="soft surfaces attract each other: they touch with a jump, and part later with a greater one",
    residual="a jump at first touch, a greater pull and later parting on the way out, a radius at zero force",
    cites=("JohnsonKendallRoberts1971", "MaugisBarquins1978"),
    parameters=(
        Parameter(
            "w_J", "1", 0.05, 0.05, 0.0, 10.0, "1.5 pi R w over K, the pull-off force", null=0.0, of="K"
        ),
        Parameter("g_J", "1", 0.1, 0.2, 0.0, 100.0, "growth of w at a retraction of x_ref per s", null=0.0),
        Parameter("n_J", "1", 0.5, 0.1, 0.1, 1.0, "exponent of that growth"),
    ),
    states=(State("joined", "1", "1 from the first touch until the surfaces part", extreme=True),),
    hooks=(hook(tip), hook(force, gives="adhesion")),
    confounded=("adhesion", "force_drift"),
    experiment="slow approach and retraction at three speeds, with air before and after",
    kinked=True,
    in_air=True,  # touch and parting show it; an elastic law imitates the rest
    companions=("adhesion",),
)
