"""The solver by itself, on a law with a known answer that overflows a long step away from it."""

import numpy as np

from vegrip.identification.fit.problem import Problem, Unknowns
from vegrip.identification.fit.solve import refine_optimum
from vegrip.types import Floats

X = np.linspace(0.0, 1.0, 50)
RATE = 3.0


class Exponential(Problem):
    """y = exp(exp(u) x): a full step from the flat side of it ends beyond 1e200."""

    def __init__(self) -> None:
        self.unknowns = Unknowns(
            names=("rate",),
            log=np.array([True]),
            place=np.array([0]),
            start=np.array([-2.0]),
            low=np.array([-9.0]),
            high=np.array([9.0]),
            prior=np.array([0.0]),
            std=np.array([10.0]),
        )
        self.largest = 0.0

    def residual(self, u: Floats) -> Floats:
        with np.errstate(over="ignore"):
            r = np.exp(np.minimum(np.exp(u[0]) * X, 500.0)) - np.exp(RATE * X)
        self.largest = max(self.largest, float(np.abs(r).max()))
        return np.asarray(r, dtype=np.float64)


def test_a_step_into_overflow_is_refused_and_the_optimum_is_found_all_the_same() -> None:
    problem = Exponential()
    found = refine_optimum(problem, problem.unknowns.start, 60)
    assert problem.largest > 1e160  # the step was taken, and its cost overflows
    assert abs(np.exp(found.u[0]) - RATE) < 0.01
