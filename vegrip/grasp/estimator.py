"""What the node asks of an estimator; :class:`vegrip.estimator.ContactEstimator` answers it."""

from typing import Protocol

from vegrip.messages import ContactEstimate, FingertipState, ModelHealth, SlipMargin


class Estimator(Protocol):
    """The contact of one finger. Nothing here raises, whatever the state contains."""

    def update(self, state: FingertipState) -> ContactEstimate:
        """Take in one state."""

    def slip_margin(self) -> SlipMargin:
        """Return the margin at the last state."""

    def health(self) -> ModelHealth:
        """Return whether the model explains what was measured."""

    def least_force(self, margin: float) -> float:
        """Return the least normal force [N] for the wanted margin over the horizon; NaN = unknown."""

    def reset(self) -> None:
        """Forget the contact; keep what is known of the finger."""
