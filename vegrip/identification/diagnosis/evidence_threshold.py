"""What a candidate has to gain. The first one pays for being one of many; a further one for not being form.

The law of an effect that was accepted need not have exactly the form of what is there. What it leaves invites
further effects which only mend that form: they gain little of what was gained before, and little of what is
left.
"""

import math
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from vegrip.identification.diagnosis.acceptance import CALM, PAYS
from vegrip.identification.diagnosis.candidate_fit import Fitted

LATER = 20.0  # [nats] for a further effect where no regime stands out any more; and in any case
MATERIAL = 0.005  # of what was gained so far,
ROUGHLY = 0.015  # where something still stands out, and
SHARE = 0.15  # of what is left, if that is little:
SMALL = 0.15  # of what was gained
TIMING = {"sensor_lag", "fast_damping", "inertia"}  # one beside another does what the other law's form does,
TIMED = 0.1  # if it gains less than this of what was gained
SURELY = 2.0  # standard deviations of the sum of squares of noise


@dataclass(frozen=True)
class Price:
    """What was gained so far and is left to be gained [nats], the misfit by regime, and what is accepted."""

    gained: float
    left: float
    misfit: float
    accepted: frozenset[str]

    def of(self, name: str) -> float:
        """Return what a candidate has to gain [nats]."""
        if not self.accepted:
            return PAYS
        calm = self.misfit <= CALM
        asked = max(LATER if calm else PAYS, (MATERIAL if calm else ROUGHLY) * self.gained)
        if self.left < SMALL * self.gained:
            asked = max(asked, SHARE * self.left)
        if name in TIMING and self.accepted & TIMING:
            asked = max(asked, TIMED * self.gained)
        return asked


def price(first: Fitted, base: Fitted, misfit: float, accepted: Collection[str]) -> Price:
    """Return what a further effect costs beside ``accepted`` ones, which led from ``first`` to ``base``."""
    return Price(base.evidence - first.evidence, left(base), misfit, frozenset(accepted))


def left(fitted: Fitted) -> float:
    """Return what is certainly more than noise in the sum of squares [nats]."""
    power = fitted.optimum.residual[fitted.problem.counted] ** 2
    return max(0.5 * float(np.sum(power - 1.0)) - SURELY * math.sqrt(0.5 * power.size), 0.0)
