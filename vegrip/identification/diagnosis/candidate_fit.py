"""Nested refits: the model with one effect more, fitted to the same rows and noise, and its evidence.

    ``ln Z = -cost - sum ln(prior std) - ln |A| / 2``,   ``A = J' J + diag(prior std^-2)``

the Laplace approximation of the probability of the recording under the model, in which every parameter pays
for the width of its prior [MacKay1992]_.
"""

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vegrip.identification.compare.where import features_of
from vegrip.identification.diagnosis.score_tests import Candidate, Hint, carrier, with_candidates
from vegrip.identification.diagnosis.thresholds import CONTENDER_SHARE
from vegrip.identification.fit.preprocess import Mask
from vegrip.identification.fit.problem import Problem
from vegrip.identification.fit.result import rms
from vegrip.identification.fit.solve import Optimum, refine_optimum, scaled
from vegrip.identification.fit.whitening import has_play
from vegrip.model import BASE, ContactModel
from vegrip.model.native import kernel_mode
from vegrip.parameters import coordinate
from vegrip.types import Floats

HELD_OUT = 0.95  # of what an episode knows; the rest stays, for values that only this episode determines
# error / noise above which the fits without an episode are made and not foretold, if they are
REFIT_ERROR = 1.5
MAX_FOLDS = 12
FAR_FOLDS = 6  # up to which a fit without one is far enough for more than
NEAR_STEPS = 2  # with the derivatives of the whole fit; they end within 1 % of fits to the end
FAR_STEPS = 15
EVALUATIONS = 20
START_FACTORS = (1.0, 0.3)  # of the multiple that the screen asks for, when it leads nowhere
NEXT_TO_NOTHING = 0.01
CANDIDATE_PRECISION_NATS = 0.02  # [nats] to which a candidate's best is sought, or
SLOPPY = 1e-4  # of what the screen expects of it, before it is known to contend, or of what is left
FAR_NATS = 100.0  # [nats] from the base, beyond which the last steps are taken with derivatives made anew
ASTRAY = 0.05  # [x_ref] of the zero of the displacement, from which the base is far from what there is
NO_DERIVATIVES = np.zeros((0, 0))
BOUND_DISTANCE = 1e-3  # of the range, from a bound at which derivatives vanish
MANY_ROWS = 20_000  # of a recording, from which on a model of its own pays
DEPTH_REGIMES = 4
CONTACT_TIMES_S = (0.3, 1.5)  # [s] in contact


class Weighted(Problem):
    """A problem whose residuals count with positive ``weights`` (rows,)."""

    def __init__(self, problem: Problem, weights: Floats) -> None:
        self.__dict__.update(problem.__dict__)
        self._weights = weights

    def white(self, raw: tuple[Floats, Floats, Floats]) -> Floats:
        return super().white(raw) * self._weights


class Nearby(Weighted):
    """The same near an ``optimum``, with the derivatives there: a step costs one run of the model."""

    def __init__(self, problem: Problem, weights: Floats, optimum: Optimum) -> None:
        super().__init__(problem, weights)
        self._jacobian = optimum.jacobian * weights[:, None]

    def jacobian(self, *_: object) -> Floats:
        return self._jacobian


def scores(problem: Problem, optimum: Optimum, A: Floats, groups: Floats) -> Floats:
    """Return minus half the squares of each group (numbered by ``groups``, (rows,)) under a fit without it.

    ``A``: information of the optimum, priors included. One linear step gives the fit without a group where
    the model is nearly right. Where much is left, or much is foretold to be, the step is wild (it once
    foretold -1e8 nats where a fit gained), so the fits are made.
    """
    numbers = np.unique(groups)
    may_fit = numbers.size <= MAX_FOLDS
    misfit = 2.0 * optimum.cost / max(int(np.count_nonzero(problem.counted)), 1)
    is_far = may_fit and misfit > REFIT_ERROR**2

    def score(rows: Mask) -> float:
        predicted = -math.inf if is_far else _predicted_gain(optimum, A, rows)
        is_wild = -2.0 * predicted > REFIT_ERROR**2 * np.count_nonzero(problem.counted & rows)
        if not (may_fit and is_wild):
            return predicted
        is_near = numbers.size > FAR_FOLDS or optimum.is_given_up
        return _fitted(problem, optimum, rows, NEAR_STEPS if is_near else FAR_STEPS)

    return np.array([score(groups == number) for number in numbers])


