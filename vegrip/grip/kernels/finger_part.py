"""One classic frame of one finger: a part of a state in, and with the last one the command out."""

from vegrip.grip.kernels.finger_step import LEFT_ALONE, STEP_COMMANDED, answer_state
from vegrip.grip.kernels.generated import *
from vegrip.grip.kernels.part_protection import protect_short
from vegrip.grip.kernels.receive_part import RING, completes, is_part_welcome, keep_part, take_parts

STEP_PART = 8  # a part has been kept, and the state is not complete
MOST_STEPS = 1e6  # beyond what any signal holds


def finger_part(
    f: Floats, t: Wholes, g: Floats, frame: Bytes, part: int, arrival: int, now: int, out: Bytes
) -> int:
    """Take part number ``part`` of a state; answer the state that it completes, see ``finger_step``."""
    if not is_part_welcome(t, frame, part, arrival):
        return LEFT_ALONE
    keep_part(t, frame, part, arrival)
    if not completes(frame, part):
        return STEP_PART
    take_parts(f, t, part)
    done = answer_state(f, t, g, now)
    if (done & STEP_COMMANDED) != 0:
        write_short_command(f, t, out)
    return done


def write_short_command(f: Floats, t: Wholes, out: Bytes) -> None:
    """Pack the command that was settled; what the frame cannot carry ends at its range, and is counted."""
    force = nearest_steps(f.grip.held / FORCE_SCALE)
    adjustment = nearest_steps(f.grip.adjustment / ADJUSTMENT_SCALE)
    carried = within(force, FORCE_LOW, FORCE_HIGH)
    carried_adjustment = within(adjustment, ADJUSTMENT_LOW, ADJUSTMENT_HIGH)
    t.parts.clipped_force += 1 if carried != force else 0
    t.parts.clipped_adjustment += 1 if carried_adjustment != adjustment else 0
    counter, reason = t.turn.seq % RING, t.turn.given_reason
    pack_short_command(out, counter, carried, carried_adjustment, reason, t.setup.expires)
    protect_short(out, SHORT_COMMAND_LENGTH, t.setup.command_id)


def nearest_steps(steps: float) -> int:
    """Return the nearest whole number, the even one of two."""
    return round(min(max(-MOST_STEPS, steps), MOST_STEPS))  # this order: max(x, nan) is x


def within(steps: int, low: int, high: int) -> int:
    """Return a number of steps that a signal can hold."""
    return min(max(steps, low), high)
