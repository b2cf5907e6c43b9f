"""What a draft is measured against: regressions of what the paper's model leaves, over what is known.

None of them has a hidden state of its own, so each is given the memories that a recording shows: the deepest
depth, the time in contact and recorded, the way rubbed and a fading depth.
"""

import math
from collections.abc import Callable
from typing import Final

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

from vegrip.identification.fit.problem import AT, Problem
from vegrip.types import Floats

KNOTS = 15  # of the plain curve
RIDGE = 1e-3
FADES_S = 2.0  # [s] of the fading depth
DEGREE_TERMS = 2  # of the sparse regression: products of so many
DROPPED = 0.02  # of the largest force: terms that do less are dropped
ROUNDS = 6
GP_ROWS = 500
Regression = Callable[[Floats, Floats, Floats], Callable[[Floats], Floats]]
"""Of inputs (n, m), what is left (n,) and episodes (n,): what foretells it."""


def inputs(problem: Problem, table: Floats) -> Floats:
    """Return what a regression may know (n, m), each over a size that is the same in every recording."""
    t, depth = problem.measured.recording.t, problem.measured.motion.displacement / problem.depth
    is_touching = table[:, AT["normal_force"]] > 0.0
    speed = np.gradient(depth, t)
    speed[np.r_[False, np.diff(problem.episodes) != 0] | np.r_[np.diff(problem.episodes) != 0, False]] = 0.0
    dt = np.diff(t, prepend=t[0])
    dt[problem.measured.first > 0.5] = 0.0
    touched, fading, way = (np.zeros(t.size) for _ in range(3))
    for i in range(1, t.size):
        is_new = problem.measured.first[i] > 0.5
        touched[i] = touched[i - 1] + dt[i] if is_touching[i] and not is_new else 0.0
        fading[i] = 0.0 if is_new else fading[i - 1]
        fading[i] += (max(depth[i], 0.0) - fading[i]) * -math.expm1(-dt[i] / FADES_S)
        way[i] = way[i - 1] + abs(speed[i]) * dt[i] * is_touching[i]
    force = table[:, AT["normal_force"]]
    deepest = np.maximum.accumulate(np.maximum(depth, 0.0))
    known = (
        np.maximum(depth, 0.0), np.arcsinh(speed), force, deepest, np.log1p(touched), fading, way / 30.0,
        t / 200.0,
    )  # fmt: skip
    return np.column_stack(known)


def plain_curve(X: Floats, left: Floats, episodes: Floats) -> Callable[[Floats], Floats]:
    """Return the curve over the one input that foretells episodes best which were held out."""

    def tents(values: Floats, knots: Floats) -> Floats:
        held = np.clip(values, knots[0], knots[-1])
        return np.column_stack([np.interp(held, knots, unit) for unit in np.eye(knots.size)])

    def solve(B: Floats, y: Floats) -> Floats:
        ridge = RIDGE * np.trace(B.T @ B) / B.shape[1]
        return np.linalg.solve(B.T @ B + ridge * np.eye(B.shape[1]), B.T @ y)

    best: tuple[float, int, Floats, Floats] | None = None
    for j in range(X.shape[1]):
        knots = np.unique(np.quantile(X[:, j], np.linspace(0.0, 1.0, KNOTS)))
        if knots.size < 2:
            continue
        B = tents(X[:, j], knots)
        missed = 0.0
        for number in np.unique(episodes):
            out = episodes == number
            missed += float(np.sum((left[out] - B[out] @ solve(B[~out], left[~out])) ** 2))
        if best is None or missed < best[0]:
            best = (missed, j, knots, solve(B, left))
    assert best is not None  # noqa: S101
    _, j, knots, curve = best
    return lambda now: tents(now[:, j], knots) @ curve


