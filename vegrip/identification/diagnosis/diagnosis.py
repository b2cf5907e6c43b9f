"""The verdict: what a model lacks, as far as a recording shows.

* adequate: nothing is missing that this recording can show,
* named: these effects explain the misfit,
* ambiguous: one of these does, and the recording does not show which,
* unexplained: none of the catalogue does; here is where it shows.
"""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar

from vegrip.displayed import Result
from vegrip.host.memory import give_back_memory
from vegrip.identification.blind import FRICTION_TREND, ZERO_JUMP
from vegrip.identification.compare.comparison import Comparison, Repeated
from vegrip.identification.compare.where import Regime
from vegrip.identification.diagnosis import thresholds
from vegrip.identification.diagnosis.acceptance import FORM, OF_EPISODES
from vegrip.identification.diagnosis.candidate_fit import (
    CandidateFit,
    evaluate_candidate,
    held_out_groups,
)
from vegrip.identification.diagnosis.clean import Clean, find_clean
from vegrip.identification.diagnosis.data_checks import (
    Doubt,
    check_before_search,
    check_clocks,
    check_lookalikes,
    other_radius,
    refuse_unusable,
)
from vegrip.identification.diagnosis.discrepancy import OUTER, Discrepancy, find_discrepancy, friction_trend
from vegrip.identification.diagnosis.motions import ONE_MOTION, unproven
from vegrip.identification.diagnosis.search import Search, Step, Tried, are_kin, best_of, left, search_effects
from vegrip.identification.diagnosis.zero_jump import NEAR, Jump, find_jump
from vegrip.identification.fit.fitting import fit, on_one_thread, used_of
from vegrip.identification.fit.given import on_recording
from vegrip.identification.fit.noise import Noise, noise_of
from vegrip.identification.fit.problem import TooManyUnknownsError, Zeros
from vegrip.identification.fit.result import Fit, fit_of
from vegrip.identification.fit.solve import Report
from vegrip.identification.recording import Recording
from vegrip.model import ContactModel
from vegrip.types import Floats

OF_CIRCLE = {"area", "profile"}  # stages of laws of the contact circle, as whose another radius shows
TIMING = "timing"  # the group of effects of a force that is late
TAKEN_OFF = "{}, which is no effect of the pad; what is said holds with the jump taken off"
AS_WELL = "instead of {} it may be that {}: record air before and after every trial"
CHANGED = "instead of {} it may be that the friction changed with time: repeat the slips in another order"
UNFINISHED = "the diagnosis was stopped before its end: this is what had been found until then"
Jumps = Mapping[tuple[str, int], Jump]  # by channel and row


def is_of_circle(one: Tried) -> bool:
    """Whether a candidate is a law of the contact circle."""
    return bool(OF_CIRCLE & {hook.stage for hook in one.candidate.effect.hooks})


def are_alike(one: Tried, other: Tried) -> bool:
    """Whether two candidates do nearly the same: between them only the form of a law decides."""
    a, b = one.change, other.change
    cosine = float(a @ b) / math.sqrt(max(float(a @ a) * float(b @ b), 1e-300))
    apart = abs(one.verdict.gain - other.verdict.gain)
    most = min(thresholds.FORM_NATS, thresholds.FORM_SHARE * one.verdict.gain)
    return cosine > thresholds.SAME_CHANGE_COSINE and apart <= most


def may_stand_beside(own: Tried, other: Tried) -> bool:
    """Whether a rival counts that explains as much as what was accepted: it passes the gates.

    Whether episodes that were held out agree says that something is there, not which of two that are known to
    resemble each other: a parameter that one episode alone determines lets the right law fail without it.
    """
    failed = set(other.verdict.failed)
    return not failed or (
        failed <= set(OF_EPISODES) and are_kin(own.candidate.effect, other.candidate.effect)
    )


