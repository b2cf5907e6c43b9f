"""What a grip policy looks at: the load of one finger and the force that would carry it."""

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Demand:
    """One finger's need of grip force, as plain numbers.

    ``least_force`` is the estimator's least normal force that keeps the lower bound of the margin at the
    wanted margin, now and over the horizon. NaN = not known; then ``trusted`` is false.
    """

    least_force: float = math.nan  # [N]
    tangential_force: float = math.nan  # [N] magnitude
    torque: float = math.nan  # [N m] about the normal, magnitude; NaN = not measured
    margin_bound: float = math.nan  # [-] lower bound of the present margin
    in_contact: bool = False
    slipping: bool = False  # slip is felt at this instant
    trusted: bool = False  # the estimate behind it is valid
