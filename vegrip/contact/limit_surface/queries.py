"""Questions to the limit surface of the paper's pressure, checked and for arrays.

The numbers are those of the compiled functions in :mod:`~vegrip.contact.limit_surface.fast`, with the error
bounds given there. Loads are normalised: f = |f_t|/(mu N), m = m_n/(mu N a). All arguments broadcast.
Whatever lies outside the range where the answer is known - an exponent below 1, a NaN, an infinite load, an
angle beyond a quarter turn - raises :class:`~vegrip.errors.DomainError`.

>>> print(f"{gauge(2, f=0.4, m=0.3):.4f}")
0.6839
>>> bool(is_inside(2, f=0.4, m=0.3))
True
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vegrip.contact.domain import within
from vegrip.contact.limit_surface import fast, reference
from vegrip.contact.limit_surface.reference import exponent, load_angle
from vegrip.errors import DomainError
from vegrip.types import Floats

_LARGEST = np.finfo(np.float64).max


def point(k: ArrayLike, d: ArrayLike) -> tuple[Floats, Floats]:
    """Point (f, m) of the surface for a centre of rotation at d >= 0 [contact radii], by quadrature."""
    return reference.point(k, d)


def gauge(k: ArrayLike, f: ArrayLike, m: ArrayLike) -> Floats:
    """Load over limit: 1 on the surface, below 1 inside, proportional to the load."""
    (value,) = _over(fast.gauge, exponent(k), _finite("force", f), _finite("torque", m))
    return value


def is_inside(k: ArrayLike, f: ArrayLike, m: ArrayLike) -> NDArray[np.bool_]:
    return np.asarray(gauge(k, f, m) < 1.0)


def radius(k: ArrayLike, psi: ArrayLike) -> Floats:
    """Distance from the origin to the surface along f = r cos(psi), m = r sin(psi), psi in [0, pi/2]."""
    (value,) = _over(fast.radius, exponent(k), load_angle(psi))
    return value


def support(k: ArrayLike, v: ArrayLike, omega: ArrayLike) -> Floats:
    """Greatest f v + m omega over the surface: friction power/(mu N a) in the slip (v [radii/s], omega)."""
    (value,) = _over(fast.support, exponent(k), _finite("slip speed", v), _finite("spin", omega))
    return value


def slip_twist(k: ArrayLike, f: ArrayLike, m: ArrayLike) -> tuple[Floats, Floats]:
    """Direction (v, omega), of length 1, of the slip the load starts: the outward normal of the surface.

    v in contact radii per second along the force. No load has no direction: DomainError.
    """
    k, f, m = exponent(k), _finite("force", f), _finite("torque", m)
    _, _, v, omega = _over(fast.gauge_gradient, k, f, m, results=4)
    length = np.hypot(v, omega)
    if not np.all(length > 0.0):
        raise DomainError("without load there is no slip direction")
    return v / length, omega / length


def cor_distance(k: ArrayLike, f: ArrayLike, m: ArrayLike) -> Floats:
    """Distance d [contact radii] of the centre of rotation of the slip the load starts; inf for m = 0."""
    v, omega = slip_twist(k, f, m)
    with np.errstate(divide="ignore"):
        return np.abs(v / omega)


def _finite(name: str, values: ArrayLike) -> Floats:
    return within(name, values, -_LARGEST, _LARGEST)


def _over(function: Callable[..., Any], *arguments: Floats, results: int = 1) -> tuple[Floats, ...]:
    with np.errstate(invalid="ignore"):  # compiled code computes inf * 0 and then does not use it
        values = np.vectorize(function, otypes=[np.float64] * results)(*arguments)
    return values if results > 1 else (values,)