def _predicted_gain(optimum: Optimum, A: Floats, rows: Mask) -> float:
    J, r = optimum.jacobian[rows], optimum.residual[rows]
    step = np.linalg.solve(A - HELD_OUT * J.T @ J, HELD_OUT * J.T @ r)
    return -0.5 * float(np.sum((r + J @ step) ** 2))


def _fitted(problem: Problem, optimum: Optimum, rows: Mask, steps: int) -> float:
    weights = np.where(rows, math.sqrt(1.0 - HELD_OUT), 1.0)
    near = max(CANDIDATE_PRECISION_NATS, SLOPPY * optimum.cost)
    found = refine_optimum(Nearby(problem, weights, optimum), optimum.u, steps, near=near)
    return -0.5 * float(np.sum((found.residual[rows] / weights[rows]) ** 2))


@dataclass(frozen=True, eq=False)
class CandidateFit:
    """A model at its best, with what is needed to judge it."""

    problem: Problem  # the model and the recording
    optimum: Optimum  # where it is best
    groups: Floats  # (rows,) number of what is held out with each residual
    evidence: float  # ln Z [nats]
    error: float  # rms of the whitened residuals over all channels; 1 is noise

    @property
    def complete(self) -> Optimum:
        """The optimum with its derivatives, taken anew where they were left out."""
        best = self.optimum
        if best.jacobian.size:
            return best
        return dataclasses.replace(best, jacobian=self.problem.jacobian(best.u, best.residual))

    @cached_property
    def information(self) -> Floats:
        """Information of the unknowns, priors included (p, p)."""
        return _information(self.problem, self.complete)

    def without_derivatives(self) -> "CandidateFit":
        """Return it without what takes most room of a fit that is kept only to be compared."""
        lean = dataclasses.replace(self, optimum=dataclasses.replace(self.optimum, jacobian=NO_DERIVATIVES))
        lean.__dict__.update({"information": self.information, **vars(self), **vars(lean)})
        return lean

    @cached_property
    def _squares(self) -> Floats:
        return scores(self.problem, self.complete, self.information, self.groups)

    @cached_property
    def heldout(self) -> Floats:
        """Log probability of each episode under a fit without it, but for a constant (episodes,) [nats]."""
        scale = self.problem.log_scale
        scales = [float(np.sum(scale[self.groups == one])) for one in np.unique(self.groups)]
        out: Floats = self._squares - np.array(scales)
        return out

    @property
    def heldout_error(self) -> float:
        """Root mean square of the whitened residuals of the episodes under fits without them."""
        count = max(int(np.count_nonzero(self.problem.counted)), 1)
        return math.sqrt(-2.0 * float(self._squares.sum()) / count)

    def whitened(self, other: "CandidateFit") -> Floats:
        """Return the residual of another model of the same rows in units of this one's noise."""
        if other.problem.whitener is self.problem.whitener:
            return other.optimum.residual
        return self.problem.white(other.problem.raw(other.problem.table(other.optimum.u)))

    def value(self, symbol: str) -> float:
        """Return the fitted value of a parameter."""
        k = self.problem.unknowns
        raw = float(self.optimum.u[k.names.index(symbol)])
        return math.exp(raw) if k.log[k.names.index(symbol)] else raw


