"""Tails of the standard normal law, as scalar code; the same text is compiled."""

import math


def upper_tail(z: float) -> float:
    """Return ``P(Z > z)``, not quite 0."""
    return max(0.5 * math.erfc(z * 0.7071067811865476), 1e-300)


def inverse_mills(z: float) -> float:
    """Return ``phi(z) / Phi(z)``, stable far in the lower tail."""
    if z < -8.0:
        return -z - 1.0 / z
    return math.exp(-0.5 * z * z) * 0.3989422804014327 / (0.5 * math.erfc(-z * 0.7071067811865476))
