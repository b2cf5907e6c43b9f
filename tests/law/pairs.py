"""Faults in pairs: any two of the slip channels and of the sensors of force and displacement."""

import itertools
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from .channels import FAULTS
from .grasp import WORLDS, Case, Occurrence, World, draw, draw_occurrence
from .sensors import SENSOR_FAULTS

LEAST_MU, MOST_MU = 0.15, 1.1  # at 5 N
REAL = replace(WORLDS["real"], mu=(LEAST_MU, MOST_MU))

NAMED = (*(name for name in FAULTS if name != "none"), *SENSOR_FAULTS)
PAIRS = tuple(
    (one, other)
    for one, other in itertools.combinations(NAMED, 2)
    if other in SENSOR_FAULTS or "absent" not in (one, other)  # no channel has no other fault
)


def draw_pair(rng: np.random.Generator, pair: tuple[str, str] | None = None, world: World = REAL) -> Case:
    """Draw a case with two faults, each with its own beginning and fingers."""
    one, other = PAIRS[int(rng.integers(len(PAIRS)))] if pair is None else pair
    case = replace(draw(rng, one, world), gain=1.0, gain_drifts=False)
    return replace(case, also=(Occurrence(other, *draw_occurrence(rng, case.make.fingers)),))


def all_pairs(frictions: Iterable[float], seed: int = 1) -> list[Case]:
    """Draw a case of every pair with each friction."""
    return [
        draw_pair(np.random.default_rng([seed, i, j]), pair, replace(REAL, mu=(mu, mu)))
        for i, pair in enumerate(PAIRS)
        for j, mu in enumerate(frictions)
    ]
