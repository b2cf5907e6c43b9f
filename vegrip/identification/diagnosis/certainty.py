"""How sure a verdict is: the share of bootstrap draws that lead to the same answer.

A draw weights the episodes at random, exponentially, as the Bayesian bootstrap does [Rubin1981]_, and every
model that stood for choice is fitted to them again by one linear step from where it is best. With weights w
over the groups g of rows,

    ``A = sum w_g J_g' J_g + S^-2``,   ``b = sum w_g J_g' r_g + S^-2 (u - p)``,
    ``cost = sum w_g |r_g|^2 / 2 + |S^-1 (u - p)|^2 / 2 - b' A^-1 b / 2``,

which costs next to nothing, because the sums over rows are made once.

And each accepted effect is certified by rows that determined none of its values. Those of one half of the
episodes foretell the change s that it makes in the others. There the residual is regressed on s, beside the
derivatives of the model without it: over its standard error the coefficient is Student's t, exactly, whatever
the size of the noise. Both halves are tested in turn, and the worse counts, times the number of candidates
that were looked at: so it holds for each of them at once, whichever rows chose the name. What else was
accepted belongs to the model without it.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.special import stdtr

from vegrip.identification.diagnosis import thresholds
from vegrip.identification.diagnosis.acceptance import misfit_by_regime
from vegrip.identification.diagnosis.candidate_fit import NEAR_STEPS, CandidateFit, Nearby
from vegrip.identification.diagnosis.diagnosis import Diagnosis, Left
from vegrip.identification.diagnosis.search import Step, required_evidence
from vegrip.identification.fit.preprocess import Mask
from vegrip.identification.fit.solve import refine_optimum
from vegrip.types import Floats

OUTSIDE = 1e-3  # weight of the rows that determine no values
SPLIT = np.array(
    [0, 1, 1, 0, 1, 0, 0, 1]
)  # of neighbouring episodes: kinds that alternate are in both halves


@dataclass(frozen=True)
class Certainty:
    """How many of so many ``draws`` lead to the ``same`` answer, and how often each answer was given."""

    draws: int
    same: int
    answers: Mapping[str, int]
    certified: Mapping[str, float]  # accepted effect -> chance that noise makes any candidate do as much

    @property
    def note(self) -> str:
        others = ", ".join(f"{answer} in {n}" for answer, n in list(self.answers.items())[1:])
        drawn = f"the same answer in {self.same} of {self.draws} draws" + (f" ({others})" if others else "")
        held = ", ".join(f"{name} p = {chance:.1g}" for name, chance in self.certified.items())
        tested = f"on episodes held apart {held}" if held else ""
        return "; ".join(one for one in (drawn if self.draws else "", tested) if one)

    def as_dict(self) -> dict[str, Any]:
        return {**asdict(self), "note": self.note}


class Redrawn:
    """A fitted model under other weights of its groups of rows."""

    def __init__(self, fitted: CandidateFit, groups: Floats) -> None:
        self.fitted, problem = fitted, fitted.problem
        self._rows = [groups == number for number in np.unique(groups)]
        J, r, k = fitted.complete.jacobian, fitted.optimum.residual, problem.unknowns
        scale = problem.log_scale
        self._A = np.array([J[rows].T @ J[rows] for rows in self._rows])
        self._b = np.array([J[rows].T @ r[rows] for rows in self._rows])
        self._c = np.array([0.5 * float(r[rows] @ r[rows]) + float(scale[rows].sum()) for rows in self._rows])
        self._prior, self._away = np.diag(k.std**-2.0), (fitted.optimum.u - k.prior) / k.std
        self._widths = float(np.sum(np.log(k.std)))

    def _step(self, weights: Floats) -> tuple[Floats, Floats, Floats]:
        A = np.tensordot(weights, self._A, 1) + self._prior
        b = weights @ self._b + self._away * np.sqrt(np.diag(self._prior))
        return A, b, -np.linalg.solve(A, b)

    def evidence(self, weights: Floats) -> float:
        """Return ln Z [nats] with ``weights`` (groups,)."""
        A, b, step = self._step(weights)
        cost = float(weights @ self._c) + 0.5 * float(self._away @ self._away) + 0.5 * float(b @ step)
        return -cost - self._widths - 0.5 * float(np.linalg.slogdet(A)[1])

    def left(self, weights: Floats, regimes: Floats) -> tuple[float, float]:
        """Return chi-square by regime and error that are left."""
        residual = self.fitted.optimum.residual + self.fitted.complete.jacobian @ self._step(weights)[2]
        each = np.zeros(residual.size)
        for weight, rows in zip(weights, self._rows, strict=True):
            each[rows] = weight
        counted = self.fitted.problem.counted
        error = float(np.sqrt(np.sum((each * residual**2)[counted]) / np.sum(each[counted])))
        return misfit_by_regime(residual, regimes, each), error


class Redraw:
    """The verdict of a search under other weights of the episodes."""

    def __init__(self, found: Diagnosis, groups: Floats) -> None:
        self._found, self._groups = found, groups
        self._known: dict[int, Redrawn] = {}

    def _of(self, fitted: CandidateFit) -> Redrawn:
        if id(fitted) not in self._known:
            self._known[id(fitted)] = Redrawn(fitted, self._groups)
        return self._known[id(fitted)]

    @cached_property
    def count(self) -> int:
        return int(np.unique(self._groups).size)

    def answer(self, weights: Floats) -> str:
        """Return verdict and names."""
        s = self._found.search
        names, is_ambiguous = [], False
        for name, contest in s.contests.items():
            rest = self._of(contest.base).evidence(weights)
            gains = {
                one.candidate.name: self._of(one.fitted).evidence(weights) - rest
                for one in contest.tried
                if one.verdict.is_passed or one is contest.tried[0]
            }
            best = max(gains, key=gains.__getitem__)
            if gains[best] < thresholds.MIN_GAIN_NATS:
                continue
            close = sorted(n for n, gain in gains.items() if gains[best] - gain <= s.within(gains[best]))
            sets = [one for one in self._found.indistinguishable if name in one]
            close = sorted({*close, *(sets[0] if sets and best in sets[0] else ())})
            is_ambiguous = is_ambiguous or len(close) > 1
            names.append(" or ".join(close))
        last, first = self._of(s.last), self._of(s.first)
        taken = [one.candidate.effect for one in s.accepted]
        asked, now = required_evidence(s.first, s.last, s.misfit(s.last), taken), last.evidence(weights)
        for one in s.steps[-1].tried:
            own = one.candidate.effect
            gain = self._of(one.fitted).evidence(weights) - now
            pays = asked.of(own, one.change, is_exact=s.leaves_noise(one.fitted))
            if set(one.verdict.failed) <= {"evidence"} and gain > max(pays, own.min_gain):
                names.append(one.candidate.name)
                break
        misfit, error = last.left(weights, s.regimes)
        left = Left(misfit, first.left(weights, s.regimes)[1], error)
        verdict = self._found.verdict_of(len(names), left, is_ambiguous=is_ambiguous)
        return f"{verdict}: {', '.join(sorted(names))}" if verdict in ("named", "ambiguous") else verdict


def certainty_of(found: Diagnosis, draws: int = 20, seed: int = 0) -> Certainty:
    """Draw so many times, and count the answers; the commonest first, the one that was given before all."""
    redraw = Redraw(found, found.groups)
    rng = np.random.default_rng(seed)
    given = redraw.answer(np.ones(redraw.count))
    weights = rng.exponential(size=(draws, redraw.count))
    answers = Counter(redraw.answer(one * redraw.count / one.sum()) for one in weights)
    rest = [(answer, n) for answer, n in answers.most_common() if answer != given]
    sets = dict([(given, answers[given]), *rest])
    return Certainty(draws, answers[given], sets, certify(found))


def certify(found: Diagnosis) -> dict[str, float]:
    """Return for each accepted effect the chance that noise makes any candidate explain as much."""
    half = SPLIT[np.unique(found.groups, return_inverse=True)[1] % SPLIT.size]
    looks = max(len(found.search.steps[0].hints), 1)

    def chance(contest: Step, tested: Mask) -> float:
        base, new = contest.base, contest.tried[0].fitted
        change = _without(base, tested) - _without(new, tested)
        rows = tested & base.problem.counted
        return chance_of(change[rows], base.optimum.residual[rows], base.optimum.jacobian[rows])

    return {
        name: min(1.0, looks * max(chance(contest, half == side) for side in (0, 1)))
        for name, contest in found.search.contests.items()
    }


def _without(fitted: CandidateFit, rows: Mask) -> Floats:
    weights, there = np.where(rows, OUTSIDE, 1.0), fitted.complete
    near = Nearby(fitted.problem, weights, there)
    return fitted.problem.residual(refine_optimum(near, there.u, NEAR_STEPS).u)


def chance_of(s: Floats, r: Floats, J: Floats) -> float:
    """Return the chance that ``s`` (n,) explains as much of the residual ``r`` beside ``J`` (n, p)."""
    basis, _ = np.linalg.qr(J)
    s, r = s - basis @ (basis.T @ s), r - basis @ (basis.T @ r)
    power, freedom = float(s @ s), r.size - J.shape[1] - 1
    if power <= 0.0 or freedom < 1:
        return 1.0
    a = float(s @ r) / power
    return float(stdtr(freedom, -a / np.sqrt(np.sum((r - a * s) ** 2) / freedom / power)))
