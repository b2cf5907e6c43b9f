"""Pressure maps of the usual shapes: taxels, ellipses, polygons, as points for :class:`PressureMap`.

Each shape is filled with Gauss points, so that sums over the points are integrals over the shape.
"""

from itertools import pairwise

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike

from vegrip.contact.domain import positive
from vegrip.contact.limit_surface.pressure_map import PressureMap
from vegrip.contact.limit_surface.reference import exponent
from vegrip.contact.pressure import profile
from vegrip.errors import DomainError
from vegrip.types import Floats


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
    turned = angle + 2.0 * np.pi / sectors * ((np.arange(rings) * 0.618034) % 1.0)[:, None]
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
    """Gauss points of a square, folded onto the triangle."""
    nodes, weights = leggauss(order)
    q, w = 0.5 * (nodes + 1.0), 0.5 * weights
    u, v = np.meshgrid(q, q, indexing="ij")
    points = a + u[..., None] * ((b - a) + v[..., None] * (c - b))
    (bx, by), (cx, cy) = b - a, c - a
    return points.reshape(-1, 2), (abs(bx * cy - by * cx) * np.outer(w * q, w)).ravel()
