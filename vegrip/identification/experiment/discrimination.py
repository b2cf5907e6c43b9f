"""How far apart an experiment puts its contestants: T-optimality [AtkinsonFedorov1975]_.

With data of model i, and model j fitted to them, the costs (half the squared whitened residuals and priors)
differ on average by what is left of the difference when the other has imitated as much of it as it can,

    ``T_ij = c_j - c_i``  [nats],
    ``c_j = 1/2 min || W (y_i - y_j) - J_j d ||^2 + || S_j^-1 (u_j + d - p_j) ||^2``

W whitening the noise, J_j the derivatives of the model by all that it may refit, p_j and S_j its priors; c_i
is that of the right model, with no difference. In one experiment the costs' difference scatters by
``sqrt(2 T)`` about that.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.special import ndtr

from vegrip.identification.diagnosis.candidate_fit import EVALUATIONS
from vegrip.identification.diagnosis.thresholds import INDISTINGUISHABLE_NATS
from vegrip.identification.experiment.hypotheses import Hypotheses
from vegrip.identification.fit.noise import noise_of
from vegrip.identification.fit.preprocess import Measured, preprocess
from vegrip.identification.fit.problem import Problem
from vegrip.identification.fit.solve import refine_optimum
from vegrip.identification.simulate import Protocol, simulate
from vegrip.types import Floats


@dataclass(frozen=True)
class Separation:
    """Expected difference of the costs, by (truth, rival) [nats]."""

    pairs: dict[tuple[str, str], float]

    @property
    def nats(self) -> float:
        """The smallest of them: the separation under any truth."""
        return min(self.pairs.values())

    @property
    def hardest(self) -> tuple[str, str]:
        """Truth and rival that it belongs to."""
        return min(self.pairs, key=lambda pair: self.pairs[pair])


def chance_to_decide(nats: float) -> float:
    """Return the probability that one experiment tells a pair apart by more than the limit of ambiguity."""
    return float(ndtr((nats - INDISTINGUISHABLE_NATS) / np.sqrt(2.0 * nats))) if nats > 0.0 else 0.0


def expected_separation(
    contest: Hypotheses, protocol: Protocol, *, refit: bool = False, seed: int = 0
) -> Separation:
    """Return how far ``protocol`` puts the contestants apart.

    Linear in what each may refit, as above, or with ``refit`` by refits, which costs ten times as much: rates
    and lengths that are far off bend the linear answer by a factor of two, now and then of ten.
    """
    pairs = {}
    for one, other in combinations(contest.names, 2):
        truth = _problem(contest, one, _recorded(contest, one, protocol, seed))
        rival = _problem(contest, other, truth.measured, truth)
        difference = _at_start(rival) - _at_start(truth)
        kind = _Refit if refit else _Linear
        right, wrong = kind(truth), kind(rival)
        none = np.zeros_like(difference)
        pairs[one, other] = max(wrong.cost(difference) - right.cost(none), 0.0)
        pairs[other, one] = max(right.cost(-difference) - wrong.cost(none), 0.0)
    return Separation(pairs)


def measure_separation(
    contest: Hypotheses, protocol: Protocol, seed: int = 0
) -> dict[tuple[str, str], float]:
    """Simulate the experiment and refit all: by how many nats each truth beats each of its rivals."""
    out = {}
    for one in contest.names:
        truth = _problem(contest, one, _recorded(contest, one, protocol, seed))
        right = refine_optimum(truth, truth.unknowns.start, EVALUATIONS).cost
        for other in contest.names:
            if other != one:
                rival = _problem(contest, other, truth.measured, truth)
                out[one, other] = refine_optimum(rival, rival.unknowns.start, 2 * EVALUATIONS).cost - right
    return out


def _recorded(contest: Hypotheses, name: str, protocol: Protocol, seed: int) -> Measured:
    made = simulate(contest.models[name], protocol, sensors=contest.sensors, rate=contest.rate, seed=seed)
    return preprocess(made, noise_of(made))


def _problem(contest: Hypotheses, name: str, measured: Measured, like: Problem | None = None) -> Problem:
    return Problem(contest.models[name], measured, like=like)


def _at_start(problem: Problem) -> Floats:
    return problem.residual(problem.unknowns.start)


class _Linear:
    """What a model leaves of a change of the data, linear about its start."""

    def __init__(self, problem: Problem) -> None:
        k = problem.unknowns
        J = problem.jacobian(k.start)
        self._away = (k.start - k.prior) / k.std
        self._basis, _ = np.linalg.qr(np.vstack([J, np.diag(1.0 / k.std)]))

    def cost(self, change: Floats) -> float:
        """Return half the squared length of residuals and priors after the refit."""
        y = np.concatenate([change, self._away])
        taken = self._basis.T @ y
        return 0.5 * float(y @ y - taken @ taken)


class _Refit:
    """The same, by a refit within the bounds."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._at_start = _at_start(problem)

    def cost(self, change: Floats) -> float:
        """Return half the squared length of residuals and priors after the refit."""
        changed = _Changed(self._problem, change - self._at_start)
        return refine_optimum(changed, self._problem.unknowns.start, 2 * EVALUATIONS).cost


class _Changed:
    """A problem with other data: a change is added to its residual."""

    def __init__(self, problem: Problem, change: Floats) -> None:
        self.unknowns = problem.unknowns
        self._problem, self._change = problem, change

    def residual(self, u: Floats) -> Floats:
        """Return the whitened residual at ``u``."""
        return self._problem.residual(u) + self._change

    def jacobian(
        self, u: Floats, residual: Floats | None = None, known: Mapping[str, Floats] | None = None
    ) -> Floats:
        """Return its derivative, which the change leaves as it is."""
        unchanged = None if residual is None else residual - self._change
        return self._problem.jacobian(u, unchanged, known)
