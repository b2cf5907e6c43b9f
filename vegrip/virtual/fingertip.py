"""Soft fingertips under imposed indentation or imposed force: the normal direction of the simulated truth.

One object holds n independent tips and advances them together by a fixed step.
"""

from collections.abc import Sequence

import numpy as np

from vegrip.types import Floats
from vegrip.virtual import profile
from vegrip.virtual.history import History
from vegrip.virtual.settings import FingertipSettings


class Fingertips:
    """n soft fingertips: ``N = int g(t-s) dN_e(delta)``, ``N_e = F0 (delta/d0)^p``, never pulling.

    Where the sum would turn negative the surface has left the object: it recovers freely, and the history
    keeps the N_e that gives zero force instead of the one of the imposed displacement.
    """

    def __init__(self, tips: Sequence[FingertipSettings], step: float, fine: int = 1024) -> None:
        self.tips, self.step = tuple(tips), step
        self.radius = np.array([tip.radius for tip in tips])
        self.d0 = np.array([tip.reference_indentation for tip in tips])
        self.p = np.array([tip.exponent for tip in tips])
        self._F0 = np.array([tip.reference_force for tip in tips])
        self.F0 = self._F0.copy()  # [N] at the present temperature
        self.history = History([tip.relaxing() for tip in tips], step, fine)
        self._past: Floats | None = None
        self.fresh_coefficient = float(profile.coefficient(np.array(profile.HERTZ)))
        self.reset()

    def reset(self) -> None:
        """Make the material fully recovered and out of contact."""
        n = len(self.tips)
        self.history.clear()
        self._past = None
        self.before = np.zeros(n)  # [N] N_e of the surface at the last step
        self.force = np.zeros(n)  # [N]
        self.indentation = np.zeros(n)  # [m] of the imposed position; negative out of contact
        self.reference = np.zeros(n)  # [N] greatest force of this contact

    @property
    def error_bound(self) -> Floats:
        """Largest error of the force per unit of total variation of N_e [-]; see :class:`History`."""
        return self.history.error_bound

    @property
    def instant(self) -> Floats:
        """Share of an increment of N_e that is felt within the step [-]."""
        return self.history.instant

    @property
    def past(self) -> Floats:
        """What all earlier increments contribute to the force of the coming step [N]."""
        if self._past is None:
            self._past = self.history.past()
        return self._past

    def heat(self, stiffness: float, speed: float) -> None:
        """Set the material: stiffness and relaxation rates as multiples of the nominal [-]."""
        self.F0 = stiffness * self._F0
        self.history.reweigh([tip.relaxing(speed) for tip in self.tips])
        self._past = None

    def elastic_force(self, indentation: Floats) -> Floats:
        """Return N_e(delta) [N]."""
        force: Floats = self.F0 * (np.maximum(indentation, 0.0) / self.d0) ** self.p
        return force

    def elastic_indentation(self, force: Floats) -> Floats:
        """Return delta_e(N) [m], the inverse of :meth:`elastic_force`."""
        indentation: Floats = self.d0 * (np.maximum(force, 0.0) / self.F0) ** (1.0 / self.p)
        return indentation

    def press(self, indentation: Floats) -> Floats:
        """Impose the indentations at the end of a step [m]; return the normal forces [N]."""
        force = self.past + self.instant * (self.elastic_force(indentation) - self.before)
        self._close(indentation, np.maximum(force, 0.0))
        return self.force

    def load(self, force: Floats) -> Floats:
        """Impose the normal forces at the end of a step [N]; return the indentations [m]."""
        wanted = np.maximum(force, 0.0)
        surface = self.before + (wanted - self.past) / self.instant
        self._close(self.elastic_indentation(surface), wanted)
        return self.indentation

    def _close(self, indentation: Floats, force: Floats) -> None:
        surface = self.before + (force - self.past) / self.instant  # the N_e that gives this force
        self.history.append(surface - self.before)
        self.before, self._past = surface, None
        self.force, self.indentation = force, indentation
        self.reference = np.where(force > 0.0, np.maximum(self.reference, force), 0.0)

    @property
    def contact_radius(self) -> Floats:
        """Contact radius ``a = sqrt(2 R delta)`` [m], zero out of contact."""
        depth = np.where(self.force > 0.0, np.maximum(self.indentation, 0.0), 0.0)
        a: Floats = np.sqrt(2.0 * self.radius * depth)
        return a

    @property
    def pressure_exponent(self) -> Floats:
        """Pressure exponent k [-]: ``C_k = C_2 / H`` with the creep ``H = delta / delta_e(N_ref)``.

        N_ref is the greatest force of this contact, so a held indentation keeps its profile and a held force
        flattens it ([TiezziKao2007]_, eq. (36); H is never below one).
        """
        fresh = self.elastic_indentation(self.reference)
        creep = np.ones_like(fresh)
        np.divide(self.indentation, fresh, out=creep, where=fresh > 0.0)
        return profile.exponent(self.fresh_coefficient / np.maximum(creep, 1.0))
