"""Which creep function belongs to which relaxation function, exactly, for any number of branches.

Under eq. (20) a history of ``N_e`` gives the force ``N = int g dN_e``; the inverse of that law is

    N_e(t) = int_0^t j(t-s) dN(s),      s^2 g^(s) j^(s) = 1

with Laplace transforms on the right. The paper takes ``h`` of eq. (41) with the amplitudes and rates of
``g``; that pair is not conjugate: ``int g dh`` tends to 0.91 instead of 1 (``docs/theory.md``).

With the memories ``z_i' = nu_i (N_e - z_i)``, ``N = N_e - c.z`` (:mod:`vegrip.contact.hereditary`), an
imposed ``N`` leaves ``z' = -M z + nu N`` with ``M = diag(nu)(I - 1 c^T)``. Scaling by ``sqrt(c_i/nu_i)``
makes ``M`` symmetric, ``diag(nu) - s s^T`` with ``s_i = sqrt(c_i nu_i)``: its eigenvalues ``lambda`` are
real, and the amplitudes ``(q_i . s)^2 / lambda_i`` of ``j`` cannot be negative.
"""

import numpy as np

from vegrip.contact.prony import Creep, Relaxation
from vegrip.errors import DomainError
from vegrip.types import Floats


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
