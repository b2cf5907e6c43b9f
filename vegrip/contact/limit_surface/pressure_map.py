"""The limit surface of any pressure map: taxels of a tactile array, an ellipse, a polygon, a few feet.

The map is a set of points with shares w_i of the normal force, sum w_i = 1. In the slip t = (v_x, v_y, omega)
the point r_i moves with v_i = v + omega x r_i, and the contact

    dissipates                W(t) = sum w_i |v_i|                      per mu N
    and carries the load   (f, m)(t) = sum w_i (e_i, r_i x e_i)         per mu N,     e_i = v_i/|v_i|

W is the support function of the limit surface and (f, m) its gradient [GoyalRuinaPapadopoulos1991]_. Here
lengths stay in metres: loads are (f_x/(mu N), f_y/(mu N), m_n/(mu N) [m]) about the origin of the positions,
the load that *drives* the slip; the friction on the body is its opposite.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

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

    def facet(self, index: int, spin: float = 1.0) -> Facet:
        """Loads carried while spinning (counter-clockwise for spin > 0) about the point of that index."""
        x, y = self.positions[index]
        omega = np.sign(spin)
        share = self.shares[index]
        axes = share * np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])
        return Facet(self.load([omega * y, -omega * x, omega]), axes)
