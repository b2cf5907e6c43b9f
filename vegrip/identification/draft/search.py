"""The search for a law that no catalogue has.

Every sentence of the grammar is screened as an effect of the catalogue is (score test), the few best are
written as effects and refitted, and judged by the same gates, where each pays for being one of many. Besides,
episodes of a protocol (alike in speed and depth) are held out together: what imitates one protocol fails on
the other. The shortest law within the noise of the best one is taken, if it breaks none of the laws that
every contact obeys.
"""

import dataclasses
import hashlib
import keyword
import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from vegrip.displayed import Result
from vegrip.effects import names
from vegrip.errors import UsageError
from vegrip.identification.diagnosis import thresholds
from vegrip.identification.diagnosis.acceptance import Verdict, judge_candidate, misfit_by_regime
from vegrip.identification.diagnosis.candidate_fit import (
    CandidateFit,
    evaluate_candidate,
    extended,
    finished,
    held_out_groups,
    log_evidence,
    regime_map,
)
from vegrip.identification.diagnosis.data_checks import check_before_search, refuse_unusable
from vegrip.identification.diagnosis.discrepancy import find_discrepancy
from vegrip.identification.diagnosis.score_tests import Candidate, Hint, null, with_candidates
from vegrip.identification.draft.grammar import LAW_PLACES, LAW_SHAPES, MEMORY_TIMES_S, Law, Place, Variable
from vegrip.identification.draft.text import PROBE_NAME, Probe, law_text, parameters_of, probe
from vegrip.identification.fit.fitting import fit, on_one_thread
from vegrip.identification.fit.given import on_recording
from vegrip.identification.fit.noise import Noise
from vegrip.identification.fit.obeys import broken_by
from vegrip.identification.fit.problem import AT, Problem, Zeros
from vegrip.identification.fit.result import Fit, fit_of, shown_by
from vegrip.identification.fit.solve import Optimum, Report
from vegrip.identification.recording import Recording
from vegrip.model import ContactModel
from vegrip.types import Floats

AMOUNT = 0.05  # of the place, at which a law is screened
SHOWN = 1e-3  # of K, by which a sensor shows a variable
COARSE = ("linear", "saturating", "beyond")  # shapes of the first look
LOOKED_AT_AGAIN = 20  # pairs of place and variable whose every shape is screened
SHARPER = (2.0, 0.5, 1.3, 1.0 / 1.3)  # steps of a law's memory on the screen, one after the other
MULTIPLIED = 12  # laws beside which every second variable is screened, and of those how many are sharpened
REFITTED = 12
JUDGED = 8
CONTENDS = 0.9  # of the evidence of the best law, with which another may predict protocols better
MAX_ALIKE = 2  # of them, of one place and variable
MIN_EPISODES = 2
MIN_SHARE = 0.3  # of the excess of the squared error over the noise's, that a law worth writing takes
SAME_PROTOCOL = 0.35  # of ln speed and ln depth, within which two episodes are one protocol
MIN_SCATTER = 1e-6  # of a variable's largest value, below which it did not change


Shaped = tuple[Law, Mapping[str, float]]
"""A law with its shape ``s`` and memory ``tau``."""


@dataclass(frozen=True, eq=False)
class Screened:
    """A law on the screen: gain [nats] and the trial with its best multiple."""

    law: Law
    gain: float
    at: Mapping[str, float]
    multiple: float


@dataclass(frozen=True, eq=False)
class Refitted:
    """A law at its best; ``gain`` of evidence [nats]."""

    law: Law
    candidate: Candidate
    problem: Problem
    optimum: Optimum
    gain: float


@dataclass(frozen=True, eq=False)
class Tried:
    """A law that was refitted; ``across``: gain [nats] where each protocol is predicted by the others."""

    law: Law
    fitted: CandidateFit
    verdict: Verdict
    share: float  # of the excess of the squared error over the noise's, that it takes
    across: float
    broken: tuple[str, ...]  # laws that must hold

    @property
    def parameters(self) -> dict[str, float]:
        """What was fitted, by the letters of :func:`~vegrip.identification.draft.text.parameters_of`."""
        free = [one.symbol for one in parameters_of(self.law, PROBE_NAME)]
        return {symbol.removesuffix(f"_{PROBE_NAME}"): self.fitted.value(symbol) for symbol in free}

    @property
    def worth(self) -> float:
        """Evidence, and what protocols predict of each other that were held out [nats]."""
        return self.verdict.gain + self.across

    @property
    def failed(self) -> tuple[str, ...]:
        little = ("little",) * (self.share < MIN_SHARE)
        return (*self.verdict.failed, *little, *("held-out protocols",) * (self.across <= 0.0), *self.broken)


