"""Bounded least squares with priors, from several starts; the noise is set up anew at every better model."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from vegrip.identification.fit.problem import AT, Problem, Unknowns
from vegrip.types import Floats

Report = Callable[[str], None]

START_EVALUATIONS = 8  # evaluations of a start before the best one is chosen
MAX_EVALUATIONS = 40
LAST_STEP_NATS = 1e-4  # [nats] a step that predicts less is the last one, or
LAST_STEP_SHARE = 1e-9  # less of the cost, as precise as derivatives by differences
SETTLED_NATS, SETTLED_SHARE = 1.0, 1e-3  # [nats], of the cost, that a model may lack which was fitted before
DAMPED = 1e-3  # of the first step
HOPE = 10.0  # times what a step predicts, by which a fit may still fall
CANCELLED = 1e-4  # of a sum of squares, below which it is summed anew
START_RATE_FACTORS = (0.1, 1.0, 10.0)  # factors on the rate of relaxation, the parameter with several minima


@dataclass(frozen=True, eq=False)
class Optimum:
    """Where a problem is at its best."""

    u: Floats  # (p,) coordinates
    residual: Floats  # (rows,) whitened
    jacobian: Floats  # (rows, p)
    cost: float  # half the sum of squares of residuals and priors
    is_given_up: bool = False  # far from what it had to beat


def fit_problem(problem: Problem, report: Report = lambda _: None, plain: Problem | None = None) -> Optimum:
    """Minimise, from several starts.

    Rows that the ``plain`` model doubts are left out; that is the paper's, fitted to the same recording, and
    ``problem`` when not given. So every model is judged on the same rows.
    """
    if plain is None:
        best = _best_start(problem, starting_points(problem), report)
        problem.doubtful = problem.doubted(best)
        return _settle(problem, best, report)
    if plain.measured.recovered:
        problem.doubtful = plain.doubted(_best_start(plain, starting_points(plain), report))
    if not problem.symbols:
        return _settle(problem, problem.unknowns.start, report)
    as_it_is = Problem(problem.model, problem.measured, symbols=(), like=problem)
    zeros = _settle(as_it_is, as_it_is.unknowns.start, report).u
    known = dict(zip(as_it_is.unknowns.names, zeros, strict=True))
    k = problem.unknowns
    given = np.array([known.get(name, start) for name, start in zip(k.names, k.start, strict=True)])
    if not _is_settled(problem, given):
        given = _best_start(problem, [given, *starting_points(problem)], report)
    return _settle(problem, given, report)


def _best_start(problem: Problem, starts: list[Floats], report: Report) -> Floats:
    best: Floats | None = None
    for i, start in enumerate(starts):
        report(f"start {i + 1} of {len(starts)}")
        problem.freeze(start)
        found = refine_optimum(problem, start, START_EVALUATIONS).u
        if best is None or _badness(problem, found) < _badness(problem, best):
            best = found
    assert best is not None  # noqa: S101
    return best


def _settle(problem: Problem, u: Floats, report: Report) -> Optimum:
    for i in range(2):
        report(f"last steps {i + 1} of 2")
        problem.freeze(u)
        best = refine_optimum(problem, u, MAX_EVALUATIONS)
        u = best.u
    return best


def _is_settled(problem: Problem, u: Floats) -> bool:
    problem.freeze(u)
    r = problem.residual(u)
    J = problem.jacobian(u, r)
    _, foretold = _step(problem.unknowns, u, J.T @ r, J.T @ J, 0.0)
    return foretold < SETTLED_NATS + SETTLED_SHARE * _cost(problem.unknowns, r, u)


def _badness(problem: Problem, u: Floats) -> float:
    """Compare optima whose noise was frozen elsewhere: in plain units of force, radius and slip."""
    force, slip, radius = problem.raw(problem.table(u))
    white = problem.measured.noise.of_force(problem.measured.force, problem.episodes).white
    total = float(np.sum((force / white) ** 2)) + float(np.sum((slip / problem.slip_std) ** 2))
    return total + float(np.sum((radius / problem.radius_std) ** 2))


def starting_points(problem: Problem) -> list[Floats]:
    """Return starts: the model with its stiffness scaled to the record, its relaxation slower and faster."""
    k = problem.unknowns
    out = []
    for factor in START_RATE_FACTORS if "nu1" in k.names else (1.0,):
        u = k.start.copy()
        if "nu1" in k.names:
            u[k.names.index("nu1")] += np.log(factor)
        out.append(np.clip(scaled(problem, u), k.low, k.high))
    return out


def scaled(problem: Problem, u: Floats) -> Floats:
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


def refine_optimum(
    problem: Problem,
    start: Floats,
    evaluations: int,
    known: Mapping[str, Floats] | None = None,
    near: float = LAST_STEP_NATS,
    least: float = math.inf,
) -> Optimum:
    """Minimise from one start with the noise as it is frozen; ``known``: derivatives near the start.

    ``least``: the cost to come below; a fit that stays far from it is given up, without its last derivatives.

    Damped Gauss-Newton steps within the bounds [Marquardt1963]_. Derivatives cost as much as all unknowns
    together, so they are kept from step to step, corrected by what each step showed [Broyden1965]_, and taken
    anew where that predicted little; ``evaluations`` limits the steps.
    """
    k = problem.unknowns
    inside = 1e-9 * k.std
    u = np.clip(start, k.low + inside, k.high - inside)
    r = problem.residual(u)
    J, fresh = problem.jacobian(u, r, known), known is None
    A = J.T @ J
    cost, damping, is_given_up = _cost(k, r, u), DAMPED, False
    for _ in range(evaluations):
        near = max(near, LAST_STEP_SHARE * cost)
        step, foretold = _step(k, u, J.T @ r, A, damping)
        if is_given_up := cost - HOPE * foretold > least:
            break
        if foretold < near and not fresh:
            J, fresh = problem.jacobian(u, r), True
            A = J.T @ J
            step, foretold = _step(k, u, J.T @ r, A, damping)
        new = u + step
        r_new = problem.residual(new)
        cost_new = _cost(k, r_new, new)
        found = cost - cost_new
        if found >= 0.0:
            z = step / k.std
            if np.any(z):
                J, A = _corrected(J, A, (r_new - r - J @ step) / (z @ z), z / k.std)
            was_fresh, fresh = fresh, False
            u, r, cost = new, r_new, cost_new
            if foretold < near and was_fresh:
                break
            damping = damping / 10.0 if found > 0.9 * foretold else damping
            if found < 0.25 * foretold:
                J, fresh = problem.jacobian(u, r), True
                A = J.T @ J
        elif foretold < near:
            break
        elif fresh:
            damping = 3.0 * max(damping, 1e-9)
        else:
            J, fresh = problem.jacobian(u, r), True
            A = J.T @ J
    else:
        J = J if fresh else problem.jacobian(u, r)
    return Optimum(u, r, J, cost, is_given_up)


def _corrected(J: Floats, A: Floats, missed: Floats, along: Floats) -> tuple[Floats, Floats]:
    """Return ``J + missed along'`` and its square, that of J corrected unless most of it cancels."""
    new = np.outer(missed, along)
    new += J
    with np.errstate(over="ignore", invalid="ignore"):
        both = np.outer(J.T @ missed, along)
        square = A + both + both.T + (missed @ missed) * np.outer(along, along)
    kept = np.all(np.diag(square) > CANCELLED * np.diag(A)) and np.isfinite(square).all()
    return new, square if kept else new.T @ new