@dataclass(frozen=True)
class Left:
    """What is left: chi-square per regime, errors of the first and of the last model over the noise."""

    misfit: float
    first: float
    error: float

    @property
    def is_explained(self) -> bool:
        first, last = (one**2 - 1.0 for one in (self.first, self.error))
        return last <= thresholds.MAX_EXCESS_SHARE * first and self.error <= thresholds.MAX_ERROR


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis(Result):
    """What a model lacks, as far as a recording shows; with the search behind it.

    Attributes:
        verdict: adequate, named, ambiguous or unexplained.
        named: effects that explain the misfit and that nothing else could stand for.
        suggested: the same where the recording shows one motion alone, which proves nothing.
        indistinguishable: sets of effects of which one explains the misfit.
        effects: what was tried, best first, each with its gains [nats], error and outcome.
        error: before and after, in units of the noise.
        unexplained: the curve over one variable that takes most of what is left; None of noise.
        where: regimes in which the first model fails.
        where_after: the same of the model with everything that was accepted.
        repeated: what of the misfit recurs where a motion is repeated.
        holds: the range in which the first model leaves only noise.
        doubts: what is wrong with the recording; a grave one forbids names.
        model: with the effects that were accepted.
        result: its fit.
        start: the fit of the model that was given, or the paper's.
        search: every step.

    """

    _display: ClassVar[str] = "diagnosis"

    start: Fit  # the fit of the model that was given, or the paper's
    search: Search  # every step
    # what is wrong with the recording; a grave one forbids names
    doubts: list[Doubt] = field(default_factory=list)
    unproven: str = ""  # why what was accepted is no more than a suggestion
    has_one_motion: bool = (
        False  # of which one thing may be distinguished from another, and nothing be proven
    )
    jumps: Jumps = field(default_factory=dict)  # which were taken off the recording
    # accepted effect -> the jump that fits better in its place, beside all others
    rival_jumps: Mapping[str, Jump] = field(default_factory=dict)

    @property
    def is_unfinished(self) -> bool:
        """Whether an interrupt ended it before its end."""
        return any(one.startswith(UNFINISHED) for one in (self.unproven, *(d.text for d in self.doubts)))

    def or_by_episode(self, own: "Diagnosis") -> "Diagnosis":
        """Return ``own``, in which each episode has its law, where it names what explains this recording.

        Where the laws alone explain it, no effect is missing but the same place: that is said.
        """
        said = Doubt(own.start.laws_note)
        gain = own.search.last.evidence - self.search.last.evidence
        if own.verdict in ("named", "ambiguous") and gain > thresholds.MIN_LATER_GAIN_NATS:
            return replace(own, doubts=[*own.doubts, said])
        return replace(self, doubts=[*self.doubts, said]) if own.verdict == "adequate" else self

    @cached_property
    def jump(self) -> Jump | None:
        """The jump of a zero that explains more than the effect that was taken, or most of what is left.

        It pays for its place; another size of a jump that was taken off does not.
        """
        for step in self.search.steps:
            gain = step.taken.verdict.gain if step.taken is not None else 0.0
            rest = left(step.base) if step.taken is None else 0.0
            least = gain + self.search.within(gain) + thresholds.MOST_OF_LEFT_SHARE * rest
            if (jump := find_jump(step.base, least)) is None:
                continue
            if near := [k for k in self.jumps if k[0] == jump.channel and abs(k[1] - jump.row) <= NEAR]:
                return replace(jump, row=near[0][1])
            is_more = jump.gain > max(gain + thresholds.MIN_SHIFT_NATS, least)
            if is_more and not self._is_change(step.base, jump):
                return jump
        return None

    def _is_change(self, base: CandidateFit, jump: Jump) -> bool:
        """Whether a stiffness that changes at one place explains more than ``base`` with a jump."""
        if self.verdict != "unexplained" or self.unexplained is None or self.unexplained.change is None:
            return False
        return self.search.first.evidence + self.unexplained.change.gain > base.evidence + jump.gain

    @cached_property
    def other_radius(self) -> float | None:
        """Radius of the tip [m] that explains as much as an effect of the contact circle that was taken.

        Beside what was accepted, or else where it was taken.
        """
        for step in (*self.search.contests.values(), *self.search.steps):
            taken = step.taken
            if taken is not None and is_of_circle(taken):
                radius, gain = other_radius(step.base)
                if gain >= taken.verdict.gain - self.search.within(taken.verdict.gain):
                    return radius
        return None

    def or_of_radius(self, own: "Diagnosis") -> "Diagnosis":
        """Return ``own``, of another radius, where with that nothing of the contact circle is missing."""
        if own.verdict == "unexplained" or any(map(is_of_circle, own.search.accepted)):
            return self
        stated, found = (1e3 * one.start.problem.model.tip_radius for one in (self, own))
        said = (
            f"the radius of the tip is stated as {stated:.3g} mm, and {found:.3g} mm explains what another "
            "law of the contact circle would: measure it; what is said holds for the latter"
        )
        return replace(own, doubts=[*own.doubts, Doubt(said)])

    @property
    def named(self) -> list[str]:
        """Effects that explain the misfit and that nothing else could stand for."""
        return self._outright if not self.has_one_motion else []

    @property
    def suggested(self) -> list[str]:
        """The same where the recording shows one motion, which is no proof of what it does not separate."""
        return self._outright if self.has_one_motion else []

    @property
    def _outright(self) -> list[str]:
        if self.verdict not in ("named", "ambiguous"):
            return []
        unsure = {name for group in self.indistinguishable for name in group}
        return [one.candidate.name for one in self.search.accepted if one.candidate.name not in unsure]

    @property
    def verdict(self) -> str:
        """adequate, named, ambiguous or unexplained."""
        s = self.search
        if s.is_given_up:
            return "unexplained"
        rest = Left(s.misfit(s.last), s.first.error, s.last.error)
        return self.verdict_of(len(s.accepted), rest, is_ambiguous=bool(self.indistinguishable))

    def verdict_of(self, count: int, left: "Left", *, is_ambiguous: bool) -> str:
        """Return the verdict where so many effects leave that much."""
        depends = left.misfit > thresholds.MAX_NOISE_CHI2  # on the regime
        if not count:
            rest = self._rest
            is_left = rest is not None and (depends or rest.gain > thresholds.MIN_CURVE_NATS)
            return "unexplained" if is_left else "adequate"
        if depends and not self._is_sufficient(count):
            return "unexplained"
        most = thresholds.MAX_ERROR_BY_REGIME if depends else thresholds.MAX_ERROR_EVEN
        if self.unproven or (left.error > most and not left.is_explained):
            return "unexplained"
        return "ambiguous" if is_ambiguous else "named"

    def _is_sufficient(self, count: int) -> bool:
        if count >= thresholds.PATCHWORK_EFFECTS:
            return False
        s, rest = self.search, self._rest
        return rest is None or rest.gain <= thresholds.MIN_CURVE_SHARE * (s.last.evidence - s.first.evidence)

    @cached_property
    def _rest(self) -> Discrepancy | None:
        return find_discrepancy(self.search.last)

    @cached_property
    def groups(self) -> Floats:
        return held_out_groups(self.start.problem)

    @cached_property
    def indistinguishable(self) -> list[list[str]]:
        """Sets of effects that explain the same equally well."""
        sets = [[name, general] for general, names in self.search.general.items() for name in names]
        for name, contest in self.search.contests.items():
            own, *others = contest.tried
            close = [
                one.candidate.name
                for one in others
                if may_stand_beside(own, one)
                and (
                    own.verdict.gain - one.verdict.gain <= self.search.within(own.verdict.gain)
                    or are_alike(own, one)
                )
            ]
            close += [ZERO_JUMP] * (name in self.rival_jumps) + [FRICTION_TREND] * self._is_trend(contest)
            if close:
                sets.append([name, *close])
        return sets

    def _is_trend(self, contest: Step) -> bool:
        """Return whether a friction that changes slowly with time explains as much as the one accepted."""
        own = contest.tried[0]
        if "normal_force" in own.candidate.effect.channels:
            return False
        least = own.verdict.gain - self.search.within(own.verdict.gain)
        return friction_trend(contest.base) >= least

    @cached_property
    def unexplained(self) -> Discrepancy | None:
        """The curve over one variable that takes most of what is left; None when noise is left.

        Where nothing is named, of what the first model leaves: a wrong effect has only bent that, but not
        what depends on a temperature or an age that it does not know.
        """
        s, rest = self.search, self._rest
        if self.verdict == "unexplained" and (rest is None or rest.variable not in OUTER):
            return find_discrepancy(s.first, with_changes=True)
        return rest if s.misfit(s.last) > thresholds.MAX_NOISE_CHI2 else None

    @cached_property
    def _start(self) -> Comparison:
        return Comparison(self.start.problem, self.start.optimum.u, fitted=True)

    @cached_property
    def where(self) -> list[Regime]:
        return self._start.where

    @cached_property
    def repeated(self) -> Repeated | None:
        return self._start.repeated

    @cached_property
    def where_after(self) -> list[Regime]:
        """Where the model with everything that was accepted fails."""
        last = self.search.last
        after = Comparison(last.problem, last.optimum.u, fitted=True)
        return after.where if self.search.accepted else self.where

    @cached_property
    def holds(self) -> Clean | None:
        return None if self.verdict == "adequate" else find_clean(self.search.first)

    @cached_property
    def result(self) -> Fit:
        last = self.search.last
        return fit_of(last.problem, last.optimum)

    @property
    def model(self) -> ContactModel:
        return self.result.model

    @property
    def error(self) -> dict[str, float]:
        return {"before": self.search.first.error, "after": self.search.last.error, "noise_floor": 1.0}

    @property
    def effects(self) -> list[dict[str, Any]]:
        """What was tried, best first: the accepted ones, then the others step by step."""
        taken = {one.candidate.name for one in self.search.accepted}
        by_name: dict[str, dict[str, Any]] = {}
        for one in [one for one in self.rounds if one["taken"] and one["name"] in taken] + self.rounds:
            by_name.setdefault(one["name"], one)
        return list(by_name.values())

    @cached_property
    def rounds(self) -> list[dict[str, Any]]:
        """What was tried, round by round."""
        return [
            self._tried_row(one, step) | {"round": number}
            for number, step in enumerate(self.search.steps, 1)
            for one in step.tried
        ]

    def in_si(self) -> dict[str, tuple[float, str]]:
        """Return the scaled parameters of what was accepted, in SI with their units."""
        last = self.result
        symbols = [p.symbol for one in self.search.accepted for p in one.candidate.effect.parameters]
        return {name: si for name in symbols if (si := last.in_si(name)) is not None}

    def _tried_row(self, one: Tried, step: Step) -> dict[str, Any]:
        gains = {other.candidate.name: other.verdict.gain for other in step.tried if other.verdict.is_passed}
        best = max([0.0, *gains.values()])
        weights = {name: math.exp(gain - best) for name, gain in gains.items()}
        total = sum(weights.values()) + math.exp(-best)
        return {
            "name": one.candidate.name,
            "probability": weights.get(one.candidate.name, 0.0) / total,
            "error_after": one.fitted.error,
            "heldout_gain": one.verdict.heldout,
            "evidence_gain": one.verdict.gain,
            "failed": list(one.verdict.failed),
            "taken": one is step.taken,
            "outcome": self._outcome(one, step),
            "parameters": {p.symbol: one.fitted.value(p.symbol) for p in one.candidate.effect.parameters},
        }

    def _outcome(self, one: Tried, step: Step) -> str:
        is_behind = one.fitted.optimum.is_given_up and step.taken is not None
        if one.verdict.failed and not is_behind:
            return f"fails: {', '.join(one.verdict.failed)}"
        if one is step.taken:
            if one.candidate.name in self.search.dropped:
                return "taken, and not needed beside the others"
            why = "a suggestion" if self.unproven or one.candidate.name in self.suggested else "not enough"
            is_sure = self.verdict != "unexplained" and one.candidate.name not in self.suggested
            return "taken" if is_sure else f"taken, {why}"
        if step.taken is not None:
            return f"{'given up' if is_behind else 'passes'}, {step.taken.candidate.name} gains more"
        if any(doubt.is_grave for doubt in self.doubts):
            return "passes, the recording is in doubt"
        return f"passes, {len(self.search.accepted)} are taken already"

    def as_dict(
        self, experiment: Mapping[str, Any] | None = None, certainty: Mapping[str, Any] | None = None
    ) -> dict[str, Any]:
        """Return what ``--json`` prints.

        ``experiment`` and ``certainty`` are the answers of
        :func:`~vegrip.identification.experiment.design.next_experiment` and
        :func:`~vegrip.identification.diagnosis.certainty.certainty_of` to this diagnosis: they build on
        diagnoses, not the other way round.
        """
        s, noise = self.search, thresholds.MAX_NOISE_CHI2
        return {
            "recording": self.start.problem.measured.recording.name,
            "verdict": self.verdict,
            "named": self.named,
            "effects": self.effects,
            "rounds": self.rounds,
            "indistinguishable": self.indistinguishable,
            "error": self.error,
            "si": {name: {"value": value, "unit": unit} for name, (value, unit) in self.in_si().items()},
            "misfit": {"before": s.misfit(s.first), "after": s.misfit(s.last), "noise": noise},
            "where": [asdict(one) for one in self.where],
            "where_after": [asdict(one) for one in self.where_after],
            "repeated": self.repeated.as_dict() if self.repeated is not None else None,
            "holds": self.holds.as_dict() if self.holds is not None else None,
            "unexplained": self.unexplained.as_dict() if self.unexplained is not None else None,
            "experiment": experiment,
            "certainty": certainty,
            "out_of_sight": s.out_of_sight,
            "suggestion": self.unproven or None,
            "doubts": [doubt.text for doubt in self.doubts] + [self.unproven] * bool(self.unproven),
            "noise": dict(self.start.problem.measured.noise.source),
            "warnings": self.result.warnings(advise=False),
        }