@dataclass(frozen=True, eq=False, repr=False)
class Draft(Result):
    """What was found: the law that is worth writing, or the reason that none is.

    Attributes:
        verdict: drafted or none.
        reason: why there is none.
        taken: the law, None where none is worth writing.
        rivals: laws over something else that are as good.
        parameters: fitted values of the law, by symbol.
        text: of the effect's file, which `vegrip add FILE` takes as any effect.
        tried: what was refitted, best first.
        screened: how many laws were looked at.
        name: of the effect.
        start: the fit of the model that was given, or the paper's.
        base: the same with what is needed to judge it.
        q: variable of the law over the size (n,).

    """

    _display: ClassVar[str] = "draft"

    start: Fit
    base: CandidateFit
    name: str
    tried: list[Tried] = field(default_factory=list)
    taken: Tried | None = None
    reason: str = ""
    screened: int = 0
    q: Floats = field(default_factory=lambda: np.zeros(0))  # of the law that is taken (n,)

    @property
    def verdict(self) -> str:
        return "drafted" if self.taken is not None else "none"

    @property
    def rivals(self) -> list[Tried]:
        """Laws over something else that pass and gain as much as the one that is taken, best first."""
        if self.taken is None:
            return []
        near = as_good(self.tried)
        return [one for one in near if set(one.law.variables) != set(self.taken.law.variables)]

    @property
    def text(self) -> str:
        return self.text_of(self.taken, self.name) if self.taken is not None else ""

    def text_of(self, one: Tried, name: str) -> str:
        return law_text(one.law, name, self._found(one, name), one.parameters)

    @property
    def parameters(self) -> dict[str, float]:
        return _named(self.taken, self.name) if self.taken else {}

    def _found(self, taken: Tried, name: str) -> dict[str, str]:
        recording = self.start.problem.measured.recording
        k = taken.fitted
        return {
            "Found in": f"{recording.name}, {len(recording)} samples, sha256 {digest(recording)}",
            "Shown for": "; ".join(spans(self.base)),
            "Error over the noise": f"{self.base.error:.4g} -> {k.error:.4g} (floor 1); held-out protocols "
            f"{taken.across:+.4g} nats",
            "Fitted values": ", ".join(f"{key} = {at:.4g}" for key, at in _named(taken, name).items()),
            "Place": taken.law.place.where,
            "What would refute it": taken.law.variable.refute,
        }

    def as_dict(self) -> dict[str, Any]:
        """Return what ``--json`` prints, but for the file."""
        one = self.taken
        error = {
            "before": self.base.error,
            "after": one.fitted.error if one else self.base.error,
            "noise_floor": 1.0,
        }
        return {
            "recording": self.start.problem.measured.recording.name,
            "verdict": self.verdict,
            "reason": self.reason,
            "law": one.law.in_words if one else None,
            "place": one.law.place.where if one else None,
            "variables": one.law.variables if one else [],
            "parameters": self.parameters,
            "error": error,
            "heldout_gain": one.verdict.heldout if one else None,
            "heldout_protocols_gain": one.across if one else None,
            "experiment": one.law.variable.refute if one else None,
            "rivals": [each.law.in_words for each in self.rivals],
            "screened": self.screened,
            "tried": [
                {
                    "law": each.law.in_words, "evidence_gain": each.verdict.gain,
                    "heldout_gain": each.verdict.heldout, "heldout_protocols_gain": each.across,
                    "error_after": each.fitted.error, "failed": list(each.failed),
                }
                for each in self.tried
            ],
        }  # fmt: skip


def _named(one: Tried, name: str) -> dict[str, float]:
    return {f"{key}_{name}": at for key, at in one.parameters.items()}


