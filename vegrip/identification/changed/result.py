"""What changed, in numbers and in words for who maintains the hand, and what would show more."""

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, ClassVar, Final

import numpy as np

from vegrip.displayed import Result
from vegrip.effects import effect
from vegrip.identification.changed.choice import Choice, Set, chance
from vegrip.identification.changed.pair import Pair
from vegrip.identification.compare.where import format_amount
from vegrip.model import ContactModel

SIDE_95 = 1.96  # standard errors to either side of an interval of 95 %
VAGUE_PERCENT = 100.0  # from which a value that may have changed so much is not said to be unchanged
COUNTS = ("none", "one", "two", "three", "four")
ALONE = "it shows a gain alone"
DEPTHS = "press to several depths, from a tenth of the deepest on"
HOLD = "press fast, and hold for several times of relaxation"
SLIDE = "pull and twist until it slips, at two loads"
KNOWN: Final = {
    "gain_normal_force": ("gain of the force sensor", f"lay a known weight on the tip: {ALONE}"),
    "gain_tangential_force": ("gain of the pull", f"hang a known weight sideways on the tip: {ALONE}"),
    "gain_torque_z": ("gain of the torque", f"hang a known weight on a lever at the tip: {ALONE}"),
    "gain_contact_radius": ("gain of the contact radius", "look at a disc of known radius"),
    "tip_radius": ("radius of the tip", "measure the radius of the tip with a gauge"),
    "zero_normal_force": ("zero of the force", "record ten seconds in the air before the first touch"),
    "zero_displacement": ("zero of the displacement", f"approach slowly out of the air, and {DEPTHS}"),
    "K": ("stiffness", DEPTHS),
    "p": ("exponent of the stiffness", DEPTHS),
    "c1": ("share that relaxes", HOLD),
    "nu1": ("rate of relaxation", HOLD),
    "mu": ("friction", SLIDE),
    "k0": ("pressure exponent", SLIDE),
}
"""What a value is called, and the experiment that shows it; first the one that needs no other."""


def label_of(name: str, model: ContactModel) -> str:
    return KNOWN[name][0] if name in KNOWN else f"{name} of {model.parameters[name][0]}"


def advice_for(names: Set, count: int, model: ContactModel) -> str:
    """Return so many experiments that distinguish changes."""
    known = [KNOWN[name][1] for name in KNOWN if name in names]
    others = [effect(model.parameters[name][0]).experiment for name in names if name not in KNOWN]
    described = list(dict.fromkeys(one for one in (*known, *others) if one))
    return "; ".join(described[:count])


@dataclass(frozen=True)
class Change:
    """What one value is in the first recording and in the second."""

    name: str  # of a parameter of the model, or zero_CHANNEL, gain_CHANNEL, tip_radius
    before: float
    after: float
    std: float  # of the difference
    unit: str  # of these, SI
    percent: float | None  # of the value before; None of a zero, and of what was not told from nothing before
    interval: tuple[
        float, float
    ]  # of the difference with 95 %, in percent, or where that is None in the unit
    p: float  # chance that noise alone gives so much to any of all that could have changed

    @property
    def within(self) -> float:
        """The end of the interval that is farther from nothing."""
        return max(map(abs, self.interval))

    def described(self, label: str) -> str:
        """Return it as a sentence has it."""
        low, high = sorted(self.interval, key=abs)
        if self.percent is None:
            every = (self.after - self.before, low, high)
            size, *ends = ("+" * (one >= 0.0) + self.amount(one) for one in every)
            return f"{label} {size} ({' to '.join(ends)})"
        change, low, high = (math.copysign(1.0, self.percent) * one for one in (self.percent, low, high))
        digits = max(0, -math.floor(math.log10(max(high - low, 1e-9))))  # of the interval's width, one
        way = (("higher", "lower"), ("stiffer", "softer"))[self.name == "K"][self.percent < 0.0]
        described = f"{change:.{digits}f} % {way} ({low:.{digits}f} to {high:.{digits}f} %)"
        return described if self.name == "K" else f"{label} {described}"

    def amount(self, value: float) -> str:
        """Return a difference in percent, or where that says nothing in its unit."""
        unit = self.unit if self.unit != "1" else ""
        return format_amount(value, unit) if self.percent is None else f"{value:.2g} %"


