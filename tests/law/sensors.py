"""What can be wrong with measured forces and displacements: pure functions of the sound value."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .plant import Array


@dataclass(slots=True)
class Measured:
    """What a sound channel of a finger measures now, and what is known beside it."""

    value: Array  # one component or two
    time: float  # [s] since the fault began
    held: Array  # measured when the fault began
    rng: np.random.Generator


Spoil = Callable[[Measured], Array]
COLUMNS = {"tangential": [1, 2], "normal": [0], "displacement": [4]}
"""Of a state, by channel."""
OFFSET = {
    "tangential": np.array([0.0, 0.4]),  # [N] against the weight, which is felt less
    "normal": np.array([0.5]),  # [N] more than there is
    "displacement": np.array([1e-4]),  # [m]
}
NOISE = {"tangential": 0.2, "normal": 0.3, "displacement": 5e-5}  # [N], [N], [m]
DRIFT_S = 50.0
"""In which a zero drifts by its offset, and on at this pace; in which a gain fades to its part, and stays."""
MISSING = 0.2  # share of the samples


def _fading(part: float) -> Spoil:
    return lambda now: part ** min(now.time / DRIFT_S, 1.0) * now.value


def _scaled(factor: float) -> Spoil:
    return lambda now: factor * now.value


def _drifting(offset: Array) -> Spoil:
    return lambda now: now.value + now.time / DRIFT_S * offset


def _shifted(offset: Array) -> Spoil:
    return lambda now: now.value + offset


def _noisy(std: float) -> Spoil:
    return lambda now: now.value + std * now.rng.standard_normal(len(now.value))


def _missing(now: Measured) -> Array:
    return np.full_like(now.value, np.nan) if now.rng.random() < MISSING else now.value


def faults_of(channel: str) -> dict[str, Spoil]:
    """Return what can be wrong with a channel, by name."""
    return {
        f"{channel}-{name}": spoil
        for name, spoil in {
            "drifts": _drifting(OFFSET[channel]),
            "fades": _fading(0.5),
            "scaled-0.6": _scaled(0.6),
            "scaled-1.6": _scaled(1.6),
            "offset": _shifted(OFFSET[channel]),
            "stuck": lambda now: now.held,
            "noisy": _noisy(NOISE[channel]),
            "dropouts": _missing,
        }.items()
    }


SENSOR_FAULTS = {name: spoil for channel in COLUMNS for name, spoil in faults_of(channel).items()}
"""By name, the channel before the first dash."""


def columns_of(fault: str) -> list[int]:
    """Return the columns of a state that a fault spoils."""
    return COLUMNS[fault.split("-", maxsplit=1)[0]]