def effect_name(path: Path) -> str:
    """Return the name of the effect that is written to ``path``.

    Raises:
        UsageError: the file's name cannot be that of an effect.

    """
    name = path.stem
    if path.suffix != ".py" or not name.isidentifier() or keyword.iskeyword(name) or name != name.lower():
        raise UsageError(
            f"{path}: name the effect by small letters, digits and _, and end it in .py, as in wear.py"
        )
    if name in names():
        raise UsageError(f"there is an effect {name!r} already; choose another name")
    return name


@on_recording
@on_one_thread
def draft(
    recording: Recording,
    model: ContactModel | None = None,
    *,
    name: str = "drafted",
    noise: Noise | None = None,
    zeros: Zeros = "recording",
    threads: int = 2,
    report: Report = lambda _: None,
) -> Draft:
    """Draft a law for what ``model`` (the paper's when not given) leaves of ``recording``.

    ``name`` is that of the effect.
    """
    start = fit(recording, model, noise=noise, zeros=zeros, report=report)
    refuse_unusable(recording, start.problem.measured)
    problem, groups = start.problem, held_out_groups(start.problem)
    base = evaluate_candidate(problem, start.optimum, groups)
    if reason := _why_not(problem, base):
        return Draft(start, base, name, reason=reason)
    report("screens the laws of the grammar")
    screen = Screen(base)
    found, count = screen_laws(screen, threads, report)
    pays = thresholds.MIN_GAIN_NATS + math.log(max(count, 1))
    found = [one for one in found if one.gain > pays]
    judge = Judge(base, groups, screen, pays, threads)
    refitted = judge.refitted(shortlist(found), report)
    refitted += judge.refitted(_kin(found, refitted), report)
    tried = judge.judged(sorted(refitted, key=lambda one: -one.gain))
    taken = min(as_good(tried), key=lambda one: one.law.complexity, default=None)
    if taken is None:
        return Draft(start, base, name, tried, None, _why_none(tried), count)
    values = screen.values(taken.law.variable, taken.parameters.get("tau", 1.0)) / taken.law.size
    return Draft(start, base, name, tried, taken, "", count, values)


class Screen:
    """The score test of laws: one run of the model for each, none of the fit."""

    def __init__(self, base: CandidateFit) -> None:
        self._base, problem = base, base.problem
        std = problem.unknowns.std
        self._basis, _ = np.linalg.qr(np.vstack([base.optimum.jacobian, np.diag(1.0 / std)]))
        has_temperature = bool(np.nanstd(problem.measured.columns.get("temperature", np.zeros(1))) > 0.0)
        self.probes = {
            name: probe(place, has_temperature=has_temperature) for name, place in LAW_PLACES.items()
        }
        self._wide = {name: self._widened(one) for name, one in self.probes.items()}
        self._sizes: dict[tuple[str, float], float] = {}

    def _widened(self, one: Probe) -> Problem:
        p = self._base.problem
        within = with_candidates(p.model, [Candidate(one.effect, null(one.effect), ())])
        return Problem(p.model, p.measured, symbols=p.symbols, like=p, within=within)

    def values(self, variable: Variable, tau: float) -> Floats:
        """Return a variable (n,) as a sensor shows it that adds a little of it."""
        p, u, wide = self._base.problem, self._base.optimum.u, self._wide["sense"]
        K = self._base.value("K") if "K" in p.unknowns.names else p.model.values["K"].value
        law = Law(LAW_PLACES["sense"], variable, LAW_SHAPES["linear"], 1.0)
        shown = [wide.table(u, self.probes["sense"].trial(amount, law, 1.0, tau)) for amount in (0.0, SHOWN)]
        return (shown[1] - shown[0])[:, AT["normal_force"]] / (SHOWN * K)

    def size_of(self, variable: Variable, tau: float) -> float:
        """Return the largest value of a variable in contact."""
        if (variable.name, tau) not in self._sizes:
            shown = np.abs(self.values(variable, tau)[self._base.problem.stiffness > 0.0])
            self._sizes[variable.name, tau] = float(np.max(shown, initial=0.0))
        return self._sizes[variable.name, tau]

    def score(self, law: Law, at: Mapping[str, float]) -> Screened | None:
        """Return the gain of a law and its best multiple; None where it changes nothing of its own."""
        base, wide = self._base, self._wide[law.place.name]
        trial = self.probes[law.place.name].trial(AMOUNT, law, **at)
        signature = np.zeros(self._basis.shape[0])
        rows = base.optimum.residual.size
        with np.errstate(all="ignore"):
            signature[:rows] = wide.white(wide.raw(wide.table(base.optimum.u, trial))) - base.optimum.residual
        power = float(signature @ signature)
        if not 0.0 < power < math.inf:
            return None
        own = signature - self._basis @ (self._basis.T @ signature)
        left = float(own @ own)
        if left < 1e-9 * power:
            return None
        along = float(own[:rows] @ base.optimum.residual)
        return Screened(law, 0.5 * along * along / (left + 1e-3), at, -along / left)


