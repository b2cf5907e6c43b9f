"""The contestants: models that a recording does not distinguish, and how far an experiment puts them apart.

Where a recording does not show an effect at all, its fitted amount is nothing, as if it
were absent; it then stands in at its declared size, and that is said.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.special import ndtr

from vegrip.effects import effect
from vegrip.errors import UsageError
from vegrip.identification.diagnosis.candidate_fit import (
    EVALUATIONS,
    evaluate_candidate,
    extend_problem,
    held_out_groups,
)
from vegrip.identification.diagnosis.score_tests import candidate_of, candidates, screen_candidates
from vegrip.identification.diagnosis.thresholds import INDISTINGUISHABLE_NATS, MIN_GAIN_NATS
from vegrip.identification.fit.noise import noise_of
from vegrip.identification.fit.preprocess import LOADS_AT_SLIP, Measured, preprocess
from vegrip.identification.fit.problem import Problem
from vegrip.identification.fit.result import Fit, fit_of
from vegrip.identification.fit.solve import refine_optimum
from vegrip.identification.simulate import DEFAULT_NOISE, Protocol, simulate
from vegrip.model import ContactModel
from vegrip.types import Floats

NO_EFFECT = "nothing"
"""Name of the model as it was given, without a further effect."""


@dataclass(frozen=True, eq=False)
class Hypotheses:
    """The models that an experiment is to distinguish."""

    models: Mapping[str, ContactModel]  # by the name of the effect that each has
    assumed: tuple[str, ...]  # names whose size is the declared one, because the recording does not show them
    sensors: Mapping[str, float]  # std of the noise of the channels that are measured, SI
    rate: float  # of the samples [Hz]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.models)

    @property
    def has_tangential_load(self) -> bool:
        return "tangential_force" in self.sensors


def hypotheses_of(
    start: Fit, names: Sequence[str], report: Callable[[str], None] = lambda _: None
) -> Hypotheses:
    """Fit each of ``names`` (effects, or "nothing") on top of ``start``.

    Raises:
        ModelError: there is no such effect.
        UsageError: fewer than two names, one that the model has, or one that the recording cannot show.

    """
    wanted = list(dict.fromkeys(names))
    if len(wanted) == 1 and wanted != [NO_EFFECT]:
        wanted.append(NO_EFFECT)
    if len(wanted) < 2:
        raise UsageError("an experiment distinguishes candidates; name two effects, or one to detect it")
    problem = start.problem
    for name in wanted:
        if name != NO_EFFECT and effect(name).name in {one.name for one in problem.model.effects}:
            raise UsageError(f"the model has {name} already; it is no candidate any more")
    _, hidden = candidates(problem.model, problem.measured)
    groups = held_out_groups(problem)
    base = evaluate_candidate(problem, start.optimum, groups)
    models: dict[str, ContactModel] = {}
    assumed = []
    for name in wanted:
        report(f"fits {name}")
        if name == NO_EFFECT:
            models[name] = start.model
            continue
        if name in hidden and not _is_reachable(name, problem.measured):
            raise UsageError(f"no experiment with these sensors shows {name}: {hidden[name]}")
        found = None
        seen = [candidate_of(effect(name), problem.model, problem.measured)] if name not in hidden else []
        if hints := screen_candidates(problem, start.optimum, seen):
            found = extend_problem(base, hints[0], groups)
        if found is not None and found.evidence - base.evidence > MIN_GAIN_NATS:
            models[name] = fit_of(found.problem, found.optimum).model
        else:
            models[name] = start.model.with_effect(effect(name))
            assumed.append(name)
    return Hypotheses(models, tuple(assumed), sensors_of(problem.measured), rate_of(problem.measured))


def _is_reachable(name: str, measured: Measured) -> bool:
    loaded = bool(LOADS_AT_SLIP & set(measured.recording.columns))
    return loaded and bool({"tangential_force", "torque_z"} & set(effect(name).channels))


def sensors_of(measured: Measured) -> dict[str, float]:
    """Return the noise of the channels that the recording has, as the fit took it."""
    noise, columns = measured.noise, set(measured.recording.columns)
    sensors = {"normal_force": noise.normal_force, "displacement": noise.displacement}
    if LOADS_AT_SLIP & columns:
        usual = {name: DEFAULT_NOISE[name] for name in ("tangential_force", "torque_z")}
        known = {name: getattr(noise, name) for name in usual}
        sensors |= {name: known[name] if known[name] > 0.0 else usual[name] for name in usual}
        sensors["slip_speed"] = DEFAULT_NOISE["slip_speed"]
    if "contact_radius" in columns and noise.contact_radius > 0.0:
        sensors["contact_radius"] = noise.contact_radius
    return sensors


def rate_of(measured: Measured) -> float:
    """Return the usual rate of the samples [Hz]."""
    return float(1.0 / np.median(np.diff(measured.recording.t)))


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
        return min(self.pairs, key=lambda pair: self.pairs[pair])


def chance_to_decide(nats: float) -> float:
    return float(ndtr((nats - INDISTINGUISHABLE_NATS) / np.sqrt(2.0 * nats))) if nats > 0.0 else 0.0


def expected_separation(contest: Hypotheses, protocol: Protocol, *, refit: bool = False) -> Separation:
    """Return how far ``protocol`` puts the contestants apart: T-optimality [AtkinsonFedorov1975]_.

    With data of model i, and model j fitted to them, the costs (half the squared whitened residuals and
    priors) differ on average by what is left of the difference when the other has imitated as much of it as
    it can,

        ``T_ij = c_j - c_i``  [nats],
        ``c_j = 1/2 min || W (y_i - y_j) - J_j d ||^2 + || S_j^-1 (u_j + d - p_j) ||^2``

    W whitening the noise, J_j the derivatives of the model by all that it may refit, p_j and S_j its priors;
    c_i is that of the right model, with no difference. In one experiment the costs' difference scatters by
    ``sqrt(2 T)`` about that.

    The model without an effect is no truth here: the one with it imitates it, at an amount of nothing.

    Linear in what each may refit, as above, or with ``refit`` by refits, which costs ten times as much: rates
    and lengths that are far off bend the linear answer by a factor of two, now and then of ten.
    """
    pairs = {}
    for one, other in combinations(contest.names, 2):
        truth = Problem(contest.models[one], _recorded(contest, one, protocol, 0))
        rival = Problem(contest.models[other], truth.measured, like=truth)
        difference = _at_start(rival) - _at_start(truth)
        kind = _Refit if refit else _Linear
        right, wrong = kind(truth), kind(rival)
        none = np.zeros_like(difference)
        if one != NO_EFFECT:
            pairs[one, other] = max(wrong.cost(difference) - right.cost(none), 0.0)
        if other != NO_EFFECT:
            pairs[other, one] = max(right.cost(-difference) - wrong.cost(none), 0.0)
    return Separation(pairs)


def measure_separation(
    contest: Hypotheses, protocol: Protocol, seed: int = 0
) -> dict[tuple[str, str], float]:
    """Simulate the experiment and refit all: by how many nats each truth beats each of its rivals."""
    out = {}
    for one in [name for name in contest.names if name != NO_EFFECT]:
        truth = Problem(contest.models[one], _recorded(contest, one, protocol, seed))
        right = refine_optimum(truth, truth.unknowns.start, EVALUATIONS).cost
        for other in contest.names:
            if other != one:
                rival = Problem(contest.models[other], truth.measured, like=truth)
                out[one, other] = refine_optimum(rival, rival.unknowns.start, 2 * EVALUATIONS).cost - right
    return out


def _recorded(contest: Hypotheses, name: str, protocol: Protocol, seed: int) -> Measured:
    made = simulate(contest.models[name], protocol, sensors=contest.sensors, rate=contest.rate, seed=seed)
    return preprocess(made, noise_of(made))


def _at_start(problem: Problem) -> Floats:
    return problem.residual(problem.unknowns.start)


class _Linear:
    def __init__(self, problem: Problem) -> None:
        k = problem.unknowns
        J = problem.jacobian(k.start)
        self._away = (k.start - k.prior) / k.std
        self._basis, _ = np.linalg.qr(np.vstack([J, np.diag(1.0 / k.std)]))

    def cost(self, change: Floats) -> float:
        y = np.concatenate([change, self._away])
        taken = self._basis.T @ y
        return 0.5 * float(y @ y - taken @ taken)


class _Refit:
    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._at_start = _at_start(problem)

    def cost(self, change: Floats) -> float:
        changed = _Changed(self._problem, change - self._at_start)
        return refine_optimum(changed, self._problem.unknowns.start, 2 * EVALUATIONS).cost


class _Changed(Problem):
    """A problem with other data: a change is added to its residual."""

    def __init__(self, problem: Problem, change: Floats) -> None:
        self.__dict__.update(problem.__dict__)
        self._problem, self._change = problem, change

    def residual(self, u: Floats) -> Floats:
        return super().residual(u) + self._change

    def jacobian(
        self, u: Floats, residual: Floats | None = None, known: Mapping[str, Floats] | None = None
    ) -> Floats:
        unchanged = None if residual is None else residual - self._change
        return self._problem.jacobian(u, unchanged, known)
