"""A change in words for who maintains the hand, and what separates changes that look the same."""

import math
from dataclasses import dataclass
from typing import Final

from vegrip.effects import effect
from vegrip.identification.compare.where import format_quantity
from vegrip.model import ContactModel

DEPTHS = "press to several depths, from a tenth of the deepest on"
HOLD = "press fast, and hold for several times of relaxation"
SLIDE = "pull and twist until it slips, at two loads"
KNOWN: Final = {
    "gain_normal_force": ("gain of the force sensor", "lay a known weight on the tip: it shows a gain alone"),
    "gain_tangential_force": (
        "gain of the pull",
        "hang a known weight sideways on the tip: it shows a gain alone",
    ),
    "gain_torque_z": (
        "gain of the torque",
        "hang a known weight on a lever at the tip: it shows a gain alone",
    ),
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


@dataclass(frozen=True)
class Change:
    """What one value is in the first recording and in the second."""

    name: str  # of a parameter of the model, or zero_CHANNEL, gain_CHANNEL, tip_radius
    before: float
    after: float
    std: float  # of the difference, in the same unit
    percent: float | None  # of the value before; None of a zero
    interval: tuple[float, float]  # of the difference with 95 %, in percent, or of a zero in its unit
    p: float  # chance that noise alone gives so much to any of all that could have changed

    def told(self, label: str) -> str:
        """Return it as a sentence has it."""
        low, high = sorted(self.interval, key=abs)
        if self.percent is None:
            size, least, most = (self.amount(one) for one in (self.after - self.before, low, high))
            return f"{label} {size} ({least} to {most})"
        least, most = (
            f"{one * math.copysign(1.0, self.percent):.{_digits(high - low)}f}" for one in (low, high)
        )
        way = ("stiffer", "softer") if self.name == "K" else ("higher", "lower")
        size = (
            f"{abs(self.percent):.{_digits(high - low)}f} % {way[self.percent < 0.0]} ({least} to {most} %)"
        )
        return size if self.name == "K" else f"{label} {size}"

    def amount(self, value: float) -> str:
        """Return a difference of a zero with its sign and unit."""
        return f"{'-' if value < 0.0 else '+'}{format_quantity(self.name.removeprefix('zero_'), abs(value))}"

    @property
    def most(self) -> str:
        """By how much it can have changed at most, with 95 %."""
        size = max(map(abs, self.interval))
        return self.amount(size)[1:] if self.percent is None else f"{size:.2g} %"


def _digits(width: float) -> int:
    return max(0, -math.floor(math.log10(max(abs(width), 1e-9))))


def label_of(name: str, model: ContactModel) -> str:
    return KNOWN[name][0] if name in KNOWN else f"{name} of {model.parameters[name][0]}"


def advice_for(names: list[str], model: ContactModel) -> str:
    """Return the experiments that tell changes apart: one less than there are."""
    known = [KNOWN[name][1] for name in KNOWN if name in names]
    others = [effect(model.parameters[name][0]).experiment for name in names if name not in KNOWN]
    told = list(dict.fromkeys(one for one in (*known, *others) if one))
    return "; ".join(told[: max(len(names) - 1, 1)])
