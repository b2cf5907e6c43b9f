"""The elastic response: force of an instantaneous indentation, its slope and their inverses.

A law is four functions of each other; ``delta`` [m] indentation, ``N`` [N] elastic force. Both laws take
``delta >= 0`` and ``N >= 0``: a fingertip that does not touch has no elastic response.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import exprel

from vegrip.contact.domain import not_negative
from vegrip.errors import DomainError
from vegrip.types import Floats


class ElasticLaw(Protocol):
    """What relaxation, creep and coupling need to know of a fingertip's elasticity."""

    def force(self, delta: ArrayLike) -> Floats:
        """Elastic force ``N_e(delta)`` [N]."""

    def stiffness(self, delta: ArrayLike) -> Floats:
        """``K = dN_e / d delta`` [N/m]."""

    def indentation(self, N: ArrayLike) -> Floats:
        """Elastic indentation ``delta_e(N)`` [m], the inverse of :meth:`force`."""

    def compliance(self, N: ArrayLike) -> Floats:
        """``S = d delta_e / dN = 1 / K`` [m/N], eq. (44)."""


@dataclass(frozen=True)
class ExponentialStiffness:
    """``K = m exp(b delta)``, eq. (11): human fingertips [PawlukHowe1999]_; ``b = 0`` is a linear spring."""

    m: float  # [N/m] stiffness at first touch
    b: float  # [1/m]

    def __post_init__(self) -> None:
        _check_parameters(self.m, self.b)

    def force(self, delta: ArrayLike) -> Floats:
        """``N_e = (m/b)(exp(b delta) - 1)`` [N], eq. (13)."""
        delta = not_negative("indentation", delta, "m")
        return np.asarray(self.m * delta * exprel(self.b * delta))

    def stiffness(self, delta: ArrayLike) -> Floats:
        """``K = m exp(b delta)`` [N/m], eq. (11)."""
        return self.m * np.exp(self.b * not_negative("indentation", delta, "m"))

    def indentation(self, N: ArrayLike) -> Floats:
        """``delta_e = (1/b) ln(1 + b N / m)`` [m], eq. (28)."""
        N = not_negative("normal force", N, "N")
        return np.log1p(self.b * N / self.m) / self.b if self.b else N / self.m

    def compliance(self, N: ArrayLike) -> Floats:
        """``S = 1 / (m + b N)`` [m/N], eq. (45)."""
        return 1 / (self.m + self.b * not_negative("normal force", N, "N"))


@dataclass(frozen=True)
class PowerStiffness:
    """``K = m delta^b``, eq. (12); ``b = 1/2`` is the sphere of [Hertz1882]_, ``b = 0`` a linear spring."""

    m: float  # [N/m^(b+1)]
    b: float  # [-]

    def __post_init__(self) -> None:
        _check_parameters(self.m, self.b)

    def force(self, delta: ArrayLike) -> Floats:
        """``N_e = m delta^(b+1) / (b+1)`` [N], eq. (14)."""
        return self.m * not_negative("indentation", delta, "m") ** (self.b + 1) / (self.b + 1)

    def stiffness(self, delta: ArrayLike) -> Floats:
        """``K = m delta^b`` [N/m], eq. (12)."""
        return self.m * not_negative("indentation", delta, "m") ** self.b

    def indentation(self, N: ArrayLike) -> Floats:
        """``delta_e = [(b+1) N / m]^(1/(b+1))`` [m], eq. (29)."""
        return ((self.b + 1) * not_negative("normal force", N, "N") / self.m) ** (1 / (self.b + 1))

    def compliance(self, N: ArrayLike) -> Floats:
        """``S = (1/m) [(b+1) N / m]^(-b/(b+1))`` [m/N], eq. (46); infinite at first touch when ``b > 0``."""
        N = not_negative("normal force", N, "N")
        with np.errstate(divide="ignore"):
            return ((self.b + 1) * N / self.m) ** (-self.b / (self.b + 1)) / self.m


def _check_parameters(m: float, b: float) -> None:
    if not (0 < m < np.inf and 0 <= b < np.inf):
        raise DomainError(f"stiffness parameters m = {m:g}, b = {b:g} must be m > 0, b >= 0")