def evaluate_candidate(problem: Problem, optimum: Optimum, groups: Floats) -> CandidateFit:
    """Return an optimum with its evidence; ``groups`` (rows,) numbers what is held out."""
    evidence, error = log_evidence(problem, optimum), rms(optimum.residual[problem.counted])
    return CandidateFit(problem, optimum, groups, evidence, error)


def log_evidence(problem: Problem, optimum: Optimum) -> float:
    """Return ln Z [nats]."""
    noise, priors = float(np.sum(problem.log_scale)), float(np.sum(np.log(problem.unknowns.std)))
    half = 0.5 * float(np.linalg.slogdet(_information(problem, optimum))[1])
    return -optimum.cost - noise - priors - half


def _information(problem: Problem, optimum: Optimum) -> Floats:
    information: Floats = optimum.jacobian.T @ optimum.jacobian + np.diag(problem.unknowns.std**-2.0)
    return information


def extend_problem(base: CandidateFit, hint: Hint, groups: Floats, least: float = math.inf) -> CandidateFit:
    """Return the fit with a candidate; where it is given up far from a cost of ``least``, as it is there."""
    return evaluate_candidate(*extended(base, hint, least), groups)


def extend_below(base: CandidateFit, hint: Hint, groups: Floats, least: float) -> CandidateFit | None:
    """Return the fit with a candidate, to the end; None where its cost stays above ``least``.

    No evidence gains more than the cost falls, since no parameter is known less than by its prior.
    """
    problem, rough = extended(base, hint, least)
    if rough.cost > least and problem.whitener is base.problem.whitener:
        return None
    return evaluate_candidate(problem, finished(base, problem, rough), groups)


def extended(base: CandidateFit, hint: Hint, least: float = math.inf) -> tuple[Problem, Optimum]:
    """Return the problem with a candidate, and where it is best; given up far from a cost of ``least``."""
    problem = _problem(base, hint.candidate)
    if has_play(problem.model):  # what the tip does not follow is another noise, which may say more
        least = base.optimum.cost - CONTENDER_SHARE * (base.optimum.cost - least)
    near = max(CANDIDATE_PRECISION_NATS, SLOPPY * hint.gain)
    known = dict(zip(base.problem.unknowns.names, base.optimum.jacobian.T, strict=True))

    def better(
        best: Optimum | None, start: Floats, evaluations: int = EVALUATIONS, *, is_near: bool = True
    ) -> Optimum:
        below = least if best is None else min(least, best.cost)
        found = refine_optimum(problem, start, evaluations, known if is_near else None, near, below)
        return found if best is None or found.cost < best.cost else best

    best = better(None, _start(problem, base, hint, START_FACTORS[0]))
    for factor in START_FACTORS[1:]:
        if best.cost >= base.optimum.cost - 0.5 * hint.gain:
            best = better(best, _start(problem, base, hint, factor))
    if any(p.null is None for p in hint.candidate.effect.parameters):  # a shape may have a better place
        best = better(best, _start(problem, base, _as_declared(hint), 1.0))
    if _is_astray(base):
        start = _start(problem, base, hint, START_FACTORS[-1])
        best = better(best, _unshifted(problem, start), 2 * EVALUATIONS, is_near=False)
    if best.cost > base.optimum.cost:  # led astray: from next to nothing it cannot end above the base
        best = better(best, _start(problem, base, hint, NEXT_TO_NOTHING), 2 * EVALUATIONS)
    if has_play(problem.model) and best.cost <= least:
        problem.freeze(best.u)
        best = refine_optimum(problem, best.u, EVALUATIONS)
    elif best.cost > least:
        best = dataclasses.replace(best, is_given_up=True)
    return problem, best


def finish_fit(base: CandidateFit, rough: CandidateFit, groups: Floats) -> CandidateFit:
    """Return a candidate with its last steps taken, see :func:`finished`."""
    best = finished(base, rough.problem, rough.optimum)
    return rough if best is rough.optimum else evaluate_candidate(rough.problem, best, groups)


