"""What shall be exported, checked."""

import re
from dataclasses import dataclass, field

from vegrip.c99.names import RESERVED
from vegrip.errors import UsageError
from vegrip.estimator import EstimatorSettings, SensorNoise
from vegrip.model import ContactModel

PREFIX = re.compile(r"[a-z][a-z0-9]{0,19}(_[a-z0-9]+)*")
FRAMES = 500
MARGIN = 0.2
"""For which the self-test asks the least force."""


@dataclass(frozen=True)
class Request:
    """A model, the noise of its sensors, how the estimator behaves, and the beginning of every name in C.

    Raises:
        UsageError: no C compiler would take the prefix.

    """

    model: ContactModel
    noise: SensorNoise = field(default_factory=SensorNoise)
    settings: EstimatorSettings = field(default_factory=EstimatorSettings)
    prefix: str = "vg"
    frames: int = FRAMES

    def __post_init__(self) -> None:
        if not PREFIX.fullmatch(self.prefix) or self.prefix in RESERVED:
            raise UsageError(
                f"--prefix {self.prefix!r}: names in C begin with a lower-case letter, then come "
                "letters, digits and single _, as in vg or left_hand"
            )
