"""What of an estimator's memory is saved over a loss of power, and between which bounds each number is legal.

Saved is what the next sample depends on and neither model nor settings contain. The exported firmware has the
same spans (:mod:`vegrip.export.saved`), so what one of them saves the other one can go on from.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vegrip.estimator.layout import (
    CHANNELS,
    COUNTS,
    FRICTION,
    LOAD_PARTS,
    MODE,
    MOTION,
    PER_CELL,
    PER_CHANNEL,
    PER_PART,
    REGIMES,
    REPORT,
    Layout,
)
from vegrip.model import ContactModel
from vegrip.parameters import coordinate
from vegrip.types import Floats

LARGEST = 1e50
"""In SI units, as in the kernels: its fourth power is finite."""
FELT = (-1e300, 1e300)
"""What is felt beside the model is kept as it comes."""
FINITE, NOT_NEGATIVE, AGE, SWITCH = (-LARGEST, LARGEST), (0.0, LARGEST), (0.0, math.inf), (0.0, 1.0)
COUNTED = (0.0, 2.0**53)
DEPTH = (-200.0, 10.0)  # tip radii
VARIANCE = (1e-15, 100.0)
"""Of ln mu: no number of slips brings it lower, no prior is wider."""
EXPONENT = (-2.0, 2.0)
"""Of friction over the load; what slides at nearly one load say of it may go beyond what can be stated."""
BEYOND = 0.05
"""Part of its bounds by which a learned parameter may be outside until the next sample brings it back."""
CORRELATED = 1.0 + 1e-3
"""Largest correlation of two coordinates of the filter's state: 1, and what rounding makes of it."""
BOUNDS = {
    "FRICTION": {
        "VAR": VARIANCE, "BASE_VAR": VARIANCE, "SCATTER_VAR": VARIANCE, "SLIDING": SWITCH,
        "TOUCHING": SWITCH, "EVENTS": COUNTED, "SLIDE_COUNT": (-1.0, COUNTED[1]), "SLIDE_MEAN": FINITE,
        "UNCONFIRMED": (-LARGEST, math.inf), "EVENT_LN_U": FINITE, "COV": FINITE, "BASE_COV": FINITE,
        "EXPONENT": EXPONENT, "BASE_EXPONENT": EXPONENT, "LOAD": FINITE,
    },
    "CHANNEL": {"STREAK": COUNTED, "REJECTED": COUNTED, "AGE": AGE, "USED": SWITCH},
    "HEALTH": {"MEAN": (-10.0, 10.0), "NIS": (0.0, 100.0)},
    "MODE": {
        "ZERO_KNOWN": SWITCH, "BLIND": SWITCH, "HEALTH_DECAY": SWITCH, "FELT": SWITCH, "MET": SWITCH,
        "REGIME": (0.0, len(REGIMES) - 1.0), "CELL": (0.0, len(REGIMES) - 1.0), "CORNER": FINITE,
        "SLOPE": FINITE, "ZERO_MEAN": FINITE, "BEND": FINITE, "FREE_DEPTH": (-math.inf, LARGEST),
    },
    "MOTION": {"POSITION": FINITE, "SPEED": FINITE, "COV": FINITE},
    "COUNTS": dict.fromkeys(COUNTS, COUNTED),
}  # fmt: skip
"""Section -> name -> least and largest value; what is not named is not negative."""


@dataclass(frozen=True)
class Span:
    """``count`` numbers from place ``first`` on, one every ``step`` places, each in ``low`` .. ``high``."""

    first: int
    count: int
    step: int
    low: float
    high: float


