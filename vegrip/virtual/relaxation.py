"""Reduced relaxation functions of the simulated material: how much of a step in N_e is left after a time.

``g(0) = 1`` and g falls towards its long-time value; any such function will do, it is only ever integrated
numerically (:mod:`vegrip.virtual.history`).
"""

from collections.abc import Callable, Sequence

import numpy as np

from vegrip.types import Floats

Relaxation = Callable[[Floats], Floats]
"""Time since the step [s] -> share of the force that is left [-], element by element."""


def prony(amplitudes: Sequence[float], rates: Sequence[float]) -> Relaxation:
    """Return ``g(t) = 1 - sum_i c_i (1 - e^{-nu_i t})`` for amplitudes c_i [-] and rates nu_i [1/s]."""
    c, nu = np.asarray(amplitudes, float), np.asarray(rates, float)

    def g(t: Floats) -> Floats:
        left: Floats = 1.0 + np.expm1(-np.multiply.outer(t, nu)) @ c
        return left

    return g


def power_law(amplitude: float, time: float, exponent: float) -> Relaxation:
    """Return ``g(t) = 1 - A + A (1 + t/tau)^{-alpha}``: straight in log t for a small exponent alpha [-]."""

    def g(t: Floats) -> Floats:
        left: Floats = 1.0 - amplitude + amplitude * (1.0 + t / time) ** -exponent
        return left

    return g
