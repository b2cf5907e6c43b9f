"""What every generated module offers; the kernels are written against these signatures.

The kernels (``simulate_kernel.py`` here, those of the estimator) are ordinary files that import from this
one, so that they can be read, linted and typed. In a generated module their text stands below the real
``advance``, ``readout`` and ``read_radius``, without the imports.
"""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

N_STATES = 0
"""How many states the effects have."""
N_VALUES = 0
"""How many parameters the effects have."""
N_OUTSIDE = 0
"""How many quantities :data:`vegrip.effects.contract.OUTSIDE` has."""
N_GEOMETRY = 0
"""How many numbers of :data:`vegrip.effects.contract.GEOMETRY` follow the parameters."""


def advance(
    m: Floats,
    values: int,
    states: int,
    delta: float,
    speed: float,
    exogenous: int,
    elastic_before: float,
    dt: float,
    new_states: int,
) -> tuple[float, float, float, float]:
    """One step of the contact: ``x``, ``elastic_force``, ``force``, ``sensed_force``; fills ``new_states``.

    Args:
        m: one array that holds everything; the other arrays are places in it.
        values: parameters, then geometry (:data:`vegrip.effects.contract.GEOMETRY`).
        states: states of the effects before the step; may be the same place as ``new_states``.
        delta: indentation at the end of the step [m].
        speed: its rate [m/s].
        exogenous: the quantities of :data:`vegrip.effects.contract.OUTSIDE`.
        elastic_before: elastic force at the start of the step [N].
        dt: length of the step [s]; 0 reads the force of the present states.
        new_states: receives the states after the step.

    """
    raise NotImplementedError


def readout(
    m: Floats,
    values: int,
    states: int,
    delta: float,
    speed: float,
    exogenous: int,
    x: float,
    elastic_force: float,
    force: float,
) -> tuple[float, float, float]:
    """Return contact radius [m], pressure exponent and friction coefficient of the present states."""
    raise NotImplementedError


def read_radius(m: Floats, values: int, states: int, *at: float) -> float:
    """Return the contact radius alone, of the arguments of :func:`readout`."""
    raise NotImplementedError
