"""What of an export depends on the precision of its numbers, and the processor that it is tried on."""

from collections.abc import Mapping
from dataclasses import dataclass

from vegrip.c99.kinds import DOUBLE, FLOAT, RealType

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
        """What the templates know by name."""
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
