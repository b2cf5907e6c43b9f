"""What shall be exported, checked."""

import re
from dataclasses import dataclass, field, replace

from vegrip.c99.names import RESERVED
from vegrip.errors import InputError, UsageError
from vegrip.estimator import EstimatorSettings, SensorNoise
from vegrip.grip.settings import ControlSettings
from vegrip.model import ContactModel

HAND = ("thumb", "index", "middle", "ring", "little")
ENTRIES = ("estimator", "finger")
PREFIX = re.compile(r"[a-z][a-z0-9]{0,19}(_[a-z0-9]+)*")
FRAMES = 500
MOST_FINGERS = 8
"""That the identifiers of a hand's frames tell apart."""
ABSENT = ("drive_lag", "measure_lag")
"""Settings of the grip for which a finger needs more of its grasp than an exported one knows."""
MARGIN = 0.2
"""For which the self-test asks the least force."""


@dataclass(frozen=True)
class Request:
    """A model, the noise of its sensors, how the estimator behaves, and the beginning of every name in C.

    ``entry`` is ``estimator``, or ``finger`` for all from frame to frame; that has ``control`` too, and the
    ``fingers`` that share the grasp, in the order of their identifiers. ``precision`` is ``double`` or
    ``float``.

    Raises:
        UsageError: no C compiler would take the prefix, or there are no fingers of these names.
        InputError: the control does what an exported finger does not.

    """

    model: ContactModel
    noise: SensorNoise = field(default_factory=SensorNoise)
    settings: EstimatorSettings = field(default_factory=EstimatorSettings)
    prefix: str = "vg"
    precision: str = "double"
    frames: int = FRAMES
    entry: str = "estimator"
    control: ControlSettings = field(default_factory=ControlSettings)
    fingers: tuple[str, ...] = HAND

    @property
    def alone(self) -> ControlSettings:
        """How a finger by itself is controlled: it neither shares friction nor probes for it."""
        friction = replace(self.control.friction, shared=False, probing=False)
        return replace(self.control, friction=friction)

    def __post_init__(self) -> None:
        if not PREFIX.fullmatch(self.prefix) or self.prefix in RESERVED:
            raise UsageError(
                f"--prefix {self.prefix!r}: names in C begin with a lower-case letter, then come "
                "letters, digits and single _, as in vg or left_hand"
            )
        if not 1 <= len(set(self.fingers)) == len(self.fingers) <= MOST_FINGERS or "" in self.fingers:
            raise UsageError(
                f"--fingers {','.join(self.fingers)!r}: give 1 to {MOST_FINGERS} names, each once, with "
                "commas between them, as in thumb,index"
            )
        for name in ABSENT if self.entry == "finger" else ():
            if getattr(self.control.grip, name) > 0.0:
                raise InputError(f"[grip] {name}: an exported finger cannot do this; leave it at its default")