class Judge:
    """Refits of laws, and what they are worth beside the model that is there."""

    def __init__(self, base: CandidateFit, groups: Floats, screen: Screen, pays: float, threads: int) -> None:
        self._base, self._groups, self._screen, self._pays = base, groups, screen, pays
        self._regimes = regime_map(base.problem, base.optimum.u)
        self._misfit = misfit_by_regime(base.optimum.residual, self._regimes)
        self._threads = threads

    def refitted(self, chosen: list[Screened], report: Report) -> list[Refitted]:
        """Return laws refitted, best first."""
        if chosen:
            report(f"refits {'; '.join(one.law.equation for one in chosen)}")
        with ThreadPoolExecutor(self._threads) as pool:
            return sorted(pool.map(self._refitted, chosen), key=lambda one: -one.gain)

    def _refitted(self, one: Screened) -> Refitted:
        probe = self._screen.probes[one.law.place.name]
        absent, trial = (probe.trial(c, one.law, **one.at) for c in (0.0, AMOUNT))
        candidate = Candidate(probe.freed_for(one.law), absent, (trial,))
        hint = Hint(candidate, one.gain, trial, one.multiple, np.zeros(0, dtype=np.float32))
        problem, rough = extended(self._base, hint)
        best = finished(self._base, problem, rough)
        return Refitted(one.law, candidate, problem, best, log_evidence(problem, best) - self._base.evidence)

    def judged(self, refitted: list[Refitted]) -> list[Tried]:
        """Return laws judged, most evidence first, down to those that the best that passes surely beats.

        Holding out costs most of the time.
        """
        tried: list[Tried] = []
        with ThreadPoolExecutor(self._threads) as pool:
            for i in range(0, min(len(refitted), JUDGED), self._threads):
                passed = [one.verdict.gain for one in tried if not one.failed]
                if passed and refitted[i].gain < CONTENDS * max(passed):
                    break
                tried += pool.map(self._tried, refitted[i : i + self._threads])
        return tried

    def _tried(self, one: Refitted) -> Tried:
        base, fitted = self._base, evaluate_candidate(one.problem, one.optimum, self._groups)
        after = misfit_by_regime(fitted.optimum.residual, self._regimes)
        verdict = judge_candidate(one.candidate, base, fitted, (self._misfit, after), self._pays)
        share = (base.error**2 - fitted.error**2) / max(base.error**2 - 1.0, 1e-12)
        if verdict.failed:
            return Tried(one.law, fitted, verdict, share, -math.inf, ())
        broken = broken_by(fit_of(fitted.problem, fitted.optimum).model, base.problem)
        return Tried(one.law, fitted, verdict, share, self._across(fitted), tuple(broken))

    def _across(self, new: CandidateFit) -> float:
        """Return by how much [nats] protocols are better predicted by fits to the others.

        Episodes, where all of them are one protocol.
        """
        if self._protocols.max() < 1.0:
            return float(np.sum(new.heldout - self._base.heldout))
        now = evaluate_candidate(new.problem, new.optimum, self._protocols)
        return float(np.sum(now.heldout - self._base_across.heldout))

    @cached_property
    def _protocols(self) -> Floats:
        problem = self._base.problem
        return protocols(problem)[problem.rows].astype(np.float64)

    @cached_property
    def _base_across(self) -> CandidateFit:
        return evaluate_candidate(self._base.problem, self._base.optimum, self._protocols)


def indistinguishable(gain: float) -> float:
    """Return by how much [nats] laws may gain less than the best and be as good."""
    return max(thresholds.INDISTINGUISHABLE_NATS, thresholds.INDISTINGUISHABLE_SHARE * gain)


