"""Indentation under an imposed load, one sample: solved in closed form against a root search on eq. (20).

The root search is scipy's ``brentq`` over the indentation, with the same recursion for the force: what is
compared is the inversion alone.
"""

import numpy as np
from scipy.optimize import brentq

from benchmarks._timing import compared
from vegrip.contact.hereditary import advance, drive

AMPLITUDES = np.array([0.2, 0.1])
RATES = np.array([3.1, 0.25])  # [1/s]
DT = 1e-3  # [s]
STIFFNESS, POWER = 4e4, 1.5  # N_e = K delta^p [N], a silicone fingertip
LOAD = 2.0  # [N]
MEMORY = np.array([2.1, 1.9])  # [N] of the elastic force
BEFORE = 2.6  # [N] elastic force at the last sample


def run() -> dict[str, dict[str, float]]:
    assert abs(closed_form() - root_search()) < 1e-12
    return {"creep_inverse_vs_root_solve": compared(closed_form, root_search)}


def closed_form() -> float:
    """The indentation [m] that carries the load."""
    N_e = drive(MEMORY, BEFORE, LOAD, DT, AMPLITUDES, RATES)
    return float((N_e / STIFFNESS) ** (1 / POWER))


def root_search() -> float:
    """The same by trial."""

    def excess(delta: float) -> float:
        return advance(MEMORY.copy(), BEFORE, STIFFNESS * delta**POWER, DT, AMPLITUDES, RATES) - LOAD

    return float(brentq(excess, 0.0, 8e-3, xtol=1e-14))
