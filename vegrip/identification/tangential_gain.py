"""Gains of the tangential channels from a known weight: of their sum, and of each finger where shares differ.

With ``read = gain * true`` each hold of a weight (:mod:`vegrip.identification.lifted_weight`) is an
equation

    sum_i T_i / g_i = m g + e,

``T_i`` as read, ``e`` a normal error: LIFT_STD of the weight in all holds of a lift together, noise in
each. The gain of the sum, ``G = sum_i T_i / (m g)``, is known from one lift, however the weight is shared.
Those of the fingers are not: of ``ln g_i = c + d_i`` the common part c is free, and the differences d_i are
normal with ALIKE_STD. One lift leaves them at that; lifts with other shares, best with one finger alone,
distinguish them. The answer is the mode of this Gaussian problem (Gauss-Newton) with its covariance, widened
where lifts scatter by more than was assumed (Birge ratio).
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from vegrip.config import declaration
from vegrip.errors import InputError
from vegrip.estimator import Sensors
from vegrip.identification.lifted_weight import Hold
from vegrip.identification.sensors import GRAVITY
from vegrip.types import Floats

LIFT_STD: Final = 0.025
"""Of m g, in one lift: a pad that faces 13 degrees up or down carries so much less along its surface."""
HOLD_STD: Final = 0.005  # of m g, in one hold: what a pad's hysteresis leaves
ALIKE_STD: Final = 0.1
"""Of ln g between fingers: two silicone pads read 0.81 to 0.95 (robertburk/ME_THESIS_ROBERT_BURKE)."""
FREE_STD: Final = 1.0  # of the common ln g, which lies within ln 0.5 .. ln 2
SEPARATED: Final = (
    0.5  # of what is assumed of the difference of two gains: its std from which on each has its own
)
DISAGREE_STD: Final = 2.0  # standard deviations by which gains at two weights differ that are not the same
STEPS: Final = 20  # of Gauss-Newton; where gains are near 1 three do


@dataclass(frozen=True, slots=True)
class Gain:
    """``read / true``, and its relative standard deviation."""

    value: float
    std: float

    def __str__(self) -> str:
        return f"{self.value:.3f} +- {self.value * self.std:.3f}"

    @property
    def meaning(self) -> str:
        percent = 100.0 * (self.value - 1.0)
        return f"{abs(percent):.0f} % {'low' if percent < 0.0 else 'high'}"

    @property
    def settings(self) -> dict[str, float]:
        return {"tangential_gain": round(self.value, 4), "tangential_gain_std": round(self.std, 4)}


@dataclass(frozen=True, slots=True)
class AtWeight:
    """The gain of the sum at one weight."""

    mass: float  # [kg]
    gain: Gain
    lifts: int
    shares: Floats  # (fingers,) of the sum


@dataclass(frozen=True, slots=True)
class TangentialGain:
    """What lifted weights show of the tangential channels."""

    common: Gain  # of the sum
    fingers: Mapping[str, Gain]
    are_separated: bool
    weights: tuple[AtWeight, ...]
    seconds: float  # in which a weight hung still

    @property
    def lifts(self) -> int:
        return sum(one.lifts for one in self.weights)

    @property
    def load_dependence(self) -> float:
        """Largest difference of ln G between two weights; 0 where it is within their errors."""
        differences = [_difference(*pair) for pair in itertools.combinations(self.weights, 2)]
        return max((abs(found) for found, std in differences if abs(found) > DISAGREE_STD * std), default=0.0)

    @property
    def settings(self) -> dict[str, Any]:
        """The parameters ``sensors`` of a grip controller; the std is that of a finger, not of the sum."""
        by_load = 0.5 * self.load_dependence
        if not self.are_separated:
            widest = max(gain.std for gain in self.fingers.values())
            return Gain(self.common.value, math.hypot(widest, by_load)).settings
        logs = np.log([gain.value for gain in self.fingers.values()])
        among = Gain(float(np.exp(np.mean(logs))), math.hypot(float(np.std(logs)), self.common.std, by_load))
        own = {
            name: Gain(gain.value, math.hypot(gain.std, by_load)).settings
            for name, gain in self.fingers.items()
        }
        return {**among.settings, "fingers": own}


def tangential_gain(names: Sequence[str], holds: Sequence[Hold]) -> TangentialGain:
    """Return what ``holds`` show of the fingers ``names``, in the order of their loads.

    Raises:
        InputError: a gain that no sensor has.

    """
    loads, weight = np.array([hold.loads for hold in holds]), np.array([hold.weight for hold in holds])
    values, covariance = _each(loads, weight, holds)
    fingers = {
        name: Gain(math.exp(value), math.sqrt(variance))
        for name, value, variance in zip(names, values.tolist(), np.diag(covariance).tolist(), strict=True)
    }
    pairs = itertools.combinations(range(len(names)), 2)
    variances = (covariance[i, i] + covariance[j, j] - 2.0 * covariance[i, j] for i, j in pairs)
    separated = bool(max(variances, default=math.inf) <= 2.0 * (SEPARATED * ALIKE_STD) ** 2)
    found = TangentialGain(
        _of_sum(holds),
        fingers,
        separated,
        tuple(
            _at_weight([hold for hold in holds if hold.weight == one]) for one in sorted(set(weight.tolist()))
        ),
        sum(hold.duration for hold in holds),
    )
    doubt = (
        "" if all(hold.is_zeroed_in_air for hold in holds) else "; and begin with open fingers, for the zeros"
    )
    _check("the tangential forces together", found.common, doubt)
    if separated:
        for name, gain in fingers.items():
            _check(f"the tangential force of {name}", gain, doubt)
    return found


def _check(what: str, gain: Gain, doubt: str) -> None:
    bounds = declaration(Sensors, "tangential_gain")
    if not bounds.low <= gain.value <= bounds.high:
        raise InputError(
            f"{what} read {gain.value:.2g} times the weight, and a gain lies in {bounds.low:g} .. "
            f"{bounds.high:g}: look at the weight, and at the unit of the channels{doubt}"
        )


def _each(loads: Floats, weight: Floats, holds: Sequence[Hold]) -> tuple[Floats, Floats]:
    """Return ln g of each finger and its covariance."""
    count = loads.shape[1]
    assumed = _inverse(ALIKE_STD**2 * np.eye(count) + FREE_STD**2)
    errors, begin = _errors(holds), np.full(count, math.log(_of_sum(holds).value))
    x, covariance = _mode(loads, weight, errors, assumed, begin)
    learned = count - float(np.trace(assumed @ covariance))  # numbers that the lifts determine
    wider = _birge(weight - loads @ np.exp(-x), holds, learned)
    return _mode(loads, weight, wider * errors, assumed, x)


def _mode(loads: Floats, weight: Floats, errors: Floats, assumed: Floats, x: Floats) -> tuple[Floats, Floats]:
    """Return the most probable ln g and its covariance; ``assumed`` is what is known of it before [1/var]."""
    information = _inverse(errors)
    covariance = _inverse(assumed)
    for _ in range(STEPS):
        slope = loads * np.exp(-x)  # of what is missing from the weight, by x
        missing = weight - np.sum(slope, axis=1)
        covariance = _inverse(slope.T @ information @ slope + assumed)
        x = x - covariance @ (slope.T @ information @ missing + assumed @ x)
    return x, covariance


def _inverse(matrix: Floats) -> Floats:
    found: Floats = np.linalg.inv(matrix).astype(np.float64, copy=False)
    return found


def _errors(holds: Sequence[Hold]) -> Floats:
    """Return the covariance of the errors of the holds [N^2]."""
    lift = np.array([hold.lift for hold in holds])
    std = np.array([math.hypot(LIFT_STD * hold.weight, hold.zero_std) for hold in holds])
    found: Floats = np.diag([hold.std**2 + (HOLD_STD * hold.weight) ** 2 for hold in holds])
    found += np.outer(std, std) * (lift[:, None] == lift)
    return found


def _birge(missing: Floats, holds: Sequence[Hold], parameters: float) -> float:
    """Return by which factor the variance of lifts is larger than was assumed, 1 at least."""
    lift = np.array([hold.lift for hold in holds])
    found = [
        float(np.mean(missing[lift == one])) ** 2
        / float(np.mean(_errors([h for h in holds if h.lift == one])))
        for one in dict.fromkeys(lift.tolist())
    ]
    return max(1.0, sum(found) / max(len(found) - parameters, 1.0))


def _of_sum(holds: Sequence[Hold]) -> Gain:
    """Return the gain of the sum: the mean of the lifts by their errors, which their scatter widens."""
    lifts = [
        [hold for hold in holds if hold.lift == one] for one in dict.fromkeys(hold.lift for hold in holds)
    ]
    means = np.array([np.mean([math.log(hold.total / hold.weight) for hold in lift]) for lift in lifts])
    variances = np.array([float(np.mean(_errors(lift))) / lift[0].weight ** 2 for lift in lifts])
    value = float(np.average(means, weights=1.0 / variances))
    scatter = float(np.sum((means - value) ** 2 / variances)) / max(len(lifts) - 1, 1)
    return Gain(math.exp(value), math.sqrt(max(scatter, 1.0) / float(np.sum(1.0 / variances))))


def _at_weight(holds: Sequence[Hold]) -> AtWeight:
    shares = np.mean([hold.loads / hold.total for hold in holds], axis=0)
    return AtWeight(holds[0].weight / GRAVITY, _of_sum(holds), len({hold.lift for hold in holds}), shares)


def _difference(one: AtWeight, other: AtWeight) -> tuple[float, float]:
    """Return the difference of ln G, and the std that errors and fingers that are not alike give it."""
    by_shares = ALIKE_STD * float(np.linalg.norm(one.shares - other.shares))
    return math.log(one.gain.value / other.gain.value), math.hypot(one.gain.std, other.gain.std, by_shares)