def as_good(tried: list[Tried]) -> list[Tried]:
    """Return the laws that pass and are within the noise of the one that is worth most, that one first."""
    passed = sorted((one for one in tried if not one.failed), key=lambda one: -one.worth)
    return [one for one in passed if one.worth >= passed[0].worth - indistinguishable(passed[0].worth)]


def _why_not(problem: Problem, base: CandidateFit) -> str:
    """Return why no law is looked for; empty where one is."""
    for doubt in check_before_search(problem):
        if doubt.is_grave:
            return f"the recording is in doubt: {doubt.text}"
    if problem.episodes.max() + 1 < MIN_EPISODES:
        return (
            "there is one episode only, so nothing can be held out; record the motion again, or another one"
        )
    regimes = regime_map(problem, base.optimum.u)
    if misfit_by_regime(base.optimum.residual, regimes) <= thresholds.MAX_NOISE_CHI2:
        rest = find_discrepancy(base)
        if rest is None or rest.gain <= thresholds.MIN_CURVE_NATS:
            return "the model leaves only noise; there is no law to be found here"
    return ""


def _why_none(tried: list[Tried]) -> str:
    if not tried:
        return "no law of the grammar gains enough; `vegrip diagnose` says where the model fails"
    best = tried[0]
    if best.broken and best.failed == best.broken:
        return f"the best law, {best.law.equation}, cannot be: {'; '.join(best.broken)}"
    would = f"{best.law.variable.refute} would show it"
    return f"the best law, {best.law.equation}, fails: {', '.join(best.failed)}; {would}"


def screen_laws(screen: Screen, threads: int, report: Report) -> tuple[list[Screened], int]:
    """Return the laws, best first, and how many were looked at.

    First every place and variable with few shapes, then the best of them with every shape, sharpened, and
    beside these a second variable.
    """
    count = 0

    def best(laws: list[Shaped]) -> list[Screened]:
        nonlocal count
        count += len(laws)
        with ThreadPoolExecutor(threads) as pool:
            found = [one for one in pool.map(lambda each: screen.score(*each), laws) if one is not None]
        return sorted(found, key=lambda one: -one.gain)

    def finer(laws: list[Screened]) -> list[Screened]:
        nonlocal count
        with ThreadPoolExecutor(threads) as pool:
            found = list(pool.map(lambda one: sharpened(screen, one), laws))
        count += sum(looks for _, looks in found)
        return sorted((one for one, _ in found), key=lambda one: -one.gain)

    places = [(place, one) for place in LAW_PLACES.values() for one in screen.probes[place.name].variables]
    coarse = best([each for pair in places for each in _laws(screen, *pair, COARSE, is_coarse=True)])
    pairs = _first(coarse, _pair)[:LOOKED_AT_AGAIN]
    looked_at = ", ".join(f"{one.law.variable.name} ({one.law.place.name})" for one in pairs[:4])
    report(f"looks again at {looked_at} ...")
    fine = best([
        each
        for one in pairs
        for each in _laws(screen, one.law.place, one.law.variable, tuple(LAW_SHAPES))
    ])  # fmt: skip
    fine = finer(_first(fine, _key))
    products = best([each for one in fine[:MULTIPLIED] for each in _products(screen, one)])
    return sorted([*fine, *finer(_first(products, _key)[:MULTIPLIED])], key=lambda one: -one.gain), count


def sharpened(screen: Screen, one: Screened) -> tuple[Screened, int]:
    """Return a law where its memory gains most on the screen, and how often it was looked at.

    Its shape is left to the fit: where the base model bends to make up for the law, the screen misplaces it.
    """
    looks, bounds = 0, (MEMORY_TIMES_S[0] / 3.0, 3.0 * MEMORY_TIMES_S[-1])
    for factor in SHARPER if one.law.variable.has_rate else ():
        while bounds[0] <= (tau := one.at["tau"] * factor) <= bounds[1]:
            looks += 1
            new = screen.score(one.law, {**one.at, "tau": tau})
            if new is None or new.gain <= one.gain:
                break
            one = new
    return one, looks