def finished(base: CandidateFit, problem: Problem, rough: Optimum) -> Optimum:
    """Return an optimum that ended far from the base with its last steps taken by derivatives made anew."""
    if rough.cost > base.optimum.cost - FAR_NATS:
        return rough
    return refine_optimum(problem, rough.u, 2 * EVALUATIONS, near=CANDIDATE_PRECISION_NATS)


def _problem(base: CandidateFit, candidate: Candidate) -> Problem:
    """Return the problem with the candidate.

    Beside the plain model it is compiled by itself, once and for all.
    """
    p = base.problem
    model = with_candidates(p.model, [candidate])
    ordered = tuple(
        s
        for s in model.parameters
        if s in p.symbols or s in [one.symbol for one in candidate.effect.parameters if one.std > 0.0]
    )
    is_plain = {one.name for one in p.model.effects} <= set(BASE)
    within = None if is_plain or candidate.effect.expensive else compiled_already(p, model)
    return Problem(model, p.measured, symbols=ordered, like=p, within=within)


def compiled_already(problem: Problem, model: ContactModel) -> ContactModel | None:
    """Return the model that has everything, in which ``model`` runs three times slower, but is there already.

    None where one of its own is compiled in less than that: a second by C, half a minute by numba.
    """
    is_quick = kernel_mode() == "c" and len(problem.measured.recording) > MANY_ROWS
    return None if is_quick else carrier(model, [])


def _is_astray(base: CandidateFit) -> bool:
    at = zip(base.problem.unknowns.names, base.optimum.u, strict=True)
    return any(abs(zero) > ASTRAY for name, zero in at if name.startswith("zero_displacement"))


def _unshifted(problem: Problem, start: Floats) -> Floats:
    """Return the start with both zeros at 0 and forces as large as the measured ones.

    What pulls where nothing should touch yet makes the plain model shift the surface, and nothing leads back.
    """
    zeros = np.array([name.startswith("zero_") for name in problem.unknowns.names])
    return scaled(problem, np.where(zeros, 0.0, start))


def _as_declared(hint: Hint) -> Hint:
    trial = {p.symbol: p.default for p in hint.candidate.effect.parameters}
    return dataclasses.replace(hint, trial=trial, multiple=1.0)


def _start(problem: Problem, base: CandidateFit, hint: Hint, factor: float) -> Floats:
    k, known = problem.unknowns, base.problem.unknowns
    u = k.start.copy()
    for j, name in enumerate(k.names):
        if name in known.names:
            u[j] = base.optimum.u[known.names.index(name)]
    multiple = factor * math.copysign(min(max(abs(hint.multiple), 0.02), 30.0), hint.multiple)
    for p in hint.candidate.effect.parameters:
        if p.symbol not in k.names:
            continue
        value = hint.trial[p.symbol]
        if p.null is not None:
            value = p.null + multiple * (value - p.null)
            inside = BOUND_DISTANCE * min(p.high - p.low, 2.0 * p.std)
            value = min(max(value, p.low + inside), p.high - inside)
        u[k.names.index(p.symbol)] = coordinate(p, min(max(value, p.low), p.high))
    return u


def regime_map(problem: Problem, u: Floats) -> Floats:
    """Return a number for every residual, -1 for those that do not count."""
    features = features_of(problem, u)
    depth = features.values["indentation"]
    contact = features.values["time_in_contact"]
    edges = (
        np.linspace(0.0, float(np.nanmax(depth)), DEPTH_REGIMES + 1)[1:-1] * 0.93
    )  # off the levels of holds
    half = (problem.episodes > np.median(problem.episodes)).astype(np.int64)
    number = features.phase.astype(np.int64)
    number = number * DEPTH_REGIMES + np.searchsorted(edges, depth)
    number = number * (len(CONTACT_TIMES_S) + 1) + np.searchsorted(CONTACT_TIMES_S, contact)
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
