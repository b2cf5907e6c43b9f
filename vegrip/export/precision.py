"""What of an export depends on the precision of its numbers, and the processor that it is tried on."""

from collections.abc import Mapping
from dataclasses import dataclass

from vegrip.c99.single import single_precision

WIDE = "vg_double_always"
"""Stands in the templates for what is a double in any precision: saved numbers."""
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
        real: the type in C.
        number_bytes: of a number.
        words: what the templates say of it.
        processor: what the templates say of the emulated processor, ``core``, ``Core``, ``board``, ``cpu``.

    """

    real: str
    number_bytes: int
    words: Mapping[str, str]
    processor: Mapping[str, str]

    @property
    def known(self) -> dict[str, str]:
        """What the templates know by name."""
        return {"real": self.real, "wide": WIDE, **self.words, **self.processor}

    def finished(self, text: str) -> str:
        """Return a file of code in this precision."""
        return (single_precision(text) if self.real == "float" else text).replace(WIDE, "double")


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
        "double", 8,
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
        "float", 4,
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
