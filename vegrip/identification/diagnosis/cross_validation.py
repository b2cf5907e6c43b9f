"""Scores of what was held out: how well a fit without an episode foretells it."""

import math

import numpy as np

from vegrip.identification.fit.preprocess import Mask
from vegrip.identification.fit.problem import Problem
from vegrip.identification.fit.solve import Optimum, refine_optimum
from vegrip.types import Floats

HELD_OUT = 0.95  # of what an episode knows; the rest stays, for values that only this episode tells
REFIT_ERROR = (
    1.5  # error / noise above which the fits without an episode are made and not foretold, if they are
)
MAX_FOLDS = 12
REFIT_STEPS = 15


class Weighted(Problem):
    """A problem whose residuals count with positive ``weights`` (rows,)."""

    def __init__(self, problem: Problem, weights: Floats) -> None:
        self.__dict__.update(problem.__dict__)
        self._weights = weights

    def white(self, raw: tuple[Floats, Floats, Floats]) -> Floats:
        """Return the weighted residual."""
        return super().white(raw) * self._weights


def scores(problem: Problem, optimum: Optimum, A: Floats, groups: Floats) -> Floats:
    """Return minus half the squares of each group (numbered by ``groups``, (rows,)) under a fit without it.

    ``A``: information of the optimum, priors included. One linear step tells the fit without a group where
    the model is nearly right. Where much is left the step is wild (it once foretold -1e8 nats where a fit
    gained), so the fits are made.
    """
    numbers = np.unique(groups)
    misfit = 2.0 * optimum.cost / max(int(np.count_nonzero(problem.counted)), 1)
    if misfit > REFIT_ERROR**2 and numbers.size <= MAX_FOLDS:
        return np.array([_fitted(problem, optimum, groups == number) for number in numbers])
    return np.array([_foretold(optimum, A, groups == number) for number in numbers])


def _foretold(optimum: Optimum, A: Floats, rows: Mask) -> float:
    J, r = optimum.jacobian[rows], optimum.residual[rows]
    step = np.linalg.solve(A - HELD_OUT * J.T @ J, HELD_OUT * J.T @ r)
    return -0.5 * float(np.sum((r + J @ step) ** 2))


def _fitted(problem: Problem, optimum: Optimum, rows: Mask) -> float:
    weights = np.where(rows, math.sqrt(1.0 - HELD_OUT), 1.0)
    found = refine_optimum(Weighted(problem, weights), optimum.u, REFIT_STEPS)
    return -0.5 * float(np.sum((found.residual[rows] / weights[rows]) ** 2))
