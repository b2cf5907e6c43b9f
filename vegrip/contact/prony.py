"""Reduced relaxation and reduced creep as sums of exponentials, with any number of branches.

Both are made of amplitudes ``c_i`` [-] and rates ``nu_i`` [1/s] and start at 1. Relaxation falls to
``1 - sum c_i``, creep rises to ``1 + sum c_i``.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from vegrip.contact.domain import not_negative
from vegrip.errors import DomainError
from vegrip.types import Floats


@dataclass(frozen=True)
class _Branches:
    amplitudes: tuple[float, ...]
    rates: tuple[float, ...]

    def __init__(self, amplitudes: Sequence[float] | Floats, rates: Sequence[float] | Floats) -> None:
        object.__setattr__(self, "amplitudes", tuple(float(c) for c in amplitudes))
        object.__setattr__(self, "rates", tuple(float(nu) for nu in rates))
        if len(self.amplitudes) != len(self.rates):
            raise DomainError(f"{len(self.amplitudes)} amplitudes do not fit {len(self.rates)} rates")
        if not all(c >= 0 for c in self.amplitudes):
            raise DomainError(f"amplitudes {self.amplitudes} must not be negative")
        if not all(0 < nu < np.inf for nu in self.rates):
            raise DomainError(f"rates {self.rates} must be positive and finite [1/s]")

    def _faded(self, t: ArrayLike) -> Floats:
        """``sum_i c_i (1 - exp(-nu_i t))``; the sum runs over a new last axis."""
        decay = -np.expm1(-not_negative("time", t, "s")[..., None] * np.array(self.rates))
        return np.asarray(decay @ np.array(self.amplitudes, dtype=np.float64))


class Relaxation(_Branches):
    """Reduced relaxation function, eq. (15), of [Fung1993]_: the force after a step of displacement.

        g(t) = c_0 + sum_i c_i exp(-nu_i t),    c_0 + sum_i c_i = 1

    ``c_0`` follows from the others and must not be negative; without branches the contact is elastic.
    """

    def __init__(self, amplitudes: Sequence[float] | Floats, rates: Sequence[float] | Floats) -> None:
        super().__init__(amplitudes, rates)
        if self.equilibrium < -1e-12:
            raise DomainError(f"relaxation amplitudes {self.amplitudes} sum to more than 1")

    @property
    def equilibrium(self) -> float:
        """``c_0 = g(inf)``, the part of the force that stays."""
        return 1.0 - sum(self.amplitudes)

    def __call__(self, t: ArrayLike) -> Floats:
        """``g(t)``, shape of ``t`` [s]; ``t = inf`` is allowed."""
        return 1.0 - self._faded(t)


class Creep(_Branches):
    """Reduced creep compliance, eq. (30), with one branch eq. (41): the response after a step of load.

        h(t) = 1 + sum_i c_i (1 - exp(-nu_i t))

    It stands for the paper's ``h``, which multiplies the indentation, eq. (27), and for the exact conjugate
    ``j`` of a relaxation function, which multiplies the load (:mod:`vegrip.contact.conjugate`).
    """

    @property
    def equilibrium(self) -> float:
        """``h(inf)``."""
        return 1.0 + sum(self.amplitudes)

    def __call__(self, t: ArrayLike) -> Floats:
        """``h(t)``, shape of ``t`` [s]; ``t = inf`` is allowed."""
        return 1.0 + self._faded(t)
