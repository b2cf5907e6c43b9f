"""Force under imposed displacement, Fung's quasi-linear law [Fung1993]_ as used in Section III of the paper.

    N(t) = int_0^t g(t-s) K(delta(s)) delta'(s) ds = int_0^t g(t-s) dN_e(s)

Of the general response to a step, eq. (5), it assumes that depth and time are separate factors, eq. (10):
``Psi(delta, t) = N_e(delta) g(t)``. With a linear elastic response it is linear viscoelasticity, eq. (7).
Patch and profile stay as they are; a tip that may leave the object is :func:`vegrip.contact.history.solve`.
"""

from numpy.typing import ArrayLike

from vegrip.contact.elastic import ElasticLaw
from vegrip.contact.hereditary import filtered, sampled
from vegrip.contact.prony import Relaxation
from vegrip.types import Floats


def force_after_step(t: ArrayLike, delta: ArrayLike, law: ElasticLaw, g: Relaxation) -> Floats:
    """Force [N] at ``t`` [s] after a step of indentation to ``delta`` [m], eq. (16): ``N_e(delta) g(t)``."""
    return law.force(delta) * g(t)


def hereditary_force(times: ArrayLike, elastic_force: ArrayLike, g: Relaxation) -> Floats:
    """Force [N] for any history of the elastic force, eqs. (18)-(20); recursive.

    ``times`` (n,) [s], ``elastic_force`` (..., n) [N], result (..., n). Exact when ``N_e`` is linear
    between the samples; equal times are a jump, and a first sample that is not zero is a step.
    """
    return filtered(times, elastic_force, g.amplitudes, g.rates)


def force(times: ArrayLike, delta: ArrayLike, law: ElasticLaw, g: Relaxation) -> Floats:
    """Force [N] for a history of the indentation ``delta`` (..., n) [m], eq. (20); ``delta >= 0``.

    Second order in the step where the elastic law is curved (``N_e`` is taken linear between samples).
    """
    times, delta = sampled(times, delta)
    return hereditary_force(times, law.force(delta), g)