@on_recording
@on_one_thread
def diagnose(
    recording: Recording,
    model: ContactModel | None = None,
    *,
    noise: Noise | None = None,
    zeros: Zeros = "recording",
    laws: Zeros = "recording",
    most: int = 4,
    threads: int = 2,
    report: Report = lambda _: None,
    can_stop: bool = False,
) -> Diagnosis:
    """Say what ``model`` (the paper's when not given) lacks to explain ``recording``.

    The model is refitted first: a wrong stiffness is no missing effect. ``most`` limits how many effects are
    named together, ``threads`` how many candidates are fitted at a time. Where nothing explains the
    recording, each episode is tried with zeros of its own, and with laws of its own, as several places or
    specimens may have been pressed; the laws are more, and are believed where zeros explain less. Neither is
    tried of more episodes than memory holds. ``can_stop``: an interrupt (Ctrl-C) once the model is fitted
    gives what was found until then, said to be unfinished; nothing is named for sure.
    """

    def started(zeros: Zeros, laws: Zeros, radius: float | None = None) -> Fit:
        give_back_memory(len(recording))
        of, tip = (recording, model) if radius is None else _of_radius(recording, model, radius)
        return fit(of, tip, noise=known, zeros=zeros, laws=laws, report=report)

    jumps: Jumps = {}

    def diagnosed(start: Fit, *, is_repeat: bool = True) -> Diagnosis:
        may_stop = can_stop and not is_repeat
        return _diagnosed(start, most, threads, report, jumps, is_repeat=is_repeat, can_stop=may_stop)

    recording = used_of(recording, zeros, laws)
    known = noise or noise_of(recording)
    start = started(zeros, laws)
    refuse_unusable(recording, start.problem.measured)
    found = diagnosed(start, is_repeat=False)
    if found.search.is_stopped or any(doubt.is_grave for doubt in found.doubts):
        return found

    def without_faults(found: Diagnosis) -> Diagnosis:
        nonlocal recording, jumps, known
        for _ in range(thresholds.MAX_JUMPS):
            if (jump := found.jump) is None:
                break
            report("tries a jump of a zero")
            before = recording, jumps, known
            rest = jump.removed(recording)
            recording, jumps, known = rest, _with_jump(jumps, jump), noise or noise_of(rest)
            own = diagnosed(started(zeros, laws))
            if own.verdict == "unexplained":
                recording, jumps, known = before
                break
            found = own
        if found.other_radius is not None:
            report("tries another radius of the tip")
            found = found.or_of_radius(diagnosed(started(zeros, laws, found.other_radius)))
        return found

    def by_episode(found: Diagnosis) -> Diagnosis:
        def gain_of(own: Fit) -> float:
            with_it = evaluate_candidate(own.problem, own.optimum, found.groups)
            return with_it.evidence - found.search.first.evidence

        try:
            by_law = started(zeros, "episode")
        except TooManyUnknownsError:
            return found
        most_of_left = thresholds.MOST_OF_LEFT_SHARE * left(found.search.last)
        gain, least = gain_of(by_law), max(thresholds.MIN_LATER_GAIN_NATS, most_of_left)
        if zeros == "recording" and gain_of(by_zero := started("episode", laws)) > least:
            report("tries zeros of each episode")
            own = diagnosed(by_zero)
            evidence = own.search.last.evidence - found.search.first.evidence
            if own.verdict != "unexplained" and evidence > gain:
                return replace(own, doubts=[*own.doubts, Doubt(by_zero.zeros_note)])
        if gain < least:
            return found
        report("tries a law of each episode")
        return found.or_by_episode(diagnosed(by_law))

    try:
        found = without_faults(found)
        if laws == "recording" and start.problem.episodes.any() and found.verdict == "unexplained":
            return by_episode(found)
        return found
    except KeyboardInterrupt:
        if not can_stop:
            raise
        return replace(found, doubts=[*found.doubts, Doubt(UNFINISHED)])


