"""The limit surface of any pressure map: taxels of a tactile array, an ellipse, a polygon, a few feet.

The map is a set of points with shares w_i of the normal force, sum w_i = 1. In the slip t = (v_x, v_y, omega)
the point r_i moves with v_i = v + omega x r_i, and the contact

    dissipates                W(t) = sum w_i |v_i|                      per mu N
    and carries the load   (f, m)(t) = sum w_i (e_i, r_i x e_i)         per mu N,     e_i = v_i/|v_i|

W is the support function of the limit surface and (f, m) its gradient [GoyalRuinaPapadopoulos1991]_. Here
lengths stay in metres: loads are (f_x/(mu N), f_y/(mu N), m_n/(mu N) [m]) about the origin of the positions,
the load that *drives* the slip; the friction on the body is its opposite.

The usual shapes are filled with Gauss points, so that sums over the points are integrals over the shape.

**Gauge of a load**, between two bounds that need no trust. It is the greatest power over dissipation,
max over slips t of l.t/W(t). With l.t fixed to 1 a convex function is minimised,

    1/gauge = min W(t)  subject to  l.t = 1,        W_eps(t) = sum w_i s_i,  s_i = sqrt(|v_i|^2 + eps^2)

by Newton's method on W_eps, eps falling by tens, because W has a kink wherever the centre of rotation (COR)
meets a point. Any slip gives a lower bound, 1/W(t). An upper bound comes from the friction vectors
u_i = v_i/s_i, all shorter than 1: they balance a load r, which is therefore carried, and r is nearly along l,

    r = c l + e   =>   gauge(l) <= (1 + gauge(e))/c,      gauge(e) <= |e| sqrt(1 + max |r_i|^2)

with lengths in units of the map's size about its centre. A COR *on* a point is tried by itself: if the
friction that this point needs is shorter than 1, the slip is the exact solution, on a :class:`Facet`.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike

from vegrip.contact.domain import positive
from vegrip.contact.limit_surface.reference import exponent
from vegrip.contact.pressure import profile
from vegrip.errors import DomainError
from vegrip.types import Floats


@dataclass(frozen=True, eq=False)
class Facet:
    """Loads a contact carries while it spins about one of its points: a flat piece of the limit surface.

    The friction of that point is any vector of length <= its share, so the loads are centre + u_1 axes[0] +
    u_2 axes[1] with |u| <= 1. For two or three feet the facets are large, for taxels they vanish.
    """

    centre: Floats  # (3,) load of all other points
    axes: Floats  # (2, 3)


class PressureMap:
    """Points of contact with the normal force on each.

    positions (n, 2) [m]; forces (n,) >= 0 in any unit, their scale does not matter. Points without force are
    dropped. Raises DomainError for shapes that do not fit, negative, missing or no force.
    """

    def __init__(self, positions: ArrayLike, forces: ArrayLike) -> None:
        positions = np.asarray(positions, dtype=np.float64)
        forces = np.asarray(forces, dtype=np.float64)
        if positions.ndim != 2 or positions.shape != (forces.size, 2):
            raise DomainError(
                f"positions {positions.shape} and forces {forces.shape} must be (n, 2) and (n,)"
            )
        if not (np.all(np.isfinite(positions)) and np.all(forces >= 0.0) and 0.0 < forces.sum() < np.inf):
            raise DomainError("a pressure map needs finite positions and forces >= 0, not all of them 0")
        loaded = forces > 0.0
        self.positions: Floats = positions[loaded]
        self.shares: Floats = forces[loaded] / forces.sum()

    @cached_property
    def centre(self) -> Floats:
        """Centre of pressure (2,) [m]."""
        return np.asarray(self.shares @ self.positions)

    @cached_property
    def size(self) -> float:
        """Root of the mean square distance from the centre of pressure [m]; 0 for a single point."""
        return float(np.sqrt(self.shares @ ((self.positions - self.centre) ** 2).sum(axis=1)))

    def velocities(self, twist: ArrayLike) -> Floats:
        """Speeds of the points (..., n, 2) in the slip (v_x, v_y, omega) of shape (..., 3)."""
        vx, vy, omega = np.moveaxis(np.asarray(twist, dtype=np.float64)[..., None], -2, 0)
        x, y = self.positions.T
        return np.stack([vx - omega * y, vy + omega * x], axis=-1)

    def support(self, twist: ArrayLike) -> Floats:
        """Dissipation W (...) of the slips (..., 3): the greatest power of any load on the surface."""
        return np.asarray(np.linalg.norm(self.velocities(twist), axis=-1) @ self.shares)

    def load(self, twist: ArrayLike) -> Floats:
        """Load (..., 3) that drives the slips (..., 3).

        A point at the very centre of rotation counts with zero friction: the middle of its :class:`Facet`.
        """
        v = self.velocities(twist)
        speed = np.linalg.norm(v, axis=-1, keepdims=True)
        return self.resultant(np.divide(v, speed, out=np.zeros_like(v), where=speed > 0.0))

    def resultant(self, friction: Floats) -> Floats:
        """Load (..., 3) of the friction vectors (..., n, 2), each in units of mu times the point's force."""
        e_x, e_y = np.moveaxis(friction, -1, 0)
        x, y = self.positions.T
        return np.stack([e_x @ self.shares, e_y @ self.shares, (x * e_y - y * e_x) @ self.shares], axis=-1)

    def facet(self, index: int, spin: float) -> Facet:
        """Loads carried while spinning (counter-clockwise for spin > 0) about the point of that index."""
        x, y = self.positions[index]
        omega = np.sign(spin)
        share = self.shares[index]
        axes = share * np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])
        return Facet(self.load([omega * y, -omega * x, omega]), axes)


