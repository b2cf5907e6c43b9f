"""The next trial: one of each kind, then the one that brings the parameters nearest to their goals.

The information of a trial that was not done is that of the model in it,

    ``A = J^T J``,  ``C = (C_now^-1 + A)^-1``

J the whitened derivatives by the parameters, at the values as they are now, the zeros of the sensors
eliminated from ``A`` (they are the trial's own). D-optimal design would maximise ``det A``
[AtkinsonFedorov1975]_; here what a parameter is known better than its goal counts nothing.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vegrip.identification.calibration.trials import TRIAL_KINDS, Trial, first_trial, trials_of, why_not
from vegrip.identification.experiment.design import rig_of
from vegrip.identification.experiment.design_space import RigLimits
from vegrip.identification.experiment.hypotheses import Hypotheses, rate_of, sensors_of
from vegrip.identification.fit.noise import noise_of
from vegrip.identification.fit.preprocess import preprocess
from vegrip.identification.fit.problem import Problem
from vegrip.identification.fit.result import Fit
from vegrip.identification.fit.solve import Report
from vegrip.identification.simulate import DEFAULT_NOISE, simulate
from vegrip.model import ContactModel, paper_model
from vegrip.types import Floats

GOALS: Mapping[str, float] = {"K": 0.03, "p": 0.03, "c1": 0.02, "nu1": 0.15, "k0": 0.1, "mu": 0.05}
"""Standard error that suffices, of the coordinate: relative where a parameter is fitted by its logarithm."""
SHARE = 0.3  # of the prior's standard deviation, for parameters of further effects
MAX_ATTEMPTS = 2  # at a kind of trial, after which the rest goes on without a good one
MIN_TRIAL_GAIN_NATS = 0.1  # [nats] that a trial must bring the parameters nearer to their goals
GENTLE_FORCE = 0.5  # of the greatest force, while the stiffness is only guessed
PLAN_RATE = 100.0  # [Hz] of planned trials at most: the information per second grows no more above it


@dataclass(frozen=True)
class Known:
    """A parameter of the model, and the standard error that suffices for it."""

    symbol: str
    effect: str
    value: float
    std: float  # of its coordinate, as the goal
    goal: float
    unit: str
    is_log: bool

    @property
    def is_known(self) -> bool:
        return self.std <= self.goal

    def errors_off(self, true: float) -> float:
        off = math.log(self.value / true) if self.is_log else self.value - true
        return off / self.std

    def as_dict(self) -> dict[str, object]:
        of_value = self.value if self.is_log else 1.0
        return {
            "effect": self.effect,
            "value": self.value,
            "std": of_value * self.std,
            "goal": of_value * self.goal,
            "unit": self.unit,
            "scale": "log" if self.is_log else "identity",
            "known": self.is_known,
        }


def known_of(fit: Fit) -> list[Known]:
    """Return how well each parameter of the model is known."""
    found, values = [], fit.model.values
    for symbol in fit.problem.symbols:
        if (declared := fit.declared(symbol)) is not None:
            effect, p = declared
            value, goal = values[symbol].value, GOALS.get(symbol, SHARE * p.std)
            is_log = p.transform == "log"
            found.append(Known(symbol, effect.name, value, fit.std[symbol], goal, p.unit, is_log))
    return found


def distance(stds: Floats, goals: Floats) -> float:
    """Return how far the parameters are from being known [nats]: 0 when all are."""
    return float(np.sum(np.log(np.maximum(stds / goals, 1.0))))


@dataclass(frozen=True)
class Next:
    """The next trial, and why; ``trial`` is None when nothing more is to be done."""

    trial: Trial | None
    why: str
    left_out: Mapping[str, str]  # kind -> why it cannot be done


def first_of(radius: float, limits: RigLimits) -> Next:
    """Return the first trial of a fingertip of ``radius`` [m], of which nothing is known."""
    gentle = replace(limits, force=GENTLE_FORCE * limits.force)
    contest = _contest(paper_model(radius), DEFAULT_NOISE, PLAN_RATE)
    why = "nothing is known yet: gentle presses show the stiffness, and how deep the fingertip may be pressed"
    return Next(first_trial(rig_of(contest, gentle)), why, {})


def next_of(
    fit: Fit, good: Sequence[str], tried: list[str], limits: RigLimits, report: Report = lambda _: None
) -> Next:
    """Return what to do after trials of the kinds ``tried``.

    Args:
        fit: to all that was recorded.
        good: kinds of the trials that showed what they are for.
        tried: kinds of all trials.
        limits: of the rig, all given.
        report: is called with how far it is.

    """
    model = fit.model
    measured = fit.problem.measured
    contest = _contest(model, sensors_of(measured), min(rate_of(measured), PLAN_RATE))
    rig = rig_of(contest, limits)
    left_out = {kind: why for kind in TRIAL_KINDS if (why := why_not(kind, contest, limits, rig))}
    known = known_of(fit)
    missing = [one.symbol for one in known if not one.is_known]
    open_ = [kind for kind in TRIAL_KINDS if kind not in good and kind not in left_out]
    open_ = [kind for kind in open_ if tried.count(kind) < MAX_ATTEMPTS]
    if not open_ and not missing:
        return Next(None, "every parameter is known as well as it must be", left_out)
    kinds = open_[:1] or [kind for kind in TRIAL_KINDS if kind not in left_out]
    goals = np.array([one.goal for one in known])
    places = [fit.problem.unknowns.names.index(symbol) for symbol in fit.problem.symbols]
    now = fit.covariance[np.ix_(places, places)]
    information = np.linalg.inv(now)
    before = distance(np.sqrt(np.diag(now)), goals)
    best: tuple[float, Trial] | None = None
    for kind in kinds:
        for trial in trials_of(kind, contest, limits, rig, is_first=bool(open_)):
            report(f"weighs {trial.protocol.name}")
            added = _information(contest, trial, fit)
            after = distance(np.sqrt(np.diag(np.linalg.inv(information + added))), goals)
            rate = (before - after) / math.sqrt(trial.protocol.duration)
            if best is None or rate > best[0]:
                best = rate, trial
    if best is None or (not open_ and best[0] * math.sqrt(best[1].protocol.duration) < MIN_TRIAL_GAIN_NATS):
        text = ", ".join(missing)
        return Next(None, f"no trial within these limits shows more of {text}", left_out)
    return Next(best[1], _reason(best[1], missing, is_first=bool(open_)), left_out)


def _reason(trial: Trial, missing: list[str], *, is_first: bool) -> str:
    if not missing:
        return f"there is no good {trial.kind} yet; it shows whether an effect is missing"
    wanted = f"not yet known well enough: {', '.join(missing)}"
    return (
        f"{wanted}; there is no good {trial.kind} yet"
        if is_first
        else f"{wanted}; this trial shows most of it"
    )


def _contest(model: ContactModel, sensors: Mapping[str, float], rate: float) -> Hypotheses:
    return Hypotheses({"model": model}, (), sensors, rate)


def _information(contest: Hypotheses, trial: Trial, fit: Fit) -> Floats:
    model = contest.models["model"]
    made = simulate(model, trial.protocol, sensors=contest.sensors, rate=contest.rate, seed=0)
    problem = Problem(model, preprocess(made, noise_of(made)), symbols=fit.problem.symbols)
    J = problem.jacobian(problem.unknowns.start)
    A = J.T @ J + np.diag(problem.unknowns.std**-2.0) * 1e-9  # never singular
    n = len(fit.problem.symbols)
    zeros = A[n:, n:]
    inner = A[:n, :n] - A[:n, n:] @ np.linalg.solve(zeros, A[n:, :n])
    return np.asarray(inner / max(fit.error, 1.0) ** 2, dtype=np.float64)