def _of_radius(
    recording: Recording, model: ContactModel | None, radius: float
) -> tuple[Recording, ContactModel | None]:
    of = replace(recording, fingertip=replace(recording.fingertip, radius=radius))
    return of, model if model is None else replace(model, tip_radius=radius)


def _with_jump(jumps: Jumps, jump: Jump) -> Jumps:
    at = jump.channel, jump.row
    size = jump.size + (jumps[at].size if at in jumps else 0.0)
    return {**jumps, at: replace(jump, size=size)}


def doubt_timing(found: Search) -> list[Doubt]:
    """Return the doubt that the force is late, where that gains something beside what was accepted."""
    late = [one for one in found.steps[-1].tried if one.candidate.effect.group == TIMING]
    best = max(late, key=lambda one: one.verdict.gain, default=None)
    if best is None or best.verdict.is_passed or best.verdict.gain < thresholds.MIN_SHIFT_NATS:
        return []
    by = 1e3 * best.fitted.value(best.candidate.effect.parameters[0].symbol)
    return [
        Doubt(
            f"the force may be {by:.2g} ms late as well: {best.candidate.name} would gain "
            f"{best.verdict.gain:.0f} nats, too little beside the others to be named; ask for the filter "
            "of its sensor, or record quicker strokes"
        )
    ]


