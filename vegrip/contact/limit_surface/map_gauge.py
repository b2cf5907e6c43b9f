"""Gauge of a load on the limit surface of a pressure map, between two bounds that need no trust.

The gauge of the load l is the greatest power over dissipation, max over slips t of l.t/W(t). With l.t fixed
to 1 a convex function is minimised,

    1/gauge = min W(t)  subject to  l.t = 1,        W_eps(t) = sum w_i s_i,  s_i = sqrt(|v_i|^2 + eps^2)

by Newton's method on W_eps, eps falling by tens, because W has a kink wherever the centre of rotation (COR)
meets a point. Any slip gives a lower bound, 1/W(t). An upper bound comes from the friction vectors
u_i = v_i/s_i, all shorter than 1: they balance a load r, which is therefore carried, and r is nearly along l,

    r = c l + e   =>   gauge(l) <= (1 + gauge(e))/c,      gauge(e) <= |e| sqrt(1 + max |r_i|^2)

with lengths in units of the map's size about its centre. A COR *on* a point is tried by itself: if the
friction that this point needs is shorter than 1, the slip is the exact solution, on a :class:`Facet`.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vegrip.contact.limit_surface.pressure_map import PressureMap
from vegrip.errors import DomainError
from vegrip.types import Floats

TOLERANCE = 1e-9
"""Relative distance of the bounds at which the search ends."""

SMOOTHING = 10.0 ** -np.arange(0.0, 11.0)
"""eps over the fastest point's speed, one Newton solution after the other."""

_NEWTON_STEPS = 40
_NOTHING_LEFT = 1e-30  # of W: gain a Newton step promises
_HALVINGS = 30


class GaugeBounds(NamedTuple):
    """Bounds of the gauge and the slip the load starts when it reaches 1."""

    lower: float
    upper: float
    twist: Floats  # (v_x [m/s], v_y [m/s], omega [rad/s]), of any scale: the outward normal


def map_gauge(pressure: PressureMap, load: ArrayLike) -> float:
    """Load (f_x/(mu N), f_y/(mu N), m_n/(mu N) [m]) over limit, the upper bound: below 1 it is held."""
    return bound_gauge(pressure, load).upper


def bound_gauge(pressure: PressureMap, load: ArrayLike) -> GaugeBounds:
    """Bounds of the gauge of one load (3,), and its slip direction.

    A single point carries no torque about itself: its gauge is then infinite. Raises DomainError for a load
    that is zero or not finite.
    """
    load = np.asarray(load, dtype=np.float64)
    if load.shape != (3,) or not np.all(np.isfinite(load)) or not np.any(load):
        raise DomainError(f"the load must be three finite numbers, not all 0, not {load}")
    if pressure.size == 0.0:
        return _single_point(pressure, load)
    # about the centre of pressure, in units of the size: all three components alike
    x, y = pressure.centre
    centred = PressureMap((pressure.positions - pressure.centre) / pressure.size, pressure.shares)
    fx, fy, m = load
    bounds = _bound_centred(centred, np.array([fx, fy, (m - x * fy + y * fx) / pressure.size]))
    vx, vy, omega = bounds.twist / np.array([1.0, 1.0, pressure.size])
    return bounds._replace(twist=np.array([vx + omega * y, vy - omega * x, omega]))


def _single_point(pressure: PressureMap, load: Floats) -> GaugeBounds:
    (x, y), (fx, fy, m) = pressure.centre, load
    moment = m - x * fy + y * fx
    if abs(moment) > 1e-12 * abs(m):
        omega = np.sign(moment)
        return GaugeBounds(np.inf, np.inf, np.array([omega * y, -omega * x, omega]))
    gauge = float(np.hypot(fx, fy))
    return GaugeBounds(gauge, gauge, np.array([fx / gauge, fy / gauge, 0.0]))