def _cost(k: Unknowns, r: Floats, u: Floats) -> float:
    """Return minus the logarithm of the posterior [nats]; infinite after a step that overflows."""
    with np.errstate(over="ignore"):
        return 0.5 * float(r @ r) + 0.5 * float(np.sum(((u - k.prior) / k.std) ** 2))


def _step(k: Unknowns, u: Floats, pull: Floats, square: Floats, damping: float) -> tuple[Floats, float]:
    """Return the damped step, kept within the bounds, and the fall of the cost that it predicts [nats].

    ``pull`` is J' r, ``square`` J' J.
    """
    A = square + np.diag(k.std**-2.0)
    g = pull + (u - k.prior) / k.std**2
    D = np.diag(A) * damping
    free = ~(((u <= k.low) & (g > 0.0)) | ((u >= k.high) & (g < 0.0)))
    step = np.zeros(u.size)
    for _ in range(u.size):
        if not free.any():
            break
        rest = g[free] + A[np.ix_(free, ~free)] @ step[~free]
        step[free] = -np.linalg.solve(A[np.ix_(free, free)] + np.diag(D[free]), rest)
        beyond = free & ((u + step < k.low) | (u + step > k.high))
        if not beyond.any():
            break
        step[beyond] = np.clip(u + step, k.low, k.high)[beyond] - u[beyond]
        free &= ~beyond
    return step, -float(g @ step) - 0.5 * float(step @ A @ step)


def covariance(problem: Problem, optimum: Optimum) -> Floats:
    """Return the covariance (p, p) of the coordinates, wider where the model leaves more than noise."""
    k = problem.unknowns
    A = optimum.jacobian.T @ optimum.jacobian
    misfit = float(np.sum(optimum.residual**2)) / max(int(np.count_nonzero(problem.counted)), 1)
    A = A / max(misfit, 1.0) + np.diag(k.std**-2.0)
    return np.asarray(np.linalg.inv(A), dtype=np.float64)
