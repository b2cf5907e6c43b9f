"""Six objects in a gripper of MuJoCo: force over the least possible, slips, and the bound while it slides.

A world that is not ours, under the controller of the node: soft round pads that do not relax, an elliptic
cone. ``python -m validation.mujoco_plant --seeds 8 --json``; exit code 1 where an object is lost or pressed
beyond what it bears.
"""

import argparse
import json
import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vegrip.bridges.mujoco_plant import MujocoHand, Shape, elliptic_least_force, simulator_creep
from vegrip.trials.candidates import KNOBS, parameters
from vegrip.trials.closed_loop import FORCE, GRASPS, SETTLED_S, UTILISATION, Loop, grip_of
from vegrip.trials.fronts import clopper_pearson, force_over_least
from vegrip.virtual import Disturbance
from vegrip.virtual.disturbance import Burden, Push, Wetting
from vegrip.virtual.settings import HandSettings

DURATION_S = 10.0
LOOK_EVERY = 5  # periods of the controller: 10 ms
SLIDES_M_S = 1e-4  # slip speed from which a contact on the cone counts as sliding
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
    shape: Shape
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


def _pushes() -> tuple[Push, ...]:
    return Push(3.0, 0.3, 0.5, -0.5), Push(6.0, 0.3, -0.6, 0.4)


def _cylinder(radius: float, half_height: float) -> Shape:
    return Shape("cylinder", (radius, half_height))


EGG = Shape("ellipsoid", (0.022, 0.03, 0.022))
SOAP = (0.03, 0.045, 0.015)  # [m] half axes
FILLED, WET = Filling(3.0, NEVER_S, 0.2, 4.0), Wetting(4.0, 5.0, 0.6)
OBJECTS: Mapping[str, Held] = {
    "box": Held("100 g, pushed twice", Shape(), 0.1, 0.6, events=_pushes()),
    "glass": Held("80 g, filled with 200 g in 4 s", _cylinder(0.03, 0.06), 0.08, 0.5, events=(FILLED,)),
    "egg": Held("60 g, bears 4 N", EGG, 0.06, 0.5, offset_y=0.0, bears=4.0),
    "bottle": Held("150 g, 5 mm off its centre", _cylinder(0.03, 0.1), 0.15, 0.6, offset_x=5e-3),
    "can": Held("250 g, wet from 4 s: 0.6 of the friction", _cylinder(0.033, 0.06), 0.25, 0.6, events=(WET,)),
    "soap": Held("120 g, slippery, wet from 4 s", Shape("ellipsoid", SOAP), 0.12, 0.35, events=(WET,)),
}


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


def run(held: Held, controller: str, seed: int) -> Outcome:
    """Hold an object for :data:`DURATION_S`, or until it is lost."""
    settings = held.settings()
    hand = MujocoHand(settings, seed, held.events, held.shape)
    believed = parameters(controller, KNOBS["pinch"][controller], settings.tip.friction)
    believed = replace(believed, limits=replace(believed.limits, max_force=held.bears))
    loop = Loop(hand, grip_of(believed, hand.fingers), least=elliptic_least_force)
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


def look(hand: MujocoHand, loop: Loop) -> "np.ndarray[Any, np.dtype[np.int64]]":
    """Return how many fingers slide, slide with a bound above zero, are below their bound, and all."""
    found = np.zeros(4, np.int64)
    for name, true in zip(hand.fingers, hand.truths(), strict=True):
        bound, utilisation = loop.grip.margin(name).lower_bound, float(true[UTILISATION])
        slides = bool(true[-4]) or (utilisation > 0.99 and true[-2] > SLIDES_M_S)
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


def main() -> int:
    """Print a row for every object; return 1 where one is lost or pressed beyond what it bears."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--only", choices=OBJECTS, nargs="*", default=list(OBJECTS))
    parser.add_argument("--controller", default="vegrip", choices=tuple(KNOBS["pinch"]))
    parser.add_argument("--json", action="store_true")
    chosen = parser.parse_args()
    told = {}
    for name in chosen.only:
        held = OBJECTS[name]
        told[name] = summed([run(held, chosen.controller, seed) for seed in range(chosen.seeds)])
        if not chosen.json:
            one = told[name]
            print(
                f"{name:7} {held.about}: {one['force_over_least']:.2f} times the least,"
                f" {one['largest_force']:.1f} N at most, {one['slips']} slips, {one['drops']} drops of"
                f" {one['trials']}, bound above zero in {one['bound_above_zero_while_sliding']} of"
                f" {one['sliding_looks']} looks that slide, margin below it {one['margin_below_bound']:.1%}"
            )
    creep = simulator_creep()
    if chosen.json:
        print(json.dumps({"objects": told, "creep": creep}))
    else:
        for row in creep:
            print(f"creep of MuJoCo itself: {row}")
    lost = any(
        one["drops"] or one["largest_force"] > 1.05 * OBJECTS[name].bears for name, one in told.items()
    )
    return int(lost)


if __name__ == "__main__":
    sys.exit(main())
