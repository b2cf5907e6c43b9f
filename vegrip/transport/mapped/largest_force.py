"""The largest force that a hand of another make may be asked for, by its map: of the command, of the sensor.

What is stated goes before it: ``limits.max_force`` of a launch file, or in ``[limits]`` of the map. A range
that a map or a database declares counts as it stands. One that is all that the bits hold says nothing of a
hand: it counts only where it is below the usual limit.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from vegrip.grip.safety import USUAL_LIMITS, WatchdogSettings
from vegrip.transport.mapped.commands import ON_STATE, Law, law_of
from vegrip.transport.mapped.plan import FingerPlan, Plan, find_signal
from vegrip.transport.maps.schema import CommandMap
from vegrip.transport.maps.signals import Signal

USUAL_N: Final = USUAL_LIMITS.max_force  # where nothing is known of a hand
BELIEVED_N: Final = WatchdogSettings().ranges.normal_force[1]  # more counts as a fault of the sensor

Ends = tuple[float, float]
"""Least and largest value, NaN where there is none."""


@dataclass(frozen=True, slots=True, order=True)
class LargestForce:
    """A force, and what it is the largest of."""

    force: float  # [N]
    why: str


def largest_force(plan: Plan) -> LargestForce | None:
    """Return the largest force that all commanded fingers can be asked for, and feel; None: not known."""
    commanded = [one for one in plan.fingers if plan.hand.fingers[one.name].command is not None]
    found = [each for finger in commanded for each in (*_of_command(plan, finger), *_of_sensor(plan, finger))]
    if commanded and math.isfinite(plan.hand.drive.maximum):
        found.append(
            LargestForce(plan.hand.drive.maximum, "the drive presses with no more ([drive] maximum)")
        )
    return _least(found)


def largest_felt(plan: Plan) -> LargestForce | None:
    """Return the largest force that all fingers of a sensor feel; None: not known."""
    return _least([each for finger in plan.fingers for each in _of_sensor(plan, finger)])


def _least(found: list[LargestForce]) -> LargestForce | None:
    if not found:
        return None
    if min(found).force > BELIEVED_N:
        return LargestForce(BELIEVED_N, "no greater force is believed (watchdog.ranges.normal_force)")
    return min(found)


def describe_limit(plan: Plan) -> str:
    """Return which limit holds where a launch file states none, in a sentence."""
    stated = plan.hand.limits.get("max_force")
    if stated is not None:
        return f"limits.max_force is {stated} N, as the map states"
    known = largest_force(plan)
    if known is not None:
        return f"limits.max_force is {known.force:g} N where you state none: {known.why}"
    return (
        f"limits.max_force is {USUAL_N:g} N where you state none: the map does not say what the hand may "
        "press with; state it there: [limits] max_force = 12.0"
    )


def _of_command(plan: Plan, finger: FingerPlan) -> Iterator[LargestForce]:
    command = plan.hand.fingers[finger.name].command
    if command is None or command.kind in ON_STATE:
        return  # a position is no force, nor is a step
    where = f"{plan.hand.path} [fingers.{finger.name}.command]"
    signal = None if plan.hand.format else find_signal(plan.database, command.signal, where)[1]
    law = law_of(command, command.unit or (signal.unit if signal is not None else ""), where)
    carried = _bits(signal, raw=command.raw) if signal is not None else (math.nan, math.nan)
    declared = _stated(command, signal, carried)
    yield from _counting(
        _most(law, declared), _most(law, carried), f"the command of {finger.name} carries no more"
    )


def _of_sensor(plan: Plan, finger: FingerPlan) -> Iterator[LargestForce]:
    channel = finger.channels.get("normal_force")
    if channel is None or len(channel.slots) != 1 or channel.table or finger.rotation:
        return  # of a sum no part says what the whole can be
    slot = plan.slots[channel.slots[0]]
    if slot.place is None or not slot.scale:
        return
    signal = slot.place
    bits = _bits(signal, raw=True)
    stated = tuple(
        (end - signal.offset) / signal.scale for end in _narrower(signal, _bits(signal, raw=False))
    )
    most, all_bits = (
        max(end * slot.scale + slot.offset + channel.constant for end in ends) for ends in (stated, bits)
    )
    yield from _counting(most, all_bits, f"the sensor of {finger.name} reads no more")


def _counting(declared: float, by_bits: float, why: str) -> Iterator[LargestForce]:
    """Yield what counts of a force that is declared and of one that the bits hold [N]."""
    if declared > 0.0:
        yield LargestForce(declared, why)
    if 0.0 < by_bits < USUAL_N:
        yield LargestForce(by_bits, why)


def _stated(command: CommandMap, signal: Signal | None, carried: Ends) -> Ends:
    """Return the range of the map, else that of the database, in the unit of the signal."""
    known = _narrower(signal, carried) if signal is not None and not command.raw else (math.nan, math.nan)
    return command.range_or(*known)


def _narrower(signal: Signal, carried: Ends) -> Ends:
    """Return the declared range, unless it is that of the bits."""
    is_known = signal.low < signal.high and not (signal.low <= carried[0] and signal.high >= carried[1])
    return (signal.low, signal.high) if is_known else (math.nan, math.nan)


def _bits(signal: Signal, *, raw: bool) -> Ends:
    if signal.is_float:
        return math.nan, math.nan
    ends = signal.raw_range
    values = ends if raw else tuple(end * signal.scale + signal.offset for end in ends)
    return min(values), max(values)


def _most(law: Law, ends: Ends) -> float:
    """Return the largest force [N] of a signal within ``ends``, NaN where that end is open."""
    forces = [law.force(value, math.nan, math.nan, math.nan) for value in (0.0, 1.0)]
    return law.force(ends[1] if forces[1] > forces[0] else ends[0], math.nan, math.nan, math.nan)
