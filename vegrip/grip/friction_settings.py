"""What is believed of friction at first, and how it is learned."""

from dataclasses import dataclass

from vegrip.config import constant, fixed_parameter
from vegrip.estimator.friction_prior import FrictionPrior
from vegrip.grip.friction_numbers import BLIND, QUICK

PRIOR = FrictionPrior()
"""What is believed of the friction of soft tips, if nothing is stated."""
COARSEST_CREEP = 2e-4
"""Threshold of felt slip [m/s] above which creep passes for holding, and probing would learn from it."""
LATEST_SLIP = BLIND / QUICK
"""Delay of felt slip [s] beyond which probing would slide too far, at the quickest."""


@dataclass(frozen=True)
class FrictionSettings:
    """What is believed of friction at first, how slip is felt, and whether force is lowered."""

    coefficient: float = fixed_parameter(
        0.0, unit="1", low=0.0, high=20.0,
        doc="of tips and object at a normal force of 5 N; 0 = as the tip's model states, else as published",
    )  # fmt: skip
    coefficient_std: float = fixed_parameter(
        0.0, unit="1", low=0.0, high=2.0,
        doc="std of its logarithm; 0 = as the model states, else as published",
    )  # fmt: skip
    load_exponent: float = fixed_parameter(
        PRIOR.load_exponent, unit="1", low=-0.5, high=0.9,
        doc="by which friction falls with the normal force: mu (N / 5 N)^-g",
    )  # fmt: skip
    load_exponent_std: float = fixed_parameter(
        PRIOR.load_exponent_std, unit="1", low=0.0, high=1.0, doc="std of that"
    )
    learning: bool = fixed_parameter(
        False,
        doc="all fingers learn it together: force is lowered slowly where slip is felt early enough",
    )
    object: str = fixed_parameter(
        "",
        doc="of what is held: its friction is kept in the folder 'learned' for the next grasp; empty = none",
    )  # fmt: skip
    own_spread: float = constant(
        0.08, unit="1", low=0.0, high=2.0, doc="std of ln mu between the fingers on one object"
    )
    slip_threshold: float = fixed_parameter(
        0.0, unit="m/s", low=0.0, high=10.0, doc="slip speed from which the tips feel slip"
    )
    slip_delay: float = fixed_parameter(0.0, unit="s", low=0.0, high=10.0, doc="by which felt slip is late")
    sliding_speed: float = constant(
        1e-3, unit="m/s", low=0.0, high=10.0,
        doc="slip speed from which a tip slides, whatever its flag says; 0 = none",
    )  # fmt: skip

    def prior_of(
        self, gain: float = PRIOR.tangential_gain, gain_std: float = PRIOR.tangential_gain_std
    ) -> FrictionPrior:
        """Return what is believed at first, by tangential channels of this gain, with its relative std."""
        law = self.coefficient, self.coefficient_std, self.load_exponent, self.load_exponent_std
        return FrictionPrior(*law, gain, gain_std)

    @property
    def why_too_coarse(self) -> str:
        """Why the slip channel does not allow probing; empty when it does."""
        if self.slip_threshold > COARSEST_CREEP:
            return f"slip is felt from {self.slip_threshold:g} m/s on, probing needs {COARSEST_CREEP:g} m/s"
        if self.slip_delay > LATEST_SLIP:
            return f"slip is felt {self.slip_delay:g} s late, probing needs {LATEST_SLIP:g} s or less"
        return ""
