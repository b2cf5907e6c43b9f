"""The choice: every item of the menu at its best amplitudes, the best of them, and whether it will do."""

import math
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from vegrip.effects import effect
from vegrip.errors import UsageError
from vegrip.identification.blind import FRICTION_TREND, ZERO_JUMP
from vegrip.identification.diagnosis.diagnosis import Diagnosis
from vegrip.identification.experiment import hypotheses
from vegrip.identification.experiment.design_space import (
    MENU,
    Item,
    Rig,
    RigLimits,
    complete_limits,
    limits_of,
)
from vegrip.identification.fit.preprocess import MIN_FIT_ROWS
from vegrip.identification.fit.result import fit_of
from vegrip.identification.fit.solve import Report
from vegrip.identification.simulate import Protocol, simulate

SUFFICIENT_NATS = 20.0  # [nats] with which an experiment decides in 99 of 100 cases
MIN_SEPARATION_NATS = 5.0  # [nats] below which it decides nothing
FAINT = 1.0  # [nats] from which repeating helps; below it, it is mostly errors of the model that add up
MAX_REPETITIONS = 6  # repetitions
REFITTED = 8  # items that are refitted in full,
QUICK_REFITTED = 3  # or so many
AMPLITUDE_FACTORS = (1.25, 0.8, 1.1, 0.9)  # factors tried on each amplitude, until one is better
WITHIN = ("depth", "stroke")  # amplitudes that are shares
DURATION_COST = 0.05  # of the score that the whole allowed duration costs


@dataclass(frozen=True)
class Planned:
    """An experiment: an item with its amplitudes, how often, and what it is expected to show."""

    item: str
    amplitudes: Mapping[str, float]
    protocol: Protocol
    separation: hypotheses.Separation
    times: int = 1
    refitted: bool = False  # the separation is that of full refits, else linear

    @property
    def nats(self) -> float:
        return self.times * self.separation.nats

    @property
    def whole(self) -> Protocol:
        return self.protocol.repeated(self.times)

    def as_dict(self) -> dict[str, Any]:
        return {
            "item": self.item,
            "nats": self.nats,
            "hardest": list(self.separation.hardest),
            "pairs": {
                " against ".join(pair): self.times * nats for pair, nats in self.separation.pairs.items()
            },
            "duration": self.whole.duration,
            "repetitions": self.times,
            "refitted": self.refitted,
            "amplitudes": dict(self.amplitudes),
        }


@dataclass(frozen=True, eq=False)
class Design:
    """Experiments that were weighed for a contest, and the one to do."""

    contest: hypotheses.Hypotheses  # the hypotheses to separate
    limits: RigLimits  # of the rig
    depth: float  # greatest depth [m] that force and depth allow
    tried: tuple[Planned, ...]  # each item at its best, best first
    left_out: Mapping[str, str] = field(default_factory=dict)  # item -> why it was not tried
    # in a simulated experiment of the best kind, nats by (truth, rival)
    achieved: Mapping[tuple[str, str], float] = field(default_factory=dict)

    @property
    def best(self) -> Planned | None:
        """The experiment to do next; None when none on the menu would decide."""
        first = self.tried[0] if self.tried else None
        return first if first is not None and first.refitted and first.nats >= MIN_SEPARATION_NATS else None

    @property
    def advice(self) -> str:
        """What to do, in a sentence or two."""
        between = " and ".join(self.contest.names)
        if self.best is not None:
            nats, seconds = self.best.nats, self.best.whole.duration
            odds = f"expected to distinguish {between} by {nats:.0f} nats in {seconds:.0f} s"
            return (
                f"{self.best.item}: {odds} (decides with probability {hypotheses.chance_to_decide(nats):.2f})"
            )
        most = f" (at most {self.tried[0].nats:.1f} nats, {self.tried[0].item})" if self.tried else ""
        answer = [effect(n).experiment for n in self.contest.names if n != hypotheses.NO_EFFECT]
        hints = "; ".join(dict.fromkeys(text for text in answer if text))
        return (
            f"no experiment on the menu distinguishes {between} within these limits{most}; what may: {hints}"
        )

    def as_dict(self) -> dict[str, Any]:
        """Return what ``--json`` prints, and the ``experiment`` of a diagnosis."""
        return {
            "between": list(self.contest.names),
            "assumed": list(self.contest.assumed),
            "separates": self.best is not None,
            "advice": self.advice,
            "best": self.best.as_dict() if self.best is not None else None,
            "chance": hypotheses.chance_to_decide(self.best.nats) if self.best is not None else 0.0,
            "achieved": {" against ".join(pair): nats for pair, nats in self.achieved.items()},
            "items": [planned.as_dict() for planned in self.tried],
            "left_out": dict(self.left_out),
            "limits": asdict(self.limits) | {"depth_for_force": self.depth},
        }


