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

    def described(self, label: str) -> str:
        """Return it as a sentence has it."""
        low, high = sorted(self.interval, key=abs)
        if self.percent is None:
            size, *ends = map(self.amount, (self.after - self.before, low, high))
            return f"{label} {size} ({' to '.join(ends)})"
        change, low, high = (math.copysign(1.0, self.percent) * one for one in (self.percent, low, high))
        digits = max(0, -math.floor(math.log10(max(high - low, 1e-9))))  # of the interval's width, one
        way = (("higher", "lower"), ("stiffer", "softer"))[self.name == "K"][self.percent < 0.0]
        described = f"{change:.{digits}f} % {way} ({low:.{digits}f} to {high:.{digits}f} %)"
        return described if self.name == "K" else f"{label} {described}"

    def amount(self, value: float) -> str:
        """Return a difference of a zero with its sign and unit, others in percent."""
        size = format_quantity(self.name.removeprefix("zero_"), abs(value))
        return f"{'-' if value < 0.0 else '+'}{size if self.percent is None else f'{abs(value):.2g} %'}"


def label_of(name: str, model: ContactModel) -> str:
    return KNOWN[name][0] if name in KNOWN else f"{name} of {model.parameters[name][0]}"


def advice_for(names: list[str], count: int, model: ContactModel) -> str:
    """Return so many experiments that distinguish changes."""
    known = [KNOWN[name][1] for name in KNOWN if name in names]
    others = [effect(model.parameters[name][0]).experiment for name in names if name not in KNOWN]
    described = list(dict.fromkeys(one for one in (*known, *others) if one))
    return "; ".join(described[: max(count, 1)])