def _bound_centred(pressure: PressureMap, load: Floats) -> GaugeBounds:
    twist = load / (load @ load)
    across = np.linalg.svd(load[None])[2][1:]  # (2, 3): changes of the slip that keep load.t = 1
    best = GaugeBounds(0.0, np.inf, twist)
    for smoothing in SMOOTHING:
        eps = smoothing * float(np.linalg.norm(pressure.velocities(twist), axis=-1).max())
        twist = _minimise(pressure, twist, across, eps)
        for bounds in (_spin_about_nearest(pressure, load, twist), _bounds(pressure, load, twist, eps)):
            if bounds is not None and bounds.upper - bounds.lower < best.upper - best.lower:
                best = bounds
        if best.upper - best.lower <= TOLERANCE * best.upper:
            break
    return best


def _bounds(pressure: PressureMap, load: Floats, twist: Floats, eps: float) -> GaugeBounds:
    v = pressure.velocities(twist)
    carried = pressure.resultant(v / _smooth_speed(v, eps)[:, None])
    along = float(carried @ load / (load @ load))
    if along <= 0.0:
        return GaugeBounds(0.0, np.inf, twist)
    reach = np.sqrt(1.0 + (pressure.positions**2).sum(axis=1).max())
    aside = float(np.linalg.norm(carried - along * load)) * reach
    return GaugeBounds(1.0 / float(pressure.support(twist)), float((1.0 + aside) / along), twist)


def _spin_about_nearest(pressure: PressureMap, load: Floats, twist: Floats) -> GaugeBounds | None:
    """Exact solution if it is the spin about the point nearest to the COR, else nothing."""
    index = int(np.argmin(np.linalg.norm(pressure.velocities(twist), axis=-1)))
    x, y = pressure.positions[index]
    spin = np.array([y, -x, 1.0])
    if load @ spin == 0.0:
        return None
    spin = spin / (load @ spin)
    dissipation = float(pressure.support(spin))
    facet = pressure.facet(index, spin[2])
    friction = np.linalg.lstsq(facet.axes.T, dissipation * load - facet.centre)[0]
    if friction @ friction > 1.0:
        return None
    return GaugeBounds(1.0 / dissipation, 1.0 / dissipation, spin)


def _minimise(pressure: PressureMap, twist: Floats, across: Floats, eps: float) -> Floats:
    """Newton's method for W_eps over the slips twist + y across; steps that overshoot are halved."""
    value, gradient, hessian = _smooth_support(pressure, twist, eps)
    for _ in range(_NEWTON_STEPS):
        g = across @ gradient
        step = -np.linalg.solve(across @ hessian @ across.T, g)
        slope = float(g @ step)
        if -slope < _NOTHING_LEFT * value:
            break
        for _ in range(_HALVINGS):
            candidate = twist + step @ across
            value, gradient, hessian = _smooth_support(pressure, candidate, eps)
            if across @ gradient @ step <= -0.5 * slope:
                break
            step, slope = 0.5 * step, 0.5 * slope
        twist = candidate
    return twist


def _smooth_support(pressure: PressureMap, twist: Floats, eps: float) -> tuple[float, Floats, Floats]:
    """W_eps with gradient (3,) and Hessian (3, 3)."""
    v = pressure.velocities(twist)
    s = _smooth_speed(v, eps)
    u = v / s[:, None]
    x, y = pressure.positions.T
    one, zero = np.ones_like(x), np.zeros_like(x)
    by_x, by_y = np.stack([one, zero, -y]), np.stack([zero, one, x])  # (3, n): d v_x/d t, d v_y/d t
    along = by_x * u[:, 0] + by_y * u[:, 1]
    w = pressure.shares / s
    hessian = (by_x * w) @ by_x.T + (by_y * w) @ by_y.T - (along * w) @ along.T
    return float(pressure.shares @ s), along @ pressure.shares, hessian


def _smooth_speed(v: Floats, eps: float) -> Floats:
    return np.asarray(np.sqrt((v**2).sum(axis=-1) + eps**2))
