"""Grips under what they were not tuned for: other friction, slip channels, hands, masses and drives.

Usage: ``python -m validation.controllers.robustness --seeds 20``.

Every case changes one thing of the usual scenarios. A trial is one of :mod:`vegrip.trials.closed_loop`; the
figures are those of :mod:`.grip_quality`, with the force over least of the first seconds after wet faces have
dried besides.
"""

import argparse
import json
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from vegrip.grip.parameters import GraspParameters
from vegrip.trials.candidates import KNOBS, parameters, with_slip_channel
from vegrip.trials.closed_loop import GRASPS, SAMPLING_S, Scenario, run_grip
from vegrip.trials.fronts import GripRecord, Surroundings, figures_of, force_over_least, record_of, wrong_slip
from vegrip.virtual import Disturbance, HandSettings, VirtualHand, disturbances
from vegrip.virtual.disturbance import Wetting

NAMES = ("vegrip", "learning", "elastic")
WET_START_S, WET_S, WET_FRICTION = 4.0, 2.0, 0.6  # the faces get wet and dry again within 0.3 s
DRYING_S = 3.0  # after wet faces have dried

_HAND, _PINCH = GRASPS["hand"], GRASPS["pinch"]
HANDS = {
    "hand": _HAND,
    "pinch": _PINCH,
    "tripod": replace(
        _HAND,
        fingers=("thumb", "index", "middle"),
        x=(0.0, -0.015, 0.015),
        y=(0.0, 0.0, 0.0),
        plate=replace(_HAND.plate, mass=0.2, inertia=3e-4),
    ),
    "gripper": replace(
        _PINCH,
        fingers=("left", "right"),
        opposing_radius=15e-3,
        opposing_stiffness=1.0,
        tip=replace(_PINCH.tip, radius=15e-3, amplitudes=(0.3, 0.15), rates=(2.0, 0.05)),
    ),
}
"""The hands of the cases; ``gripper`` is a parallel gripper with two soft pads."""

USUAL = Surroundings()


@dataclass(frozen=True)
class Case:
    """What differs from the usual."""

    hand: str = "hand"  # one of HANDS
    surroundings: Surroundings = USUAL
    mass: float = 1.0  # [-] of the object, times the usual
    only_wet: bool = False  # nothing acts but one wetting
    world: str = "old"  # one of WORLDS, of the friction

    def settings(self, seed: int) -> HandSettings:
        """Return the hand with the object of ``seed``."""
        hand, there = HANDS[self.hand], Scenario(seed, 10.0, world=self.world).settings
        tip = replace(hand.tip, friction=there.tip.friction, friction_exponent=there.tip.friction_exponent)
        sensor = replace(hand.sensor, tangential_gain=there.sensor.tangential_gain)
        hand = replace(hand, tip=tip, sensor=sensor)
        plate = replace(hand.plate, mass=hand.plate.mass * self.mass, inertia=hand.plate.inertia * self.mass)
        return self.surroundings.applied(replace(hand, plate=plate))

    def events(self, seed: int, duration: float) -> tuple[Disturbance, ...]:
        """Return what acts, as heavy as the object."""
        if self.only_wet:
            return (Wetting(WET_START_S, WET_S, WET_FRICTION),)
        plate = self.settings(seed).plate
        wet = tuple(e for e in Scenario(seed, duration).events if isinstance(e, Wetting))
        acting = (*disturbances(seed, duration, weight=plate.mass * plate.gravity), *wet)
        return tuple(sorted(acting, key=lambda event: event.start))


CASES = {
    "hand": Case(),
    "pinch": Case("pinch"),
    "hand, half the friction": Case(surroundings=Surroundings(friction_scale=0.5)),
    "hand, twice the friction": Case(surroundings=Surroundings(friction_scale=2.0)),
    "hand, friction as published": Case(world="published"),
    "pinch, friction as published": Case("pinch", world="published"),
    "hand, slip from 0.5 mm/s, 10 ms late": Case(
        surroundings=Surroundings(slip_threshold=5e-4, slip_delay=0.01)
    ),
    "hand, slip not felt": Case(surroundings=Surroundings(slip_channel="absent")),
    "hand, wet to 0.6 in 0.3 s": Case(only_wet=True),
    "pinch, drives of 80 Hz": Case("pinch", Surroundings(80.0)),
    "hand, drives of 5 Hz": Case(surroundings=Surroundings(5.0)),
    "hand, half the mass": Case(mass=0.5),
    "hand, twice the mass": Case(mass=2.0),
    "three fingers": Case("tripod"),
    "parallel gripper, two soft pads": Case("gripper"),
}
"""By what one would call them."""


