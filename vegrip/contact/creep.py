"""Indentation under imposed load, by the paper's law and by the exact inverse of the relaxation law.

Two constitutive laws:

* **consistent** (default everywhere in vegrip): eq. (20) turned round. The creep function ``j``, conjugate
  of ``g``, acts on the load, ``N_e = int j dN``, and the indentation is ``delta_e(N_e)``.
* **paper**, Section IV, eqs. (6), (27): the reduced creep compliance ``h`` acts on the indentation,
  ``delta = int h d delta_e(N)``.

They agree where the elastic response is linear, eq. (8), and ``h = j``. Under a step of load the consistent
law gives ``delta / delta_0 = j^(1/p)`` for ``N_e ~ delta^p``; for exponential stiffness the ratio depends on
the load, and no function ``h`` of time alone exists.
"""

import numpy as np
from numpy.typing import ArrayLike

from vegrip.contact.elastic import ElasticLaw
from vegrip.contact.geometry import GEOMETRIC, parabolic_radius
from vegrip.contact.hereditary import filtered, sampled
from vegrip.contact.prony import Creep, Relaxation, creep_of
from vegrip.types import Floats


def elastic_force(times: ArrayLike, N: ArrayLike, g: Relaxation) -> Floats:
    """Elastic force [N] under an imposed load ``N`` (..., n) [N], the inverse of eq. (20); recursive.

        N_e(t) = int_0^t j(t-s) dN(s)

    Exact when ``N`` is linear between the samples ``times`` (n,) [s]. (The step-by-step inverse of the
    recursion, exact when ``N_e`` is, is :func:`vegrip.contact.hereditary.solve`.)
    """
    return _crept(times, N, creep_of(g))


def indentation(times: ArrayLike, N: ArrayLike, law: ElasticLaw, g: Relaxation) -> Floats:
    """Indentation [m] under an imposed load ``N`` (..., n) [N] by the consistent law; ``N >= 0``."""
    times, N = sampled(times, N)
    return law.indentation(elastic_force(times, N, g))


def indentation_after_step(t: ArrayLike, N: ArrayLike, law: ElasticLaw, g: Relaxation) -> Floats:
    """Indentation [m] at ``t`` [s] after a step of the load to ``N`` [N] by the consistent law."""
    return law.indentation(np.asarray(N, dtype=np.float64) * creep_of(g)(t))


def paper_indentation(times: ArrayLike, N: ArrayLike, law: ElasticLaw, h: Creep) -> Floats:
    """Indentation [m] under an imposed load ``N`` (..., n) [N] by the paper's law, eqs. (42), (43).

        delta(t) = int_0^t h(t-s) S(N(s)) N'(s) ds = int_0^t h(t-s) d delta_e(N(s))

    Exact when the elastic indentation ``delta_e(N)`` is linear between the samples ``times`` (n,) [s].
    """
    times, N = sampled(times, N)
    return _crept(times, law.indentation(N), h)


def paper_indentation_after_step(t: ArrayLike, N: ArrayLike, law: ElasticLaw, h: Creep) -> Floats:
    """Indentation [m] at ``t`` [s] after a step of load to ``N`` [N], eqs. (27), (31): ``delta_e h(t)``."""
    return law.indentation(N) * h(t)


def paper_radius(times: ArrayLike, N: ArrayLike, law: ElasticLaw, h: Creep, R: float) -> Floats:
    """Contact radius [m] under an imposed load ``N`` (..., n) [N], eq. (47): ``sqrt(2 R delta)``."""
    return parabolic_radius(paper_indentation(times, N, law, h), R, GEOMETRIC)


def paper_radius_after_step(t: ArrayLike, N: ArrayLike, law: ElasticLaw, h: Creep, R: float) -> Floats:
    """Contact radius [m] at ``t`` [s] after a step of the load, eqs. (33), (34): ``a_0 sqrt(h(t))``."""
    return parabolic_radius(law.indentation(N), R, GEOMETRIC) * np.sqrt(h(t))


def _crept(times: ArrayLike, x: ArrayLike, creep: Creep) -> Floats:
    return filtered(times, x, [-c for c in creep.amplitudes], creep.rates)
