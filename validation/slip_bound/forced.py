"""A grasp whose force is set from outside, and looks at what is said of its margin.

The fingers close within 0.5 s to the force that is set, the weight comes at 0.75 to 1 s and stays. What the
controller commands is ignored. A grasp that is *taught* begins with too little force, slides for most of a
second, and is then pressed with what is set.
"""

import math
from dataclasses import dataclass
from typing import Final

from validation.slip_bound.hand import CONFIDENCES, FINGERS, RATE, Hand
from validation.slip_bound.pinch import Pinch
from validation.slip_bound.worlds import Grasp
from vegrip import GripController
from vegrip.estimator.estimator import quantile

CLOSED, LIFTS, LIFTED = 0.5, 0.75, 1.0  # [s]
LOOKS: Final = (0.5, 1.0, 2.0, 4.0)  # [s] after the load, and the force that is set, have come
LESSON, LESSON_ENDS = 0.8, 1.8  # of the least force, until [s]
RAISED = 2.1  # [s] when the force that is set is there after that
STATED: Final = 0.95


@dataclass(frozen=True)
class Look:
    """What is true of the finger with the least margin, and what is said of it."""

    margin: float  # true
    bounds: dict[float, float]  # by confidence; NaN: none is stated
    earliest_slip: float  # [s] at the stated confidence; NaN: none is stated
    slides: bool  # the object slides
    finger: int = 0  # which one that is


def set_force(grasp: Grasp, t: float, *, taught: bool) -> float:
    """Return the normal force [N] of each finger at ``t`` [s]."""
    wanted = grasp.force_ratio * grasp.least_force
    first = LESSON * grasp.least_force if taught else wanted
    if t < CLOSED:
        return first * t / CLOSED
    if not taught or t < LESSON_ENDS:
        return first
    return first + (wanted - first) * min((t - LESSON_ENDS) / (RAISED - LESSON_ENDS), 1.0)


def play(grip: GripController, grasp: Grasp, *, feels_slip: bool, taught: bool = False) -> list[Look]:
    """Play a grasp; return what is true and said at each of LOOKS."""
    begin = RAISED if taught else LIFTED
    due = [round((begin + look) * RATE) for look in LOOKS]
    pinch = Pinch(grasp)
    hand = Hand(grip, pinch, due[-1] + 1, feels_slip=feels_slip)
    looks = []
    for k in range(due[-1] + 1):
        t = k / RATE
        force = set_force(grasp, t, taught=taught)
        pinch.step(1.0 / RATE, force, grasp.weight * min(max((t - LIFTS) / (LIFTED - LIFTS), 0.0), 1.0))
        now = hand.send(k, force)
        if k in due:
            looks.append(look(grip, pinch, force, now))
    return looks


def look(grip: GripController, pinch: Pinch, force: float, now: int) -> Look:
    """Look at the finger whose true margin is the least."""
    margins = pinch.margins(force)
    least = 0 if margins[0] <= margins[1] else 1
    finger = FINGERS[least]
    bounds = {confidence: stated_bound(grip, finger, confidence, now) for confidence in CONFIDENCES}
    earliest = grip.margin(finger).earliest_slip if not math.isnan(bounds[STATED]) else math.nan
    return Look(margins[least], bounds, earliest, min(pinch.slips) > 0.0, least)


def stated_bound(grip: GripController, name: str, confidence: float, now: int) -> float:
    """Return the lower bound of the margin as it is stated at another confidence, of the same belief."""
    finger = grip.fingers[name]
    usual = finger.memory["SET_QUANTILE"]
    finger.memory["SET_QUANTILE"] = quantile(confidence)
    try:
        return finger.reports.margin(now).lower_bound
    finally:
        finger.memory["SET_QUANTILE"] = usual