def doubt_form(found: Search) -> list[Doubt]:
    """Return the doubt about what would be accepted, if what is accepted were sure of its form."""
    beside = " and ".join(one.candidate.name for one in found.accepted)
    return [
        Doubt(
            f"{one.candidate.name} would gain {one.verdict.gain:.0f} nats beside {beside}, but so would "
            f"another form of {beside} in pulls, twists or the radius; vegrip experiment separates them"
        )
        for one in found.steps[-1].tried
        if one.verdict.failed == (FORM,)
    ]


def _diagnosed(
    start: Fit,
    most: int,
    threads: int,
    report: Report,
    jumps: Jumps,
    *,
    is_repeat: bool,
    can_stop: bool,
) -> Diagnosis:
    start.problem.threads = threads
    doubts = [*check_before_search(start.problem), *(Doubt(TAKEN_OFF.format(one)) for one in jumps.values())]
    is_unreliable = any(doubt.is_grave for doubt in doubts)
    asked = 0 if is_unreliable else most
    found = search_effects(
        start.problem,
        start.optimum,
        most=asked,
        threads=threads,
        report=report,
        is_repeat=is_repeat,
        can_stop=can_stop,
    )
    if found.is_stopped:
        why = UNFINISHED if found.accepted else ""
        best = f"; {best_of(found.refitted)}, uncontested" if found.refitted else ""
        more = [] if why else [Doubt(UNFINISHED + best)]
        return Diagnosis(start, found, [*doubts, *more], unproven=why, jumps=jumps)
    if found.is_given_up:
        return Diagnosis(start, found, doubts)
    if not is_unreliable and (found.accepted or found.misfit(found.first) > thresholds.MAX_NOISE_CHI2):
        late = (one for one in found.contests.values() if one.tried[0].candidate.effect.group == TIMING)
        timed = next(late, found.steps[0])  # which the clocks have to beat beside the others
        doubts += check_clocks(timed.base, max((one.verdict.gain for one in timed.tried), default=0.0))
    if any(doubt.is_grave for doubt in doubts):
        return Diagnosis(start, found.untaken, doubts)
    names = [one.candidate.name for one in found.accepted]
    values = {symbol: found.last.value(symbol) for symbol in found.last.problem.symbols}
    doubts += check_lookalikes(names, values, start.problem.model.tip_radius)
    if found.accepted:
        doubts += [*doubt_timing(found), *doubt_form(found)]
    said = Diagnosis(start, found, doubts, jumps=jumps)
    if not found.accepted or said.verdict == "unexplained":
        return said
    contests = {name: (one.base, one.tried[0].fitted) for name, one in found.contests.items()}
    instead = {name: find_jump(one.base, one.tried[0].verdict.gain) for name, one in found.contests.items()}
    rivals = {name: jump for name, jump in instead.items() if jump is not None}
    doubts += [Doubt(AS_WELL.format(name, jump)) for name, jump in rivals.items()]
    doubts += [Doubt(CHANGED.format(one[0])) for one in said.indistinguishable if FRICTION_TREND in one]
    if rivals:
        said = replace(said, rival_jumps=rivals)  # anew, for the old one knows its verdict
    why = unproven(start.problem, contests)
    gains_of = {name: one.tried[0].verdict.gain for name, one in found.contests.items()}
    if why == ONE_MOTION and max(gains_of, key=gains_of.__getitem__) not in said.named:  # a set stands
        return replace(said, doubts=[*doubts, Doubt(why)], has_one_motion=True)
    return replace(said, unproven=why) if why else said  # which knows what is left