def _laws(
    screen: Screen, place: Place, variable: Variable, shapes: tuple[str, ...], *, is_coarse: bool = False
) -> Iterator[Shaped]:
    if place.name not in variable.places:
        return
    for tau in MEMORY_TIMES_S if variable.has_rate else (1.0,):
        size = screen.size_of(variable, tau)
        if not size > MIN_SCATTER:
            continue
        for shape in (LAW_SHAPES[name] for name in shapes):
            if shape.of_what and variable.name not in shape.of_what:
                continue
            tried = shape.trials[len(shape.trials) // 2 :][:1] if is_coarse else shape.trials
            for s in tried or (1.0,):
                yield Law(place, variable, shape, size), {"s": s, "tau": tau}


def _products(screen: Screen, one: Screened) -> Iterator[Shaped]:
    """Yield a law times each other variable that shares no rate with it."""
    for second in screen.probes[one.law.place.name].variables:
        size = screen.size_of(second, one.at["tau"])
        is_apart = second.name != one.law.variable.name and not second.has_rate
        if is_apart and one.law.place.name in second.places and size > MIN_SCATTER:
            yield dataclasses.replace(one.law, second=second, second_size=size), one.at


def shortlist(found: list[Screened]) -> list[Screened]:
    """Return the laws that are refitted: of one place and variable only a few."""
    alike: Counter[tuple[str, ...]] = Counter()
    chosen = []
    for one in _first(found, _key):
        alike[_pair(one.law)] += 1
        if alike[_pair(one.law)] <= MAX_ALIKE:
            chosen.append(one)
    return chosen[:REFITTED]


def _kin(found: list[Screened], tried: list[Refitted]) -> list[Screened]:
    """Return laws of the best one's place and variable in other shapes, and without its memory."""
    if not tried:
        return []
    best = tried[0].law
    there = {_key(one.law) for one in tried}
    own = (best.variable.name, best.variable.kin)
    near = [one for one in _first(found, _key) if one.law.place == best.place and one.law.second is None]
    return [one for one in near if one.law.variable.name in own and _key(one.law) not in there]


def _key(law: Law) -> tuple[str, ...]:
    return (law.place.name, *law.variables, law.shape.name)


def _pair(law: Law) -> tuple[str, ...]:
    return law.place.name, law.variable.name


def _first(found: list[Screened], key: Callable[[Law], tuple[str, ...]]) -> list[Screened]:
    seen: dict[tuple[str, ...], Screened] = {}
    for one in found:
        seen.setdefault(key(one.law), one)
    return list(seen.values())


def protocols(problem: Problem) -> NDArray[np.int64]:
    """Return the protocol (n,) of each row: episodes alike in their quickest motion and deepest point."""
    m = problem.measured
    depth, speed = m.motion.displacement, np.abs(np.gradient(m.motion.displacement, m.recording.t))
    marks: list[tuple[float, float]] = []
    number = np.zeros(problem.episodes.size, dtype=np.int64)
    for episode in range(int(problem.episodes.max()) + 1):
        rows = problem.episodes == episode
        deep = max(float(np.max(depth[rows])), 1e-9 * problem.depth)
        mark = (math.log(max(float(np.quantile(speed[rows], 0.9)), 1e-9 * problem.depth)), math.log(deep))
        near = [i for i, one in enumerate(marks) if math.dist(one, mark) < SAME_PROTOCOL]
        if not near:
            marks.append(mark)
        number[rows] = near[0] if near else len(marks) - 1
    return number


def spans(base: CandidateFit) -> list[str]:
    """Return for which depths, speeds, loads and times the recording shows anything."""
    shown, t = shown_by(base.problem, base.optimum.u), base.problem.measured.recording.t
    return [
        f"depths up to {1e3 * shown.depth:.3g} mm",
        f"speeds up to {1e3 * shown.speed:.3g} mm/s",
        f"loads up to {shown.load:.3g} N",
        f"{t[-1] - t[0]:.4g} s",
    ]


def digest(recording: Recording) -> str:
    """Return a hash of what was recorded."""
    hashed = hashlib.sha256(np.ascontiguousarray(recording.t).tobytes())
    for name in sorted(recording.columns):
        hashed.update(name.encode() + np.ascontiguousarray(recording.columns[name]).tobytes())
    return hashed.hexdigest()[:16]