def taxel_map(centres: ArrayLike, pressures: ArrayLike, pitch: float, order: int = 3) -> PressureMap:
    """Map of a tactile array: square taxels of side pitch [m], centres (n, 2) [m], pressures (n,) >= 0.

    The pressure is uniform over each taxel, sampled at order^2 points.
    """
    centres, pressures = np.asarray(centres, dtype=np.float64), np.asarray(pressures, dtype=np.float64)
    if centres.ndim != 2 or centres.shape != (pressures.size, 2):
        raise DomainError(f"centres {centres.shape} and pressures {pressures.shape} must be (n, 2) and (n,)")
    nodes, weights = leggauss(order)
    half = 0.5 * float(positive("taxel pitch", pitch, "m"))
    offsets = half * np.stack(np.meshgrid(nodes, nodes), axis=-1).reshape(-1, 2)
    cell = np.outer(weights, weights).ravel()
    positions = (centres[:, None] + offsets).reshape(-1, 2)
    return PressureMap(positions, np.outer(pressures, cell).ravel())


def elliptical_map(
    semi_axes: tuple[float, float], k: float = 2.0, rings: int = 40, sectors: int = 96
) -> PressureMap:
    """Map of an elliptical contact: pressure (1 - s^k)^(1/k), s = 1 on the edge (k = 2: Hertz).

    semi_axes [m] along x and y; k in [1, inf]. With the default numbers of points the support function of a
    circle is good to 1e-5, loads to 5e-4.
    """
    exponent(k)
    a, b = (float(positive("semi-axis", axis, "m")) for axis in semi_axes)
    nodes, weights = leggauss(rings)
    q = 0.5 * (nodes + 1.0)
    s = np.sin(0.5 * np.pi * q)  # ds = pi/2 cos: the edge's root singularity is gone
    force = weights * s * np.cos(0.5 * np.pi * q) * profile(s, k)
    angle = 2.0 * np.pi * (np.arange(sectors) + 0.5) / sectors
    # turned ring by ring, so that the spokes do not line up
    turned = angle + 2.0 * np.pi / sectors * (np.arange(rings) * 0.618034)[:, None]
    positions = np.stack([a * s[:, None] * np.cos(turned), b * s[:, None] * np.sin(turned)], axis=-1)
    return PressureMap(positions.reshape(-1, 2), np.repeat(force, sectors))


def polygon_map(corners: ArrayLike, order: int = 48) -> PressureMap:
    """Map of a flat face: uniform pressure over a convex polygon, corners (n, 2) [m] in order."""
    corners = np.asarray(corners, dtype=np.float64)
    if corners.ndim != 2 or corners.shape[0] < 3 or corners.shape[1] != 2:
        raise DomainError(f"a polygon needs three corners or more as (n, 2), not {corners.shape}")
    parts = [_triangle(corners[0], *pair, order) for pair in pairwise(corners[1:])]
    return PressureMap(np.concatenate([p for p, _ in parts]), np.concatenate([w for _, w in parts]))


def _triangle(a: Floats, b: Floats, c: Floats, order: int) -> tuple[Floats, Floats]:
    nodes, weights = leggauss(order)
    q, w = 0.5 * (nodes + 1.0), 0.5 * weights
    u, v = np.meshgrid(q, q, indexing="ij")
    points = a + u[..., None] * ((b - a) + v[..., None] * (c - b))
    (bx, by), (cx, cy) = b - a, c - a
    return points.reshape(-1, 2), (abs(bx * cy - by * cx) * np.outer(w * q, w)).ravel()


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


def bound_gauge(pressure: PressureMap, load: ArrayLike) -> GaugeBounds:
    """Bounds of the gauge of one load (f_x/(mu N), f_y/(mu N), m_n/(mu N) [m]), and its slip direction.

    The load is held while the upper bound is below 1.
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
        eps = smoothing * float(np.linalg.norm(pressure.velocities(twist), axis=1).max())
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
    index = int(np.argmin(np.linalg.norm(pressure.velocities(twist), axis=1)))
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
    return np.asarray(np.sqrt((v**2).sum(axis=1) + eps**2))
