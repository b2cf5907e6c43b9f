"""What a candidate has to gain. The first one pays for being one of many; a further one for not being form.

The law of an effect that was accepted need not have exactly the form of what is there. What it leaves invites
further effects which only mend that form: they gain little of what was gained before, and little of what is
left.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from vegrip.effects import Effect
from vegrip.identification.diagnosis.candidate_fit import CandidateFit
from vegrip.identification.diagnosis.thresholds import (
    LITTLE_LEFT_SHARE,
    MAX_NOISE_CHI2,
    MIN_GAIN_NATS,
    MIN_LATER_GAIN_NATS,
    MIN_SHARE_OF_GAIN,
    MIN_SHARE_OF_GAIN_IN_MISFIT,
    MIN_SHARE_OF_LEFT,
    MIN_TIMING_SHARE_OF_GAIN,
    SURELY_LEFT_STD,
)


@dataclass(frozen=True)
class EvidenceThreshold:
    """What was gained so far and is left to be gained [nats], the misfit by regime, and what is accepted."""

    gained: float
    left: float
    misfit: float
    accepted: tuple[Effect, ...]

    def of(self, candidate: Effect) -> float:
        """Return what a candidate has to gain [nats]."""
        if not self.accepted:
            return MIN_GAIN_NATS
        fits_noise = self.misfit <= MAX_NOISE_CHI2
        asked = max(
            MIN_LATER_GAIN_NATS if fits_noise else MIN_GAIN_NATS,
            (MIN_SHARE_OF_GAIN if fits_noise else MIN_SHARE_OF_GAIN_IN_MISFIT) * self.gained,
        )
        if self.left < LITTLE_LEFT_SHARE * self.gained:
            asked = max(asked, MIN_SHARE_OF_LEFT * self.left)
        if candidate.shifts_time and any(one.shifts_time for one in self.accepted):
            asked = max(asked, MIN_TIMING_SHARE_OF_GAIN * self.gained)
        return asked


def required_evidence(
    first: CandidateFit, base: CandidateFit, misfit: float, accepted: Iterable[Effect]
) -> EvidenceThreshold:
    """Return what a further effect costs beside ``accepted`` ones, which led from ``first`` to ``base``."""
    return EvidenceThreshold(base.evidence - first.evidence, left(base), misfit, tuple(accepted))


def left(fitted: CandidateFit) -> float:
    """Return what is certainly more than noise in the sum of squares [nats]."""
    power = fitted.optimum.residual[fitted.problem.counted] ** 2
    return max(0.5 * float(np.sum(power - 1.0)) - SURELY_LEFT_STD * math.sqrt(0.5 * power.size), 0.0)
