"""The limit surface once more, on another path: in polar coordinates about the centre of rotation."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.special import gamma

Point = Callable[[float, float], tuple[float, float]]


@pytest.fixture(scope="session")
def area_integral() -> Point:
    """Give (k, d) -> (f, m) by a double integral over the area, without elliptic integrals or rings.

    About the centre of rotation the slip direction is constant along every ray, and the area element takes
    away the singularity: force int p cos(phi) s ds dphi, torque about that centre int p s^2 ds dphi.
    """
    return _point


def _point(k: float, d: float) -> tuple[float, float]:
    span = np.pi if d < 1 else np.arcsin(1 / d)  # rays from the one through the contact centre
    phi, w_phi = _tanh_sinh(0.0, span)
    half = np.sqrt(np.maximum(1 - (d * np.sin(phi)) ** 2, 0.0))
    nearest, first, last = d * np.cos(phi), d * np.cos(phi) - half, d * np.cos(phi) + half
    f = torque = 0.0
    # split at the nearest approach to the contact centre, where |r|^k may have a kink
    for low, high in ((np.maximum(first, 0.0), np.maximum(nearest, 0.0)), (np.maximum(nearest, 0.0), last)):
        s, w_s = _tanh_sinh(low[:, None], high[:, None])
        r = np.sqrt((s - nearest[:, None]) ** 2 + (d * np.sin(phi[:, None])) ** 2)
        pressure = np.maximum(1 - r**k, 0.0) ** (1 / k) * w_s * w_phi[:, None]
        f += 2 * np.sum(pressure * np.cos(phi[:, None]) * s)
        torque += 2 * np.sum(pressure * s**2)
    scale = 1.5 * k * gamma(3 / k) / (gamma(1 / k) * gamma(2 / k)) / np.pi
    return scale * f, scale * (torque - d * f)


def _tanh_sinh(low, high, step: float = 1 / 32, reach: float = 3.3):  # type: ignore[no-untyped-def]
    t = np.arange(-reach, reach + step / 2, step)
    x = np.tanh(np.pi / 2 * np.sinh(t))
    w = step * np.pi / 2 * np.cosh(t) / np.cosh(np.pi / 2 * np.sinh(t)) ** 2
    return (low + high) / 2 + (high - low) / 2 * x, (high - low) / 2 * w
