"""A stiffness that changes at one instant (a crack) or from one depth on (a second object).

Beside the model, its parameters fitted anew, the force has one term more, at ``t0`` or ``d0``,

    ``s H(t - t0) N``   or   ``s max(d - d0, 0)``,

N the force of the model; the term is there at once or relaxes as the model does. Its evidence at every place,
s and all parameters integrated out, is linear algebra [RasmussenWilliams2006]_; at the best place the model
is fitted again, and the places are looked through once more. The places weighted by their evidence are the
posterior of the change point, of which the interval holds 95 %.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vegrip.compiled import njit
from vegrip.identification.diagnosis.candidate_fit import CandidateFit
from vegrip.identification.diagnosis.thresholds import CONTENDER_SHARE, MAX_ERROR, MIN_POINTING_NATS
from vegrip.identification.diagnosis.zero_jump import best_step
from vegrip.identification.fit.problem import AT, Problem
from vegrip.identification.fit.result import overall_error
from vegrip.identification.fit.solve import refine_optimum
from vegrip.identification.fit.whitening import Sensitivity
from vegrip.types import Floats

VARIABLES = ("time", "displacement")
DEPTHS = 20_000  # that a change may have
PLACES = 48  # looked at in one pass, and
PLACES_AT_ONCE = 8  # of them in memory
PASSES = 5  # each over those that had an evidence within
FAR_NATS = 8.0  # of the best
ROUNDS = 4  # of looking and fitting
REFIT_EVALUATIONS = 40
PRIOR_STD = 1.0  # of the amount: of the stiffness, or of the greatest stiffness
LOW, HIGH = -0.95, 20.0
INTERVAL = (0.025, 0.975)
BRANCHES = (("c1", "nu1"), ("c2", "nu2"))


@dataclass(frozen=True)
class Change:
    """A change of the stiffness at one place."""

    variable: str  # time or displacement
    at: float  # where, [s] on the recording's clock or [m] deep
    interval: tuple[float, float]  # that holds it with 95 %
    change: float  # share of the stiffness, or stiffness that is added [N/m]
    std: float  # its standard error
    gain: float  # of evidence [nats]
    error: float  # that is left, in units of the noise

    @property
    def note(self) -> str:
        goes = "rises" if self.change > 0.0 else "falls"
        if self.variable == "time":
            low, high = (f"{one:.6g}" for one in self.interval)
            share, std = 100.0 * abs(self.change), 100.0 * self.std
            places = min(max(1, -math.floor(math.log10(std))), 4) if std > 0.0 else 1
            amount = f"{share:.{places}f} +- {std:.{places}f} %"
            text = f"{goes} by {amount} at {self.at:.6g} s ({low} to {high} s with 95 %)"
        else:
            at, low, high = (f"{1e3 * one:.4g}" for one in (self.at, *self.interval))
            stiffer, std = 1e-3 * abs(self.change), 1e-3 * self.std
            text = f"{goes} by {stiffer:.3g} +- {std:.1g} N/mm from {at} mm on ({low} to {high} mm with 95 %)"
        left = f"the stiffness {text}; with that {self.error:.2f} times the noise is left"
        return left + ", so more is missing, and the interval may miss the place" * (self.error > MAX_ERROR)


class Changed(Problem):
    """The problem with the term as one unknown more, the last one, in units of the largest stiffness."""

    def __init__(self, base: Problem, variable: str, *, is_relaxing: bool) -> None:
        self.__dict__.update(base.__dict__)  # the same rows, noise and compiled model
        self.variable, self.is_relaxing, self.onset = variable, is_relaxing, math.inf
        m = base.measured
        self.along = m.recording.t if variable == "time" else m.motion.displacement
        self.inner = np.unique(self.along[base.used & (base.stiffness > 0.0)])[1:-1]
        self.scale = 1.0
        if variable == "displacement" and self.inner.size:
            self.inner = np.linspace(self.inner[0], self.inner[-1], DEPTHS)
            self.scale = float(base.stiffness.max())
        self.unknowns = base.unknowns.with_one("change", LOW, HIGH, PRIOR_STD)

    def table(self, u: Floats, instead: Mapping[str, float] | None = None) -> Floats:
        """Return the prediction (n, 14) with the change."""
        out = super().table(u, instead)
        out[:, AT["normal_force"]] += u[-1] * self.term(u, out, np.array([self.onset]), float(u[-1]))[:, 0]
        return out

    def freeze(self, u: Floats) -> None:
        self.amount = float(u[-1])
        super().freeze(u)

    def _sensitivity(self, u: Floats) -> Sensitivity:
        changed = self.amount * (self.along >= self.onset)
        if self.variable == "time":
            self.stiffness = self.stiffness * (1.0 + changed)
        else:
            self.stiffness = self.stiffness + self.scale * changed * (self.stiffness > 0.0)
        return super()._sensitivity(u)

    def term(self, u: Floats, table: Floats, places: Floats, amount: float) -> Floats:
        """Return what an amount of 1 adds to the force for each place, (n, places) [N].

        As long as with ``amount`` it makes no force that pulls: then the contact is lost.
        """
        vector, (_, zero) = self.parts(u)
        force = table[:, AT["normal_force"]] - zero
        here = self.along[:, None]
        if self.variable == "displacement":
            added = self.scale * np.maximum(here - places, 0.0)
        elif self.is_relaxing:
            added = (here >= places) * table[:, AT["elastic_force"], None]
        else:
            added = (here >= places) * force[:, None]
        m, out = self.measured, added
        for c, nu in BRANCHES if self.is_relaxing else ():
            if c in self._places:
                share, rate = (float(vector[self._places[symbol]]) for symbol in (c, nu))
                out = out - share * added + relaxed(m.recording.t, m.first, added, share, rate)
        if amount != 0.0:
            most = -np.maximum(force, 0.0)[:, None] / amount
            out = np.maximum(out, most) if amount > 0.0 else np.minimum(out, most)
        return np.where(force[:, None] != 0.0, out, 0.0)

    def look(self, u: Floats) -> tuple[Floats, Floats]:
        """Return places, ascending, denser where the evidence is, and the evidence of a change there [nats].

        In a model that is linear about ``u``, as it is without the change.
        """
        amount, u = float(u[-1]), np.append(u[:-1], 0.0)
        n, table = self.measured.recording.t.size, self.table(u)
        w = self.white(self.raw(table))
        J = self.jacobian(u, w)[:, :-1]
        A = J.T @ J + np.diag(self.unknowns.std[:-1] ** -2.0)

        def evidence_of(places: Floats) -> Floats:
            B = self.whitener(self.term(u, table, places, amount))
            C = J[:n].T @ B
            through = np.linalg.solve(A, np.column_stack([C, J.T @ w]))
            M = np.einsum("ij,ij->j", B, B) - np.einsum("ij,ij->j", C, through[:, :-1])
            b = B.T @ w[:n] - C.T @ through[:, -1]
            tell = np.maximum(M, 0.0) * PRIOR_STD**2
            gain: Floats = 0.5 * (b * PRIOR_STD) ** 2 / (1.0 + tell) - 0.5 * np.log1p(tell)
            return gain

        def evidence(places: Floats) -> Floats:
            some = np.array_split(places, -(-places.size // PLACES_AT_ONCE))
            return np.concatenate([evidence_of(one) for one in some])

        low, high = 0, self.inner.size - 1
        places, gains, likely = np.zeros(0), np.zeros(0), low
        if self.variable == "time":  # a peak may be narrower than the places of the first pass are apart
            always = self.whitener(self.term(u, table, self.along[:1], amount))[:, 0]
            left = w - J @ np.linalg.solve(A, J.T @ w)
            row = best_step(self, np.r_[always, np.zeros(w.size - n)], left, J, A)[1]
            likely = min(int(np.searchsorted(self.inner, self.along[row])), high)
        for _ in range(PASSES):
            rows = np.unique(np.r_[likely, np.linspace(low, high, PLACES)].astype(int))
            new = np.setdiff1d(self.inner[rows], places)
            if not new.size:
                break
            places, gains = np.r_[places, new], np.r_[gains, evidence(new)]
            order = np.argsort(places)
            places, gains = places[order], gains[order]
            near = np.flatnonzero(gains > gains.max() - FAR_NATS)
            ends = max(near[0] - 1, 0), min(near[-1] + 1, places.size - 1)
            low, high = (int(np.searchsorted(self.inner, places[i])) for i in ends)
        return places, gains


def find_change(fitted: CandidateFit, beside: float = MIN_POINTING_NATS) -> Change | None:
    """Return the change with the greatest evidence; None where none comes near ``beside`` [nats]."""
    u = np.append(fitted.optimum.u, 0.0)
    found: list[Change] = []
    for variable in VARIABLES:
        problems = [Changed(fitted.problem, variable, is_relaxing=so) for so in (False, True)]
        looks = [(one, *one.look(u)) for one in problems if one.inner.size > PLACES]
        best = max(looks, key=lambda look: float(look[-1].max()), default=None)
        if best is not None and best[-1].max() > CONTENDER_SHARE * beside:
            found.append(_refit(fitted, *best))
            beside = max(beside, found[-1].gain)
    return max(found, key=lambda one: one.gain, default=None)


def _refit(fitted: CandidateFit, problem: Changed, places: Floats, gains: Floats) -> Change:
    u = np.append(fitted.optimum.u, 0.0)
    before = -fitted.optimum.cost - float(problem.log_scale.sum())
    is_found = False
    for i in range(ROUNDS):
        if is_found:
            break
        at = float(places[np.argmax(gains)])
        is_found, problem.onset = at == problem.onset, at
        if i > 0:  # the first model may be far astray, and its noise with it
            problem.freeze(u)
        best = refine_optimum(problem, u, REFIT_EVALUATIONS)
        u = best.u
        places, gains = problem.look(u)
    error = overall_error(problem, u)
    widening = max(error, 1.0) ** 2
    weight = np.gradient(places) * np.exp((gains - gains.max()) / widening)
    share = np.cumsum(weight) / weight.sum()
    low, high = (float(places[np.searchsorted(share, q)]) for q in INTERVAL)
    if problem.variable == "time":  # a row is the first one after the change
        low = float(problem.inner[max(int(np.searchsorted(problem.inner, low)) - 1, 0)])
        t = problem.measured.recording.t
        for event in problem.measured.events:  # whose rows were left out, until the force is back
            if low < event.time <= high:
                at, low, high = event.time, float(t[event.begin]), event.time
    A = best.jacobian.T @ best.jacobian / widening + np.diag(problem.unknowns.std**-2.0)
    covariance = np.linalg.inv(A)
    std = math.sqrt(covariance[-1, -1])
    if problem.variable == "displacement":
        zero = float(np.median(problem.parts(u)[1][0]))
        of_zeros = [
            i for i, name in enumerate(problem.unknowns.names) if name.startswith("zero_displacement")
        ]
        reach = 1.96 * problem.depth * math.sqrt(float(np.mean(np.diag(covariance)[of_zeros])))
        below, above = math.hypot(at - low, reach), math.hypot(high - at, reach)
        at, low, high = at - zero, at - zero - below, at - zero + above
    located = math.log(weight.sum() / np.ptp(problem.inner))
    after = -best.cost - float(problem.log_scale.sum())
    gain = after - before + math.log(std / PRIOR_STD) + located
    return Change(
        problem.variable, at, (low, high), problem.scale * float(u[-1]), problem.scale * std, gain, error
    )


@njit
def relaxed(t: Floats, first: Floats, added: Floats, c: float, nu: float) -> Floats:
    """Return what a branch of amplitude ``c`` and rate ``nu`` [1/s] remembers of ``added`` (n, m)."""
    out = np.zeros(added.shape)
    for i in range(t.size):
        if first[i] > 0.0:
            out[i] = c * added[i]
        else:
            keep = np.exp(-nu * (t[i] - t[i - 1]))
            out[i] = keep * out[i - 1] + c * np.sqrt(keep) * (added[i] - added[i - 1])
    return out