def design(
    contest: hypotheses.Hypotheses,
    limits: RigLimits,
    *,
    is_thorough: bool = True,
    report: Report = lambda _: None,
) -> Design:
    """Find the experiment that separates the contestants by enough nats in the shortest time.

    Where none does, the one that comes closest. The menu is gone through with linear refits, the most
    promising ones are refitted in full. ``is_thorough`` looks at more of them, searches on from the
    amplitudes that the menu begins with, and simulates the best one, noise and all.
    """
    rig = rig_of(contest, limits)
    left_out: dict[str, str] = {}
    least = MIN_FIT_ROWS / min(AMPLITUDE_FACTORS)
    jobs: list[tuple[Item, Rig, Mapping[str, float]]] = []
    for item in MENU:
        own, reason = suited_rig(item, contest, limits, rig)
        possible = [(a, item.protocol(own, a)) for a in item.choices()]
        brief = [(a, made) for a, made in possible if made.duration <= limits.duration]
        fits = [a for a, made in brief if made.recorded * own.rate >= least]
        if reason or not fits:
            why = "it has too few samples" if brief else f"it takes longer than {limits.duration:g} s"
            left_out[item.name] = reason or why
        jobs += [(item, own, a) for a in fits if not reason]

    if not jobs:
        return Design(contest, limits, rig.depth, (), left_out)

    def plan(job: tuple[Item, Rig, Mapping[str, float]]) -> Planned:
        item, own, amplitudes = job
        protocol = item.protocol(own, amplitudes)
        return Planned(item.name, amplitudes, protocol, hypotheses.expected_separation(contest, protocol))

    def score(one: Planned) -> float:
        return _score(one, limits)

    with ThreadPoolExecutor(2) as pool:
        report(f"{len(jobs)} experiments on the menu")
        scanned = sorted(pool.map(plan, jobs), key=score, reverse=True)
        chosen = _promising(scanned)[: REFITTED if is_thorough else QUICK_REFITTED]
        report(f"refits for {len(chosen)} of them")
        refitted = list(pool.map(lambda one: _refitted(one, contest), chosen))
    best = max((_often(one, limits) for one in refitted), key=score)
    if is_thorough:
        report(f"amplitudes of {best.item}")
        refitted.append(_polished(replace(best, times=1), contest, limits, rig))
    ranked = sorted((_often(one, limits) for one in refitted), key=score, reverse=True)
    tried = _one_each([*ranked, *scanned])
    made = Design(contest, limits, rig.depth, tuple(tried), left_out)
    if is_thorough and made.best is not None:
        report("simulates the best one")
        made = replace(made, achieved=hypotheses.measure_separation(contest, made.best.whole, seed=1))
    return made


def _promising(scanned: list[Planned]) -> list[Planned]:
    return [one for one in _one_each(scanned) if one.nats >= FAINT] or [scanned[0]]


def _refitted(planned: Planned, contest: hypotheses.Hypotheses) -> Planned:
    return replace(
        planned,
        separation=hypotheses.expected_separation(contest, planned.protocol, refit=True),
        refitted=True,
    )


def _one_each(ranked: Iterable[Planned]) -> list[Planned]:
    """Return the first of each item."""
    first: dict[str, Planned] = {}
    for one in ranked:
        first.setdefault(one.item, one)
    return list(first.values())


def rig_of(contest: hypotheses.Hypotheses, limits: RigLimits) -> Rig:
    """Return what the menu is scaled to, its depth such that no contestant's force passes the limit.

    Raises:
        UsageError: a limit that has to be known is not.

    """
    for name in ("depth", "force", "speed"):
        if not getattr(limits, name) > 0.0:
            raise UsageError(f"the greatest {name} is not known; give it with the limits")
    friction = max(m.values["mu"].value if "mu" in m.values else 0.7 for m in contest.models.values())
    rig = Rig(limits.depth, limits.speed, contest.rate, limits.pause, friction)
    return replace(rig, depth=_depth_for(contest, rig, limits.force))


