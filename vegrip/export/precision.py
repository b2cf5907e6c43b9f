"""What of an export depends on the precision of its numbers, and the processor that it is tried on."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from vegrip.c99.kinds import DOUBLE, FLOAT, Kind, RealType
from vegrip.c99.names import RESERVED
from vegrip.errors import InputError, UsageError
from vegrip.estimator import EstimatorSettings, SensorNoise
from vegrip.estimator.memory import FingerMemory
from vegrip.estimator.origins import Origins
from vegrip.grip.settings import ControlSettings
from vegrip.messages import USUAL_FINGERS
from vegrip.model import ContactModel


@dataclass(frozen=True)
class Unit:
    """A generated text and its entries, a memory, and what the templates know besides."""

    text: str
    origins: Origins
    entries: Mapping[str, tuple[Kind, ...]]
    blank: FingerMemory
    """Before the first sample."""
    reals: NDArray[np.float64]
    """Of the memory after the recorded sequence."""
    words: Mapping[str, str]
    command: int = 0
    """Bytes of a command."""


ENTRIES = ("estimator", "finger")
PREFIX = re.compile(r"[a-z][a-z0-9]{0,19}(_[a-z0-9]+)*")
FRAMES = 500
MOST_FINGERS = 8
"""That the identifiers of a hand's frames distinguish."""
MARGIN = 0.2
"""For which the self-test asks the least force."""


@dataclass(frozen=True)
class Request:
    """A model, the noise of its sensors, how the estimator behaves, and the beginning of every name in C.

    ``entry`` is ``estimator``, or ``finger`` for all from frame to frame. Of ``control`` an estimator has the
    friction, a finger all, and the ``fingers`` that share the grasp, in the order of their identifiers.
    ``precision`` is ``double`` or ``float``.
    """

    model: ContactModel
    noise: SensorNoise = field(default_factory=SensorNoise)
    settings: EstimatorSettings = field(default_factory=EstimatorSettings)
    prefix: str = "vg"
    precision: str = "double"
    frames: int = FRAMES
    entry: str = "estimator"
    control: ControlSettings = field(default_factory=ControlSettings)
    fingers: tuple[str, ...] = USUAL_FINGERS

    @property
    def estimator(self) -> EstimatorSettings:
        """How the estimator behaves: samples come in order, and friction is as ``control`` has it."""
        return replace(self.settings, late=0, friction=self.control.friction.prior_of())

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
        if self.entry == "finger" and self.control.grip.drive_lag > 0.0:
            raise InputError("[grip] drive_lag: an exported finger does not lead its load; leave it at 0")
        if self.control.friction.learning:
            raise InputError("[friction] learning: it takes all fingers of a node; leave it out of an export")


CORTEX_M7 = {
    "core": "cortex_m7", "Core": "Cortex-M7", "board": "mps2-an500",
    "cpu": "-mcpu=cortex-m7 -mthumb -mfloat-abi=hard -mfpu=fpv5-d16",
}  # fmt: skip
CORTEX_M4 = {
    "core": "cortex_m4", "Core": "Cortex-M4F", "board": "mps2-an386",
    "cpu": "-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16",
}  # fmt: skip


@dataclass(frozen=True)
class Precision:
    """Double or single.

    Attributes:
        reals: how C writes them; in templates ``real`` is the type, ``F`` and ``f`` end literals and names.
        number_bytes: of a number.
        words: what the templates say of it.
        processor: what the templates say of the emulated processor, ``core``, ``Core``, ``board``, ``cpu``.

    """

    reals: RealType
    number_bytes: int
    words: Mapping[str, str]
    processor: Mapping[str, str]

    @property
    def known(self) -> dict[str, str]:
        reals = {"real": self.reals.c, "F": self.reals.literal, "f": self.reals.function}
        return {**reals, **self.words, **self.processor}


EXACT = """Prints PASS and returns 0 when every flag is the same and no number is off by more than 1e-5 of its
 * size: the search for the least force ends within a millionth. Where hypot, erfc, exp and so on round as in
 * the mathematical library of the machine that wrote this (glibc), none is off at all."""
NEAR = """Prints PASS and returns 0 when no estimate is off by more than a fifth of its standard deviation, no
 * other number by more than a fifth of its size, and no more than one sample in a hundred has other flags."""
FINGER_EXACT = """all reasons too, and no force is off by more than 1e-5 of its size. Where hypot, erfc and
 * exp round as in the mathematical library of the machine that wrote this (glibc), every byte is the same."""
FINGER_NEAR = """no more than one reason in fifty is another, and no force is off by more than what the
 * fail-safe ramp climbs in two commands: it may begin one command earlier or later."""
PRECISIONS = {
    "double": Precision(
        DOUBLE, 8,
        {
            "precision": "Double", "sameness": EXACT, "allowed": "1e-5", "flags_allowed": "0",
            "scale": "fmax(fabs(wanted), 1e-300)", "time": "(t)", "whole_memory": "1",
            "difference": "relative difference", "least_double": "8",
            "likeness": "to the bit", "finger_sameness": FINGER_EXACT, "reasons_allowed": "0",
            "finger_scale": "fmax(fabs(size), 1e-300)", "finger_difference": "relative difference",
        },
        CORTEX_M7,
    ),
    "float": Precision(
        FLOAT, 4,
        {
            "precision": "Single", "sameness": NEAR, "allowed": "0.2", "flags_allowed": "(FRAMES / 100)",
            "scale": "fmax(fabs(std), 1e-30)", "time": "(1.0 / (1.0 + (double)(t)))", "whole_memory": "0",
            "difference": "difference in standard deviations", "least_double": "4",
            "likeness": "as near as can be", "finger_sameness": FINGER_NEAR,
            "reasons_allowed": "(numbers / 100)",
            "finger_scale": "1.0", "finger_difference": "difference in newton",
        },
        CORTEX_M4,
    ),
}  # fmt: skip