@dataclass(frozen=True, eq=False, repr=False)
class Changed(Result):
    """What changed from the first recording to the second.

    Attributes:
        verdict: nothing, named, ambiguous or new_effect.
        sentence: the verdict in words.
        changes: every value that changed, or may have, each with its interval.
        unchanged: by how much each other value can have changed.
        remarks: what else is to be known, in sentences.

    """

    _display: ClassVar[str] = "changed"

    pair: Pair
    choice: Choice
    new_effects: tuple[str, ...]  # which the second shows alone
    overlap: dict[str, Any]  # channels, depths [m] and speeds [m/s] of both
    doubts: list[str]

    @property
    def verdict(self) -> str:
        """nothing, named, ambiguous or new_effect."""
        if self.new_effects:
            return "new_effect"
        return "ambiguous" if self.choice.unsure else "named" if self.choice.best else "nothing"

    @cached_property
    def changes(self) -> list[Change]:
        """Every value that changed, or may have: those that are sure first."""
        order = [*self.choice.sure, *(name for _, names in self.choice.unsure for name in names)]
        sets = (self.choice.best, *self.choice.rivals)
        return [self._change(name, next(one for one in sets if name in one)) for name in order]

    @cached_property
    def unchanged(self) -> list[Change]:
        """By how much each other value can have changed, if it did beside those that did."""
        rest = [name for name in self.pair.questions if not any(name in one for one in self.choice.rivals)]
        found = [self._change(name, (*self.choice.best, name)) for name in rest]
        return [one for one in found if one.percent is None or one.within < VAGUE_PERCENT]

    def _change(self, name: str, among: Set) -> Change:
        """Return the change of ``name`` where these differ, and nothing else."""
        pair, j = self.pair, self.pair.names.index(name)
        w, cost = pair.solved(among)
        gain = pair.cost([one for one in among if one != name]) - cost
        u, d = pair.origin[j] + w[j], w[len(pair.names) + j]
        side = SIDE_95 * pair.std(among)[among.index(name)]
        values, unit = pair.in_si(name, u + np.array([0.0, d, d - side, d + side]))
        before, after, *ends = values.tolist()
        std = (ends[1] - ends[0]) / (2.0 * SIDE_95)
        is_relative = pair.is_log(name) or not (name.startswith("zero_") or abs(before) < SIDE_95 * std)
        scale = 100.0 / abs(before) if is_relative else 1.0
        possible = np.clip(u + np.array([d - side, d + side]), pair.least[j], pair.most[j])
        low, high = (scale * (end - before) for end in pair.in_si(name, possible)[0].tolist())
        percent = scale * (after - before) if is_relative else None
        p = chance(gain, 1, len(pair.questions))
        return Change(name, before, after, std, unit, percent, (low, high), p)

    @property
    def indistinguishable(self) -> list[list[str]]:
        return [list(names) for _, names in self.choice.unsure]

    @property
    def experiment(self) -> list[dict[str, Any]]:
        """What would distinguish the members of each set: it suffices to find what is not there."""
        few, model = [(names, len(names) - count) for count, names in self.choice.unsure], self.pair.model
        return [{"between": list(names), "advice": advice_for(names, count, model)} for names, count in few]

    @property
    def sentence(self) -> str:
        """The verdict in words."""
        described = {one.name: one.described(label_of(one.name, self.pair.model)) for one in self.changes}
        parts = [f"{' and '.join(self.new_effects)} in the second only"] if self.new_effects else []
        parts += [described[name] for name in self.choice.sure]
        for count, names in self.choice.unsure:
            parts.append(f"{COUNTS[count]} of these: {' or '.join(described[name] for name in names)}")
        if not self.choice.unsure:
            parts.append("nothing else" if parts else "nothing changed")
        first = self.pair.first.measured.recording
        return f"{first.name if first.is_material else first.fingertip.name}: {', '.join(parts)}"

    @property
    def remarks(self) -> Iterator[str]:
        """What else is to be known, in sentences."""
        yield from (f"to distinguish them: {one['advice']}" for one in self.experiment)
        labels = {name: label_of(name, self.pair.model) for name in self.pair.comparable}
        if same := [f"{labels[one.name]} {one.amount(one.within)}" for one in self.unchanged]:
            yield f"unchanged, each by itself with 95 % within: {', '.join(same)}"
        known = {one.name for one in (*self.changes, *self.unchanged)}
        if unseen := [label for name, label in labels.items() if name not in known]:
            yield f"not compared, for both do not show it: {', '.join(unseen)}"
        yield from self.doubts

    def as_dict(self) -> dict[str, Any]:
        """Return what ``--json`` prints."""
        return {
            "verdict": self.verdict,
            "sentence": self.sentence,
            "changed": [asdict(one) for one in self.changes],
            "indistinguishable": self.indistinguishable,
            "new_effects": list(self.new_effects),
            "experiment": {"sets": self.experiment} if self.experiment else None,
            "unchanged": [asdict(one) for one in self.unchanged],
            "overlap": self.overlap,
            "doubts": self.doubts,
        }
