"""Soft fingertips under imposed indentation or imposed force: the normal direction of the simulated truth.

One object holds n independent tips and advances them together by a fixed step.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from vegrip.types import Floats
from vegrip.virtual import kernels, profile
from vegrip.virtual.history import History
from vegrip.virtual.kernels import Contacts, Records
from vegrip.virtual.profile import shares_on_rings
from vegrip.virtual.settings import FingertipSettings, ThermalSettings


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
    return Grid(tuple(float(r) for r in np.linspace(0.0, 1.0, rings + 1)), spokes)


def utilisation(grid: Grid, k: float, f: float, m: float) -> float:
    """Return how much of the limit the load ``f = f_t/(mu N)``, ``m = m_n/(mu N a)`` uses: 1 = slides."""
    size = float(np.hypot(f, m))
    if size == 0.0:
        return 0.0
    load = grid.load(np.array([k]))[0]
    return size / kernels.limit_along(load, grid.rings, grid.rays, abs(f), abs(m))


class Fingertips:
    """n soft fingertips: ``N = int g(t-s) dN_e(delta)``, ``N_e = F0 (delta/d0)^p``, never pulling.

    ``records`` are those of the compiled steps (:class:`vegrip.virtual.kernels.Tip`), the rest views of them.
    """

    def __init__(self, tips: Sequence[FingertipSettings], step: float, fine: int = 1024) -> None:
        self.tips, self.step = tuple(tips), step
        self.records = r = np.zeros(len(tips), kernels.TIP)
        r["radius"] = [tip.radius for tip in tips]
        r["d0"] = [tip.reference_indentation for tip in tips]
        r["p"] = [tip.exponent for tip in tips]
        r["C_fresh"] = profile.coefficient(np.array(profile.HERTZ))
        r["friction"] = r["mu"] = [tip.friction for tip in tips]
        r["friction_exponent"] = [tip.friction_exponent for tip in tips]
        r["stiffness"] = [tip.bristle_stiffness for tip in tips]
        r["damping"] = [tip.bristle_damping for tip in tips]
        self.radius, self.instant, self.force, self.indentation = (
            r[name] for name in ("radius", "instant", "force", "depth")
        )
        self.before, self.reference = r["before"], r["reference"]
        self._F0 = np.array([tip.reference_force for tip in tips])
        r["F0"] = self._F0
        self.follow(History([tip.relaxing() for tip in tips], step, fine))
        self.reset()

    def follow(self, history: History) -> None:
        self.history = history
        self.instant[:] = history.instant

    def reset(self) -> None:
        """Make the material fully recovered and out of contact."""
        self.history.clear()
        for values in (self.before, self.force, self.indentation, self.reference, self.records["past"]):
            values[:] = 0.0

    @property
    def past(self) -> Floats:
        """What all earlier increments contribute to the force of the coming step [N]."""
        return self.records["past"]

    def heat(self, stiffness: float, speed: float) -> None:
        """Set the material: stiffness and relaxation rates as multiples of the nominal [-]."""
        self.records["F0"] = stiffness * self._F0
        self.history.reweigh([tip.relaxing(speed) for tip in self.tips])
        self.follow(self.history)
        self.past[:] = self.history.past()

    def elastic_force(self, indentation: Floats) -> Floats:
        """Return N_e(delta) [N]."""
        r = self.records
        force: Floats = r["F0"] * (np.maximum(indentation, 0.0) / r["d0"]) ** r["p"]
        return force

    def elastic_indentation(self, force: Floats) -> Floats:
        """Return delta_e(N) [m], the inverse of :meth:`elastic_force`."""
        r = self.records
        indentation: Floats = r["d0"] * (np.maximum(force, 0.0) / r["F0"]) ** (1.0 / r["p"])
        return indentation

    def press(self, indentation: Floats) -> Floats:
        """Impose the indentations at the end of a step [m]; return the normal forces [N]."""
        kernels.press_tips(self.records, indentation)
        self._remember()
        return self.force.copy()

    def load(self, force: Floats) -> Floats:
        """Impose the normal forces at the end of a step [N]; return the indentations [m]."""
        wanted = np.maximum(force, 0.0)
        surface = self.before + (wanted - self.past) / self.instant
        self._close(self.elastic_indentation(surface), wanted)
        return self.indentation.copy()

    def _close(self, indentation: Floats, force: Floats) -> None:
        kernels.settle_tips(self.records, indentation, force)
        self._remember()

    def _remember(self) -> None:
        self.history.append(self.records["increment"])
        self.past[:] = self.history.past()

    @property
    def contact_radius(self) -> Floats:
        """Contact radius [m], zero out of contact."""
        kernels.find_exponents(self.records, profile.coefficient_logarithms())
        return self.records["a"].copy()

    @property
    def pressure_exponent(self) -> Floats:
        """Pressure exponent k [-]."""
        kernels.find_exponents(self.records, profile.coefficient_logarithms())
        return self.records["k"].copy()


class Warming:
    """Temperature of the tips: ``T = T0 + rise (1 - e^{-t/tau})``; softer and quicker when warm."""

    def __init__(self, settings: ThermalSettings) -> None:
        self.settings = settings
        self._applied = settings.start  # temperature the material was last set to

    def temperature(self, time: float) -> float:
        """Return the temperature at ``time`` [s] in degrees Celsius."""
        s = self.settings
        return s.start + (s.rise * -math.expm1(-time / s.time) if s.warming else 0.0)

    def material(self, time: float) -> tuple[float, float] | None:
        """Return factors of stiffness and relaxation rates [-] when they have changed noticeably, else None.

        The rates are taken as those of the present temperature for the whole history: right for warming that
        is slow against the relaxation, and renewed every 0.1 degrees.
        """
        warmth = self.temperature(time)
        if abs(warmth - self._applied) < 0.1:
            return None
        self._applied = warmth
        s, above = self.settings, warmth - self.settings.start
        return math.exp(-s.softening * above), math.exp(s.quickening * above)
