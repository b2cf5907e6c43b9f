"""What the node asks of an estimator; :class:`vegrip.estimator.ContactEstimator` answers it."""

from typing import Protocol

from vegrip.messages import ContactEstimate, Estimate, FingertipState, ModelHealth, SlipMargin


class Estimator(Protocol):
    """The contact of one finger. Nothing here raises, whatever the state contains."""

    @property
    def in_contact(self) -> bool:
        """Whether the fingertip touches."""

    @property
    def normal_force(self) -> Estimate:
        """The normal force [N]."""

    def assimilate(self, state: FingertipState) -> None:
        """Take in one state."""

    def contact_estimate(self) -> ContactEstimate:
        """Return what is known of the contact; asked for less often than states come."""

    def slip_margin(self) -> SlipMargin:
        """Return the margin at the last state."""

    def health(self) -> ModelHealth:
        """Return whether the model explains what was measured."""

    def reset_health(self) -> None:
        """Forget how well the model explained what was felt so far."""

    def least_force(self, margin: float, confidence: float, load: tuple[float, float] | None = None) -> float:
        """Return the least normal force [N] for the wanted margin over the horizon; NaN = unknown.

        The margin is kept with the one-sided ``confidence``, under the last load or the given one, tangential
        force [N] and torque [N m].
        """

    def reset(self) -> None:
        """Forget the contact; keep what is known of the finger."""
