"""Contact radius and pressure profile move together: the paper's two coupling equations, exactly.

Hypothesis, eq. (25): ``a`` is proportional to ``1 / sqrt(C_k)``, so a patch that grows by creep becomes
flatter in pressure. With ``a = a_0 sqrt(h)``, eq. (34), follows ``C_k = C_k0 / h``, eq. (36). The paper
inverts ``C_k`` by a fitted power law (:mod:`vegrip.contact.paper.tables`); here eq. (4) itself is
inverted, so that ``h = 1`` gives back ``k_0``.

The hypothesis has an end: as ``C_k > 1``, ``h < C_k0``. From ``k_0 = 2`` a patch cannot grow by more than
``sqrt(1.5)``, 22 % in radius; what creeps further is reported as saturated.
When the history is not a step of load, the creep ratio ``H``, eq. (48), drives the coupling: the paper
replaces ``h(t)`` by a convolution over the load. Normalised so that a step gives back ``h``, it is

    H(t) = delta(t) / delta_e(N_ref(t))

and the paper leaves ``N_ref`` open. With the present force, ``N_ref = N``, a hold at constant
displacement would flatten the profile (``N`` falls), while Section III keeps the profile as it is. The
default takes the largest force of this contact: ``H = 1`` after a step of displacement, ``H = h`` after a
step of load, and unloading does not count.
"""

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import digamma

from vegrip.contact.domain import not_negative, positive, within
from vegrip.contact.elastic import ElasticLaw
from vegrip.contact.hereditary import sampled
from vegrip.contact.pressure import coefficient, coefficient_excess
from vegrip.types import Floats

LEAST_COEFFICIENT = 1.0 + 1e-4
"""Below it the profile counts as uniform; ``k`` there is about 180, which is as good as infinite."""

_LARGEST_COEFFICIENT = 1e3  # k = 0.2: a spike no contact has; Newton below converges on all of the range
_NEWTON_STEPS = 12


class Exponent(NamedTuple):
    """Pressure exponent with the mark of where the coupling came to its end."""

    k: Floats
    saturated: NDArray[np.bool_]


def radius_ratio(k: ArrayLike, k0: ArrayLike = 2.0) -> Floats:
    """``a / a_0 = sqrt(C_k0 / C_k)``, eq. (25)."""
    return np.sqrt(coefficient(k0) / coefficient(k))


def exponent_from_coefficient(C: ArrayLike) -> Floats:
    """The exponent ``k`` whose coefficient is ``C``: exact inverse of eq. (4).

    Newton's method for ``ln(C_k - 1)`` as a function of ``ln k``, which is nearly a straight line, eq. (37).

    Raises:
        DomainError: ``C`` outside ``1.0001 .. 1000``.

    """
    C = within("pressure coefficient C_k", C, LEAST_COEFFICIENT, _LARGEST_COEFFICIENT)
    target = np.log(C - 1)
    x = (0.54 - target) / 1.79  # the paper's line
    for _ in range(_NEWTON_STEPS):
        excess = coefficient_excess(np.exp(x))
        step = (np.log(excess) - target) / _slope(x, excess)
        x = x - step
        if np.all(np.abs(step) < 1e-14):
            break
    return np.exp(x)


def saturating_exponent(C: ArrayLike) -> Exponent:
    """Like :func:`exponent_from_coefficient`, but below ``1.0001`` it is the largest ``k``, marked."""
    C = np.asarray(C, dtype=np.float64)
    saturated = C < LEAST_COEFFICIENT
    return Exponent(exponent_from_coefficient(np.where(saturated, LEAST_COEFFICIENT, C)), saturated)


def exponent_after_creep(h: ArrayLike, k0: ArrayLike = 2.0) -> Exponent:
    """Pressure exponent when the indentation has crept by the ratio ``h``, eqs. (35), (36), (39), exactly.

        C_k = C_k0 / h

    ``h`` is :func:`vegrip.contact.coupling.creep_ratio` in a history that is not a step, eq. (48).
    """
    return saturating_exponent(coefficient(k0) / positive("creep ratio h", h))


def _slope(x: Floats, excess: Floats) -> Floats:
    """``d ln(C_k - 1) / d ln k`` at ``x = ln k``."""
    u = np.exp(-x)
    dlnC_dx = -u * (3 * digamma(1 + 3 * u) - digamma(1 + u) - 2 * digamma(1 + 2 * u))
    return np.asarray((1 + excess) / excess * dlnC_dx)


Reference = Literal["largest", "present"]


def creep_ratio(
    times: ArrayLike,
    delta: ArrayLike,
    N: ArrayLike,
    law: ElasticLaw,
    *,
    reference: Reference = "largest",
    fading: float = np.inf,
) -> Floats:
    """``H(t)`` (n,), never below 1, for histories of indentation ``delta`` (n,) [m] and force ``N`` (n,) [N].

    Without contact (``N = 0``) it is 1. ``fading`` [s] lets the largest force be forgotten exponentially;
    at zero it would be the present force.
    """
    t, delta = sampled(times, not_negative("indentation", delta, "m"))
    t, N = sampled(t, not_negative("normal force", N, "N"))
    N_ref = N if reference == "present" else largest_force(t, N, fading)
    delta_e = law.indentation(N_ref)
    touching = (N > 0) & (delta_e > 0)
    return np.maximum(np.divide(delta, delta_e, out=np.ones_like(delta), where=touching), 1.0)


def largest_force(times: ArrayLike, N: ArrayLike, fading: float = np.inf) -> Floats:
    """Largest force [N] of the present contact so far (n,); starts anew when contact is lost (``N = 0``)."""
    t, N = sampled(times, N)
    keep = np.exp(-np.diff(t, prepend=t[:1]) / positive("fading time", fading, "s"))
    largest = np.empty_like(N)
    previous = 0.0
    for i, force in enumerate(N):
        previous = max(force, force + keep[i] * (previous - force)) if force > 0 else 0.0
        largest[i] = previous
    return largest
