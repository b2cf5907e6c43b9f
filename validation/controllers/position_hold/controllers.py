"""Rules of when to stop closing and when to tighten again.

* :class:`Elastic`: close to the elastic need times a constant, once. No choice of that constant knows how
  much this pad will lose.
* :class:`ElasticAgain`: the same, and tighten again to the same force whenever the measured one has come
  near the need.
* :class:`LastRatio`: close to the need times the ratio that the last hold lost, times a constant.
* :class:`Forecast`: close until the force left at the end of the hold suffices with a wanted probability.
* :class:`ForecastAgain`: close for the first seconds only, go on learning, and tighten again, to the end of
  the hold, before the contact slips.
"""

import math
from statistics import NormalDist
from typing import Protocol

import numpy as np

from validation.controllers.position_hold.forecast import HoldForecast
from validation.controllers.position_hold.pad import Pad
from validation.controllers.position_hold.scenario import FRICTION_SPREAD, Load
from vegrip.messages import FingertipState
from vegrip.types import Floats

UNMODELLED_SPREAD = 0.05
"""Std of ln N at the end of a hold beyond what the estimator knows: two branches are not the material."""
GUARD = 0.12
"""Part of the need on top at which a measured force counts as near it: 2.3 stds of the friction told."""
PATIENCE_S = 3.0  # for which the first closing of ForecastAgain is to hold
FARTHER = 4.0  # times as long as it has held by then it is to hold by a tightening, and PATIENCE_S
REACTION_S = 0.5  # ahead of a slip it tightens
LOOK_S = 0.25  # between two looks ahead
ON_TOP = 1.0  # standard deviations by which tightening again goes beyond what asks for it


NORMAL = NormalDist()


class HoldRule(Protocol):
    """When to stop, when to tighten again."""

    def begin(self, pad: Pad, friction: float, load: Load) -> None:
        """Begin a hold of ``load`` with the friction that is told; ``pad`` gives the contact radius alone."""

    def feel(self, state: FingertipState, held: float) -> None:
        """Take one sample; ``held`` [s] since closing, negative before."""

    def is_enough(self, depth: float, force: float) -> bool:
        """Whether to stop moving at this indentation [m] and force [N]."""

    def wants_more(self) -> bool:
        """Whether to tighten again."""


class Elastic:
    """Close once to the elastic need times ``1 + knob``."""

    def __init__(self, knob: float) -> None:
        self.knob = knob

    def begin(self, pad: Pad, friction: float, load: Load) -> None:
        """Keep what is told."""
        self._pad, self._friction, self._load = pad, friction, load

    def feel(self, state: FingertipState, held: float) -> None:
        """Nothing is measured but the force at which to stop."""

    def need(self, depth: float) -> float:
        """Return the least force [N] of the contact at an indentation [m], by the friction told."""
        return self._load.need(self._friction, self._pad.contact_radius(depth))

    def is_enough(self, depth: float, force: float) -> bool:
        """Whether the force is the wanted one."""
        return force >= (1.0 + self.knob) * self.need(depth)

    def wants_more(self) -> bool:
        """Never."""
        return False


class ElasticAgain(Elastic):
    """Close, and tighten again once the knob is lost, to the need times ``(1 + GUARD) (1 + knob)``."""

    def begin(self, pad: Pad, friction: float, load: Load) -> None:
        """Keep what is told; nothing measured yet."""
        super().begin(pad, friction, load)
        self._force, self._depth = math.inf, 0.0

    def feel(self, state: FingertipState, held: float) -> None:
        """Keep what was measured last."""
        del held
        self._force, self._depth = state.normal_force, state.displacement

    def is_enough(self, depth: float, force: float) -> bool:
        """Whether the force is the wanted one."""
        return force >= (1.0 + GUARD) * (1.0 + self.knob) * self.need(depth)

    def wants_more(self) -> bool:
        """Whether the force has come near the need."""
        return self._force < (1.0 + GUARD) * self.need(self._depth)


