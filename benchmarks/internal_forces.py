"""Sharing the internal forces of five fingers: non-negative least squares against general solvers of QPs.

SLSQP comes with scipy; the others take part where they are installed (``pip install quadprog daqp proxsuite
osqp``). All solve the same problem, and the answers are compared before they are timed. Ours is timed with
the names of the fingers going in and coming out, theirs is the solver alone.
"""

import importlib
import importlib.util
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, minimize
from scipy.sparse import csc_matrix

from benchmarks._timing import compared
from vegrip.grip.allocation.internal_forces import ContactPlace, InternalForces, grasp_map
from vegrip.types import Floats

UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
CONTACTS = {
    "thumb": ContactPlace((0.0, 0.0, -0.01), UP),
    "index": ContactPlace((-0.033, 0.0, 0.01), DOWN),
    "middle": ContactPlace((-0.011, 0.004, 0.01), DOWN),
    "ring": ContactPlace((0.011, 0.003, 0.01), DOWN),
    "little": ContactPlace((0.033, -0.004, 0.01), DOWN),
}
NEEDS = np.array([2.0, 0.6, 1.4, 0.9, 0.7])  # [N]


def run() -> dict[str, dict[str, float]]:
    grasp = InternalForces(CONTACTS)

    def ours() -> Floats:
        grasp.shared({})  # or the last answer would be given again
        return np.array(list(grasp.shared(dict(zip(CONTACTS, NEEDS, strict=True))).values()))

    results = {}
    for name, theirs in solvers():
        assert np.allclose(theirs(), ours(), rtol=1e-4), name
        results[f"internal_forces_vs_{name}"] = compared(ours, theirs)
    return results


def solvers() -> Iterator[tuple[str, Callable[[], Floats]]]:
    """Yield minimisers of ``sum d^2 / m`` subject to ``A (m + d) = 0``, ``d >= 0``."""
    whole = grasp_map(tuple(CONTACTS.values()))
    left, size, _ = np.linalg.svd(whole)
    rank = int((size > 1e-9).sum())
    A = (left.T @ whole)[:rank]  # equations that do not depend on each other, which some solvers insist on
    n, H = len(NEEDS), np.diag(1.0 / NEEDS)
    G, b = np.vstack([A, np.eye(n)]), np.concatenate([np.zeros(rank), NEEDS])

    def slsqp() -> Floats:
        search: Any = minimize  # its types ask for one dimension, which arithmetic on arrays does not keep
        found = search(
            lambda N: float(np.sum((N - NEEDS) ** 2 / NEEDS)),
            2.0 * NEEDS,
            jac=lambda N: 2.0 * (N - NEEDS) / NEEDS,
            method="SLSQP",
            bounds=Bounds(NEEDS, np.inf),
            constraints=LinearConstraint(A, 0.0, 0.0),
            options={"ftol": 1e-12, "maxiter": 200},
        )
        return np.asarray(found.x)

    def quadprog() -> Floats:
        return np.asarray(importlib.import_module("quadprog").solve_qp(H, np.ones(n), G.T, b, rank)[0])

    def daqp() -> Floats:
        upper, kinds = np.concatenate([np.full(n, 1e30), np.zeros(rank)]), np.repeat([0, 5], [n, rank])
        lower = np.concatenate([NEEDS, np.zeros(rank)])
        solve = importlib.import_module("daqp").solve
        return np.asarray(solve(H, -np.ones(n), A.copy(), upper, lower, kinds.astype(np.int32))[0])

    def proxsuite() -> Floats:
        qp = importlib.import_module("proxsuite").proxqp.dense.QP(n, rank, n)
        qp.settings.eps_abs = 1e-9
        qp.init(H, -np.ones(n), A, np.zeros(rank), np.eye(n), NEEDS, np.full(n, 1e20))
        qp.solve()
        return np.asarray(qp.results.x)

    def osqp() -> Floats:
        solver = importlib.import_module("osqp").OSQP()
        upper = np.concatenate([np.zeros(rank), np.full(n, np.inf)])
        accuracy = {"eps_abs": 1e-8, "eps_rel": 1e-8, "max_iter": 100000}
        solver.setup(csc_matrix(H), -np.ones(n), csc_matrix(G), b, upper, verbose=False, **accuracy)
        return np.asarray(solver.solve().x)

    yield "slsqp", slsqp
    for solver in (quadprog, daqp, proxsuite, osqp):
        if importlib.util.find_spec(solver.__name__) is not None:
            yield solver.__name__, solver
