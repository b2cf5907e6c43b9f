"""Six objects in a gripper of MuJoCo: force over the least possible, slips, and the bound while it slides.

A world that is not ours, under the controller of the node: soft round pads that do not relax, an elliptic
cone. ``python -m validation.mujoco_plant --seeds 8 --json``; exit code 1 where an object is lost or pressed
beyond what it bears.
"""

import argparse
import json
import sys
from collections.abc import Mapping

from validation.held_object import NEVER_S, Filling, Held, Outcome, sentence, summed, two_pushes
from validation.held_object import run as run_plant
from vegrip.bridges.mujoco_plant import MujocoHand, Shape, elliptic_least_force, simulator_creep
from vegrip.trials.candidates import KNOBS
from vegrip.virtual.disturbance import Wetting


def _cylinder(radius: float, half_height: float) -> Shape:
    return Shape("cylinder", (radius, half_height))


SHAPES: Mapping[str, Shape] = {
    "box": Shape(),
    "glass": _cylinder(0.03, 0.06),
    "egg": Shape("ellipsoid", (0.022, 0.03, 0.022)),
    "bottle": _cylinder(0.03, 0.1),
    "can": _cylinder(0.033, 0.06),
    "soap": Shape("ellipsoid", (0.03, 0.045, 0.015)),
}
FILLED, WET = Filling(3.0, NEVER_S, 0.2, 4.0), Wetting(4.0, 5.0, 0.6)
OBJECTS: Mapping[str, Held] = {
    "box": Held("100 g, pushed twice", 0.1, 0.6, events=two_pushes()),
    "glass": Held("80 g, filled with 200 g in 4 s", 0.08, 0.5, events=(FILLED,)),
    "egg": Held("60 g, bears 4 N", 0.06, 0.5, offset_y=0.0, bears=4.0),
    "bottle": Held("150 g, 5 mm off its centre", 0.15, 0.6, offset_x=5e-3),
    "can": Held("250 g, wet from 4 s: 0.6 of the friction", 0.25, 0.6, events=(WET,)),
    "soap": Held("120 g, slippery, wet from 4 s", 0.12, 0.35, events=(WET,)),
}


def run(name: str, controller: str, seed: int) -> Outcome:
    """Hold one of :data:`OBJECTS`."""
    held = OBJECTS[name]
    hand = MujocoHand(held.settings(), seed, held.events, SHAPES[name])
    return run_plant(hand, controller, held.friction, held.bears, elliptic_least_force)


def main() -> int:
    """Print a row for every object; return 1 where one is lost or pressed beyond what it bears."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--only", choices=OBJECTS, nargs="*", default=list(OBJECTS))
    parser.add_argument("--controller", default="vegrip", choices=tuple(KNOBS["pinch"]))
    parser.add_argument("--json", action="store_true")
    chosen = parser.parse_args()
    figures = {}
    for name in chosen.only:
        figures[name] = summed([run(name, chosen.controller, seed) for seed in range(chosen.seeds)])
        if not chosen.json:
            print(f"{name:7} {OBJECTS[name].about}: {sentence(figures[name])}")
    creep = simulator_creep()
    if chosen.json:
        print(json.dumps({"objects": figures, "creep": creep}))
    else:
        for row in creep:
            print(f"creep of MuJoCo itself: {row}")
    lost = any(
        one["drops"] or one["largest_force"] > 1.05 * OBJECTS[name].bears for name, one in figures.items()
    )
    return int(lost)


if __name__ == "__main__":
    sys.exit(main())
