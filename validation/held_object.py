"""A trial of an object in a gripper of another make than ours: force over the least, slips, and the bound.

The plants are :mod:`.mujoco_plant` and :mod:`.lugre_plant`; the controller is that of the node.
"""

import math
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from vegrip.trials.candidates import KNOBS, parameters
from vegrip.trials.closed_loop import FORCE, GRASPS, SETTLED_S, UTILISATION, Loop, grip_of
from vegrip.trials.fronts import clopper_pearson, force_over_least
from vegrip.trials.known_contact import LeastForce, Plant
from vegrip.virtual import Disturbance
from vegrip.virtual.disturbance import Burden, Push
from vegrip.virtual.settings import HandSettings

DURATION_S = 10.0
LOOK_EVERY = 5  # periods of the controller: 10 ms
SLIDES_M_S = 1e-4  # slip speed from which a contact on the limit counts as sliding
ON_LIMIT = 0.99  # utilisation from which a contact that moves counts as sliding
NEVER_S = 1e4  # [s] an event that lasts beyond every trial


@dataclass(frozen=True)
class Filling(Disturbance):
    """Water is poured in, and stays."""

    mass: float  # [kg]
    time: float  # [s] that it takes

    def acting(self, part: float) -> Burden:
        return Burden(mass=self.mass * min(part * self.duration / self.time, 1.0))


@dataclass(frozen=True)
class Held:
    """An object, and what happens to it."""

    about: str
    mass: float  # [kg]
    friction: float  # [1] at 5 N
    offset_x: float = 0.0  # [m] of the centre of mass from the grasp
    offset_y: float = -0.01
    bears: float = 15.0  # [N] largest force, stated to the controller
    events: tuple[Disturbance, ...] = ()

    def settings(self) -> HandSettings:
        pinch = GRASPS["pinch"]
        place = replace(pinch.plate, mass=self.mass, offset_x=self.offset_x, offset_y=self.offset_y)
        return replace(pinch, plate=place, tip=replace(pinch.tip, friction=self.friction))


class MovingPlant(Plant, Protocol):
    """A plant that also shows how far its object has moved."""

    @property
    def shift(self) -> float:
        """How far the object has moved along the faces since the start [m]."""


def two_pushes() -> tuple[Push, ...]:
    return Push(3.0, 0.3, 0.5, -0.5), Push(6.0, 0.3, -0.6, 0.4)


@dataclass(frozen=True)
class Outcome:
    """One trial."""

    slips: int
    dropped: bool
    force_over_least: float
    largest_force: float  # [N]
    sliding: int  # looks at which a contact slides
    above_zero: int  # of them, looks at which the bound of that finger is above zero
    below_bound: int  # looks at which the true margin is below the bound
    looks: int
    moved: float  # [m] of the object


def run(hand: MovingPlant, controller: str, friction: float, bears: float, least: LeastForce) -> Outcome:
    """Hold an object for :data:`DURATION_S`, or until it is lost; ``friction`` is for who is told of it."""
    believed = parameters(controller, KNOBS["pinch"][controller], friction)
    believed = replace(believed, limits=replace(believed.limits, max_force=bears))
    loop = Loop(hand, grip_of(believed, hand.fingers), least=least)
    counts, periods, largest = np.zeros(4, int), 0, 0.0
    while hand.time < DURATION_S and not hand.dropped:
        loop.step()
        periods += 1
        largest = max(largest, float(hand.truths()[:, FORCE].max()))
        if periods % LOOK_EVERY == 0 and hand.time > SETTLED_S:
            counts += look(hand, loop)
    loop.course.finish(hand)
    sliding, above_zero, below_bound, looks = counts.tolist()
    ratio = force_over_least(loop.course, SETTLED_S)
    return Outcome(
        loop.course.slips, hand.dropped, ratio, largest, sliding, above_zero, below_bound, looks, hand.shift
    )


def look(hand: Plant, loop: Loop) -> "np.ndarray[Any, np.dtype[np.int64]]":
    """Return how many fingers slide, slide with a bound above zero, are below their bound, and all."""
    found = np.zeros(4, np.int64)
    for name, true in zip(hand.fingers, hand.truths(), strict=True):
        bound, utilisation = loop.grip.margin(name).lower_bound, float(true[UTILISATION])
        slides = bool(true[-4]) or (utilisation > ON_LIMIT and true[-2] > SLIDES_M_S)
        found += (slides, slides and bound > 0.0, 1.0 - utilisation < bound, 1)
    return found


def summed(outcomes: list[Outcome]) -> dict[str, Any]:
    """Return the figures of the trials of one object."""
    slipped = sum(one.slips > 0 or one.dropped for one in outcomes)
    looks, sliding = sum(one.looks for one in outcomes), sum(one.sliding for one in outcomes)
    return {
        "trials": len(outcomes),
        "slips": sum(one.slips for one in outcomes),
        "drops": sum(one.dropped for one in outcomes),
        "slip_probability_bounds": clopper_pearson(slipped, len(outcomes)),
        "force_over_least": float(np.mean([one.force_over_least for one in outcomes])),
        "largest_force": max(one.largest_force for one in outcomes),
        "sliding_looks": sliding,
        "bound_above_zero_while_sliding": sum(one.above_zero for one in outcomes),
        "margin_below_bound": sum(one.below_bound for one in outcomes) / looks if looks else math.nan,
        "moved": max(one.moved for one in outcomes),
    }


def sentence(figures: dict[str, Any]) -> str:
    """Return those figures in words."""
    one = figures
    return (
        f"{one['force_over_least']:.2f} times the least, {one['largest_force']:.1f} N at most,"
        f" {one['slips']} slips, {one['drops']} drops of {one['trials']}, bound above zero in"
        f" {one['bound_above_zero_while_sliding']} of {one['sliding_looks']} looks that slide,"
        f" margin below it {one['margin_below_bound']:.1%}"
    )