def sparse_regression(X: Floats, left: Floats, _episodes: Floats) -> Callable[[Floats], Floats]:
    """Return a sparse sum of products of the inputs, by sequentially thresholded least squares (SINDy)."""
    size = np.maximum(np.max(np.abs(X), axis=0), 1e-12)

    def library(values: Floats) -> Floats:
        q = np.clip(values / size, -1.0, 1.0)
        pairs = [q[:, i] * q[:, j] for i in range(q.shape[1]) for j in range(i, q.shape[1])]
        return np.column_stack([np.ones(q.shape[0]), q, np.sign(q[:, 1]) * q[:, 2], *pairs])

    terms = library(X)
    is_kept = np.ones(terms.shape[1], dtype=bool)
    c = np.zeros(terms.shape[1])
    for _ in range(ROUNDS):
        A = terms[:, is_kept]
        ridge = RIDGE * np.eye(A.shape[1])
        c[:] = 0.0
        c[is_kept] = np.linalg.solve(A.T @ A + ridge, A.T @ left)
        strong = np.abs(c) > DROPPED * np.max(np.abs(X[:, 2]))
        if np.array_equal(strong, is_kept) or not strong.any():
            break
        is_kept = strong
    return lambda now: library(now) @ c


def gaussian_process(X: Floats, left: Floats, _episodes: Floats) -> Callable[[Floats], Floats]:
    """Return a Gaussian process with a length of its own for each input, those of the greatest evidence."""
    rng = np.random.default_rng(0)
    rows = rng.permutation(left.size)[:GP_ROWS]
    middle, largest = np.mean(X, axis=0), np.max(np.abs(X), axis=0)
    scale = np.maximum(np.std(X, axis=0), 1e-6 * largest + 1e-12)  # what hardly varies is rounding
    Z, y = (X[rows] - middle) / scale, left[rows]
    var = max(float(np.var(y)), 1e-12)

    def kernel(A: Floats, B: Floats, lengths: Floats) -> Floats:
        a, b = A / lengths, B / lengths
        squares = np.sum(a * a, axis=1)[:, None] + np.sum(b * b, axis=1) - 2.0 * a @ b.T
        near: Floats = np.exp(-0.5 * np.maximum(squares, 0.0))
        return near

    def cost(h: Floats) -> float:
        K = math.exp(h[-2]) * kernel(Z, Z, np.exp(h[:-2])) + (math.exp(h[-1]) + 1e-6) * np.eye(y.size)
        try:
            factor = cho_factor(K, lower=True)
        except np.linalg.LinAlgError:
            return 1e12
        half = float(np.sum(np.log(np.diag(factor[0]))))
        return half + 0.5 * float(y @ cho_solve(factor, y)) / var + 0.5 * float(h @ h) / 9.0

    start = np.r_[np.full(X.shape[1], math.log(2.0)), 0.0, math.log(0.2)]
    found = minimize(
        cost, start, method="L-BFGS-B", bounds=[(-8.0, 8.0)] * start.size, options={"maxiter": 12}
    )
    h = np.asarray(found.x)
    K = math.exp(h[-2]) * kernel(Z, Z, np.exp(h[:-2])) + (math.exp(h[-1]) + 1e-6) * np.eye(y.size)
    weights = cho_solve(cho_factor(K, lower=True), y)
    return lambda now: math.exp(h[-2]) * kernel((now - middle) / scale, Z, np.exp(h[:-2])) @ weights


def regressions(problem: Problem, table: Floats) -> dict[str, Callable[[Problem, Floats], Floats]]:
    """Return by name what each regression of what a model leaves adds to its force (n,) [N] in any recording.

    ``table``: what the model predicts of the recording of ``problem``, to which the regressions are fitted.
    """
    left = problem.measured.force - table[:, AT["normal_force"]]
    touching = (table[:, AT["elastic_force"]] > 0.0) & problem.used
    known, episodes = inputs(problem, table)[touching], problem.episodes[touching].astype(np.float64)
    if np.ptp(episodes) == 0.0:  # of a single one its tenths are held out
        episodes = np.floor(np.linspace(0.0, 10.0, episodes.size, endpoint=False))

    def fitted(regression: Regression) -> Callable[[Problem, Floats], Floats]:
        more = regression(known, left[touching], episodes)
        return lambda there, told: np.where(
            told[:, AT["elastic_force"]] > 0.0, more(inputs(there, told)), 0.0
        )

    return {name: fitted(regression) for name, regression in BASELINES.items()}


BASELINES: Final[dict[str, Regression]] = {
    "curve": plain_curve,
    "sparse": sparse_regression,
    "gp": gaussian_process,
}
