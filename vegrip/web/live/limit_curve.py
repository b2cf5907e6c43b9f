"""The friction limit surface as a curve to draw: tangential force against torque, normalised."""

import math
from functools import lru_cache

import numpy as np

from vegrip.contact.limit_surface.reference import point

EXPONENT_STEP = (
    0.1  # of the pressure exponent between two curves; the surface moves by less than a line's width
)
RANGE = (1.0, 50.0)  # of the pressure exponent; beyond, the pressure is as good as uniform
_CENTRES = (0.0, 0.1, 0.2, 0.3, 0.42, 0.55, 0.7, 0.85, 1.0, 1.25, 1.7, 2.6, 5.0, 20.0)
"""Distances of the centre of rotation [contact radii], from pure torque to pure force."""

Curve = tuple[tuple[float, float], ...]
"""Points (f, m): tangential force over mu N, torque over the largest torque, of the quarter f, m >= 0."""


def limit_curve(exponent: float) -> Curve:
    """Return the limit surface of a pressure exponent k; one below 1 or unknown counts as k = 2, Hertz."""
    if not math.isfinite(exponent) or exponent < RANGE[0]:
        exponent = 2.0
    return _curve(round(min(exponent, RANGE[1]) / EXPONENT_STEP))


@lru_cache(maxsize=256)
def _curve(steps: int) -> Curve:
    f, m = point(max(steps * EXPONENT_STEP, RANGE[0]), np.array(_CENTRES))
    points = [(round(float(x), 3), round(float(y / m[0]), 3)) for x, y in zip(f, m, strict=True)]
    return (*points, (1.0, 0.0))