def _depth_for(contest: hypotheses.Hypotheses, rig: Rig, force: float) -> float:
    """Return the greatest depth [m] at which the force of a fast press stays below ``force`` [N]."""
    low, high = 0.0, rig.depth
    if _force_at(contest, rig, high) <= force:
        return high
    for _ in range(12):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _force_at(contest, rig, middle) <= force else (low, middle)
    return low if low > 0.0 else high


def _force_at(contest: hypotheses.Hypotheses, rig: Rig, depth: float) -> float:
    own = replace(rig, depth=depth)
    protocol = Protocol("press", (own.press(depth),), 0.0)
    exact = {"normal_force": 0.0, "displacement": 0.0}
    return max(
        float(simulate(model, protocol, sensors=exact, rate=rig.rate).columns["normal_force"].max())
        for model in contest.models.values()
    )


def suited_rig(item: Item, contest: hypotheses.Hypotheses, limits: RigLimits, rig: Rig) -> tuple[Rig, str]:
    """Return the rig for an item, or why it cannot be done."""
    if not item.has_tangential_load:
        return rig, ""
    if not contest.has_tangential_load:
        return rig, "no tangential force is measured"
    if not limits.tangential_force > 0.0:
        return rig, "the rig does not pull"
    allowed = limits.tangential_force / rig.friction
    if item.name.startswith("twists") and not limits.torque > 0.0:
        return rig, "the rig does not twist"
    return replace(rig, depth=_depth_for(contest, rig, min(allowed, limits.force))), ""


def _score(planned: Planned, limits: RigLimits) -> float:
    reached = min(planned.nats / SUFFICIENT_NATS, 1.0)
    return reached - DURATION_COST * planned.whole.duration / limits.duration


def _polished(planned: Planned, contest: hypotheses.Hypotheses, limits: RigLimits, rig: Rig) -> Planned:
    item = next(item for item in MENU if item.name == planned.item)
    own, _ = suited_rig(item, contest, limits, rig)
    best = planned
    for name in item.levels:
        for factor in AMPLITUDE_FACTORS:
            amplitudes = {**best.amplitudes, name: best.amplitudes[name] * factor}
            protocol = item.protocol(own, amplitudes)
            if protocol.duration > limits.duration or (name in WITHIN and amplitudes[name] > 1.0):
                continue
            tried = _refitted(replace(best, amplitudes=amplitudes, protocol=protocol), contest)
            if _score(tried, limits) > _score(best, limits):
                best = tried
                break
    return best


def _often(planned: Planned, limits: RigLimits) -> Planned:
    """Repeat an experiment that separates, but not enough, as often as the time allows."""
    nats = planned.separation.nats
    if not FAINT <= nats < SUFFICIENT_NATS:
        return planned
    once = planned.protocol.duration + planned.protocol.pause
    room = int((limits.duration + planned.protocol.pause) // once)
    times = int(np.clip(math.ceil(SUFFICIENT_NATS / nats), 1, min(room, MAX_REPETITIONS)))
    return replace(planned, times=times)


def hypotheses_after(found: Diagnosis) -> hypotheses.Hypotheses | None:
    """Return the first set of effects that ``found`` could not distinguish; None where there is none."""
    sets = [
        [name for name in names if name not in (ZERO_JUMP, FRICTION_TREND)]
        for names in found.indistinguishable
    ]
    names = next((names for names in sets if len(names) > 1), None)
    if names is None:
        return None
    fits = {one.candidate.name: one.fitted for one in found.search.contests[names[0]].tried}
    models = {name: fit_of(fits[name].problem, fits[name].complete).model for name in names}
    measured = found.start.problem.measured
    return hypotheses.Hypotheses(models, (), hypotheses.sensors_of(measured), hypotheses.rate_of(measured))


def next_experiment(found: Diagnosis) -> dict[str, Any] | None:
    """Return what a diagnosis says of the next experiment: a quick look at the menu, within what was done."""
    contest = hypotheses_after(found)
    if contest is None:
        return None
    limits = complete_limits(RigLimits(), limits_of(found.start.problem.measured.recording))
    made = design(contest, limits, is_thorough=False).as_dict()
    effects = {e.name: e for model in contest.models.values() for e in model.effects}
    answer = {name: effects[name].experiment for name in contest.names if effects[name].experiment}
    return {**made, "suggestions": answer}