class SavedNumbers:
    """The numbers that are saved of an estimator, in their order."""

    def __init__(self, model: ContactModel, layout: Layout) -> None:
        self._model, self._layout = model, layout
        self.spans = tuple(_joined(self._spans()))
        """First comes the filter's state, then its covariance."""
        each = [(one, one.first + i * one.step) for one in self.spans for i in range(one.count)]
        self.places = np.array([place for _, place in each])
        """Of the numbers in the memory."""
        self._low, self._high = (np.array([getattr(one, end) for one, _ in each]) for end in ("low", "high"))

    def are_legal(self, numbers: Floats) -> bool:
        """Return whether each number is within its bounds, and the covariance is one."""
        n = self._layout.n
        if numbers.shape != self.places.shape or not np.all((self._low <= numbers) & (numbers <= self._high)):
            return False
        covariance = numbers[n : n + n * n].reshape(n, n)
        variances = np.diag(covariance)
        most = CORRELATED * np.sqrt(np.maximum(variances, 0.0))[:, None] * np.sqrt(np.maximum(variances, 0.0))
        is_symmetric = np.abs(covariance - covariance.T) <= (CORRELATED - 1.0) * most
        return bool(np.all(variances >= 0.0) and np.all(np.abs(covariance) <= most) and is_symmetric.all())

    def put_into(self, memory: Floats, numbers: Floats) -> None:
        """Put legal ``numbers`` into a ``memory``, and the values of the parameters that follow from them."""
        layout, places = self._layout, self._layout.places()
        memory[self.places] = numbers
        values, learned = places["VALUES"][0], memory[layout.learned_from :]
        for place, log, u in zip(layout.learned, layout.learned_log, learned.tolist(), strict=False):
            memory[values + place] = math.exp(u) if log else u
        friction = places["FRICTION"][0]
        memory[values + layout.mu] = math.exp(memory[friction + FRICTION.index("LN_MU")])
        considered = places["CONSIDER"][0] + layout.considered.index(layout.mu)
        of = {
            name: memory[friction + FRICTION.index(name)] for name in ("VAR", "COV", "EXPONENT_VAR", "LOAD")
        }
        memory[considered] = (
            of["VAR"] - 2.0 * of["LOAD"] * of["COV"] + of["LOAD"] * of["LOAD"] * of["EXPONENT_VAR"]
        )

    def _spans(self) -> Iterator[Span]:
        layout, places = self._layout, self._layout.places()
        start = {name: place for name, (place, _) in places.items()}
        yield from self._state()
        for name, bounds in (("P", FINITE), ("EXOGENOUS", FELT)):
            yield Span(start[name], layout.sections()[name], 1, *bounds)
        yield from _named("FRICTION", FRICTION, start, 1, self._friction())
        yield Span(start["REPORT"] + REPORT.index("CONTACT"), 1, 1, *SWITCH)
        yield from _named("CHANNEL", PER_CHANNEL, start, len(CHANNELS))
        yield from _named("HEALTH", PER_CELL, start, len(CHANNELS) * len(REGIMES))
        yield from _named("MODE", MODE, start, 1)
        yield from _named("MOTION", MOTION, start, 1)
        yield from _named("COUNTS", COUNTS, start, 1)
        for name in ("BEND_SUM", "RATIO"):
            yield Span(start[name], layout.sections()[name], 1, *FINITE)
        yield from _named("PART", PER_PART, start, len(LOAD_PARTS))

    def _state(self) -> Iterator[Span]:
        layout, model = self._layout, self._model
        yield Span(0, 1, 1, *(model.tip_radius * end for end in DEPTH))
        yield Span(1, layout.learned_from - 1, 1, *FINITE)  # speed and states of the effects
        declared = [one for _, one in model.parameters.values()]
        for j, place in enumerate(layout.learned, layout.learned_from):
            value = model.values[declared[place].symbol]
            low, high = (coordinate(declared[place], end) for end in (value.low, value.high))
            beyond = BEYOND * (high - low)
            yield Span(j, 1, 1, max(low - beyond, -LARGEST), min(high + beyond, LARGEST))
        yield Span(layout.moving, layout.n - layout.moving, 1, *FINITE)  # offset and bias

    def _friction(self) -> dict[str, tuple[float, float]]:
        mu = self._model.values[list(self._model.parameters)[self._layout.mu]]
        logarithm = math.log(max(mu.low, 1.0 / LARGEST)), math.log(min(mu.high, LARGEST))
        found = {"LN_MU": logarithm, "BASE_LN": logarithm}
        if mu.std == 0.0:  # friction that is stated and not learned
            found |= dict.fromkeys(("VAR", "BASE_VAR"), (0.0, VARIANCE[1]))
        return found


def _named(
    section: str,
    names: tuple[str, ...],
    start: dict[str, int],
    count: int,
    more: dict[str, tuple[float, float]] | None = None,
) -> Iterator[Span]:
    known = BOUNDS.get(section, {}) | (more or {})
    for i, name in enumerate(names):
        step = len(names) if count > 1 else 1
        yield Span(start[section] + i, count, step, *known.get(name, NOT_NEGATIVE))


def _joined(spans: Iterator[Span]) -> Iterator[Span]:
    held = next(spans)
    for one in spans:
        follows = one.step == held.step == 1 and one.first == held.first + held.count
        if follows and (one.low, one.high) == (held.low, held.high):
            held = Span(held.first, held.count + one.count, 1, one.low, one.high)
        else:
            yield held
            held = one
    yield held