class LastRatio(ElasticAgain):
    """Close once to the need times what the last hold lost times ``1 + knob``."""

    def __init__(self, knob: float) -> None:
        super().__init__(knob)
        self._first = self._last = math.nan
        self.ratio = 2.0  # [-] before anything was held

    def begin(self, pad: Pad, friction: float, load: Load) -> None:
        """Take the ratio of the hold that has ended."""
        if self._last > 0.0:
            self.ratio = self._first / self._last
        super().begin(pad, friction, load)

    def feel(self, state: FingertipState, held: float) -> None:
        """Keep the first and the last force of the hold."""
        super().feel(state, held)
        if held <= 0.0:
            self._first = state.normal_force
        self._last = state.normal_force

    def is_enough(self, depth: float, force: float) -> bool:
        """Whether the force is the wanted one."""
        return force >= (1.0 + self.knob) * self.ratio * self.need(depth)

    def wants_more(self) -> bool:
        """Never."""
        return False


class Forecast(Elastic):
    """Close until the force suffices at the end of the hold with the probability ``knob``."""

    def __init__(self, knob: float) -> None:
        super().__init__(knob)
        self.forecast = HoldForecast()
        normal = np.random.default_rng(6).standard_normal(len(self.forecast.left_after(np.zeros(1))))
        self._beside = np.exp(math.hypot(FRICTION_SPREAD, UNMODELLED_SPREAD) * normal)

    def begin(self, pad: Pad, friction: float, load: Load) -> None:
        """Keep what is told; what was learned of the pads stays."""
        super().begin(pad, friction, load)
        self._held, self._depth, self._force, self._part = -1.0, 0.0, 0.0, 0.0

    def feel(self, state: FingertipState, held: float) -> None:
        """Let the estimator take the sample, and see how much of the force will be left."""
        self.forecast.feel(state)
        self._held, self._depth, self._force = max(held, 0.0), state.displacement, state.normal_force
        self._part = math.nan  # of the present force that counts; found when it is asked for

    def is_enough(self, depth: float, force: float) -> bool:
        """Whether what will be left of the force is the need."""
        if math.isnan(self._part):
            self._part = self.part_left(self.horizon, self.wanted)
        return force * self._part >= self.need(depth)

    @property
    def horizon(self) -> float:
        """For how long the force is to suffice from now on [s]."""
        return max(self._load.duration - self._held, LOOK_S)

    @property
    def wanted(self) -> float:
        """The probability [-] with which the force is to suffice."""
        return self.knob

    def part_left(self, horizon: float, probability: float) -> float:
        """Return the part of the force that is left after ``horizon`` [s] with a probability [-].

        Friction counts as what is told times its scatter, the force as forecast times what no model tells.
        """
        left: Floats = self.forecast.left_after(np.array([horizon]))[:, 0]
        return float(np.quantile(left * self._beside, 1.0 - probability))


class ForecastAgain(Forecast):
    """Close for the first seconds, learn, and tighten again before the contact slips."""

    def begin(self, pad: Pad, friction: float, load: Load) -> None:
        """Begin without having closed."""
        super().begin(pad, friction, load)
        self._looked = 0.0

    @property
    def horizon(self) -> float:
        """The first seconds when it closes; a hold of some seconds tells no rates of minutes [s]."""
        left = max(self._load.duration - self._held, LOOK_S)
        return min(PATIENCE_S + FARTHER * self._held, left)

    @property
    def wanted(self) -> float:
        """Beyond what asks for it when it tightens, else it would tighten again at the next look [-]."""
        return NORMAL.cdf(NORMAL.inv_cdf(self.knob) + ON_TOP) if self._held > 0.0 else self.knob

    def wants_more(self) -> bool:
        """Whether the force may not suffice any more within the time to react."""
        if self._held < self._looked + LOOK_S:
            return False
        self._looked = self._held
        ahead = min(REACTION_S, max(self._load.duration - self._held, LOOK_S))
        return self._force * self.part_left(ahead, self.knob) < self.need(self._depth)


RULES = {
    "elastic": Elastic,
    "elastic, again": ElasticAgain,
    "last ratio": LastRatio,
    "forecast": Forecast,
    "forecast, again": ForecastAgain,
}
"""By name."""
