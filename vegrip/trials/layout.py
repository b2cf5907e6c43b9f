"""Sizes and places of what a compiled trial keeps: one flat array for hand, drives, sensors and control."""

from dataclasses import dataclass

import numpy as np

from vegrip.grip.confirmed_load import CONFIRM_SIZE
from vegrip.virtual import profile

FLAGS = 64
"""Samples by which felt slip may be late."""
SLOTS = 25
"""Of the running median, as :data:`vegrip.grip.policies.running_median.WINDOW_SLOTS`."""
TABLE = 400
"""Pressure exponents of the hand's tables."""

ROW_FINGER = (
    "force", "command", "margin", "mu", "radius", "exponent", "tangential", "torque", "least",
    "ln_mu_stated", "ln_mu_std",
)  # fmt: skip
"""Truth of one finger in a row of the result, and what is believed of its friction; NaN = not in contact."""
ROW_HEAD = ("time", "slips", "micro_slips")

HAND_SCALARS = (
    "STEP", "TICKS", "Z", "DROPPED", "SLIPS", "EVENT_OPEN", "COUNTED", "EVENT_REST", "MICRO", "MICROS",
    "FORCE_LIMIT", "FORCE_RATE", "BANDWIDTH", "DRIVE_SPEED", "STICTION", "INITIAL_FORCE", "CLOSE_TIME",
    "LIFT_TIME", "MASS", "INERTIA", "GRAVITY", "FAR_LOST", "ANGLE_LOST", "SAMPLE_TIME", "SLIP_SENSOR",
    "SLIP_THRESHOLD", "SLIP_DELAY",
)  # fmt: skip
HAND_FINGER = (
    "D0", "POWER", "FORCE_SCALE", "TIP_RADIUS", "FINAL", "INSTANT", "PAST", "SUM", "BEFORE", "FORCE", "DEPTH",
    "REFERENCE", "RADIUS", "K", "MU", "MU_DRY", "STIFFNESS", "DAMPING", "DRIVE", "TARGET", "COMMAND",
    "SLIDING", "EVENT_SLID",
)  # fmt: skip
CONTROL_SCALARS = (
    "POLICY", "MARGIN", "QUANTILE", "QUANTILE_KNOWN",
    "DEAD_BAND", "RELEASE_TIME", "SETTLE_TIME", "SLOT", "SLIP_GROWTH",
    "MIN_FORCE", "MAX_FORCE", "RAISE_RATE", "LOWER_RATE", "LIFETIME", "FAIL_FORCE", "FAIL_HOLD", "FAIL_RAMP",
    "CONSTANT", "CONE", "LONGEST_GAP", "LEARNS", "KNOWN", "PROVEN_TIME", "RECOVERY",
)  # fmt: skip
CONTROL_FINGER = (
    "COMMAND", "REQUIRED", "FAULTY", "SAMPLES", "INFORMED", "TRANSFER", "FIRST_FORCE", "FIRST_LOAD",
    "FIRST_ARM", "SINCE_LED", "BELIEVED", "BELIEVED_VAR", "SEEN", "SITE", "SITE_WEIGHTED", "ENVELOPE",
    "QUIET", "SLOTS_USED", "SLOT_FILLED", "SLOT_PRESENT", "SLOT_MEDIAN", "PROVEN",
)  # fmt: skip


@dataclass(frozen=True)
class TrialLayout:
    """Places for a hand of so many fingers, rings and spokes of a patch, and relaxation branches."""

    fingers: int
    rings: int
    spokes: int
    branches: int

    def sections(self) -> dict[str, int]:
        """Name -> length of each section, in order."""
        n, elements = self.fingers, self.rings * self.spokes
        sections = {f"H_{name}": 1 for name in HAND_SCALARS}
        sections |= {f"H_{name}": n for name in HAND_FINGER}
        sections |= {f"H_{name}": n * self.branches for name in ("BRANCHES", "BRANCH_DECAY", "BRANCH_SHARE")}
        sections |= {"H_STEPS": 3, "H_POSE": 6, "H_START": 3, "H_PLACE": 2 * n, "H_WRENCH": 3 * n}
        sections |= {"H_SLIP": 3 * n, "H_READING": 8 * n, "H_FLAGS": FLAGS * n, "H_SPEEDS": FLAGS * n}
        sections |= {"H_LOAD": self.rings * n}
        sections |= {"H_REACH": self.rings, "H_AREA": self.rings, "H_COSINE": self.spokes}
        sections |= {"H_SINE": self.spokes, "H_BRISTLE": 2 * n * elements, "H_EXPONENT_TABLE": TABLE}
        sections |= {"H_RING_TABLE": TABLE * self.rings}
        sections |= {f"G_{name}": 1 for name in CONTROL_SCALARS}
        sections |= {f"G_{name}": n for name in CONTROL_FINGER}
        return sections | {
            "G_ELASTIC": 5,
            "G_CONFIRMED": CONFIRM_SIZE * n,
            "G_SLOTS": SLOTS * n,
            "G_SORTED": SLOTS,
        }

    def places(self) -> dict[str, slice]:
        """Name -> where each section lies."""
        out, at = {}, 0
        for name, length in self.sections().items():
            out[name] = slice(at, at + length)
            at += length
        return out

    @property
    def size(self) -> int:
        """Length of the whole array."""
        return sum(self.sections().values())

    @property
    def row(self) -> int:
        """Length of a row of the result."""
        return len(ROW_HEAD) + self.fingers * len(ROW_FINGER)

    def constants(self) -> str:
        """Return the constants as program text for the generated module."""
        lines = [f"{name} = {place.start}" for name, place in self.places().items()]
        sizes = {
            "HAND_FINGERS": self.fingers, "HAND_RINGS": self.rings, "HAND_SPOKES": self.spokes,
            "HAND_BRANCHES": self.branches, "HAND_TABLE": TABLE, "HAND_FLAGS": FLAGS, "SLOT_COUNT": SLOTS,
            "ROW": self.row, "ROW_FINGER": len(ROW_FINGER),
        }  # fmt: skip
        lines += [f"HAND_RATIO = {profile.RATIO!r}", f"HAND_FRESH = {_fresh_coefficient()!r}"]
        return "\n".join([*lines, *(f"{name} = {value}" for name, value in sizes.items())])


def _fresh_coefficient() -> float:
    """Return C_k of a contact that has just been made."""
    return float(profile.coefficient(np.array(profile.HERTZ)))
