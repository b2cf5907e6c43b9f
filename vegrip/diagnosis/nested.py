"""Nested refits: the model with one effect more, fitted to the same rows and noise, and its evidence.

    ``ln Z = -cost - sum ln(prior std) - ln |A| / 2``,   ``A = J' J + diag(prior std^-2)``

the Laplace approximation of the probability of the recording under the model, in which every parameter pays
for the width of its prior [MacKay1992]_.
"""

import math
from dataclasses import dataclass

import numpy as np

from vegrip.diagnosis.catalogue import Candidate
from vegrip.diagnosis.screen import Hint, with_candidates
from vegrip.fit.channels import rms
from vegrip.fit.problem import Problem
from vegrip.fit.smoother import Floats
from vegrip.fit.solve import Optimum, refine
from vegrip.parameters import coordinate

EVALUATIONS = 14
STARTS = (1.0, 0.3)  # of the multiple that the screen asks for, when it leads nowhere
HELD_OUT = 0.95  # of what an episode knows; the rest stays, for values that only this episode tells
AWAY = 1e-3  # of the range, from a bound at which derivatives vanish


@dataclass(frozen=True, eq=False)
class Fitted:
    """A model at its best, with what is needed to judge it.

    Attributes:
        problem: the model and the recording.
        optimum: where it is best.
        evidence: ln Z [nats].
        heldout: (episodes,) score of each episode under a fit without it [nats].
        error: rms of standardised residuals over all channels.

    """

    problem: Problem
    optimum: Optimum
    evidence: float
    heldout: Floats
    error: float

    @property
    def std(self) -> Floats:
        """Standard errors of the coordinates."""
        J, s = self.optimum.jacobian, self.problem.unknowns.std
        return np.sqrt(np.maximum(np.diag(np.linalg.inv(J.T @ J + np.diag(s**-2.0))), 0.0))

    def value(self, symbol: str) -> float:
        """Return the fitted value of a parameter."""
        k = self.problem.unknowns
        raw = float(self.optimum.u[k.names.index(symbol)])
        return math.exp(raw) if k.log[k.names.index(symbol)] else raw


def judged(problem: Problem, optimum: Optimum, groups: Floats) -> Fitted:
    """Return an optimum with evidence and held-out scores; ``groups`` (rows,) numbers what is held out."""
    s = problem.unknowns.std
    J, r = optimum.jacobian, optimum.residual
    prior = np.diag(s**-2.0)
    A = J.T @ J + prior
    evidence = -optimum.cost - float(np.sum(np.log(s))) - 0.5 * float(np.linalg.slogdet(A)[1])
    scores = []
    for number in np.unique(groups):
        rows = groups == number
        J_b, r_b = J[rows], r[rows]
        step = np.linalg.solve(A - HELD_OUT * J_b.T @ J_b, J_b.T @ r_b)
        scores.append(-0.5 * float(np.sum((r_b + J_b @ step) ** 2)))
    z = problem.standardised(problem.raw(problem.table(optimum.u)))
    return Fitted(problem, optimum, evidence, np.array(scores), rms(z[problem.counted]))


def extended(base: Fitted, hint: Hint, groups: Floats) -> Fitted:
    """Refit with a candidate, from where the screen points."""
    best: Optimum | None = None
    problem = _problem(base, hint.candidate)
    for factor in STARTS:
        start = _start(problem, base, hint, factor)
        found = refine(problem, start, EVALUATIONS)
        if best is None or found.cost < best.cost:
            best = found
        if best.cost < base.optimum.cost - 0.5 * hint.gain:
            break
    assert best is not None  # noqa: S101
    return judged(problem, best, groups)


def _problem(base: Fitted, candidate: Candidate) -> Problem:
    model = with_candidates(base.problem.model, [candidate])
    symbols = [s for s in model.parameters if s in base.problem.symbols]
    added = [p.symbol for p in candidate.effect.parameters]
    ordered = tuple(s for s in model.parameters if s in symbols or s in added)
    return Problem(model, base.problem.measured, zeros=base.problem.zeros, symbols=ordered, like=base.problem)


def _start(problem: Problem, base: Fitted, hint: Hint, factor: float) -> Floats:
    """Return the base optimum beside the trial, its amount scaled as the screen asks, within reason."""
    k, known = problem.unknowns, base.problem.unknowns
    u = k.start.copy()
    for j, name in enumerate(k.names):
        if name in known.names:
            u[j] = base.optimum.u[known.names.index(name)]
    multiple = factor * math.copysign(min(max(abs(hint.multiple), 0.02), 30.0), hint.multiple)
    for p in hint.candidate.effect.parameters:
        value = hint.trial[p.symbol]
        if p.null is not None:
            value = p.null + multiple * (value - p.null)
            inside = AWAY * min(p.high - p.low, 2.0 * p.std)
            value = min(max(value, p.low + inside), p.high - inside)
        u[k.names.index(p.symbol)] = coordinate(p, min(max(value, p.low), p.high))
    return u
