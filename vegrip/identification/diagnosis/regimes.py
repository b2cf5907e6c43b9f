"""The map of regimes on which a misfit is judged: phase, depth, time in contact, half of the session."""

import numpy as np

from vegrip.identification.compare.features import features_of
from vegrip.identification.diagnosis.candidate_fit import Fitted
from vegrip.identification.fit.problem import Problem
from vegrip.identification.fit.smoother import Floats

DEPTHS = 4
TIMES = (0.3, 1.5)  # [s] in contact


def regime_map(problem: Problem, u: Floats) -> Floats:
    """Return a number for every residual, -1 for those that do not count."""
    features = features_of(problem, problem.table(u))
    depth = features.values["indentation"]
    contact = features.values["time_in_contact"]
    edges = np.linspace(0.0, float(np.nanmax(depth)), DEPTHS + 1)[1:-1] * 0.93  # off the levels of holds
    half = (problem.episodes > np.median(problem.episodes)).astype(np.int64)
    number = features.phase.astype(np.int64)
    number = number * DEPTHS + np.searchsorted(edges, depth)
    number = number * (len(TIMES) + 1) + np.searchsorted(TIMES, contact)
    number = number * 2 + half
    rows = problem.rows
    block = np.concatenate([
        np.zeros(len(problem.measured.recording), dtype=np.int64),
        np.full(problem.measured.sliding.size, 1),
        np.full(problem.measured.seen.size, 2),
    ])  # fmt: skip
    every = number[rows] * 3 + block
    return np.where(problem.counted, every, -1).astype(np.float64)


def held_out_groups(problem: Problem) -> Floats:
    """Return for every residual what is held out with it: its episode, or a tenth of a single one."""
    if problem.episodes.max() >= 2:
        group = problem.episodes
    else:
        group = np.arange(problem.episodes.size) * 10 // problem.episodes.size
    return group[problem.rows].astype(np.float64)


def before(fitted: Fitted) -> Floats:
    """Return the map at a fitted model."""
    return regime_map(fitted.problem, fitted.optimum.u)
