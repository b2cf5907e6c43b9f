"""The law: no channel, however wrong, drops an object, lets it slide, crushes it or stays unnamed."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from .grasp import DELAY_S, LIFT_S, SLID_M, Case, Outcome, run, without_a_channel
from .plant import Make, Plant
from .sensors import COLUMNS

NAMED_S = 2.0  # after the first contradiction
CRUSHED = 3.0  # times the least force, from 5 s after the beginning of the fault
LIFTED_S = 2.0  # a sound channel has been of use until here
LATE = ("late-100", "late-500", "ever-later")
EVIDENT = ("tangential-stuck", "normal-stuck", *(f"{channel}-dropouts" for channel in COLUMNS))
"""Faults of sensors that show by themselves: the noise is gone, samples are missing. A gain does not."""
AS_SOUND = 1.1  # times the slide by a sound channel, where that is more than may be
AS_WITHOUT = 1.3  # times the grip without a channel, where that is more: friction that is not known costs it


def breaches(case: Case, told: Outcome) -> Iterator[str]:
    """Yield what of the law is broken."""
    if told.dropped < math.inf:
        yield f"DROPPED at {told.dropped:.1f} s"
    elif told.slid > SLID_M:
        yield f"SLID {1e3 * told.slid:.1f} mm"
    due, slip_faults = told.contradicted + NAMED_S, {one.fault for one in case.slip_faults}
    if slip_faults != {"absent"} and due < min(case.duration, told.dropped, told.named, told.explained):
        yield f"NOT NAMED, contradicted at {told.contradicted:.1f} s"
    yield from (f"NOT NAMED: {fault}" for fault in unnamed(case, told))
    if case.gain == 1.0 and not slip_faults and not case.sensor_faults and told.named < math.inf:
        yield f"NAMED though sound at {told.named:.1f} s"
    felt = max(case.gain, 1.0) * max(case.tangential_gain, 1.0)
    if told.after_fault > CRUSHED * felt:  # what is felt of a load is all that is known of it
        yield f"CRUSHED {told.after_fault:.1f} x"


def unnamed(case: Case, told: Outcome) -> Iterator[str]:
    """Yield the evident faults of sensors of which nothing has been said in time."""
    for fault in case.sensor_faults:
        due = max(fault.start, LIFT_S) + NAMED_S
        if fault.fault in EVIDENT and due < min(case.duration, told.dropped, told.named):
            yield fault.fault


def least_slide(make: Make, felt: float) -> float:
    """Return how far [m] an object at its limit slides when its load rises by half within 50 ms.

    So late [s] as it is ``felt``, and no sooner, all fingers are commanded 15 N.
    """
    plant, began, load = Plant(make), math.inf, np.zeros((2, 2))
    held = 1.05 * float(plant.least_squeeze(np.array(make.load), np.ones(make.fingers)))
    for k in range(400):
        t = (k + 1) / 200.0
        rises = min(t / 0.5, 1.0) + 0.5 * min(max((t - 1.0) / 0.05, 0.0), 1.0)
        load = np.array([load[1], [0.0, -make.load * rises]])
        squeeze = 15.0 if t >= began + felt else held
        plant.advance(0.005, np.full(make.fingers, squeeze), (np.ones(make.fingers),) * 2, load)
        if plant.slid.min() > 0.0 and t > 1.0:
            began = min(began, t)
    return float(plant.slid.min())


def sound(case: Case) -> Outcome:
    """Return what the same grip does by a channel without a fault."""
    return run(replace(case, fault="none", which=(), also=case.sensor_faults))


def sound_until(case: Case) -> float:
    """Return until when all slip channels are sound [s]; one that flickers is missing before."""
    return min((0.0 if one.fault == "flicker" else one.start for one in case.slip_faults), default=math.inf)


def excused(case: Case, told: Outcome, found: Sequence[str]) -> tuple[list[str], str]:
    """Take out of what was ``found`` what the grip without a channel does, too; say what that does.

    An object that was held until the channel failed has shown its friction, so that is no excuse, unless
    less and less is felt of its load, or another sensor is wrong as well. A slide that a sound channel lets
    be as long is one of the drives, up to what no command could hold (:func:`least_slide`): a load that rises
    by half while the object is at its limit has to be felt and answered first. A channel that is late, or one
    finger's that is dead beside sound ones, contradicts no load as long as all is held.
    """
    if not found:
        return [], ""
    bare = run(without_a_channel(case))
    left = []
    for one in found:
        was_lifted = case.begins > LIFTED_S and told.slid_at > case.begins
        is_felt = case.gain >= 1.0 and not case.sensor_faults
        was_sound = told.slid_at < min(sound_until(case), case.begins)
        was_held = (was_lifted and is_felt) or was_sound
        if one.startswith(("DROPPED", "SLID")) and bare.slid > SLID_M and not was_held:
            continue
        if one.startswith("CRUSHED") and float(one.split()[1]) <= AS_WITHOUT * max(
            bare.after_fault, bare.over_least
        ):
            continue
        some = any(fault.which or fault.fault in LATE for fault in case.slip_faults)
        if one.startswith("NOT NAMED,") and told.slid <= SLID_M and some:
            continue
        is_of_the_drives = one.startswith(
            ("SLID", "DROPPED") if was_sound else "SLID"
        ) and told.slid <= least_slide(case.make, DELAY_S)
        if is_of_the_drives and told.slid <= AS_SOUND * sound(case).slid:
            continue
        left.append(one)
    return left, (
        f"without: slid {1e3 * bare.slid:.2f} mm, {bare.over_least:.2f} x"
        + (f", dropped {bare.dropped:.1f} s" if bare.dropped < math.inf else "")
    )
