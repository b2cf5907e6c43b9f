"""A part of the load that is gone at once, and alone: its channel is doubted, until that has lasted.

A load on an object is a force with a lever, so a contact feels it as tangential force and as torque, and it
comes and goes over several samples. Where one of the two falls within one sample below GONE of the least that
it has been for LASTING, while the other is felt and stays, the channel is more likely wrong than the load
gone. It is doubted until the part is back, for LASTING at most. That is longer than a fault lasts that
nothing else shows; so the end of one, where a part falls as suddenly, raises no doubt. Meanwhile

* slip and its absence say nothing of friction, because the load they happen at is not known;
* the least force assumes what was held.
"""

import math

from vegrip.estimator.kernels.generated import *

PART_OF_FORCE = 0
PART_OF_TORQUE = 1

LASTING = 1.1  # [s], as SUSTAINED of friction
AVERAGED = 0.1  # [s] over which a part is averaged, of which the least is looked for
GONE = 0.5  # of the least that was held
BACK = 0.7  # of it, from which on the part is there again
ALTERED = 0.2  # of the average, beyond which a part does not stay
ALTERED_NOISE = 4.0  # standard deviations of the noise that are added to it
FELT_NOISE = 6.0  # standard deviations from which a part is felt, and by which one must fall


def follow_load(m: Floats, dt: float, tangential: float, torque: float) -> None:
    """Follow both parts of the load [N], [N m]; NaN = not measured."""
    force, moment = abs(tangential), abs(torque)
    force_stays = does_part_stay(m, PART_OF_FORCE, force, m.set.s_tangential)
    torque_stays = does_part_stay(m, PART_OF_TORQUE, moment, m.set.s_torque)
    follow_part(m, PART_OF_FORCE, dt, force, m.set.s_tangential, torque_stays)
    follow_part(m, PART_OF_TORQUE, dt, moment, m.set.s_torque, force_stays)


def does_part_stay(m: Floats, part: int, value: float, noise: float) -> bool:
    """Whether a part is felt, is not doubted, and has not changed."""
    at = PART0 + PART_SIZE * part
    average = m[at + PART_AVERAGE]
    near = abs(value - average) <= ALTERED * average + ALTERED_NOISE * noise
    return bool(near and average > FELT_NOISE * noise and m[at + PART_LOST] <= 0.0)


def follow_part(m: Floats, part: int, dt: float, value: float, noise: float, other_stays: bool) -> None:
    """Follow a part that is ``value`` now and whose noise has the std ``noise``."""
    at = PART0 + PART_SIZE * part
    if not math.isfinite(value) or dt > m.set.longest_gap:
        forget_part(m, at)
    elif m[at + PART_LOST] > 0.0:
        wait_for_part(m, at, dt, value)
    elif other_stays and is_gone(m, at, value, noise):
        m[at + PART_LOST] = LASTING
    else:
        note_part(m, at, dt, value)


def is_gone(m: Floats, at: int, value: float, noise: float) -> bool:
    """Whether the part at ``at`` has fallen at once far below what was held, and not by its noise."""
    held, least_fall = held_part(m, at), FELT_NOISE * noise
    sudden = m[at + PART_LAST] - value > least_fall
    return bool(sudden and value < GONE * held and held - value > least_fall)


def held_part(m: Floats, at: int) -> float:
    """The least that the part at ``at`` has been for LASTING, and up to twice as long."""
    return float(min(m[at + PART_BEFORE], m[at + PART_LEAST]))


def note_part(m: Floats, at: int, dt: float, value: float) -> None:
    """Go on with what the part at ``at`` has been, in blocks of LASTING."""
    m[at + PART_LAST] = value
    m[at + PART_AVERAGE] += dt / (AVERAGED + dt) * (value - m[at + PART_AVERAGE])
    m[at + PART_LEAST] = min(m[at + PART_LEAST], m[at + PART_AVERAGE])
    m[at + PART_BLOCK] += dt
    if m[at + PART_BLOCK] >= LASTING:
        m[at + PART_BEFORE], m[at + PART_LEAST] = m[at + PART_LEAST], m[at + PART_AVERAGE]
        m[at + PART_BLOCK] = 0.0


def wait_for_part(m: Floats, at: int, dt: float, value: float) -> None:
    """Doubt the part at ``at`` until it is back or the time is over; then it counts as it is."""
    if value > BACK * held_part(m, at):
        m[at + PART_LOST], m[at + PART_LAST] = 0.0, value
        return
    m[at + PART_LOST] -= dt
    if m[at + PART_LOST] <= 0.0:
        forget_part(m, at)


def forget_part(m: Floats, at: int) -> None:
    """Know nothing of the part at ``at``."""
    for i in range(PART_SIZE):
        m[at + i] = 0.0


def is_load_doubted(m: Floats) -> bool:
    """Whether a part of the load is gone that may still be there."""
    return bool(is_part_doubted(m, PART_OF_FORCE) or is_part_doubted(m, PART_OF_TORQUE))


def is_part_doubted(m: Floats, part: int) -> bool:
    """Whether one part is."""
    return bool(m.part[PART_SIZE * part + PART_LOST] > 0.0)


def load_to_hold(m: Floats, tangential: float, torque: float) -> tuple[float, float]:
    """Return the magnitudes of a load [N], [N m] with no less of a doubted part than was held."""
    if is_part_doubted(m, PART_OF_FORCE):
        tangential = max(tangential, held_part(m, PART0 + PART_SIZE * PART_OF_FORCE))
    if is_part_doubted(m, PART_OF_TORQUE):
        torque = max(torque, held_part(m, PART0 + PART_SIZE * PART_OF_TORQUE))
    return tangential, torque
