"""Bounded least squares with priors, from several starts; the noise is set up anew at every better model."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from vegrip.fit.problem import AT, Problem
from vegrip.fit.smoother import Floats

Report = Callable[[str], None]

ROUGH = 8  # evaluations of a start before the best one is chosen
FINE = 40
SETTLED = 1e-3  # of a standard deviation: the last step of a fit
RATES = (0.1, 1.0, 10.0)  # factors on the rate of relaxation, the parameter with several minima


@dataclass(frozen=True, eq=False)
class Optimum:
    """Where a problem is at its best.

    Attributes:
        u: (p,) coordinates.
        residual: (rows,) whitened.
        jacobian: (rows, p).
        cost: half the sum of squares of residuals and priors.

    """

    u: Floats
    residual: Floats
    jacobian: Floats
    cost: float


def fit_problem(problem: Problem, report: Report = lambda _: None) -> Optimum:
    """Minimise, from several starts."""
    starts = starting_points(problem)
    best: Optimum | None = None
    for i, start in enumerate(starts):
        report(f"start {i + 1} of {len(starts)}")
        problem.freeze(start)
        found = refine(problem, start, ROUGH)
        if best is None or _badness(problem, found.u) < _badness(problem, best.u):
            best = found
    assert best is not None  # noqa: S101
    problem.distrust(best.u)
    for _ in range(2):
        report("fine")
        problem.freeze(best.u)
        best = refine(problem, best.u, FINE)
    return best


def _badness(problem: Problem, u: Floats) -> float:
    """Compare optima whose noise was frozen elsewhere: in plain units of force, radius and slip."""
    force, slip, radius = problem.raw(problem.table(u))
    noise = problem.measured.noise
    total = float(np.sum((force / noise.normal_force) ** 2)) + float(np.sum((slip / problem.slip_std) ** 2))
    return total + float(np.sum((radius / problem.radius_std) ** 2))


def starting_points(problem: Problem) -> list[Floats]:
    """Return starts: the model with its stiffness scaled to the record, its relaxation slower and faster."""
    k = problem.unknowns
    out = []
    for factor in RATES if "nu1" in k.names else (1.0,):
        u = k.start.copy()
        if "nu1" in k.names:
            u[k.names.index("nu1")] += np.log(factor)
        out.append(np.clip(_scaled(problem, u), k.low, k.high))
    return out


def _scaled(problem: Problem, u: Floats) -> Floats:
    """Scale K so that the predicted forces are as large as the measured ones."""
    k = problem.unknowns
    if "K" not in k.names:
        return u
    used = np.isfinite(problem.measured.force)
    for _ in range(3):
        said, seen = problem.table(u)[used, AT["normal_force"]], problem.measured.force[used]
        power = float(said @ said)
        if power > 0.0 and float(said @ seen) > 0.0:
            u = u.copy()
            u[k.names.index("K")] += np.log(float(said @ seen) / power)
    return u


def refine(problem: Problem, start: Floats, evaluations: int) -> Optimum:
    """Minimise from one start with the noise as it is frozen."""
    k = problem.unknowns
    inside = 1e-9 * k.std
    low, high = k.low, k.high
    start = np.clip(
        start, np.where(np.isfinite(low), low + inside, low), np.where(np.isfinite(high), high - inside, high)
    )

    def cost(u: Floats) -> Floats:
        return np.concatenate([problem.residual(u), (u - k.prior) / k.std])

    def slope(u: Floats) -> Floats:
        return np.vstack([problem.jacobian(u), np.diag(1.0 / k.std)])

    found = least_squares(
        cost, start, slope, bounds=(low, high), x_scale=k.std, method="trf",
        max_nfev=evaluations, ftol=1e-9, xtol=SETTLED * 1e-3, gtol=1e-9,
    )  # fmt: skip
    rows = found.fun.size - k.std.size
    return Optimum(found.x, found.fun[:rows], np.asarray(found.jac)[:rows], float(found.cost))


def covariance(problem: Problem, optimum: Optimum) -> Floats:
    """Return the covariance (p, p) of the coordinates, wider where the model leaves more than noise."""
    k = problem.unknowns
    A = optimum.jacobian.T @ optimum.jacobian
    misfit = float(np.sum(optimum.residual**2)) / max(int(np.count_nonzero(problem.counted)), 1)
    A = A / max(misfit, 1.0) + np.diag(k.std**-2.0)
    return np.asarray(np.linalg.inv(A), dtype=np.float64)
