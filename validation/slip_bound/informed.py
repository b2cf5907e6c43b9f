"""The best bound that there is without a slip channel: how friction is spread in a world is known.

Without a slip channel a load that is held looks like one that slides, so of friction *f* (gain of the sensors
included) only its distribution *F* at the force of the grasp is known. With *u* = *T* / *N* as measured the
bound at the confidence *c* is::

    1 - u / F^-1(1 - c)

No bound that keeps its confidence at every friction of that world lies higher.
"""

import math
from dataclasses import replace
from functools import cache
from typing import Final

import numpy as np

from validation.slip_bound.forced import Look
from validation.slip_bound.hand import CONFIDENCES
from validation.slip_bound.worlds import STATED_AT, Grasp, draw_grasp

POPULATION: Final = range(1_000_000, 1_010_000)
"""Numbers of the grasps by which the distribution is known: none of those that are judged."""


@cache
def _population(world: str) -> tuple[np.ndarray, np.ndarray]:
    grasps = [draw_grasp(world, number) for number in POPULATION]
    return (
        np.log([one.gain * one.mu[0] for one in grasps]), np.array([one.exponent for one in grasps])
    )  # fmt: skip


def friction_quantiles(world: str, force: float) -> np.ndarray:
    """Return the quantile of friction as measured, at a normal force [N], for each of CONFIDENCES."""
    at_5_N, exponents = _population(world)
    logs = at_5_N - exponents * math.log(force / STATED_AT)
    return np.exp(np.quantile(logs, [1.0 - confidence for confidence in CONFIDENCES]))


def informed(world: str, grasp: Grasp, look: Look) -> Look:
    """Return the same look with the bounds of one who knows the world; never an earliest slip."""
    force = grasp.force_ratio * grasp.least_force
    friction = grasp.gain * grasp.limits(force)[look.finger] / force
    measured = (1.0 - look.margin) * friction
    bounds = 1.0 - measured / friction_quantiles(world, force)
    return replace(look, bounds=dict(zip(CONFIDENCES, bounds.tolist(), strict=True)), earliest_slip=math.nan)