@dataclass(frozen=True)
class RobustnessTrial:
    """One run: which controller, in which case, with which seed."""

    name: str
    case: Case
    seed: int
    duration: float = 10.0  # [s]


def settings_of(trial: RobustnessTrial, hand: HandSettings) -> GraspParameters:
    """Return the controller at its operating point, with the slip channel and the size of the tips."""
    few = len(hand.fingers) == 2
    settings = parameters(trial.name, KNOBS["pinch" if few else "hand"][trial.name], hand.tip.friction)
    tips = {finger: tip for finger, tip in settings.tips.items() if finger in hand.fingers}
    informed = with_slip_channel(settings, hand.sensor)
    return replace(informed, tip=replace(settings.tip, radius=hand.tip.radius), tips=tips)


def record_of_trial(trial: RobustnessTrial) -> tuple[GripRecord, float]:
    """Run one trial; return its record, and the force over least after wet faces have dried (or NaN)."""
    hand, events = trial.case.settings(trial.seed), trial.case.events(trial.seed, trial.duration)
    settings, channel = settings_of(trial, hand), trial.case.surroundings.slip_channel
    held = VirtualHand(hand, trial.seed, events)
    run = run_grip(held, settings, trial.duration, spoil=wrong_slip(channel, trial.seed))
    dry = WET_START_S + WET_S
    ratio = force_over_least(run, dry, dry + DRYING_S) if trial.case.only_wet else math.nan
    return record_of(run, events, hand.actuator.close_time), ratio


def figures_of_case(name: str, case: Case, seeds: Sequence[int], duration: float = 10.0) -> dict[str, Any]:
    """Return the figures of a controller in a case over ``seeds``."""
    found = [record_of_trial(RobustnessTrial(name, case, seed, duration)) for seed in seeds]
    dried = [ratio for _, ratio in found if math.isfinite(ratio)]
    return {
        **figures_of([record for record, _ in found], SAMPLING_S),
        "over_least_after_wet": float(np.mean(dried)) if dried else math.nan,
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the cases, print a table."""
    parser = argparse.ArgumentParser(prog="python -m validation.controllers.robustness", description=__doc__)
    parser.add_argument("--seeds", type=int, default=20, help="scenarios of each case (default 20)")
    parser.add_argument("--first", type=int, default=2000, help="first seed (default 2000)")
    parser.add_argument("--only", nargs="+", choices=NAMES, default=NAMES, help="these controllers alone")
    parser.add_argument("--case", nargs="+", choices=tuple(CASES), default=tuple(CASES), help="these cases")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    given = parser.parse_args(arguments)
    if given.seeds < 1 or given.first < 0:
        parser.error("--seeds is at least 1, --first is at least 0")
    seeds = range(given.first, given.first + given.seeds)
    console, told = Console(stderr=True), {}
    with console.status("simulating") as status:
        for case in given.case:
            for name in given.only:
                status.update(f"{case}: {name}")
                told[f"{case}: {name}"] = figures_of_case(name, CASES[case], seeds)
    if given.json:
        sys.stdout.write(json.dumps(_plain(told)) + "\n")
    else:
        Console().print(table(told))
    return 0


def _plain(value: Any) -> Any:
    """Return ``value`` with what is not a number as null: JSON has no NaN."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    return None if isinstance(value, float) and math.isnan(value) else value


def table(told: dict[str, dict[str, Any]]) -> Table:
    """Return one row per case and controller."""
    out = Table(title="one thing changed at a time")
    for header in ("case", "trials with a slip", "95 %", "drops", "force over least", "micro-slip",
                   "margin, 5 %", "after wet"):  # fmt: skip
        out.add_column(header, justify="left" if header == "case" else "right")
    for name, one in told.items():
        low, high = one["slip_probability_bounds"]
        wet = one["over_least_after_wet"]
        out.add_row(
            name, f"{one['trials_with_slip']} of {one['trials']}", f"{low:.2f} to {high:.2f}",
            str(one["drops"]), f"{one['force_over_least']:.2f}", f"{1e6 * one['largest_micro_slip']:.0f} um",
            f"{one['margin_q05']:.2f}", "" if math.isnan(wet) else f"{wet:.2f}",
        )  # fmt: skip
    return out


if __name__ == "__main__":
    sys.exit(main())
