"""The contact patch, element by element: what friction does is summed, never looked up.

The disc of radius a is cut into rings and spokes. An element carries its share of the pressure and a stiff
bristle to the object with Coulomb's limit; presliding, the limit surface and the frictional torque emerge.
Elements keep their place in the disc when the contact grows or shrinks (their bristles ride along).
"""

from dataclasses import dataclass, field
from functools import cache

import numpy as np

from vegrip.types import Floats
from vegrip.virtual import kernels
from vegrip.virtual.kernels import Contacts, Records
from vegrip.virtual.profile import shares_on_rings


@dataclass(frozen=True)
class Grid:
    """Rings and spokes in the unit disc; the same for all fingers."""

    edges: tuple[float, ...]  # of the rings, 0..1
    spokes: int
    rings: Records = field(init=False, repr=False, compare=False)  # (R,) of kernels.RING
    rays: Records = field(init=False, repr=False, compare=False)  # (S,) of kernels.SPOKE

    def __post_init__(self) -> None:
        r, rings = np.array(self.edges), np.zeros(len(self.edges) - 1, kernels.RING)
        rings["reach"] = 2.0 / 3.0 * np.diff(r**3) / np.diff(r**2)  # centroid of a thin sector
        rings["area"] = np.diff(r**2) / self.spokes
        angle = 2.0 * np.pi * (np.arange(self.spokes) + 0.5) / self.spokes
        rays = np.zeros(self.spokes, kernels.SPOKE)
        rays["cosine"], rays["sine"] = np.cos(angle), np.sin(angle)
        object.__setattr__(self, "rings", rings)
        object.__setattr__(self, "rays", rays)

    def contacts(self, tips: Records) -> Contacts:
        """Return patches of ``tips`` with unbent bristles."""
        load = np.zeros((len(tips), len(self.rings)))
        bristles = np.zeros((*load.shape, self.spokes, 2))
        return Contacts(tips, bristles, load, self.rings, self.rays)

    def load(self, k: Floats) -> Floats:
        """Return the share of the normal force on one element of each ring for exponents k; (n, R)."""
        shares: Floats = shares_on_rings(k, self.edges) / self.spokes
        return shares


@cache
def even_grid(rings: int, spokes: int) -> Grid:
    """Return a grid of equally wide rings."""
    return Grid(tuple(float(r) for r in np.linspace(0.0, 1.0, rings + 1)), spokes)


def utilisation(grid: Grid, k: float, f: float, m: float) -> float:
    """Return how much of the limit the load ``f = f_t/(mu N)``, ``m = m_n/(mu N a)`` uses: 1 = slides."""
    size = float(np.hypot(f, m))
    if size == 0.0:
        return 0.0
    load = grid.load(np.array([k]))[0]
    return size / kernels.limit_along(load, grid.rings, grid.rays, abs(f), abs(m))
