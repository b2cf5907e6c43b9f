"""Reduced relaxation and reduced creep as sums of exponentials, and which creep belongs to which relaxation.

Both are made of amplitudes ``c_i`` [-] and rates ``nu_i`` [1/s] and start at 1. Relaxation falls to
``1 - sum c_i``, creep rises to ``1 + sum c_i``.

Under eq. (20) a history of ``N_e`` gives the force ``N = int g dN_e``; the inverse of that law is

    N_e(t) = int_0^t j(t-s) dN(s),      s^2 g^(s) j^(s) = 1

with Laplace transforms on the right. The paper takes ``h`` of eq. (41) with the amplitudes and rates of
``g``; that pair is not conjugate: ``int g dh`` tends to 0.91 instead of 1 (``docs/theory.md``).

With the memories ``z_i' = nu_i (N_e - z_i)``, ``N = N_e - c.z`` (:mod:`vegrip.contact.hereditary`), an
imposed ``N`` leaves ``z' = -M z + nu N`` with ``M = diag(nu)(I - 1 c^T)``. Scaling by ``sqrt(c_i/nu_i)``
makes ``M`` symmetric, ``diag(nu) - s s^T`` with ``s_i = sqrt(c_i nu_i)``: its eigenvalues ``lambda`` are
real, and the amplitudes ``(q_i . s)^2 / lambda_i`` of ``j`` cannot be negative.
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
    ``j`` of a relaxation function, which multiplies the load (:mod:`vegrip.contact.prony`).
    """

    @property
    def equilibrium(self) -> float:
        return 1.0 + sum(self.amplitudes)

    def __call__(self, t: ArrayLike) -> Floats:
        """``h(t)``, shape of ``t`` [s]; ``t = inf`` is allowed."""
        return 1.0 + self._faded(t)


def creep_of(g: Relaxation) -> Creep:
    """The exact conjugate ``j`` of ``g``; ``j(inf) = 1 / c_0``.

    With one branch: ``j(t) = 1 + (c/c_0)(1 - exp(-c_0 nu t))``.

    Raises:
        DomainError: ``c_0 = 0``, a fluid: it creeps without end and no sum of exponentials describes it.

    """
    if g.equilibrium <= 1e-12:
        raise DomainError("a relaxation function that falls to zero has no bounded creep function")
    return Creep(*_spectrum(g.amplitudes, g.rates, -1.0))


def relaxation_of(j: Creep) -> Relaxation:
    """The relaxation function whose exact conjugate is ``j``; inverse of :func:`creep_of`."""
    return Relaxation(*_spectrum(j.amplitudes, j.rates, +1.0))


def _spectrum(amplitudes: tuple[float, ...], rates: tuple[float, ...], sign: float) -> tuple[Floats, Floats]:
    if not rates:
        return np.zeros(0), np.zeros(0)
    nu = np.array(rates)
    s = np.sqrt(np.array(amplitudes) * nu)
    eigenvalues, q = np.linalg.eigh(np.diag(nu) + sign * np.outer(s, s))
    return (s @ q) ** 2 / eigenvalues, eigenvalues
