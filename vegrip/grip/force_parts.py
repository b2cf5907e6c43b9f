"""What the command of a finger is made of, stage by stage: the answer to "why this force?"."""

import math
from dataclasses import dataclass, fields

from vegrip.grip.finger import REASONS, GraspFinger
from vegrip.messages import Reason


@dataclass(frozen=True, slots=True)
class ForceParts:
    """Forces [N] of the last step in the order in which they arise; NaN: the stage had nothing to say."""

    least: float  # keeps the wanted margin under this load, now and over the horizon
    kept: float  # not lowered below until a load is felt; 0: nothing is kept
    followed: float  # the need of the margin grip: up at once, down slowly
    required: float  # what policy or fail-safe asks for, within the limits
    balanced: float  # the share of the grasp, against the thumb
    commanded: float  # within the rates
    reason: Reason  # the last stage that changed it

    def __str__(self) -> str:
        """Return a line for each stage, and why the last one changed it."""
        forces = (one.name for one in fields(self) if one.name != "reason")
        lines = [f"{name:<10}{getattr(self, name):8.3f} N" for name in forces]
        return "\n".join([*lines, f"{'reason':<10}{self.reason.name.lower()}"])


def force_parts(finger: GraspFinger, balanced: float) -> ForceParts:
    """Return what the last command of ``finger`` is made of; ``balanced`` [N] is its share of the grasp."""
    memory = finger.memory
    least, kept, followed, required = (
        float(memory[name]) for name in ("DEMAND_LEAST", "GRIP_KEPT", "GRIP_ENVELOPE", "GRIP_REQUIRED")
    )
    if not finger.started:
        least = kept = followed = required = math.nan
    reason = REASONS[memory["TURN_GIVEN_REASON"]] if finger.started else Reason.INACTIVE
    return ForceParts(least, kept, followed, required, balanced, finger.held, reason)
