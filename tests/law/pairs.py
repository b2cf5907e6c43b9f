"""Faults in pairs: any two of the slip channels and of the sensors of force and displacement."""

import itertools
from collections.abc import Sequence
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


def case_of(pair: tuple[str, str], mu: float, seed: int = 1) -> Case:
    """Draw the rest of a case of a pair with this friction."""
    rng = np.random.default_rng([seed, PAIRS.index(pair), round(1000.0 * mu)])
    return draw_pair(rng, pair, replace(REAL, mu=(mu, mu)))


def all_pairs(frictions: Sequence[float], seed: int = 1, *, in_turn: bool = False) -> list[Case]:
    """Draw a case of every pair with each friction, or with one of them in turn."""
    if in_turn:
        return [case_of(pair, frictions[i % len(frictions)], seed) for i, pair in enumerate(PAIRS)]
    return [case_of(pair, mu, seed) for pair in PAIRS for mu in frictions]
