"""A small diagnosis, and linear problems."""

from types import SimpleNamespace

import numpy as np
import pytest

from vegrip.identification.diagnosis import diagnose
from vegrip.identification.diagnosis.candidate_fit import CandidateFit, evaluate_candidate
from vegrip.identification.fit.problem import Problem, Unknowns
from vegrip.identification.fit.solve import Optimum
from vegrip.types import Floats

NONE = np.zeros(0)


class White:
    """Leaves what is white as it is."""

    def __init__(self, n: int) -> None:
        self.log_scale = np.zeros(n)

    def __call__(self, raw: Floats) -> Floats:
        """Return it."""
        return raw


class Linear(Problem):
    """Residuals ``y - X u`` with unit noise, and a prior."""

    def __init__(self, y: Floats, columns: Floats, std: Floats, prior: Floats | None = None) -> None:
        self.y, self.columns = y, columns
        self.whitener, self.slip_std, self.radius_std = White(y.size), NONE, NONE
        self.doubtful, self.measured = np.zeros(y.size, bool), SimpleNamespace(force=y)
        n, middle = std.size, np.zeros(std.size) if prior is None else prior
        names, far = tuple(f"u{i}" for i in range(n)), np.full(n, 99.0)
        self.unknowns = Unknowns(names, np.zeros(n, bool), np.arange(n), middle, -far, far, middle, std)
        self.table = lambda u, _=None: y - columns @ u  # a problem of another class takes them over
        self.raw = lambda table: (table, NONE, NONE)

    def solved(self) -> Optimum:
        """Return the optimum, by one equation."""
        k, X = self.unknowns, self.columns
        u = k.prior + np.linalg.solve(X.T @ X + np.diag(k.std**-2.0), X.T @ (self.y - X @ k.prior))
        w = self.table(u)
        return Optimum(u, w, -X, 0.5 * float(w @ w + np.sum(((u - k.prior) / k.std) ** 2)))

    def fitted(self, groups: Floats) -> CandidateFit:
        """Return the fit."""
        return evaluate_candidate(self, self.solved(), groups)


@pytest.fixture(scope="session")
def linear():
    """Give the problem that is linear."""
    return Linear


@pytest.fixture(scope="session")
def small(tip):
    """Give a diagnosis of three touches that stick, in half a second."""
    return diagnose(tip(13, kinds=("hold", "ramp", "hold"), pull=0.06))
